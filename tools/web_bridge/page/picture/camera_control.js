// Where the picture is seen from: a camera of the scenario, or the person's own view after dragging.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const NEAR_M = 0.01, FAR_M = 60;  // as the OpenGL renderer
const NO_CAMERA = { name: "", eyeM: [0, -1, 1], targetM: [0, 0, 0], verticalFovRad: 0.8, object: -1, isMounted: false,
  up: [0, 0, 0] };

export class CameraControl {
  fixed = "";  // name of a camera to stay with; "": the one named after the step, else the first
  isFree = false;

  constructor(cameras, element, onChange) {
    this.cameras = cameras;
    this.firstMounted = cameras.find(({ isMounted }) => isMounted);
    this.onChange = onChange;
    this.camera = new THREE.PerspectiveCamera(45, 1, NEAR_M, FAR_M);
    this.camera.up.set(0, 0, 1);
    this.carried = new THREE.PerspectiveCamera(45, 1, NEAR_M, FAR_M);
    this.controls = new OrbitControls(this.camera, element);
    this.controls.minDistance = 0.02;
    this.controls.maxDistance = 20;
    this.controls.addEventListener("start", () => { this.isFree = true; });
    this.controls.addEventListener("change", onChange);
  }

  choose(name) {
    this.fixed = name;
    this.isFree = false;
    this.onChange();
  }

  named(name) { return this.cameras.find((one) => one.name === name); }

  // Of this step, where its object stands now.
  update(step, instances, aspect) {
    this.camera.aspect = aspect;
    const shown = this.named(this.fixed) ?? this.named(step) ?? this.cameras[0] ?? NO_CAMERA;
    if (!this.isFree) this.#place(shown, instances);
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    return shown;
  }

  #place(given, instances) {
    this.controls.target.copy(place(this.camera, given, instances));
    this.camera.up.set(0, 0, 1);  // of a person's own view
  }

  // The first camera that is mounted on a part, where that is now; null: there is none.
  mounted(instances, aspect) {
    if (!this.firstMounted) return null;
    place(this.carried, this.firstMounted, instances);
    this.carried.aspect = aspect;
    this.carried.updateProjectionMatrix();
    this.carried.updateMatrixWorld();
    return this.carried;
  }
}

// Puts a camera where the scenario's stands. Returns what it looks at.
function place(camera, { eyeM, targetM, up, verticalFovRad, object, isMounted }, instances) {
  const eye = new THREE.Vector3(...eyeM), target = new THREE.Vector3(...targetM), upwards = new THREE.Vector3(...up);
  const carrier = instances[object]?.group.matrix;
  if (carrier && isMounted) {
    eye.applyMatrix4(carrier);
    target.applyMatrix4(carrier);
    upwards.transformDirection(carrier);
  } else if (carrier) {
    const origin = new THREE.Vector3().setFromMatrixPosition(carrier);
    eye.add(origin);
    target.add(origin);
  }
  const forward = target.clone().sub(eye).normalize();
  if (up.every((value) => value === 0)) upwards.set(...(Math.abs(forward.z) > 0.999 ? [0, 1, 0] : [0, 0, 1]));
  camera.fov = THREE.MathUtils.radToDeg(verticalFovRad);
  camera.position.copy(eye);
  camera.up.copy(upwards);
  camera.lookAt(target);
  return target;
}
