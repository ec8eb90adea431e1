// What explains a scene: arrows, rings, axes, lines, points, voxels and spheres, by the OpenGL renderer's shaders. Each is
// drawn twice: faint, so that it shows through parts, then solid where nothing hides it.

import * as THREE from "three";
import { corners } from "./full_screen.js";
import { toEs } from "./glsl.js";
import { floatsOf } from "./tables.js";

const HIDDEN = 0.3;  // opacity of what a part hides, as overlay_painter.cpp
const FAINT_ORDER = 1, SOLID_ORDER = 2;

// Axes with the given z.
function frameOf(z) {
  const x = (Math.abs(z.x) < 0.8 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0)).cross(z).normalize();
  return [x, z.clone().cross(x), z];
}

// Closed frustum from a ring of radius 1 at z = 0 to a ring of the given radius at z = 1, with the shaders' names.
function frustum(sides, topRadius) {
  const made = new THREE.CylinderGeometry(topRadius, 1, 1, sides).rotateX(Math.PI / 2).translate(0, 0, 0.5);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("a_p_M", made.attributes.position);
  geometry.setAttribute("a_n_M", made.attributes.normal);
  geometry.setIndex(made.index);
  return geometry;
}

// A ring's arc: part of the sweep, cosine and sine of the angle around the tube.
function tube() {
  const steps = 40, sides = 8;
  const points = [], indices = [];
  for (let i = 0; i <= steps; ++i) {
    for (let j = 0; j < sides; ++j) {
      points.push(i / steps, Math.cos(2 * Math.PI * j / sides), Math.sin(2 * Math.PI * j / sides));
      if (i === steps) continue;
      const a = i * sides + j, b = i * sides + (j + 1) % sides;
      indices.push(a, b, b + sides, a, b + sides, a + sides);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("a_u_cos_sin", new THREE.Float32BufferAttribute(points, 3));
  geometry.setIndex(indices);
  return geometry;
}

const poseMatrix = ([w, x, y, z, px, py, pz]) => new THREE.Matrix4().compose(new THREE.Vector3(px, py, pz),
  new THREE.Quaternion(x, y, z, w), new THREE.Vector3(1, 1, 1));

// Meshes of one kind that are taken anew for each frame and keep their buffers.
class Pool {
  #made = []; #used = 0;
  constructor(make) { this.make = make; }
  begin() { this.#used = 0; }
  take() { return (this.#made[this.#used++] ??= this.make()); }
  end() { this.#made.forEach((one, i) => one.forEach((mesh) => { mesh.visible = i < this.#used; })); }
}

export class Overlays {
  scene = new THREE.Scene();
  #blocks = new Map(); #frame = null;

  // `fetchBlock`: async (number) => floats of points that many frames have in common.
  constructor(shaders, { fetchBlock, onBlock }) {
    this.fetchBlock = fetchBlock;
    this.onBlock = onBlock;
    this.shaders = shaders;
    this.scene.matrixWorldAutoUpdate = true;
    this.common = { u_clip_W: { value: new THREE.Matrix4() }, u_eye_W: { value: new THREE.Vector3() },
      u_exposure: { value: 1 } };
    const shaft = frustum(10, 1), head = frustum(14, 0), arc = tube();
    const body = (geometry) => () => this.#twice(geometry, "overlay_vertex", "overlay_fragment", { model: "u_A_WM" });
    this.pools = {
      shaft: new Pool(body(shaft)), head: new Pool(body(head)),
      arc: new Pool(() => this.#twice(arc, "ring_vertex", "overlay_fragment",
        { model: "u_X_WR", uniforms: { u_radius_tube_sweep: { value: new THREE.Vector3() } } })),
      line: new Pool(() => this.#twice(corners(), "line_vertex", "flat_fragment", { isFlat: true,
        uniforms: { u_half_size_width_px: { value: new THREE.Vector3() } } })),
      dots: new Pool(() => this.#twice(new THREE.BufferGeometry(), "point_vertex", "point_fragment", { isFlat: true,
        Kind: THREE.Points, uniforms: { u_clip_P: { value: new THREE.Matrix4() }, u_size_px: { value: new THREE.Vector2() },
          u_strength_opacity: { value: new THREE.Vector2() } } })),
      cube: new Pool(() => this.#grains("cube_fragment", true)),
      sphere: new Pool(() => this.#grains("sphere_fragment", false)),
    };
  }

  #material(vertex, fragment, { model, uniforms = {} }, more) {
    return new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3, transparent: true, side: THREE.DoubleSide,
      vertexShader: toEs(this.shaders[vertex], { model }), fragmentShader: toEs(this.shaders[fragment], { model }),
      uniforms: { ...this.common, u_color: { value: new THREE.Vector4() }, ...uniforms }, ...more });
  }

  #add(geometry, material, order, Kind = THREE.Mesh) {
    const mesh = new Kind(geometry, material);
    mesh.matrixAutoUpdate = mesh.frustumCulled = false;
    mesh.renderOrder = order;
    this.scene.add(mesh);
    return mesh;
  }

  // A faint and a solid mesh. Bodies hide each other, flat ones do not.
  #twice(geometry, vertex, fragment, options) {
    const kinds = [[FAINT_ORDER, { depthTest: false, depthWrite: false }],
      [SOLID_ORDER, { depthTest: true, depthWrite: !options.isFlat }]];
    return kinds.map(([order, more]) => {
      const uniforms = Object.fromEntries(Object.entries(options.uniforms ?? {})
        .map(([name, { value }]) => [name, { value: value.clone() }]));
      return this.#add(geometry, this.#material(vertex, fragment, { ...options, uniforms }, more), order, options.Kind);
    });
  }

  #grains(fragment, isOpaque) {
    return [this.#add(corners(), this.#material("grain_vertex", fragment, { uniforms: {
      u_clip_P: { value: new THREE.Matrix4() }, u_eye_P: { value: new THREE.Vector3() },
      u_scale_reach: { value: new THREE.Vector2() } } }, { depthWrite: isOpaque }), 0)];
  }

  #paint(meshes, color, opacity) {
    meshes.forEach(({ material }, i) => {
      const share = meshes.length === 2 && i === 0 ? HIDDEN : 1;
      material.uniforms.u_color.value.set(...color, opacity * share);
    });
  }

  // Points of a frame's message: null until their block is there.
  #points(message) {
    if (!message) return null;
    if (message.block === 0) return message.here.length > 0 ? floatsOf(message.here) : null;
    const known = this.#blocks.get(message.block);
    if (known) {
      known.usedMs = performance.now();
      return known.floats;
    }
    const block = { floats: null, usedMs: performance.now() };
    this.#blocks.set(message.block, block);
    this.fetchBlock(message.block).then((floats) => {
      block.floats = floats;
      this.onBlock();
    }).catch(() => this.#blocks.delete(message.block));
    return null;
  }

  #forgetBlocks() {
    const old = performance.now() - 10_000;
    for (const [number, { usedMs }] of this.#blocks) if (usedMs < old) this.#blocks.delete(number);
  }

  show(frame) { this.#frame = frame; }

  // Before each picture: sizes on the screen depend on the camera. `film`: {width, height, exposure}.
  prepare(camera, film) {
    const frame = this.#frame;
    if (!frame) return;
    this.common.u_clip_W.value.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    this.common.u_eye_W.value.setFromMatrixPosition(camera.matrixWorld);
    this.common.u_exposure.value = film.exposure;
    Object.values(this.pools).forEach((pool) => pool.begin());
    for (const { tail, vector, color } of frame.arrows) this.#arrow(new THREE.Vector3(...tail), new THREE.Vector3(...vector), color);
    for (const axes of frame.axes) this.#axes(axes);
    for (const ring of frame.rings) this.#ring(ring);
    for (const line of frame.lines) this.#line(line, film);
    for (const set of frame.dots) this.#dots(set, camera, film);
    for (const grains of frame.grains) this.#grain(grains, film);
    Object.values(this.pools).forEach((pool) => pool.end());
    this.#forgetBlocks();
  }

  #place(meshes, p, [x, y, z], radius, length, color) {
    const matrix = new THREE.Matrix4().makeBasis(x.clone().multiplyScalar(radius), y.clone().multiplyScalar(radius),
      z.clone().multiplyScalar(length)).setPosition(p);
    for (const mesh of meshes) {
      mesh.matrix.copy(matrix);
      mesh.matrixWorldNeedsUpdate = true;
    }
    this.#paint(meshes, color, 1);
  }

  #arrow(p, vector, color) {
    const length = vector.length();
    if (length <= 0) return;
    const frame = frameOf(vector.clone().divideScalar(length));
    // The radius is proportional to the distance, so the thickness on the screen is constant.
    const radius = Math.min(0.0025 * p.distanceTo(this.common.u_eye_W.value), 0.08 * length);
    const head = Math.min(9 * radius, 0.5 * length);
    this.#place(this.pools.shaft.take(), p, frame, radius, length - head, color);
    this.#place(this.pools.head.take(), p.clone().addScaledVector(frame[2], length - head), frame, 2.8 * radius, head, color);
  }

  #axes({ pose, lengthM }) {
    const matrix = poseMatrix(pose);
    for (const k of [0, 1, 2]) {
      const color = [0.1, 0.1, 0.1].map((value, i) => (i === k ? 1 : value));
      this.#arrow(new THREE.Vector3().setFromMatrixPosition(matrix),
        new THREE.Vector3().setFromMatrixColumn(matrix, k).multiplyScalar(lengthM), color);
    }
  }

  #ring({ centre, axis, radiusM, sweepRad, color }) {
    const p = new THREE.Vector3(...centre);
    const [x, y, z] = frameOf(new THREE.Vector3(...axis));
    const meshes = this.pools.arc.take();
    const thick = Math.min(0.0025 * p.distanceTo(this.common.u_eye_W.value), 0.1 * radiusM);
    for (const mesh of meshes) {
      mesh.matrix.makeBasis(x, y, z).setPosition(p);
      mesh.matrixWorldNeedsUpdate = true;
      mesh.material.uniforms.u_radius_tube_sweep.value.set(radiusM, thick, sweepRad);
    }
    this.#paint(meshes, color, 1);
    const outwards = x.clone().multiplyScalar(Math.cos(sweepRad)).addScaledVector(y, Math.sin(sweepRad));
    const onwards = z.clone().cross(outwards);
    this.#place(this.pools.head.take(), p.clone().addScaledVector(outwards, radiusM), frameOf(onwards), 0.11 * radiusM,
      0.34 * radiusM, color);
  }

  #line({ points, color, widthPx, opacity }, film) {
    const p = this.#points(points);
    if (!p || p.length < 6) return;
    const meshes = this.pools.line.take();
    const { geometry } = meshes[0];
    this.#fill(geometry, p, { a_p0_W: [3, 0], a_p1_W: [3, 3] });
    geometry.instanceCount = p.length / 3 - 1;
    for (const { material } of meshes) {
      material.uniforms.u_half_size_width_px.value.set(0.5 * film.width, 0.5 * film.height, 0.5 * widthPx * film.height / 360);
    }
    this.#paint(meshes, color.map((value) => value / film.exposure), opacity);
  }

  // An instance for each row of `stride` floats; rows overlap where an attribute reaches into the next.
  #fill(geometry, floats, places, stride = 3) {
    if (geometry.userData.floats === floats) return;
    geometry.userData.floats = floats;
    const rows = floats.length / stride;
    const old = geometry.userData.buffer;
    if (!old || old.count < rows) {
      geometry.dispose();
      const buffer = new THREE.InstancedInterleavedBuffer(new Float32Array(2 * floats.length), stride);
      buffer.setUsage(THREE.DynamicDrawUsage);
      geometry.userData.buffer = buffer;
      for (const [name, [size, offset]] of Object.entries(places)) {
        geometry.setAttribute(name, new THREE.InterleavedBufferAttribute(buffer, size, offset));
      }
    }
    geometry.userData.buffer.set(floats);
    geometry.userData.buffer.needsUpdate = true;
  }

  #dots(set, camera, film) {
    const p = this.#points(set.points);
    const colors = set.colors && this.#points(set.colors);
    if (!p || (set.colors && !colors)) return;
    const meshes = this.pools.dots.take().filter((_, i) => i === 1 || set.showsThrough);
    const { geometry } = meshes[0];
    if (geometry.userData.p !== p || geometry.userData.colors !== (colors ?? set.color.join())) {
      geometry.userData = { p, colors: colors ?? set.color.join() };
      geometry.dispose();
      geometry.setAttribute("a_p_P", new THREE.BufferAttribute(p, 3));
      geometry.setAttribute("a_color", new THREE.BufferAttribute(
        colors ?? Float32Array.from(p, (_, i) => set.color[i % 3]), 3));
    }
    geometry.setDrawRange(0, p.length / 3);
    const clip_P = this.common.u_clip_W.value.clone().multiply(poseMatrix(set.pose));
    for (const { material: { uniforms }, renderOrder } of meshes) {
      uniforms.u_clip_P.value.copy(clip_P);
      uniforms.u_size_px.value.set(set.sizePx * film.height / 360,
        0.5 * film.height * camera.projectionMatrix.elements[5] * set.mostM);
      uniforms.u_strength_opacity.value.set(1 / film.exposure, renderOrder === FAINT_ORDER ? HIDDEN : 1);
    }
  }

  #grain({ pose, points, sizeM, color, opacity, areSpheres }, film) {
    const p = this.#points(points);
    if (!p) return;
    const [mesh] = areSpheres ? this.pools.sphere.take() : this.pools.cube.take();
    const stride = areSpheres ? 4 : 3;
    this.#fill(mesh.geometry, p, { a_p_P_size: [stride, 0] }, stride);
    mesh.geometry.instanceCount = p.length / stride;
    const { uniforms } = mesh.material;
    const matrix = poseMatrix(pose);
    uniforms.u_clip_P.value.multiplyMatrices(this.common.u_clip_W.value, matrix);
    uniforms.u_eye_P.value.copy(this.common.u_eye_W.value).applyMatrix4(matrix.invert());
    uniforms.u_scale_reach.value.set(areSpheres ? 1 : 0.5 * sizeM, areSpheres ? 1 : Math.sqrt(3));
    this.#paint([mesh], color.map((value) => value / film.exposure), opacity);
  }
}
