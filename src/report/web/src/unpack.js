// Reads the packed meshes; the format is described in src/report/mesh_packing.h.

function bytesOfBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function readAxis(bytes, offset, count, step, origin, out, axis) {
  let value = 0;
  for (let v = 0; v < count; ++v) {
    const difference = bytes[offset + v] | (bytes[offset + count + v] << 8) | (bytes[offset + 2 * count + v] << 16);
    value = (value + difference) & 0xffffff;
    out[3 * v + axis] = origin + value * step;
  }
}

function readPlane(bytes, offset, count, out, stride, start) {
  let value = 0;
  for (let v = 0; v < count; ++v) {
    value = (value + bytes[offset + v]) & 255;
    out[stride * v + start] = value;
  }
}

// Texture coordinates of the corners, u and v.
function readTexcoords(bytes, offset, count) {
  const texcoords = new Float32Array(2 * count);
  for (let axis = 0; axis < 2; ++axis, offset += 2 * count) {
    let value = 0;
    for (let i = 0; i < count; ++i) {
      value = (value + (bytes[offset + i] | (bytes[offset + count + i] << 8))) & 0xffff;
      texcoords[2 * i + axis] = value / 65535;
    }
  }
  return texcoords;
}

function readFaces(bytes, offset, count) {
  const indices = new Uint32Array(count);
  let last = 0;
  for (let i = 0; i < count; ++i) {
    let code = 0, shift = 0, byte = 0;
    do {
      byte = bytes[offset++];
      code |= (byte & 127) << shift;
      shift += 7;
    } while (byte & 128);
    last += (code >>> 1) ^ -(code & 1);
    indices[i] = last;
  }
  return { indices, end: offset };
}

// Area-weighted vertex normals.
function computeNormals(positions, indices) {
  const normals = new Float32Array(positions.length);
  const p = positions;
  for (let i = 0; i < indices.length; i += 3) {
    const a = 3 * indices[i], b = 3 * indices[i + 1], c = 3 * indices[i + 2];
    const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
    const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    for (const k of [a, b, c]) {
      normals[k] += nx;
      normals[k + 1] += ny;
      normals[k + 2] += nz;
    }
  }
  return normals;
}

const pause = () => new Promise((resolve) => setTimeout(resolve));

// Typed arrays of a mesh: positions (relative to `center`), normals, indices; colors (RGB), errors and texcoords (u, v of each
// corner, v down) or null.
export async function unpackMesh(element, packed, center) {
  const bytes = await inflate(bytesOfBase64(element.textContent));
  element.remove();
  await pause();
  const n = packed.vertices;
  const positions = new Float32Array(3 * n);
  for (let axis = 0; axis < 3; ++axis) {
    readAxis(bytes, 3 * n * axis, n, packed.step, packed.origin[axis] - center[axis], positions, axis);
  }
  let offset = 9 * n;
  let colors = null, errors = null;
  if (packed.colors) {
    colors = new Uint8Array(3 * n);
    for (let k = 0; k < 3; ++k, offset += n) readPlane(bytes, offset, n, colors, 3, k);
  }
  if (packed.errors) {
    errors = new Uint8Array(n);
    readPlane(bytes, offset, n, errors, 1, 0);
    offset += n;
  }
  await pause();
  const { indices, end } = readFaces(bytes, offset, 3 * packed.faces);
  await pause();
  const texcoords = packed.texture ? readTexcoords(bytes, end, 3 * packed.faces) : null;
  return { positions, indices, colors, errors, texcoords, normals: computeNormals(positions, indices) };
}
