// Another camera's picture in the lower right corner of the canvas, above the caption: as the OpenGL viewer's camera_feed.cpp.

import * as THREE from "three";
import { Film } from "./film.js";
import { FullScreen } from "./full_screen.js";
import { toEs } from "./glsl.js";

const PERIOD_MS = 200, FRAME = 0x8c9eb3;

const FRAGMENT = `precision highp float;
uniform sampler2D u_picture;
uniform vec2 u_corner;  // where its first pixel goes
out vec4 o_color;
void main() { o_color = texelFetch(u_picture, ivec2(gl_FragCoord.xy - u_corner), 0); }`;

export class Inset {
  #takenMs = -Infinity;

  constructor(shaders) {
    this.film = new Film(shaders);
    this.paste = new FullScreen({ vertex: toEs(shaders.film_vertex), fragment: FRAGMENT,
      uniforms: { u_picture: { value: null }, u_corner: { value: new THREE.Vector2() } } });
  }

  isOld({ width, height }) {
    return this.picture?.width !== width || this.picture.height !== height || performance.now() - this.#takenMs >= PERIOD_MS;
  }

  // What the film has now.
  take(renderer, { width, height }) {
    this.#takenMs = performance.now();
    if (this.picture?.width !== width || this.picture.height !== height) {
      this.picture?.dispose();
      this.picture = new THREE.WebGLRenderTarget(width, height, { depthBuffer: false, minFilter: THREE.NearestFilter,
        magFilter: THREE.NearestFilter });
      this.paste.uniforms.u_picture.value = this.picture.texture;
    }
    this.film.show(renderer, this.picture);
  }

  show(renderer, { width, height }) {
    const margin = Math.floor(height / 36), frame = Math.max(1, Math.floor(height / 360));
    const x = width - margin - this.picture.width, y = Math.floor(height / 5);
    renderer.setRenderTarget(null);
    renderer.setScissorTest(true);
    renderer.setScissor(x - frame, y - frame, this.picture.width + 2 * frame, this.picture.height + 2 * frame);
    renderer.setClearColor(FRAME, 1);
    renderer.clear(true, false, false);
    renderer.setClearColor(0x000000, 0);
    renderer.setScissor(x, y, this.picture.width, this.picture.height);
    this.paste.uniforms.u_corner.value.set(x, y);
    this.paste.draw(renderer, null);
    renderer.setScissorTest(false);
  }
}
