import {
  BufferAttribute, BufferGeometry, LineBasicMaterial, LinearMipmapLinearFilter, LineSegments, Mesh, OrthographicCamera, PlaneGeometry, Scene,
  ShaderMaterial, Texture, Vector3, WebGLRenderer, WireframeGeometry, GLSL3,
} from 'three';
import { borderLoops } from './borders.js';
import { meshMaterial } from './material.js';
import { Rig } from './rig.js';

export const STYLES = ['clay', 'color', 'normals', 'errors'];

const RIM = [0.02, 0.1, 0.9], HOLE = [0.9, 0.0, 0.05];

function photoMaterial() {
  return new ShaderMaterial({
    glslVersion: GLSL3,
    transparent: true,
    depthTest: false,
    vertexShader: 'out vec2 place; void main() { place = uv; gl_Position = vec4(position.xy * 2.0, 0.0, 1.0); }',
    fragmentShader: 'in vec2 place; uniform sampler2D photo; uniform float opacity; out vec4 result;' +
      'void main() { result = vec4(texture(photo, place).rgb, opacity); }',
    uniforms: { photo: { value: null }, opacity: { value: 0 } },
  });
}

// Values of vertices for the corners of the faces.
function perCorner(values, size, indices) {
  const result = new values.constructor(size * indices.length);
  for (let i = 0; i < indices.length; ++i) for (let k = 0; k < size; ++k) result[size * i + k] = values[size * indices[i] + k];
  return result;
}

// Lines from the centres of the photos to the corners of their pictures.
function frustums(report, rig, indices, length) {
  const points = [];
  const f = report.focus;
  for (const i of indices) {
    const p = report.photos[i], r = p.rotation, center = rig.photoCenter(i);
    const corner = (x, y) => {
      const inCam = [((x - p.cx) / p.fx) * length, ((y - p.cy) / p.fy) * length, length].map((v, k) => v - p.translation[k]);
      return new Vector3(...[0, 1, 2].map((k) => r[k] * inCam[0] + r[3 + k] * inCam[1] + r[6 + k] * inCam[2] - f[k]));
    };
    const corners = [corner(0, 0), corner(p.width, 0), corner(p.width, p.height), corner(0, p.height)];
    corners.forEach((c, k) => points.push(center, c, c, corners[(k + 1) % 4]));
  }
  return new BufferGeometry().setFromPoints(points);
}

// Draws all panes into one canvas, each with its mesh and all with the camera of the rig. Draws only when something changed.
export class Viewer {
  constructor(canvas, stage, report, onRigChange) {
    this.report = report;
    this.stage = stage;
    this.renderer = new WebGLRenderer({ canvas, alpha: true, antialias: true, powerPreference: 'high-performance' });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.debug.checkShaderErrors = false; // asking for them waits for the compiler
    this.renderer.autoClear = false;
    this.renderer.setScissorTest(true);
    this.scene = new Scene();
    this.meshes = report.meshes.map(() => null);
    this.panes = []; // {element, meshes: [index] or [left, right]}
    this.settings = { style: 'clay', wireframe: false, facets: false, borders: false, cameras: false, blend: 0, wipe: 0.5 };
    this.photos = new Map();
    this.photoQuad = new Mesh(new PlaneGeometry(1, 1), photoMaterial());
    this.photoQuad.frustumCulled = false;
    this.flatCamera = new OrthographicCamera();
    this.pending = false;
    this.numFrames = 0;
    this.rig = new Rig(stage, report, () => {
      onRigChange();
      this.request();
    });
    this.addCameras();
    new ResizeObserver(() => this.resize()).observe(stage);
    this.resize();
  }

