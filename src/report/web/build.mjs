// Bundles the page into one file: node build.mjs SOURCE_FOLDER NODE_MODULES OUTPUT.html
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join, resolve } from 'node:path';

const [sourceFolder, nodeModules, output] = process.argv.slice(2).map((p) => resolve(p));
const { buildSync } = createRequire(join(nodeModules, 'x.js'))('esbuild');

function bundle(file, options) {
  const result = buildSync({
    entryPoints: [join(sourceFolder, file)],
    bundle: true,
    minify: true,
    write: false,
    legalComments: 'inline',
    nodePaths: [nodeModules],
    target: ['es2022'],
    ...options,
  });
  return result.outputFiles[0].text;
}

const script = bundle('main.js', { format: 'iife' }).replaceAll('</script', '<\\/script');
const style = bundle('page.css', { loader: { '.css': 'css' } });
// Functions, because "$" means something in a replacement text.
const page = readFileSync(join(sourceFolder, 'page.html'), 'utf8')
  .replace('/*LSMVS-STYLE*/', () => style)
  .replace('/*LSMVS-SCRIPT*/', () => script);
writeFileSync(output, page);
