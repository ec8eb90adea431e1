// Depth as seen from the sun, in two maps: of static casters, drawn once, and of moving ones, when something has moved.

import * as THREE from "three";
import { MOVABLE, STATIC } from "./bodies.js";

const SIZE = 1024;  // texels per side, as the OpenGL renderer has
const SAME_SUN = 1 - 3.8e-7;  // cosine: a tenth of the sun's width

const VERTEX = `precision highp float;
in vec3 a_p_M;
uniform mat4 modelMatrix, u_sun_W;
void main() {
  gl_Position = u_sun_W * (modelMatrix * vec4(a_p_M, 1.0));
  gl_Position.z = max(gl_Position.z, -1.0);  // what is nearer to the sun than the map begins casts its shadow all the same
}`;
const FRAGMENT = "precision highp float;\nout vec4 o_color;\nvoid main() { o_color = vec4(0.0); }";

function makeTarget() {
  const target = new THREE.WebGLRenderTarget(SIZE, SIZE, { depthBuffer: true });
  target.depthTexture = new THREE.DepthTexture(SIZE, SIZE, THREE.UnsignedIntType);
  target.depthTexture.compareFunction = THREE.LessEqualCompare;
  target.depthTexture.minFilter = target.depthTexture.magFilter = THREE.NearestFilter;
  return target;
}

export class ShadowMap {
  #sun = new THREE.Vector3(); #casters = ""; #version = -1; #moving = makeTarget(); #fixed = makeTarget();
  #eye = new THREE.OrthographicCamera(-1, 1, 1, -1, 1, 3);

  constructor(surfaces) {
    this.common = surfaces.common;
    this.sun_W = surfaces.sun_W;
    this.material = new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3, vertexShader: VERTEX, fragmentShader: FRAGMENT,
      uniforms: { u_sun_W: { value: this.sun_W } }, side: THREE.DoubleSide, colorWrite: false, polygonOffset: true, polygonOffsetFactor: 1.5,
      polygonOffsetUnits: 2 });
    this.common.u_shadow.value = this.#moving.depthTexture;
    this.common.u_shadow_of_static.value = this.#fixed.depthTexture;
  }

  // Fits the map to the sphere around the box of all objects, 10 % larger so that they can move.
  #fit(bodies, sun) {
    this.#sun.copy(sun);
    this.#casters = "";
    const box = bodies.box();
    const centre = box.getCenter(new THREE.Vector3());
    const radius = Math.max(0.05, 0.55 * box.getSize(new THREE.Vector3()).length());
    const eye = this.#eye;
    eye.left = eye.bottom = -radius;
    eye.right = eye.top = radius;
    eye.near = radius;
    eye.far = 3 * radius;
    eye.up.set(...(Math.abs(sun.z) > 0.999 ? [0, 1, 0] : [0, 0, 1]));
    eye.position.copy(centre).addScaledVector(sun, 2 * radius);
    eye.lookAt(centre);
    eye.updateProjectionMatrix();
    eye.updateMatrixWorld();
    this.sun_W.multiplyMatrices(eye.projectionMatrix, eye.matrixWorldInverse);
    this.common.u_shadow_offset_m.value = 1.5 * 2 * radius / SIZE;
  }

  update(renderer, bodies) {
    const sun = this.common.u_sun_direction_W.value;
    if (this.#casters === "" || sun.dot(this.#sun) < SAME_SUN) this.#fit(bodies, sun);
    const casters = bodies.instances.map(({ group }) => Number(group.visible)).join("");
    if (casters === this.#casters && bodies.version === this.#version) return;
    this.#version = bodies.version;
    if (casters !== this.#casters) {
      this.#casters = casters;
      this.#draw(renderer, bodies, STATIC, this.#fixed);
    }
    this.#draw(renderer, bodies, MOVABLE, this.#moving);
  }

  #draw(renderer, bodies, layer, target) {
    renderer.setRenderTarget(target);
    renderer.clear(false, true, false);
    this.#eye.layers.set(layer);
    bodies.scene.overrideMaterial = this.material;
    renderer.render(bodies.scene, this.#eye);
    bodies.scene.overrideMaterial = null;
  }
}
