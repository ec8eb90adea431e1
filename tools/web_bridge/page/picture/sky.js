// What is far away: stars, sun, Moon, and the Earth with its air, by the OpenGL renderer's shaders. It is drawn into a
// picture of its own, anew when the camera turns or time has passed, and shown where nothing is in front of it.

import * as THREE from "three";
import { EarthGround } from "./earth_ground.js";
import { FullScreen } from "./full_screen.js";
import { toEs } from "./glsl.js";
import { Stars } from "./stars.js";
import { cubeOfNoise, tableTexture } from "./tables.js";

const GLARE = [0.35, 0.34, 0.32];  // of the sun in the camera, as sky.cpp
const GLARE_REACH_RAD = 0.2;  // as sky.cpp
const TURN_RAD_PER_MS = 1.14e-6;  // of an orbit
const OLD_PX = 0.5;  // the sky is drawn anew when it has turned so far
const LEAST_OLD_MS = 500;
const UNFINISHED_MS = 100;  // while the Earth's surface is still computed

const SHOW_VERTEX = `precision highp float;
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 1.0, 1.0); }`;
const SHOW_FRAGMENT = `precision highp float;
uniform sampler2D u_sky;
out vec4 o_color;
void main() { o_color = texelFetch(u_sky, ivec2(gl_FragCoord.xy), 0); }`;

const { CustomBlending, ZeroFactor, OneFactor, SrcColorFactor, SrcAlphaFactor } = THREE;

// What a camera has of the sky.
class SkyView {
  drawn = null; drawnMs = -Infinity; isTurning = false;

  resize(width, height) {
    if (this.picture?.width === width && this.picture.height === height) return;
    this.picture?.dispose();
    this.splatted?.dispose();
    const options = { type: THREE.HalfFloatType, depthBuffer: false, minFilter: THREE.NearestFilter,
      magFilter: THREE.NearestFilter };
    this.picture = new THREE.WebGLRenderTarget(width, height, options);
    this.splatted = new THREE.WebGLRenderTarget(width, height, options);
    this.drawn = null;
  }
}

export class Sky {
  views = { main: new SkyView(), inset: new SkyView() };
  #isBegun = false; #left = 1;

  constructor(assets, shaders) {
    const { air } = assets;
    this.assets = assets;
    this.stars = new Stars(assets.stars);
    this.ground = new EarthGround(assets, shaders);
    const vertex = toEs(shaders.sky_vertex);
    const common = { u_sky_clip: { value: new THREE.Matrix4() }, u_sun_direction_W: { value: new THREE.Vector3() },
      u_glare: { value: new THREE.Vector3() } };
    this.starLight = new FullScreen({ vertex, fragment: toEs(shaders.stars_fragment),
      uniforms: { ...common, u_stars: { value: null } } });
    this.sun = new FullScreen({ vertex, fragment: toEs(shaders.sun_fragment), uniforms: common, transparent: true,
      blending: CustomBlending, blendSrc: OneFactor, blendDst: OneFactor });
    this.moon = new FullScreen({ vertex, fragment: toEs(shaders.moon_fragment),
      uniforms: { ...common, u_moon_W: { value: new THREE.Vector4() } } });
    const earth = { ...common, u_earth_W: { value: new THREE.Vector4() }, u_R_EW: { value: new THREE.Matrix3() },
      u_scattering: { value: tableTexture(air.scattering) }, u_through: { value: tableTexture(air.through) },
      u_ground_light: { value: tableTexture(air.groundLight) }, u_earth: { value: this.ground.ground.texture },
      u_lights: { value: this.ground.lights.texture }, u_fine: { value: cubeOfNoise(assets.fine) },
      u_shell: { value: new THREE.Vector4(air.top, air.horizon, air.leastMuS, air.lowest) },
      u_mie: { value: new THREE.Vector4(...air.mieRatio, air.mieG) },
      u_sun: { value: new THREE.Vector3(...assets.sunColor) },
      u_samples: { value: new THREE.Vector3(...air.samples) } };
    // What is behind is kept as far as the air lets it through, for each colour; then the air's own light is added.
    this.keep = new FullScreen({ vertex, fragment: toEs(shaders.earth_air_fragment, { output: "o_keep" }),
      uniforms: earth, transparent: true, blending: CustomBlending, blendSrc: ZeroFactor, blendDst: SrcColorFactor,
      blendSrcAlpha: ZeroFactor, blendDstAlpha: SrcAlphaFactor });
    this.add = new FullScreen({ vertex, fragment: toEs(shaders.earth_air_fragment, { output: "o_color" }),
      uniforms: earth, transparent: true, blending: CustomBlending, blendSrc: OneFactor, blendDst: OneFactor });
    this.shown = new FullScreen({ vertex: SHOW_VERTEX, fragment: SHOW_FRAGMENT, uniforms: { u_sky: { value: null } },
      depthTest: true, depthFunc: THREE.LessEqualDepth });
    this.common = common;
    this.earth = earth;
  }

