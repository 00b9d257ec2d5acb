// Opens what mesh_exporter wrote in other programs: node export_test.mjs CHROMIUM BUILD_FOLDER
// The Khronos validator must find no fault; three.js, 3d-tiles-renderer and CesiumJS must draw what our renderer draws, to
// 1 grey level in the mean, and no background inside the silhouette at any level of detail. Pictures are left in BUILD_FOLDER.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import http from 'node:http';
import { createRequire } from 'node:module';
import { dirname, extname, join, normalize, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const [chromiumPath, folder] = process.argv.slice(2);
const here = dirname(fileURLToPath(import.meta.url));
const require = createRequire(join(resolve(folder), 'x.js'));
const { chromium } = require('playwright-core');
const validator = require('gltf-validator');

const TYPES = { '.js': 'text/javascript', '.mjs': 'text/javascript', '.html': 'text/html', '.json': 'application/json', '.png': 'image/png', '.wasm': 'application/wasm', '.css': 'text/css' };
const PAGE = `<!doctype html><html><body style="margin:0"><script type="importmap">{"imports": {
  "three": "/node_modules/three/build/three.module.js", "three/addons/": "/node_modules/three/examples/jsm/",
  "three/examples/jsm/": "/node_modules/three/examples/jsm/",
  "3d-tiles-renderer": "/node_modules/3d-tiles-renderer/build/index.three.js",
  "3d-tiles-renderer/core": "/node_modules/3d-tiles-renderer/build/index.core.js"}}</script>
  <script type="module" src="/test/viewer.js"></script></body></html>`;

const server = http.createServer((request, response) => {
  const url = decodeURIComponent(new URL(request.url, 'http://x').pathname);
  if (url === '/favicon.ico') return void response.writeHead(204).end();
  if (url === '/three.html') return void response.writeHead(200, { 'content-type': 'text/html' }).end(PAGE);
  const path = url.startsWith('/test/') ? join(here, normalize(url.slice(5))) : join(folder, normalize(url));
  fs.readFile(path, (error, bytes) => {
    if (error) response.writeHead(404).end();
    else response.writeHead(200, { 'content-type': TYPES[extname(path)] ?? 'application/octet-stream' }).end(bytes);
  });
});
await new Promise((done) => server.listen(0, '127.0.0.1', done));
const base = `http://127.0.0.1:${server.address().port}`;

const browser = await chromium.launch({
  executablePath: chromiumPath,
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});
const complaints = [];
async function open(path) {
  const page = await browser.newPage({ viewport: { width: 800, height: 600 } });
  page.on('console', (m) => { if (m.type() === 'error' || process.env.LSMVS_VERBOSE) complaints.push(m.text()); });
  page.on('pageerror', (e) => complaints.push(e.message));
  await page.goto(base + path);
  await page.waitForFunction(() => window.ready, undefined, { timeout: 120000 });
  return page;
}

const reference = (name) => `data:image/png;base64,${fs.readFileSync(join(folder, 'data', `${name}.png`)).toString('base64')}`;
const keep = (name, picture) => fs.writeFileSync(join(folder, `${name}.png`), Buffer.from(picture.split(',')[1], 'base64'));

// Mean difference in grey levels where both show the mesh two pixels around; pixels that only one shows; pixels of background
// that the mesh encloses.
const compare = (page, picture, wanted) => page.evaluate(async (urls) => {
  const [a, b] = await Promise.all(urls.map(async (url) => {
    const image = new Image();
    image.src = url;
    await image.decode();
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [image.width, image.height];
    const context = canvas.getContext('2d', { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    return context.getImageData(0, 0, image.width, image.height);
  }));
  const { width, height } = a;
  const isMesh = (image, i) => !(image.data[4 * i] < 8 && image.data[4 * i + 1] > 247 && image.data[4 * i + 2] < 8);
  const inside = (image, x, y) => {
    for (let dy = -2; dy <= 2; ++dy) for (let dx = -2; dx <= 2; ++dx) {
      if (x + dx < 0 || y + dy < 0 || x + dx >= width || y + dy >= height || !isMesh(image, (y + dy) * width + x + dx)) return false;
    }
    return true;
  };
  let sum = 0, count = 0, single = 0, largest = 0, mesh = 0;
  for (let y = 0; y < height; ++y) for (let x = 0; x < width; ++x) {
    const i = y * width + x;
    single += isMesh(a, i) !== isMesh(b, i);
    mesh += isMesh(a, i);
    if (!inside(a, x, y) || !inside(b, x, y)) continue;
    for (let k = 0; k < 3; ++k) {
      const d = Math.abs(a.data[4 * i + k] - b.data[4 * i + k]);
      sum += d;
      largest = Math.max(largest, d);
    }
    count += 3;
  }
  // Background that cannot be reached from the picture's rim.
  const reached = new Uint8Array(width * height), stack = [];
  const visit = (x, y) => {
    const i = y * width + x;
    if (x < 0 || y < 0 || x >= width || y >= height || reached[i] || isMesh(a, i)) return;
    reached[i] = 1;
    stack.push([x, y]);
  };
  for (let x = 0; x < width; ++x) { visit(x, 0); visit(x, height - 1); }
  for (let y = 0; y < height; ++y) { visit(0, y); visit(width - 1, y); }
  while (stack.length) { const [x, y] = stack.pop(); visit(x + 1, y); visit(x - 1, y); visit(x, y + 1); visit(x, y - 1); }
  let holes = 0;
  for (let i = 0; i < width * height; ++i) holes += !isMesh(a, i) && !reached[i];
  return { mean: sum / count, largest, single, holes, mesh, count };
}, [picture, wanted]);

// Greatest errors on the screen [px] that are allowed, from the finest tiles to the root alone (Cesium shows nothing beyond). An edge of the coloured mesh
// stands for a texel.
// Cesium makes sRGB of linear vertex colours by a power of 2.2, which is up to 8 grey levels off; textures it leaves as they are.
const FINEST = { '3d-tiles-renderer': { mesh: 1, colored: 1 }, cesium: { mesh: 1, colored: 2 } };
const COARSE = { mesh: { mean: 4, single: 1000 }, colored: { mean: 15, single: 1000 } };
const ERRORS = { mesh: [0.01, 16, 24, 32, 48, 150], colored: [0.01, 150, 250, 400, 600] };
async function judge(page, what, picture, name, limits) {
  keep(what.replace(/[^a-z0-9.]+/gi, '_'), picture);
  const r = await compare(page, picture, reference(name));
  console.log(`${what}: mean ${r.mean.toFixed(3)}, largest ${r.largest}, single ${r.single}, holes ${r.holes}`);
  assert(r.mesh > 50000, `${what} shows hardly anything: ${r.mesh} pixels`);
  assert(r.mean <= limits.mean, `${what}: mean difference ${r.mean}`);
  assert(r.single <= limits.single, `${what}: ${r.single} pixels of the silhouette differ`);
  assert.equal(r.holes, 0, `${what}: background inside the silhouette`);
}

function glbsIn(path) {
  return fs.readdirSync(path, { recursive: true }).filter((f) => f.endsWith('.glb')).map((f) => join(path, f));
}

let failed = false;
try {
  const glbs = glbsIn(join(folder, 'data'));
  assert(glbs.length > 20);
  for (const glb of glbs) {
    const { issues } = await validator.validateBytes(new Uint8Array(fs.readFileSync(glb)));
    assert.equal(issues.numErrors + issues.numWarnings, 0, `${glb}: ${JSON.stringify(issues.messages.slice(0, 3))}`);
  }
  console.log(`validator: ${glbs.length} files without error or warning`);

  const three = await open('/three.html');
  for (const name of ['mesh', 'colored']) {
    for (const file of [`out/${name}.glb`, `out/${name}_compressed.glb`, `obj/${name}.obj`, ...(name === 'colored' ? ['out/colored.ply'] : [])]) {
      await judge(three, `three ${file}`, await three.evaluate((url) => window.drawFile(url), `/data/${file}`), name, { mean: 1, single: 200 });
    }
  }
  const viewers = { '3d-tiles-renderer': three, cesium: await open('/test/cesium.html') };
  for (const viewer of (process.env.LSMVS_WITHOUT ?? '').split(',')) delete viewers[viewer]; // while working on one of them
  for (const [viewer, page] of Object.entries(viewers)) {
    for (const name of ['mesh', 'colored']) {
      const sets = new Set();
      for (const error of ERRORS[name]) {
        const { picture, shown, errors } = await page.evaluate(([url, e]) => window.drawTiles(url, e), [`/data/tiles_${name}/tileset.json`, error]);
        assert.deepEqual(errors, [], `${viewer} ${name} ${error}`);
        sets.add(shown);
        const finest = error < 1;
        await judge(page, `${viewer} ${name} at ${error}`, picture, name, finest ? { mean: FINEST[viewer][name], single: 200 } : COARSE[name]);
        console.log(`  ${shown.split(' ').length} tiles: ${shown.slice(0, 100)}`);
      }
      assert(sets.size >= 3, `${viewer} never changes the level: ${[...sets]}`);
    }
  }
  assert.deepEqual(complaints, []);
  console.log('all well');
} catch (error) {
  failed = true;
  console.error(error, complaints);
}
await browser.close();
server.close();
process.exit(failed ? 1 : 0);
