import { Matrix4, PerspectiveCamera, Vector3 } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

// The one camera of all views: free, or held at the pose of a photo with that photo's own projection.
export class Rig {
  // World coordinates are relative to report.focus.
  constructor(element, report, onChange) {
    this.report = report;
    this.element = element;
    this.onChange = onChange;
    this.photo = null; // index while held
    this.camera = new PerspectiveCamera(45, 1, 0.01, 100);
    this.camera.up.set(...report.up).normalize();
    this.controls = new OrbitControls(this.camera, element);
    this.controls.enableDamping = false;
    this.controls.zoomToCursor = false;
    this.controls.addEventListener('start', () => this.release());
    this.controls.addEventListener('change', onChange);
    this.overview();
  }

  photoCenter(i) {
    const { rotation: r, translation: t } = this.report.photos[i];
    const f = this.report.focus;
    return new Vector3(...[0, 1, 2].map((k) => -(r[k] * t[0] + r[3 + k] * t[1] + r[6 + k] * t[2]) - f[k]));
  }

  // Sets the camera's pose to the photo's; three's cameras look along -z with y up.
  hold(i) {
    const r = this.report.photos[i].rotation;
    const c = this.photoCenter(i);
    this.photo = i;
    this.camera.position.copy(c);
    this.camera.quaternion.setFromRotationMatrix(new Matrix4().set(
      r[0], -r[3], -r[6], 0,
      r[1], -r[4], -r[7], 0,
      r[2], -r[5], -r[8], 0,
      0, 0, 0, 1));
    this.camera.updateMatrixWorld();
    this.onChange();
  }

  // From a photo's pose to free movement from there.
  release() {
    if (this.photo === null) return;
    const photo = this.report.photos[this.photo];
    this.photo = null;
    this.camera.fov = (2 * Math.atan(photo.height / 2 / photo.fy) * 180) / Math.PI;
    const forward = new Vector3(0, 0, -1).applyQuaternion(this.camera.quaternion);
    const distance = Math.max(-this.camera.position.dot(forward), 0.2 * this.report.radius);
    this.controls.target.copy(this.camera.position).addScaledVector(forward, distance);
    this.controls.update();
    this.onChange();
  }

  // Everything worth seeing, from the side of the photos and a little above; with the cameras from farther away.
  overview(withCameras = false) {
    this.photo = null;
    const { photos } = this.report;
    let { radius } = this.report;
    if (withCameras) photos.forEach((_, i) => { radius = Math.max(radius, 1.1 * this.photoCenter(i).length()); });
    const up = this.camera.up;
    const direction = new Vector3();
    photos.forEach((_, i) => direction.add(this.photoCenter(i)));
    direction.addScaledVector(up, -direction.dot(up));
    if (direction.length() < 1e-6) direction.set(up.y, up.z, up.x).addScaledVector(up, -(up.x * up.y + up.y * up.z + up.z * up.x));
    direction.normalize().addScaledVector(up, 0.35).normalize();
    this.camera.fov = 40;
    this.controls.target.set(0, 0, 0);
    this.camera.position.copy(direction.multiplyScalar((1.15 * radius) / Math.sin((20 * Math.PI) / 180)));
    this.controls.update();
    this.onChange();
  }

  turn(azimuth, elevation) {
    this.release();
    const up = this.camera.up;
    const offset = this.camera.position.clone().sub(this.controls.target).applyAxisAngle(up, azimuth);
    const side = new Vector3().crossVectors(up, offset).normalize();
    const angle = offset.angleTo(up);
    const limited = Math.min(Math.max(angle - elevation, 0.05), Math.PI - 0.05);
    offset.applyAxisAngle(side, limited - angle);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
  }

  // In shares of the distance.
  move(right, up) {
    this.release();
    const distance = this.camera.position.distanceTo(this.controls.target);
    const shift = new Vector3(right * distance, up * distance, 0).applyQuaternion(this.camera.quaternion);
    this.camera.position.add(shift);
    this.controls.target.add(shift);
    this.controls.update();
  }

  zoom(factor) {
    this.release();
    const { position } = this.camera;
    position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
  }

  // Points the projection at a pane of this size. Held at a photo the whole photo fits into the pane; returns its place there.
  project(width, height) {
    const camera = this.camera;
    const distance = camera.position.length();
    const near = Math.max(distance - 60 * this.report.radius, this.report.radius / 500);
    const far = distance + 200 * this.report.radius;
    if (this.photo === null) {
      // Narrow panes see as much sideways as square ones.
      const vertical = Math.tan((camera.fov * Math.PI) / 360) * Math.max(1, height / width);
      const horizontal = (vertical * width) / height;
      camera.projectionMatrix.makePerspective(-horizontal * near, horizontal * near, vertical * near, -vertical * near, near, far);
      camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
      return null;
    }
    const p = this.report.photos[this.photo];
    const scale = Math.min(width / p.width, height / p.height);
    const marginX = (width / scale - p.width) / 2, marginY = (height / scale - p.height) / 2;
    camera.projectionMatrix.makePerspective(
      (near * (-marginX - p.cx)) / p.fx, (near * (p.width + marginX - p.cx)) / p.fx,
      (near * (p.cy + marginY)) / p.fy, (near * (p.cy - p.height - marginY)) / p.fy, near, far);
    camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
    return { x: marginX * scale, y: marginY * scale, width: p.width * scale, height: p.height * scale };
  }
}
