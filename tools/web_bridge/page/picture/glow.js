// A lamp's glow: a square that faces the eye, added to what is behind it.

import * as THREE from "three";

const VERTEX = `precision highp float;
in vec3 position;
uniform mat4 u_clip_W;
uniform vec3 u_centre_W, u_right_W, u_up_W;  // half width
out vec2 v_uv;
void main() {
  v_uv = position.xy;
  gl_Position = u_clip_W * vec4(u_centre_W + v_uv.x * u_right_W + v_uv.y * u_up_W, 1.0);
}`;
const FRAGMENT = `precision highp float;
uniform vec3 u_color;
in vec2 v_uv;
out vec4 o_color;
void main() {
  float d = max(0.0, 1.0 - dot(v_uv, v_uv));
  o_color = vec4(u_color * (0.25 * d * d * d), 0.0);
}`;

export class Glow {
  scene = new THREE.Scene();
  #pool = [];
  #square = new THREE.PlaneGeometry(2, 2);

  prepare(frame, bodies, camera) {
    const eye = new THREE.Vector3().setFromMatrixPosition(camera.matrixWorld);
    const clip = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    const axis = (k) => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, k);
    const shown = frame.lamps.filter(({ instance }) => bodies.instances[instance].isShown);
    shown.forEach(({ instance, color }, i) => {
      const { centre, mesh } = bodies.instances[instance];
      const { radius } = mesh.sphere;
      const { uniforms } = (this.#pool[i] ??= this.#make()).material;
      uniforms.u_clip_W.value.copy(clip);
      // In front of the lamp, so that only other objects hide it.
      uniforms.u_centre_W.value.copy(centre).addScaledVector(eye.clone().sub(centre).normalize(), 1.2 * radius);
      uniforms.u_right_W.value.copy(axis(0)).multiplyScalar(3.2 * radius);
      uniforms.u_up_W.value.copy(axis(1)).multiplyScalar(3.2 * radius);
      uniforms.u_color.value.fromArray(color);
    });
    this.#pool.forEach((mesh, i) => { mesh.visible = i < shown.length; });
  }

  #make() {
    const uniforms = { u_clip_W: { value: new THREE.Matrix4() }, u_centre_W: { value: new THREE.Vector3() },
      u_right_W: { value: new THREE.Vector3() }, u_up_W: { value: new THREE.Vector3() },
      u_color: { value: new THREE.Vector3() } };
    const mesh = new THREE.Mesh(this.#square, new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3, vertexShader: VERTEX,
      fragmentShader: FRAGMENT, uniforms, transparent: true, depthWrite: false, blending: THREE.CustomBlending,
      blendSrc: THREE.OneFactor, blendDst: THREE.OneFactor }));
    mesh.frustumCulled = false;
    this.scene.add(mesh);
    return mesh;
  }
}
