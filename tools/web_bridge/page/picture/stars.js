// Stars as the OpenGL renderer's CPU has them: each star's illuminance over its pixel's solid angle, shared between the
// four pixels whose centres surround it.

import * as THREE from "three";
import { floatsOf } from "./tables.js";

const VERTEX = `precision highp float;
in vec3 a_direction;
in vec3 a_illuminance;
uniform mat3 u_R_VC;      // V: x right, y up, looking along -z
uniform vec2 u_size_px;
uniform float u_focal_px;
flat out vec2 v_px;
flat out vec3 v_luminance;
void main() {
  vec3 d = u_R_VC * a_direction;
  v_px = 0.5 * u_size_px + u_focal_px * d.xy / -d.z;
  // A pixel at the angle a from the axis has the solid angle cos(a)^3 / focal^2.
  float cosine = -d.z / length(d);
  v_luminance = a_illuminance * (u_focal_px * u_focal_px / (cosine * cosine * cosine));
  gl_Position = d.z < -1e-3 ? vec4(2.0 * v_px / u_size_px - 1.0, 0.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = 2.0;
}`;
const FRAGMENT = `precision highp float;
flat in vec2 v_px;
flat in vec3 v_luminance;
out vec4 o_color;
void main() {
  vec2 share = max(1.0 - abs(gl_FragCoord.xy - v_px), 0.0);
  o_color = vec4(v_luminance * (share.x * share.y), 0.0);
}`;

const BRIGHTEST = 15000;  // while the camera turns

export class Stars {
  #scene = new THREE.Scene();

  constructor(bytes) {
    const buffer = new THREE.InterleavedBuffer(floatsOf(bytes), 6);
    this.geometry = new THREE.BufferGeometry();
    this.geometry.setAttribute("a_direction", new THREE.InterleavedBufferAttribute(buffer, 3, 0));
    this.geometry.setAttribute("a_illuminance", new THREE.InterleavedBufferAttribute(buffer, 3, 3));
    this.number = buffer.count;
    this.uniforms = { u_R_VC: { value: new THREE.Matrix3() }, u_size_px: { value: new THREE.Vector2() },
      u_focal_px: { value: 1 } };
    const points = new THREE.Points(this.geometry, new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3,
      vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: this.uniforms, depthTest: false, depthWrite: false,
      transparent: true, blending: THREE.CustomBlending, blendSrc: THREE.OneFactor, blendDst: THREE.OneFactor }));
    points.frustumCulled = false;
    this.#scene.add(points);
  }

  // `R_VC`: from the celestial frame to the camera's.
  draw(renderer, target, { R_VC, focal_px, isTurning }) {
    this.uniforms.u_R_VC.value.copy(R_VC);
    this.uniforms.u_size_px.value.set(target.width, target.height);
    this.uniforms.u_focal_px.value = focal_px;
    this.geometry.setDrawRange(0, isTurning ? BRIGHTEST : this.number);
    renderer.setRenderTarget(target);
    renderer.clear(true, false, false);
    renderer.render(this.#scene, new THREE.Camera());
  }
}
