// Materials: the OpenGL renderer's surface shader, a variant for each kind of surface.

import * as THREE from "three";
import { toEs } from "./glsl.js";
import { tableTexture, tiledTexture } from "./tables.js";

const MAX_LAMPS = 4;
const vectors = (number, Vector) => Array.from({ length: number }, () => new Vector());

// Constants of the light panels, as surface_painter.cpp has them.
function panelsText(panels) {
  const numbers = (...values) => values.map((value) => value.toFixed(7)).join(",");
  return [0, 1].map((k) => {
    const [x, y, z, strength, outer, inner] = panels.slice(6 * k, 6 * k + 6);
    return `const vec4 kPanel${k} = vec4(${numbers(x, y, z, strength)});\n` +
      `const vec2 kPanelEdge${k} = vec2(${numbers(outer, inner)});\n`;
  }).join("");
}

// Where a body is, for the shaders: relative to the eye (E, with the axes of W), to the picture, to the shadow map.
export class Place {
  uniforms = { u_X_EM: { value: new THREE.Matrix4() }, u_clip_M: { value: new THREE.Matrix4() },
    u_sun_M: { value: new THREE.Matrix4() } };

  set(X_WM, { eye_W, clip_W, sun_W }) {
    const { u_X_EM, u_clip_M, u_sun_M } = this.uniforms;
    u_X_EM.value.copy(X_WM);
    for (const k of [0, 1, 2]) u_X_EM.value.elements[12 + k] -= eye_W.getComponent(k);
    u_clip_M.value.multiplyMatrices(clip_W, X_WM);
    u_sun_M.value.multiplyMatrices(sun_W, X_WM);
  }
}

export class Surfaces {
  constructor(assets, shaders) {
    this.shaders = shaders;
    // What all surfaces of a picture have in common.
    this.common = {
      u_shadow_offset_m: { value: 0 },
      u_sun_direction_W: { value: new THREE.Vector3() }, u_lamp_position: { value: vectors(MAX_LAMPS, THREE.Vector4) },
      u_lamp_color: { value: vectors(MAX_LAMPS, THREE.Vector3) }, u_num_lamps: { value: 0 },
      u_earth_W: { value: new THREE.Vector4() }, u_sun: { value: new THREE.Vector3() },
      u_earth: { value: new THREE.Vector3() }, u_panels: { value: new THREE.Vector3() },
      u_everywhere: { value: new THREE.Vector3() }, u_irradiance: { value: vectors(9, THREE.Vector3) },
      u_shadow: { value: null }, u_shadow_of_static: { value: null }, u_split_sum: { value: tableTexture(assets.splitSum) },
      u_wrinkles: { value: tiledTexture(assets.wrinkles) },
    };
    this.head = shaders.irradiance + panelsText(assets.panels);
    this.sun_W = new THREE.Matrix4();  // of the shadow map
    this.lamps = [];
  }

  setLight(sky) {
    const { common } = this;
    common.u_sun_direction_W.value.fromArray(sky.sunDirection);
    common.u_earth_W.value.fromArray(sky.earthDirectionSine);
    common.u_sun.value.fromArray(sky.sun);
    common.u_earth.value.fromArray(sky.earthLight);
    common.u_panels.value.fromArray(sky.panels);
    common.u_everywhere.value.fromArray(sky.everywhere);
    common.u_irradiance.value.forEach((term, i) => term.fromArray(sky.irradiance, 3 * i));
  }

  // Before each picture. Of each lamp: centre (Vector3, W), reach [m], colour.
  place(eye_W, lamps) {
    const shining = lamps.slice(0, MAX_LAMPS);
    shining.forEach(({ centre, reach, color }, i) => {
      this.common.u_lamp_position.value[i].set(centre.x - eye_W.x, centre.y - eye_W.y, centre.z - eye_W.z, reach);
      this.common.u_lamp_color.value[i].fromArray(color);
    });
    this.common.u_num_lamps.value = shining.length;
  }

  // A material for a surface of a body in its place, with the textures of a mesh's part if it shows its own.
  make(surface, place, part = {}, textures = []) {
    const textureOf = (index) => (surface.isFoil ? undefined : textures[index - 1]);
    const maps = { BASE_MAP: textureOf(part.baseTexture), SURFACE_MAP: textureOf(part.surfaceTexture),
      NORMAL_MAP: textureOf(part.normalTexture), GLOW_MAP: textureOf(part.emissiveTexture) };
    const defines = Object.keys(maps).filter((name) => maps[name]);
    if (surface.isFoil) defines.push("FOIL");
    if (surface.coat > 0 && !surface.isFoil) defines.push("COAT");
    const material = new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3,
      vertexShader: toEs(this.head + this.shaders.surface_vertex, { defines }),
      fragmentShader: toEs(this.head + this.shaders.surface_fragment, { defines }),
      side: part.isTwoSided === false ? THREE.FrontSide : THREE.DoubleSide,
      uniforms: { ...this.common, ...place.uniforms, u_base_metallic: { value: new THREE.Vector4() },
        u_emissive_roughness: { value: new THREE.Vector4() }, u_occlusion: { value: part.hasOcclusion ? 1 : 0 },
        u_base_map: { value: maps.BASE_MAP }, u_surface_map: { value: maps.SURFACE_MAP },
        u_normal_map: { value: maps.NORMAL_MAP }, u_glow_map: { value: maps.GLOW_MAP },
        u_coat: { value: new THREE.Vector2(surface.coat, surface.coatRoughness) } } });
    setSurface(material, surface);
    return material;
  }
}

// `added`: emitted besides.
export function setSurface(material, { baseColor, metallic, emissive, roughness }, added = [0, 0, 0]) {
  material.uniforms.u_base_metallic.value.set(...baseColor, metallic);
  material.uniforms.u_emissive_roughness.value.set(...emissive.map((value, i) => value + added[i]), roughness);
}
