// A triangle that covers a target, for shaders that make their corners from gl_VertexID.

import * as THREE from "three";

const NOWHERE = new THREE.Camera();

const geometry = new THREE.BufferGeometry();
geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(9), 3));

export class FullScreen {
  #scene = new THREE.Scene();

  constructor({ vertex, fragment, uniforms, ...more }) {
    this.uniforms = uniforms;
    this.material = new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3, vertexShader: vertex, fragmentShader: fragment,
      uniforms, depthTest: false, depthWrite: false, ...more });
    this.mesh = new THREE.Mesh(geometry, this.material);
    this.mesh.frustumCulled = false;
    this.#scene.add(this.mesh);
  }

  draw(renderer, target) {
    renderer.setRenderTarget(target);
    this.drawBound(renderer);
  }
  // Into the target that is set.
  drawBound(renderer) { renderer.render(this.#scene, NOWHERE); }
}

// Four corners for shaders that draw an instance for each row of attributes: gl_VertexID is 0 to 3.
export function corners() {
  const four = new THREE.InstancedBufferGeometry();
  four.setIndex([0, 1, 2, 2, 1, 3]);
  four.setAttribute("position", new THREE.BufferAttribute(new Float32Array(12), 3));
  return four;
}
