// Draws the scene into a canvas: shadow map, surfaces, sky, what explains the scene, film.

import * as THREE from "three";
import { Bodies, MOVABLE, STATIC } from "./bodies.js";
import { Film } from "./film.js";
import { Glow } from "./glow.js";
import { Inset } from "./inset.js";
import { LightMeter } from "./light_meter.js";
import { ObjectIds } from "./object_ids.js";
import { Overlays } from "./overlays.js";
import { Phantoms } from "./phantoms.js";
import { ShadowMap } from "./shadow.js";
import { Sky } from "./sky.js";
import { Surfaces } from "./surfaces.js";

const METER_MS = 700;  // measuring waits for the picture
const INSET_SHARE = 4;  // of the canvas's width and height, as camera_feed.cpp

export class Picture {
  #frame = null; #meteredMs = 0;

  // `fetchBlock`, `onBlock`: of Overlays.
  constructor(canvas, assets, { fetchBlock, onBlock }) {
    const shaders = Object.fromEntries(assets.shaders.map(({ name, text }) => [name, text]));
    this.renderer = new THREE.WebGLRenderer({ canvas, alpha: false, antialias: false, depth: false, stencil: false,
      powerPreference: "high-performance" });
    this.renderer.autoClear = false;
    this.renderer.setClearColor(0x000000, 0);
    this.renderer.debug.checkShaderErrors = false;
    this.surfaces = new Surfaces(assets, shaders);
    this.bodies = new Bodies(assets, this.surfaces);
    this.shadow = new ShadowMap(this.surfaces);
    this.sky = new Sky(assets, shaders);
    this.overlays = new Overlays(shaders, { fetchBlock, onBlock });
    this.phantoms = new Phantoms(shaders, assets.highlight);
    this.glow = new Glow();
    this.ids = new ObjectIds();
    this.film = new Film(shaders);
    this.inset = new Inset(shaders);
    this.meter = new LightMeter(shaders, assets.exposure);
    this.film.exposure = this.meter.daylight;
  }

  show(frame) {
    this.#frame = frame;
    this.surfaces.setLight(frame.sky);
    this.bodies.show(frame);
    this.overlays.show(frame);
  }

  showSheets(sheets) { this.bodies.showSheets(sheets); }

  // `camera`: a PerspectiveCamera of this aspect; `inset`: another, whose picture is in a corner, or null. `isStill`: a
  // picture that is to be compared.
  draw(camera, { width, height, isStill = false, inset = null }) {
    const { renderer, film } = this;
    if (renderer.domElement.width !== width || renderer.domElement.height !== height) renderer.setSize(width, height, false);
    if (isStill) film.exposure = this.meter.daylight;
    this.shadow.update(renderer, this.bodies);
    this.#expose(film, camera, { width, height, isStill }, this.sky.views.main);
    film.show(renderer, null);
    if (inset) this.#drawInset(inset, { width, height, isStill });
    if (!isStill) this.#adapt();
  }

  // `isPlain`: without what explains the scene.
  #expose(film, camera, { width, height, isStill }, skyView, isPlain = false) {
    const { renderer, surfaces, bodies } = this;
    film.resize(width, height);
    this.sky.prepare(renderer, this.#frame.sky, camera, { width, height, isStill }, skyView);
    bodies.place({ eye_W: new THREE.Vector3().setFromMatrixPosition(camera.matrixWorld), sun_W: surfaces.sun_W,
      clip_W: new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse) });
    renderer.setRenderTarget(film.light);
    renderer.clear(false, true, false);
    camera.layers.set(STATIC);
    camera.layers.enable(MOVABLE);
    renderer.render(bodies.scene, camera);
    camera.layers.set(0);
    this.sky.show(renderer, film.light, skyView);
    this.glow.prepare(this.#frame, bodies, camera);
    renderer.render(this.glow.scene, camera);
    this.phantoms.draw(renderer, this.#frame, bodies, camera, film, isPlain);
    if (!isPlain) {
      this.overlays.prepare(camera, film);
      renderer.setRenderTarget(film.light);
      renderer.render(this.overlays.scene, camera);
    }
    film.finish(renderer);
  }

  #drawInset(camera, { width, height, isStill }) {
    const { renderer, inset } = this;
    const size = { width: Math.floor(width / INSET_SHARE), height: Math.floor(height / INSET_SHARE), isStill };
    if (isStill || inset.isOld(size)) {
      inset.film.exposure = this.film.exposure;
      this.#expose(inset.film, camera, size, this.sky.views.inset, true);
      inset.take(renderer, size);
    }
    inset.show(renderer, { width, height });
  }

  #adapt() {
    const now = performance.now();
    if (now - this.#meteredMs < METER_MS) return;
    const dtS = Math.min(1, (now - this.#meteredMs) / 1000);
    this.#meteredMs = now;
    this.film.exposure = this.meter.adapt(this.renderer, this.film, this.film.exposure, dtS);
  }

  // What is seen at a place of the canvas, from 0 to 1 from its upper left corner: an instance or null.
  pick(camera, u, v) {
    const size = { width: 640, height: Math.max(1, Math.round(640 / camera.aspect)) };
    const at = { x: Math.floor(u * size.width), y: Math.floor((1 - v) * size.height), w: 1, h: 1 };
    camera.layers.enableAll();
    const [id] = this.ids.read(this.renderer, this.bodies, camera, size, at);
    camera.layers.set(0);
    return id > 0 ? this.bodies.instances[id - 1] : null;
  }

  // Of all pixels, from the upper left corner.
  readIds(camera, width, height) {
    camera.layers.enableAll();
    const ids = this.ids.read(this.renderer, this.bodies, camera, { width, height }, { x: 0, y: 0, w: width, h: height });
    camera.layers.set(0);
    return ids;
  }
}
