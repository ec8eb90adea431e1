// Tables and pictures of the assets as textures.

import * as THREE from "three";

// Floats of protobuf's bytes, which need not lie at a multiple of four.
export const floatsOf = (bytes) => new Float32Array(bytes.slice().buffer);
export const indicesOf = (bytes) => new Uint32Array(bytes.slice().buffer);

const FORMATS = { 1: THREE.RedFormat, 2: THREE.RGFormat, 4: THREE.RGBAFormat };

function asTexture(values, width, height, numChannels, type) {
  const texture = new THREE.DataTexture(values, width, height, FORMATS[numChannels], type);
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.unpackAlignment = 1;
  texture.needsUpdate = true;
  return texture;
}

// WebGL has no textures of three floats that are filtered.
function withFourth(values) {
  const wide = new Float32Array(values.length / 3 * 4).fill(1);
  for (let i = 0; i < values.length; ++i) wide[Math.floor(i / 3) * 4 + i % 3] = values[i];
  return wide;
}

export function tableTexture(table) {
  const { width, height, numChannels } = table;
  if (table.hasBytes) return asTexture(table.values, width, height, numChannels, THREE.UnsignedByteType);
  const values = floatsOf(table.values);
  if (numChannels !== 3) return asTexture(values, width, height, numChannels, THREE.FloatType);
  return asTexture(withFourth(values), width, height, 4, THREE.FloatType);
}

// Noise in a cube that repeats.
export function cubeOfNoise({ width, values, numChannels }) {
  const texture = new THREE.Data3DTexture(values, width, width, width);
  texture.format = FORMATS[numChannels];
  texture.type = THREE.UnsignedByteType;
  texture.minFilter = THREE.LinearMipmapLinearFilter;
  texture.magFilter = THREE.LinearFilter;
  texture.wrapS = texture.wrapT = texture.wrapR = THREE.RepeatWrapping;
  texture.generateMipmaps = true;
  texture.unpackAlignment = 1;
  texture.needsUpdate = true;
  return texture;
}

// Repeats, and has smaller levels for what is far away.
export function tiledTexture(table) {
  const texture = tableTexture(table);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.minFilter = THREE.LinearMipmapNearestFilter;
  texture.generateMipmaps = true;
  return texture;
}

export function pictureTexture({ width, height, rgba, isColor }) {
  const texture = tiledTexture({ width, height, numChannels: 4, values: rgba, hasBytes: true });
  texture.colorSpace = isColor ? THREE.SRGBColorSpace : THREE.NoColorSpace;
  return texture;
}

// Linear reflectance times the share of land, so that filtering mixes no colour of water into a coast.
export function landTexture({ width, height, values }) {
  const linear = Uint16Array.from({ length: 256 }, (_, code) => {
    const c = code / 255;
    return THREE.DataUtils.toHalfFloat(c > 0.04045 ? ((c + 0.055) / 1.055) ** 2.4 : c / 12.92);
  });
  const one = THREE.DataUtils.toHalfFloat(1);
  const land = new Uint16Array(values.length);
  for (let i = 0; i < values.length; i += 4) {
    if (values[i + 3] === 0) continue;
    for (let k = 0; k < 3; ++k) land[i + k] = linear[values[i + k]];
    land[i + 3] = one;
  }
  const texture = asTexture(land, width, height, 4, THREE.HalfFloatType);
  texture.wrapS = THREE.RepeatWrapping;
  return texture;
}
