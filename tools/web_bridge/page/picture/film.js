// Light becomes a picture: exposure, tone curve, sRGB, smooth edges, by the OpenGL renderer's shaders.

import * as THREE from "three";
import { FullScreen } from "./full_screen.js";
import { toEs } from "./glsl.js";

const targetOf = (width, height, more) => new THREE.WebGLRenderTarget(width, height,
  { minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter, generateMipmaps: false, ...more });

export class Film {
  exposure = 1;
  width = 0;
  height = 0;

  constructor(shaders) {
    const vertex = toEs(shaders.film_vertex);
    this.develop = new FullScreen({ vertex, fragment: toEs(shaders.tone_curve + shaders.develop_fragment),
      uniforms: { u_light: { value: null }, u_exposure: { value: 1 } } });
    this.smooth = new FullScreen({ vertex, fragment: toEs(shaders.smooth_fragment),
      uniforms: { u_picture: { value: null }, u_texel: { value: new THREE.Vector2() } } });
  }

  resize(width, height) {
    if (width === this.width && height === this.height) return;
    Object.assign(this, { width, height });
    for (const one of [this.light, this.developed]) one?.dispose();
    this.light?.depthTexture.dispose();
    this.light = targetOf(width, height, { type: THREE.HalfFloatType, depthBuffer: true });
    this.light.depthTexture = new THREE.DepthTexture(width, height, THREE.UnsignedIntType);
    this.developed = targetOf(width, height, { depthBuffer: false, minFilter: THREE.LinearFilter,
      magFilter: THREE.LinearFilter });
    this.develop.uniforms.u_light.value = this.light.texture;
    this.smooth.uniforms.u_picture.value = this.developed.texture;
    this.smooth.uniforms.u_texel.value.set(1 / width, 1 / height);
  }

  finish(renderer) {
    this.develop.uniforms.u_exposure.value = this.exposure;
    this.develop.draw(renderer, this.developed);
  }

  // Into all of a target: null is the canvas.
  show(renderer, target) { this.smooth.draw(renderer, target); }
}