  addCameras() {
    const all = this.report.photos.map((_, i) => i);
    const length = 0.09 * this.report.radius;
    this.cameraLines = new LineSegments(frustums(this.report, this.rig, all, length), new LineBasicMaterial({ color: 0x0b6bcb }));
    this.chosenLines = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: 0xd9730d }));
    this.scene.add(this.cameraLines, this.chosenLines);
  }

  choosePhoto(i) {
    this.chosenLines.geometry.dispose();
    this.chosenLines.geometry = i === null ? new BufferGeometry() : frustums(this.report, this.rig, [i], 0.14 * this.report.radius);
    this.request();
  }

  addMesh(index, data) {
    const geometry = new BufferGeometry();
    // A vertex has several texture coordinates where charts meet: a textured mesh is drawn corner by corner.
    const spread = data.texcoords ? (values, size) => perCorner(values, size, data.indices) : (values) => values;
    if (!data.texcoords) geometry.setIndex(new BufferAttribute(data.indices, 1));
    geometry.setAttribute('position', new BufferAttribute(spread(data.positions, 3), 3));
    geometry.setAttribute('normal', new BufferAttribute(spread(data.normals, 3), 3));
    if (data.colors) geometry.setAttribute('rgb', new BufferAttribute(spread(data.colors, 3), 3, true));
    if (data.errors) geometry.setAttribute('error', new BufferAttribute(spread(data.errors, 1), 1, true));
    if (data.texcoords) geometry.setAttribute('texcoord', new BufferAttribute(data.texcoords, 2));
    const mesh = new Mesh(geometry, meshMaterial(!!data.colors, !!data.errors));
    mesh.userData.surface = { positions: data.positions, indices: data.indices };
    if (data.texcoords) this.loadTexture(index, mesh);
    mesh.frustumCulled = false;
    mesh.visible = false;
    this.scene.add(mesh);
    this.meshes[index] = mesh;
  }

  loadTexture(index, mesh) {
    const image = new Image();
    image.onload = () => {
      const texture = new Texture(image);
      texture.colorSpace = ''; // the shader passes the values through
      texture.flipY = false;
      texture.minFilter = LinearMipmapLinearFilter;
      texture.needsUpdate = true;
      mesh.material.uniforms.page.value = texture;
      mesh.material.uniforms.hasPage.value = true;
      this.request();
    };
    image.src = `data:image/jpeg;base64,${document.getElementById(`texture-${index}`).textContent}`;
  }

  // Lines of a mesh, made when they are first wanted.
  linesOf(mesh) {
    if (!mesh.userData.lines) {
      mesh.userData.lines = new LineSegments(new WireframeGeometry(mesh.geometry), new LineBasicMaterial({ color: 0x23282d, transparent: true, opacity: 0.45 }));
      mesh.userData.lines.frustumCulled = false;
      this.scene.add(mesh.userData.lines);
    }
    return mesh.userData.lines;
  }

  // The mesh's border: its longest loop, the rim, in one colour, the holes in another. Made when it is first wanted.
  bordersOf(mesh) {
    if (!mesh.userData.borders) {
      const { positions, indices } = mesh.userData.surface;
      const loops = borderLoops(positions, indices);
      const count = loops.reduce((sum, loop) => sum + loop.length, 0);
      const points = new Float32Array(6 * count), colors = new Float32Array(6 * count);
      let at = 0;
      loops.forEach((loop, i) => loop.forEach((v, k) => {
        for (const w of [v, loop[(k + 1) % loop.length]]) {
          points.set(positions.subarray(3 * w, 3 * w + 3), at);
          colors.set(i === 0 ? RIM : HOLE, at);
          at += 3;
        }
      }));
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new BufferAttribute(points, 3));
      geometry.setAttribute('color', new BufferAttribute(colors, 3));
      mesh.userData.borders = new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true }));
      mesh.userData.borders.frustumCulled = false;
      this.scene.add(mesh.userData.borders);
    }
    return mesh.userData.borders;
  }

  photoTexture(i) {
    if (!this.photos.has(i)) {
      this.photos.set(i, null);
      const image = new Image();
      image.onload = () => {
        const texture = new Texture(image);
        texture.colorSpace = ''; // the shader passes the values through
        texture.needsUpdate = true;
        this.photos.set(i, texture);
        this.request();
      };
      image.src = `data:image/jpeg;base64,${document.getElementById(`photo-${i}`).textContent}`;
    }
    return this.photos.get(i);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.request();
  }

  set(settings) {
    Object.assign(this.settings, settings);
    this.request();
  }

  request() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.draw();
    });
  }

  draw() {
    const stage = this.stage.getBoundingClientRect();
    this.renderer.setScissor(0, 0, stage.width, stage.height);
    this.renderer.clear();
    for (const pane of this.panes) {
      const box = pane.element.getBoundingClientRect();
      const left = Math.round(box.left - stage.left - this.stage.clientLeft), top = Math.round(box.top - stage.top - this.stage.clientTop);
      const width = Math.round(box.width), height = Math.round(box.height);
      const rect = { x: left, y: this.stage.clientHeight - top - height, width, height };
      if (pane.meshes.length === 1) {
        this.drawPane(pane, pane.meshes[0], rect, rect);
        continue;
      }
      const split = Math.round(rect.width * this.settings.wipe);
      this.drawPane(pane, pane.meshes[0], rect, { ...rect, width: split });
      this.drawPane(pane, pane.meshes[1], rect, { ...rect, x: rect.x + split, width: rect.width - split });
    }
    this.numFrames += 1;
  }

  drawPane(pane, meshIndex, view, scissor) {
    if (scissor.width < 1 || scissor.height < 1) return;
    const { style, wireframe, facets, borders, cameras, blend } = this.settings;
    const { camera } = this.rig;
    camera.updateMatrixWorld();
    const photoRect = this.rig.project(view.width, view.height);
    this.meshes.forEach((mesh, i) => {
      if (!mesh) return;
      mesh.visible = i === meshIndex;
      if (mesh.userData.lines) mesh.userData.lines.visible = mesh.visible && wireframe;
      if (mesh.userData.borders) mesh.userData.borders.visible = mesh.visible && borders;
      if (!mesh.visible) return;
      if (borders) this.bordersOf(mesh).visible = true;
      if (wireframe) this.linesOf(mesh).visible = true;
      const { uniforms } = mesh.material;
      uniforms.style.value = STYLES.indexOf(style);
      uniforms.facets.value = facets;
      uniforms.up.value = camera.up.clone().transformDirection(camera.matrixWorldInverse);
    });
    this.cameraLines.visible = cameras && this.rig.photo === null;
    this.chosenLines.visible = cameras && this.rig.photo === null;
    this.renderer.setViewport(view.x, view.y, view.width, view.height);
    this.renderer.setScissor(scissor.x, scissor.y, scissor.width, scissor.height);
    this.renderer.render(this.scene, camera);
    pane.viewMatrix = camera.matrixWorldInverse.toArray();
    if (photoRect && blend > 0 && this.report.photos[this.rig.photo].has_picture) this.drawPhoto(view, photoRect);
  }

  drawPhoto(view, rect) {
    const texture = this.photoTexture(this.rig.photo);
    if (!texture) return;
    const { uniforms } = this.photoQuad.material;
    uniforms.photo.value = texture;
    uniforms.opacity.value = this.settings.blend;
    this.renderer.setViewport(view.x + rect.x, view.y + rect.y, rect.width, rect.height);
    this.renderer.render(this.photoQuad, this.flatCamera);
  }

  // The photo whose drawn camera is near a place on the screen, or null.
  photoAt(clientX, clientY) {
    if (!this.settings.cameras || this.rig.photo !== null) return null;
    let best = null, bestDistance = 18;
    for (const pane of this.panes) {
      const box = pane.element.getBoundingClientRect();
      if (clientX < box.left || clientX > box.right || clientY < box.top || clientY > box.bottom) continue;
      this.rig.project(box.width, box.height);
      this.report.photos.forEach((_, i) => {
        const p = this.rig.photoCenter(i).project(this.rig.camera);
        if (p.z < -1 || p.z > 1) return;
        const distance = Math.hypot(box.left + ((p.x + 1) / 2) * box.width - clientX, box.top + ((1 - p.y) / 2) * box.height - clientY);
        if (distance < bestDistance) [best, bestDistance] = [i, distance];
      });
    }
    return best;
  }
}
