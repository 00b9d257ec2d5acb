// Draws exported meshes with three.js and with 3d-tiles-renderer from the pose of camera.json.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { MTLLoader } from 'three/addons/loaders/MTLLoader.js';
import { OBJLoader } from 'three/addons/loaders/OBJLoader.js';
import { PLYLoader } from 'three/addons/loaders/PLYLoader.js';
import { TilesRenderer } from '3d-tiles-renderer';

const camera = new THREE.PerspectiveCamera();
let renderer = null, pose = null;

// Rotations from the mesh's frame to that of the scene, by rows.
const FRAMES = { world: [1, 0, 0, 0, 1, 0, 0, 0, 1], yUp: [1, 0, 0, 0, -1, 0, 0, 0, -1], zUp: [1, 0, 0, 0, 0, 1, 0, -1, 0] };

function placeCamera(frame) {
  const [a, b, c, d, e, f, g, h, i] = FRAMES[frame];
  const sceneFromWorld = new THREE.Matrix4().set(a, b, c, 0, d, e, f, 0, g, h, i, 0, 0, 0, 0, 1);
  const r = pose.rotation, t = pose.translation;
  // The camera of three.js looks along -z with y up.
  const camFromWorld = new THREE.Matrix4().set(
    r[0], r[1], r[2], t[0], -r[3], -r[4], -r[5], -t[1], -r[6], -r[7], -r[8], -t[2], 0, 0, 0, 1);
  const worldFromCam = camFromWorld.invert();
  camera.matrixAutoUpdate = false;
  camera.matrix.copy(sceneFromWorld.multiply(worldFromCam));
  camera.matrix.decompose(camera.position, camera.quaternion, camera.scale);
  camera.fov = (2 * Math.atan(pose.height / 2 / pose.focal) * 180) / Math.PI;
  camera.aspect = pose.width / pose.height;
  [camera.near, camera.far] = [0.1, 100];
  camera.updateProjectionMatrix();
  camera.updateMatrixWorld(true);
}

async function setUp() {
  pose = await (await fetch('/data/camera.json')).json();
  renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true });
  renderer.setPixelRatio(1);
  renderer.setSize(pose.width, pose.height);
  renderer.setClearColor(0x00ff00, 1);
  renderer.toneMapping = THREE.NoToneMapping;
  document.body.append(renderer.domElement);
}

// Plain textures: no mip maps, which our renderer does not have either.
function unlit(object) {
  object.traverse((o) => {
    if (!o.isMesh) return;
    const materials = [o.material].flat().map((m) => {
      const map = m.map ?? null;
      if (map) {
        map.colorSpace = THREE.SRGBColorSpace;
        map.generateMipmaps = false;
        map.minFilter = THREE.LinearFilter;
        map.needsUpdate = true;
      }
      return new THREE.MeshBasicMaterial({ map, vertexColors: !!o.geometry.attributes.color, side: THREE.DoubleSide });
    });
    o.material = Array.isArray(o.material) ? materials : materials[0];
  });
  return object;
}

const LOADERS = {
  async glb(url) {
    return [unlit((await new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).loadAsync(url)).scene), 'yUp'];
  },
  async obj(url) {
    const loader = new OBJLoader();
    if (!url.includes('colored')) {
      const folder = url.slice(0, url.lastIndexOf('/') + 1);
      const materials = await new Promise((done, fail) => {
        const manager = new THREE.LoadingManager();
        const mtl = new MTLLoader(manager).setPath(folder);
        mtl.load(url.slice(folder.length).replace(/obj$/, 'mtl'), (m) => {
          m.preload();
          manager.onLoad = () => done(m);
        }, undefined, fail);
      });
      loader.setMaterials(materials);
    }
    return [unlit(await loader.loadAsync(url)), 'world'];
  },
  async ply(url) {
    return [unlit(new THREE.Mesh(await new PLYLoader().loadAsync(url), new THREE.MeshBasicMaterial())), 'world'];
  },
};

window.drawFile = async (url) => {
  const [object, frame] = await LOADERS[url.split('.').pop()](url);
  const scene = new THREE.Scene();
  scene.add(object);
  placeCamera(frame);
  renderer.render(scene, camera);
  return renderer.domElement.toDataURL('image/png');
};

// All that the tileset shows with the greatest error allowed; also which tiles that are.
window.drawTiles = async (url, errorTarget) => {
  const tiles = new TilesRenderer(url);
  tiles.errorTarget = errorTarget;
  tiles.setCamera(camera);
  tiles.setResolution(camera, pose.width, pose.height);
  const errors = [];
  tiles.addEventListener('load-error', (e) => errors.push(String(e.error ?? e.url)));
  tiles.addEventListener('load-model', (e) => unlit(e.scene));
  const scene = new THREE.Scene();
  scene.add(tiles.group);
  placeCamera('zUp');
  const shown = () => [...tiles.visibleTiles].map((t) => t.content.uri.split('/').pop()).sort().join(' ');
  let same = 0, last = '';
  for (let i = 0; i < 600 && same < 40; ++i) { // what is to be loaded is found step by step
    tiles.group.updateMatrixWorld(true);
    camera.updateMatrixWorld(true);
    tiles.update();
    renderer.render(scene, camera);
    await new Promise((done) => setTimeout(done, 25));
    const now = shown();
    same = now !== '' && now === last && tiles.loadProgress === 1 ? same + 1 : 0;
    last = now;
  }
  renderer.render(scene, camera);
  const picture = renderer.domElement.toDataURL('image/png');
  tiles.dispose();
  return { picture, shown: last, errors };
};

await setUp();
window.ready = true;
