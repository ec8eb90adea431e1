// What has a place in the scene: instances of meshes, and deformable sheets.

import * as THREE from "three";
import { Skin } from "./skin.js";
import { Place, setSurface } from "./surfaces.js";
import { floatsOf, indicesOf, pictureTexture } from "./tables.js";

export const STATIC = 1, MOVABLE = 2;  // layers, by what the shadow map draws anew

// Attributes of an interleaved buffer by the names that the shaders have: [offset, number of floats].
function addAttributes(geometry, buffer, places) {
  for (const [name, [offset, size]] of Object.entries(places)) {
    geometry.setAttribute(name, new THREE.InterleavedBufferAttribute(buffer, size, offset));
  }
}

function boundsOf(vertices, stride) {
  const box = new THREE.Box3();
  const point = new THREE.Vector3();
  for (let i = 0; i < vertices.length; i += stride) box.expandByPoint(point.fromArray(vertices, i));
  const centre = box.isEmpty() ? new THREE.Vector3() : box.getCenter(new THREE.Vector3());
  let radius = 0;
  for (let i = 0; i < vertices.length; i += stride) radius = Math.max(radius, centre.distanceTo(point.fromArray(vertices, i)));
  return { box, sphere: new THREE.Sphere(centre, radius) };
}

class Mesh {
  constructor(message) {
    const vertices = floatsOf(message.vertices);
    const indices = indicesOf(message.indices);
    const { box, sphere } = boundsOf(vertices, 8);
    this.box = box;
    this.sphere = sphere;
    this.textures = message.textures.map(pictureTexture);
    this.hasLens = message.parts.some((part) => part.isLens);
    const buffer = new THREE.InterleavedBuffer(vertices, 8);
    const rest = message.skin.length === 0 ? buffer : new THREE.InterleavedBuffer(vertices.slice(), 8);
    if (message.skin.length > 0) {
      this.skin = new Skin(vertices, floatsOf(message.skin), floatsOf(message.joints));
      this.buffer = buffer.setUsage(THREE.DynamicDrawUsage);
    }
    const geometryOf = (first, number) => {
      const geometry = new THREE.BufferGeometry();
      addAttributes(geometry, buffer, { a_p_M: [0, 3], a_n_M: [3, 3], a_uv: [6, 2] });
      addAttributes(geometry, rest, { a_rest_p: [0, 3], a_rest_n: [3, 3] });
      geometry.setIndex(new THREE.BufferAttribute(indices.subarray(first, first + number), 1));
      geometry.boundingSphere = sphere;
      return geometry;
    };
    this.whole = geometryOf(0, indices.length);
    this.parts = message.parts.map((part) => ({ ...part, geometry: geometryOf(part.firstIndex, part.numIndices) }));
  }

  // Of a mesh with a skin, which no other instance has.
  bend(poses) {
    const vertices = this.buffer.array;
    if (!this.skin.bend(poses, vertices)) return;
    this.buffer.needsUpdate = true;
    const { box, sphere } = boundsOf(vertices, 8);
    this.box.copy(box);
    this.sphere.copy(sphere);
  }
}

const GIVEN_NOTHING = { surface: { baseColor: [0.8, 0.8, 0.8], metallic: 0, roughness: 0.6, emissive: [0, 0, 0] },
  isSurfaceGiven: false, isHidden: false, opacity: 1, highlight: 0 };

const NOT_MOVED = new THREE.Matrix4();

class Instance {
  place = new Place();
  #look = null;

  constructor(message, mesh, index, surfaces, root) {
    Object.assign(this, { index, mesh, name: message.name, isScenery: message.isScenery });
    this.group = new THREE.Group();
    this.group.matrixAutoUpdate = false;
    this.parts = mesh.parts.map((part) => {
      const own = surfaces.make(part.surface, this.place, part, mesh.textures);
      const drawn = new THREE.Mesh(part.geometry, own);
      drawn.matrixAutoUpdate = false;
      drawn.layers.set(message.isMovable ? MOVABLE : STATIC);
      drawn.userData.id = index + 1;
      this.group.add(drawn);
      return { part, own, given: null, drawn };
    });
    root.add(this.group);
    this.surfaces = surfaces;
  }

  setPose(poses, at) {
    const [w, x, y, z, px, py, pz] = poses.subarray(at, at + 7);
    this.group.matrix.compose(new THREE.Vector3(px, py, pz), new THREE.Quaternion(x, y, z, w), new THREE.Vector3(1, 1, 1));
    this.group.matrixWorldNeedsUpdate = true;
  }

  get centre() { return this.mesh.sphere.center.clone().applyMatrix4(this.group.matrix); }

