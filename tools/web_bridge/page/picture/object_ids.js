// Which object is seen at each pixel: its index + 1; 0: none.

import * as THREE from "three";

const VERTEX = `precision highp float;
in vec3 a_p_M;
uniform mat4 modelMatrix, u_clip_W;
void main() { gl_Position = u_clip_W * (modelMatrix * vec4(a_p_M, 1.0)); }`;
const FRAGMENT = `precision highp float;
uniform float u_id;
out vec4 o_color;
void main() { o_color = vec4(mod(u_id, 256.0) / 255.0, floor(u_id / 256.0) / 255.0, 0.0, 1.0); }`;

export class ObjectIds {
  constructor() {
    this.uniforms = { u_clip_W: { value: new THREE.Matrix4() }, u_id: { value: 0 } };
    this.material = new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3, vertexShader: VERTEX, fragmentShader: FRAGMENT,
      uniforms: this.uniforms, side: THREE.DoubleSide });
  }

  // Of the rectangle, row by row from its lower end. Transparent objects count.
  read(renderer, bodies, camera, { width, height }, { x, y, w, h }) {
    const target = new THREE.WebGLRenderTarget(width, height, { minFilter: THREE.NearestFilter,
      magFilter: THREE.NearestFilter });
    const all = [...bodies.instances.flatMap(({ parts }) => parts.map(({ drawn }) => drawn)),
      ...bodies.sheets.map(({ drawn }) => drawn)];
    const hidden = bodies.instances.filter(({ isShown, group }) => isShown && !group.visible);
    for (const { group } of hidden) group.visible = true;
    for (const drawn of all) {
      drawn.onBeforeRender = () => {
        this.uniforms.u_id.value = drawn.userData.id;
        this.material.uniformsNeedUpdate = true;
      };
    }
    this.uniforms.u_clip_W.value.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    renderer.setRenderTarget(target);
    renderer.clear();
    bodies.scene.overrideMaterial = this.material;
    renderer.render(bodies.scene, camera);
    bodies.scene.overrideMaterial = null;
    const pixels = new Uint8Array(4 * w * h);
    renderer.readRenderTargetPixels(target, x, y, w, h, pixels);
    for (const drawn of all) drawn.onBeforeRender = () => {};
    for (const { group } of hidden) group.visible = false;
    target.dispose();
    return Uint16Array.from({ length: w * h }, (_, i) => pixels[4 * i] + 256 * pixels[4 * i + 1]);
  }
}
