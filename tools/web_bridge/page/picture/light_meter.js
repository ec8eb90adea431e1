// The exposure of what is shown adapts, as an eye does, towards a mean luminance.

import * as THREE from "three";
import { FullScreen } from "./full_screen.js";
import { toEs } from "./glsl.js";

const WIDTH = 32, HEIGHT = 18;  // with 16 samples each

export class LightMeter {
  #pixels = new Float32Array(4 * WIDTH * HEIGHT);

  constructor(shaders, [daylight, least, most, grey, timeConstantS]) {
    Object.assign(this, { daylight, least, most, grey, timeConstantS });
    this.meter = new FullScreen({ vertex: toEs(shaders.film_vertex), fragment: toEs(shaders.meter_fragment),
      uniforms: { u_light: { value: null }, u_cell_px: { value: new THREE.Vector2() } } });
    this.target = new THREE.WebGLRenderTarget(WIDTH, HEIGHT, { type: THREE.FloatType, depthBuffer: false });
  }

  // The exposure after `dtS` seconds of this light. Waits for the picture.
  adapt(renderer, film, exposure, dtS) {
    this.meter.uniforms.u_light.value = film.light.texture;
    this.meter.uniforms.u_cell_px.value.set(film.width / WIDTH, film.height / HEIGHT);
    this.meter.draw(renderer, this.target);
    renderer.readRenderTargetPixels(this.target, 0, 0, WIDTH, HEIGHT, this.#pixels);
    let sum = 0, number = 0;
    for (let i = 0; i < this.#pixels.length; i += 4) {
      sum += this.#pixels[i];
      number += this.#pixels[i + 1];
    }
    if (number === 0) return exposure;
    const wanted = Math.min(this.most, Math.max(this.least, this.grey / 2 ** (sum / number)));
    return exposure * (wanted / exposure) ** (1 - Math.exp(-dtS / this.timeConstantS));
  }
}