  #setSurroundings(sky) {
    const sun = new THREE.Vector3(...sky.sunDirection);
    this.common.u_sun_direction_W.value.copy(sun);
    this.common.u_glare.value.set(...GLARE.map((value, i) => value * sky.sunlight[i]));
    const moon = new THREE.Vector3(...sky.moon);
    const moon_m = Math.max(moon.length(), 1);
    this.moon.uniforms.u_moon_W.value.set(...moon.divideScalar(moon_m), this.assets.moonRadiusM / moon_m);
    const [w, x, y, z, ...centre] = sky.earth;
    const toEarth = new THREE.Vector3(...centre);
    const earth_m = Math.max(toEarth.length(), 1);
    const R_EW = new THREE.Quaternion(x, y, z, w).invert();
    this.eye_E = toEarth.clone().negate().applyQuaternion(R_EW);
    this.earth.u_R_EW.value.setFromMatrix4(new THREE.Matrix4().makeRotationFromQuaternion(R_EW));
    const toward = toEarth.divideScalar(earth_m);
    this.earth.u_earth_W.value.set(toward.x, toward.y, toward.z, this.assets.air.bottomM / earth_m);
  }

  // Into the picture of its view, when it has to be. `isStill`: a picture that is kept.
  prepare(renderer, sky, camera, { width, height, isStill }, view) {
    view.resize(width, height);
    const seen = [...camera.quaternion.toArray(), camera.fov, camera.aspect].join();
    const now = performance.now();
    const isSame = seen === view.drawn;
    const focal_px = 0.5 * height / Math.tan(THREE.MathUtils.degToRad(camera.fov) / 2);
    const oldMs = this.#left > 0 ? UNFINISHED_MS : Math.max(LEAST_OLD_MS, OLD_PX / focal_px / TURN_RAD_PER_MS);
    if (isSame && !isStill && !view.isTurning && now - view.drawnMs < oldMs) return;
    // The very first picture is quick: bright stars, and the Earth with the next.
    const isFirst = !this.#isBegun && !isStill;
    this.#isBegun = true;
    view.isTurning = isFirst || (!isSame && view.drawn !== null && !isStill);
    view.drawn = seen;
    view.drawnMs = now;
    this.#setSurroundings(sky);
    if (!isFirst) this.#left = this.ground.bake(renderer, this.eye_E, isStill);
    const R_VW = new THREE.Matrix4().makeRotationFromQuaternion(camera.quaternion.clone().invert());
    const [w, x, y, z] = sky.celestial;
    const R_WC = new THREE.Matrix4().makeRotationFromQuaternion(new THREE.Quaternion(x, y, z, w));
    const R_VC = new THREE.Matrix3().setFromMatrix4(new THREE.Matrix4().multiplyMatrices(R_VW, R_WC));
    this.stars.draw(renderer, view.splatted, { R_VC, isTurning: view.isTurning, focal_px });
    this.starLight.uniforms.u_stars.value = view.splatted.texture;
    this.common.u_sky_clip.value.multiplyMatrices(camera.projectionMatrix, R_VW).invert();
    this.starLight.draw(renderer, view.picture);
    this.#clipToDisc(view.picture, camera, R_VW, this.common.u_sun_direction_W.value, GLARE_REACH_RAD);
    this.sun.draw(renderer, view.picture);
    const moon = this.moon.uniforms.u_moon_W.value;
    this.#clipToDisc(view.picture, camera, R_VW, moon, Math.asin(Math.min(1, moon.w)));
    this.moon.draw(renderer, view.picture);
    if (!isFirst) {
      const earth = this.earth.u_earth_W.value;
      this.#clipToDisc(view.picture, camera, R_VW, earth, Math.asin(Math.min(1, earth.w * this.assets.air.top)));
      this.keep.draw(renderer, view.picture);
      this.add.draw(renderer, view.picture);
    }
    view.picture.scissorTest = false;
  }

  // Whether another picture would show more.
  get isUnfinished() { return this.#left > 0 || this.views.main.isTurning; }

  // Only the rectangle of a disc around a direction is shaded. radius: of the disc, rad.
  #clipToDisc(picture, camera, R_VW, { x, y, z }, radius) {
    const centre = new THREE.Vector3(x, y, z).applyMatrix4(R_VW);
    const size = new THREE.Vector2(picture.width, picture.height);
    const focal = 0.5 * size.y / Math.tan(THREE.MathUtils.degToRad(camera.fov) / 2);
    // Of the angles to the left and right, and up and down, in the planes through the eye.
    const range = (across) => {
      const mid = Math.atan2(across, -centre.z);
      const flat = Math.hypot(across, centre.z);
      const half = flat > Math.sin(radius) ? Math.asin(Math.sin(radius) / flat) : Math.PI;
      const edge = (angle) => focal * Math.tan(Math.min(1.55, Math.max(-1.55, angle)));
      return mid - half > 1.55 || mid + half < -1.55 ? [0, 0] : [edge(mid - half), edge(mid + half)];
    };
    const [left, right] = range(centre.x), [low, high] = range(centre.y);
    const clamp = (value, most) => Math.min(most, Math.max(0, value));
    const x0 = clamp(Math.floor(0.5 * size.x + left), size.x), x1 = clamp(Math.ceil(0.5 * size.x + right), size.x);
    const y0 = clamp(Math.floor(0.5 * size.y + low), size.y), y1 = clamp(Math.ceil(0.5 * size.y + high), size.y);
    picture.scissorTest = true;
    picture.scissor.set(x0, y0, x1 - x0, y1 - y0);
  }

  // Where nothing is in front of it.
  show(renderer, target, view) {
    this.shown.uniforms.u_sky.value = view.picture.texture;
    this.shown.draw(renderer, target);
  }
}
