import { DataTexture, DoubleSide, RGBAFormat, ShaderMaterial, UnsignedByteType, GLSL3 } from 'three';
import { errorColor, UNKNOWN } from './colors.js';

function errorTexture() {
  const data = new Uint8Array(256 * 4);
  for (let i = 0; i < 256; ++i) data.set([...(i === 255 ? UNKNOWN : errorColor(i / 254)), 255], 4 * i);
  const texture = new DataTexture(data, 256, 1, RGBAFormat, UnsignedByteType);
  texture.needsUpdate = true;
  return texture;
}

const VERTEX = `
in vec3 rgb;
in float error;
in vec2 texcoord;
out vec2 vTexcoord;
out vec3 inCam;
out vec3 vNormal;
out vec3 vColor;
out float vError;
void main() {
  vec4 x = modelViewMatrix * vec4(position, 1.0);
  inCam = x.xyz;
  vNormal = mat3(modelViewMatrix) * normal;
  vColor = rgb;
  vError = error;
  vTexcoord = texcoord;
  gl_Position = projectionMatrix * x;
}`;

// The same light as the pictures of mesh_renderer, without soft shadows: sky, and a key light over the left shoulder.
const FRAGMENT = `
in vec3 inCam;
in vec3 vNormal;
in vec3 vColor;
in float vError;
in vec2 vTexcoord;
uniform int style;
uniform bool facets;
uniform bool hasColor;
uniform bool hasError;
uniform vec3 up;
uniform sampler2D errorColors;
uniform bool hasPage;
uniform sampler2D page;
out vec4 result;
vec3 toLinear(vec3 c) { return pow(c, vec3(2.2)); }
void main() {
  vec3 flatNormal = normalize(cross(dFdx(inCam), dFdy(inCam)));
  if (dot(flatNormal, inCam) > 0.0) flatNormal = -flatNormal;
  vec3 n = facets || dot(vNormal, vNormal) == 0.0 ? flatNormal : normalize(vNormal);
  if (dot(n, flatNormal) < 0.0) n = -n; // the side that is seen, also where the smooth normal turns away
  if (style == 2) { result = vec4(0.5 + 0.5 * n, 1.0); return; }
  float key = max(0.0, dot(n, normalize(vec3(-0.5, 0.75, 0.85))));
  float light = 0.50 * (0.75 + 0.25 * dot(n, up)) + 0.86 * key;
  vec3 albedo = vec3(0.55, 0.52, 0.48);
  if (style == 1 && hasPage) { result = vec4(texture(page, vTexcoord).rgb, 1.0); return; } // as the photos show it
  if (style == 1 && hasColor) { albedo = toLinear(vColor); light = mix(1.0, light, 0.35); }
  if (style == 3) {
    albedo = vec3(0.3);
    if (hasError) albedo = toLinear(texture(errorColors, vec2((vError * 255.0 + 0.5) / 256.0, 0.5)).rgb);
    light = mix(1.0, light, 0.4);
  }
  result = vec4(pow(min(albedo * light, 1.0), vec3(1.0 / 2.2)), 1.0);
}`;

let sharedTexture = null;

export function meshMaterial(hasColor, hasError) {
  sharedTexture ??= errorTexture();
  return new ShaderMaterial({
    glslVersion: GLSL3,
    side: DoubleSide,
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    uniforms: {
      style: { value: 0 },
      facets: { value: false },
      hasColor: { value: hasColor },
      hasError: { value: hasError },
      up: { value: null },
      errorColors: { value: sharedTexture },
      hasPage: { value: false },
      page: { value: sharedTexture },
    },
  });
}
