// Transparent copies of bodies, and bodies that are transparent or highlighted: mixed so that their order does not matter.

import * as THREE from "three";
import { FullScreen } from "./full_screen.js";
import { toEs } from "./glsl.js";

const { CustomBlending, ZeroFactor, OneFactor, OneMinusSrcColorFactor } = THREE;

export class Phantoms {
  #scene = new THREE.Scene(); #pool = []; #targets = new Map();  // of each film

  constructor(shaders, highlight) {
    this.highlight = highlight;
    this.common = { u_clip_W: { value: new THREE.Matrix4() }, u_eye_W: { value: new THREE.Vector3() },
      u_exposure: { value: 1 } };
    this.shaders = shaders;
    this.mix = new FullScreen({ vertex: toEs(shaders.film_vertex), fragment: toEs(shaders.mix_fragment),
      uniforms: { u_sum: { value: null }, u_seen: { value: null } }, transparent: true });
  }

  #material(output, more) {
    return new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3, side: THREE.DoubleSide, transparent: true,
      vertexShader: toEs(this.shaders.overlay_vertex, { model: "u_A_WM" }),
      fragmentShader: toEs(this.shaders.phantom_fragment, { output }),
      uniforms: { ...this.common, u_color: { value: new THREE.Vector4() } }, depthWrite: false, polygonOffset: true,
      polygonOffsetFactor: -1, polygonOffsetUnits: -2, blending: CustomBlending, ...more });
  }

  // Of a frame's own phantoms, and of bodies: {instance, matrix, color, opacity}. `isPlain`: only what is transparent.
  #all(frame, bodies, isPlain) {
    const all = (isPlain ? [] : frame.phantoms).map(({ instance, pose: [w, x, y, z, px, py, pz], color, opacity }) => ({ instance, color,
      opacity, matrix: new THREE.Matrix4().compose(new THREE.Vector3(px, py, pz), new THREE.Quaternion(x, y, z, w),
        new THREE.Vector3(1, 1, 1)) }));
    bodies.instances.forEach(({ isShown, isSolid, color, opacity, highlight, group }, instance) => {
      if (!isShown) return;
      if (!isSolid) all.push({ instance, matrix: group.matrix, color, opacity });
      if (highlight > 0 && !isPlain) all.push({ instance, matrix: group.matrix, color: this.highlight, opacity: highlight });
    });
    return all.filter(({ instance }) => bodies.instances[instance].parts.length > 0);
  }

  #targetsOf(film) {
    const { width, height, light: { depthTexture } } = film;
    const old = this.#targets.get(film);
    if (old?.depthTexture === depthTexture) return old;  // which is new with another size
    old?.sum.dispose();
    old?.seen.dispose();
    const options = { minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter, depthTexture };
    const made = { depthTexture, sum: new THREE.WebGLRenderTarget(width, height, { ...options, type: THREE.HalfFloatType }),
      seen: new THREE.WebGLRenderTarget(width, height, { ...options, format: THREE.RedFormat }) };
    this.#targets.set(film, made);
    return made;
  }

  #fill(all, bodies) {
    while (this.#pool.length < all.length) {
      const made = [
        this.#material("o_sum", { blendSrc: OneFactor, blendDst: OneFactor }),
        this.#material("o_hidden", { blendSrc: ZeroFactor, blendDst: OneMinusSrcColorFactor })].map((material, pass) => {
        const mesh = new THREE.Mesh(undefined, material);
        mesh.matrixAutoUpdate = mesh.frustumCulled = false;
        mesh.layers.set(pass);
        this.#scene.add(mesh);
        return mesh;
      });
      this.#pool.push(made);
    }
    this.#pool.forEach((pair, i) => {
      for (const mesh of pair) {
        mesh.visible = i < all.length;
        if (!mesh.visible) continue;
        mesh.geometry = bodies.instances[all[i].instance].mesh.whole;
        mesh.matrix.copy(all[i].matrix);
        mesh.matrixWorldNeedsUpdate = true;
        mesh.material.uniforms.u_color.value.set(...all[i].color, all[i].opacity);
      }
    });
  }

  draw(renderer, frame, bodies, camera, film, isPlain) {
    const all = this.#all(frame, bodies, isPlain);
    if (all.length === 0) return;
    const { sum, seen } = this.#targetsOf(film);
    this.mix.uniforms.u_sum.value = sum.texture;
    this.mix.uniforms.u_seen.value = seen.texture;
    this.#fill(all, bodies);
    this.common.u_clip_W.value.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    this.common.u_eye_W.value.setFromMatrixPosition(camera.matrixWorld);
    this.common.u_exposure.value = film.exposure;
    const eye = new THREE.Camera();
    [[sum, 0x000000, 0], [seen, 0xffffff, 1]].forEach(([target, clear, alpha], pass) => {
      renderer.setRenderTarget(target);
      renderer.setClearColor(clear, alpha);
      renderer.clear(true, false, false);
      eye.layers.set(pass);
      renderer.render(this.#scene, eye);
    });
    renderer.setClearColor(0x000000, 0);
    this.mix.draw(renderer, film.light);
  }
}