  // Of a lamp with a lens only the lens shines.
  show(look = GIVEN_NOTHING) {
    if (look === this.#look) return;
    this.#look = look;
    this.isShown = !look.isHidden;
    this.isSolid = look.opacity >= 1;
    this.opacity = look.opacity;
    this.highlight = look.highlight;
    this.group.visible = this.isShown && this.isSolid;
    for (const one of this.parts) {
      const isGiven = look.isSurfaceGiven && (!this.mesh.hasLens || one.part.isLens);
      if (isGiven) {
        one.given ??= this.surfaces.make(look.surface, this.place, { isTwoSided: one.part.isTwoSided });
        setSurface(one.given, look.surface);
      } else {
        setSurface(one.own, one.part.surface, look.isSurfaceGiven ? undefined : look.surface.emissive);
      }
      one.drawn.material = isGiven ? one.given : one.own;
    }
    this.color = look.isSurfaceGiven ? look.surface.baseColor : this.mesh.parts[0]?.surface.baseColor ?? [0.8, 0.8, 0.8];
  }
}

class Sheet {
  place = new Place();

  constructor(message, rest, surfaces, root) {
    this.buffer = new THREE.InterleavedBuffer(floatsOf(message.vertices), 6);
    this.buffer.setUsage(THREE.DynamicDrawUsage);
    const geometry = new THREE.BufferGeometry();
    addAttributes(geometry, this.buffer, { a_p_M: [0, 3], a_n_M: [3, 3] });
    addAttributes(geometry, new THREE.InterleavedBuffer(floatsOf(rest), 6), { a_rest_p: [0, 3], a_rest_n: [3, 3] });
    geometry.setAttribute("a_uv", new THREE.BufferAttribute(new Float32Array(this.buffer.count * 2), 2));
    geometry.setIndex(new THREE.BufferAttribute(indicesOf(message.indices), 1));
    this.drawn = new THREE.Mesh(geometry, surfaces.make(message.surface, this.place));
    this.drawn.frustumCulled = false;
    this.drawn.layers.set(MOVABLE);
    this.drawn.userData.id = message.instance + 1;
    root.add(this.drawn);
  }

  show(message) {
    this.buffer.set(floatsOf(message.vertices));
    this.buffer.needsUpdate = true;
    setSurface(this.drawn.material, message.surface);
    this.drawn.visible = !message.isHidden;
  }
}

export class Bodies {
  scene = new THREE.Scene();
  sheets = [];
  lamps = [];
  version = 0;  // changes with whatever casts a shadow

  constructor(assets, surfaces) {
    this.scene.matrixAutoUpdate = false;
    this.surfaces = surfaces;
    this.rest = assets.sheetsAtRest;
    const meshes = assets.meshes.map((message) => new Mesh(message));
    this.instances = assets.instances.map((one, i) => new Instance(one, meshes[one.mesh], i, surfaces, this.scene));
    this.meshes = meshes;
  }

  show(frame) {
    const poses = floatsOf(frame.poses);
    const looks = new Map(frame.looks.map((look) => [look.instance, look]));
    this.instances.forEach((instance, i) => {
      instance.setPose(poses, 7 * i);
      instance.show(looks.get(i));
    });
    for (const { instance, joints } of frame.postures) this.instances[instance].mesh.bend(floatsOf(joints));
    this.lamps = frame.lamps.filter(({ color, instance }) =>
      color.some((value) => value > 0) && this.instances[instance].isShown).map(({ color, instance }) =>
      ({ color, centre: this.instances[instance].centre, reach: 2.5 * this.instances[instance].mesh.sphere.radius }));
    ++this.version;
  }

  // Before each picture: {eye_W, clip_W, sun_W}.
  place(view) {
    for (const { place, group } of this.instances) place.set(group.matrix, view);
    for (const { place } of this.sheets) place.set(NOT_MOVED, view);
    this.surfaces.place(view.eye_W, this.lamps);
  }

  showSheets({ sheets }) {
    sheets.forEach((message, i) => {
      this.sheets[i] ??= new Sheet(message, this.rest[i], this.surfaces, this.scene);
      this.sheets[i].show(message);
    });
    ++this.version;
  }

  // The box around all that is no scenery.
  box() {
    const all = new THREE.Box3();
    for (const { isShown, isScenery, mesh, group } of this.instances) {
      if (isShown && !isScenery && !mesh.box.isEmpty()) all.union(mesh.box.clone().applyMatrix4(group.matrix));
    }
    return all.isEmpty() ? new THREE.Box3(new THREE.Vector3(), new THREE.Vector3()) : all;
  }
}
