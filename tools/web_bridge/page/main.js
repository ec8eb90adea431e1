// The page: takes the key from the address, loads the scene, draws what arrives.

import { HandControl } from "./hand_control.js";
import { Hud } from "./hud.js";
import { Link } from "./link.js";
import { Panel } from "./panel.js";
import { CameraControl } from "./picture/camera_control.js";
import { Picture } from "./picture/picture.js";
import { RenderScale } from "./picture/render_scale.js";
import { floatsOf } from "./picture/tables.js";

const LEAST_FPS = 45;  // that the picture's size is chosen for
const MOST_IN_WORK = 2;
const FIRST_FRAMES = 5;  // in which shaders are compiled
const CLICK_PX = 4, CLICK_MS = 400;

// "#key=...&view=...": what a browser does not send to the server.
const address = new URLSearchParams(location.hash.slice(1));
const canvas = document.getElementById("view");

class Page {
  #wanted = false; #isAsked = false; #inWork = 0; #newest = null; #sheets = null; #assetsOf = null; #offsetMs = 0;
  #finishedMs = 0; #down = null; #turns = new MessageChannel(); #inGpu = [];  // pictures, the oldest first
  frames = 0;
  latencies = [];  // [ms] of the newest pictures with a new state

  constructor(key) {
    this.scale = new RenderScale(1000 / LEAST_FPS);
    this.#turns.port1.onmessage = () => this.#seeWhetherDrawn();
    this.link = new Link(key, { frame: ({ bytes }) => this.#take(bytes), sheets: ({ bytes }) => this.#takeSheets(bytes),
      status: (status) => this.#takeStatus(status), on: () => this.panel.say("live"),
      off: () => this.panel.say("the bridge does not answer", true), said: (text, isBad) => this.panel.say(text, isBad) });
    this.panel = new Panel({ set: (name, isOn) => this.link.setParameter(`scene.${name}`, isOn ? 1 : 0),
      view: (name) => this.control?.choose(name), parameter: (name, value) => this.link.setParameter(name, value),
      call: (service, request) => this.link.call(service, request).catch((error) => this.panel.say(error.message, true)) });
    this.hud = new Hud(document.getElementById("hud"));
    this.begun = this.#begin();
  }

  async #begin() {
    const bytes = await this.link.load("assets");
    if (!bytes) return;  // none yet; the status says when
    await this.link.known;
    const assets = this.link.decode("SceneAssets", bytes);
    this.picture = new Picture(canvas, assets, { onBlock: () => this.wish(),
      fetchBlock: async (number) => floatsOf(await this.link.load(`block/${number}`)) });
    this.control = new CameraControl(assets.cameras, canvas, () => this.wish());
    this.control.fixed = address.get("view") ?? "";
    this.panel.begin(assets);
    this.assets = assets;
    this.hand = new HandControl(canvas, (numbers) => this.link.call("/hand", { numbers }));
    this.#listen();
    if (this.#sheets) this.#takeSheets(this.#sheets);
    this.#measureClock();
    this.wish();
  }

  // Another scenario has other assets.
  #takeStatus(status) {
    this.panel.showStatus(status);
    if (status.assets && this.#assetsOf !== null && this.#assetsOf !== status.assets) location.reload();
    if (status.assets && !this.picture && this.#assetsOf === null) this.begun = this.begun.then(() => this.picture || this.#begin());
    this.#assetsOf ??= status.assets || null;
  }

  #take(bytes) {
    this.#newest = bytes;
    this.wish();
  }

  #takeSheets(bytes) {
    this.#sheets = bytes;
    if (!this.picture) return;
    this.picture.showSheets(this.link.decode("SceneSheets", bytes));
    this.wish();
  }

  // Asks for a picture. While the GPU's process draws one, the next is prepared; a third would only be older than it need be.
  wish() {
    this.#wanted = true;
    this.#ask();
  }

  #ask() {
    if (!this.#wanted || this.#isAsked || this.#inWork >= MOST_IN_WORK) return;
    this.#isAsked = true;
    requestAnimationFrame(() => {
      this.#isAsked = false;
      this.#wanted = false;
      this.#draw();
    });
  }

  #draw() {
    if (!this.picture || (!this.frame && !this.#newest)) return;
    ++this.#inWork;
    const beginMs = performance.now();
    const isNew = this.#newest !== null;
    if (isNew) this.#showNewest();
    const size = this.size();
    this.control.update(this.frame.step, this.picture.bodies.instances, size.width / size.height);
    this.hand.update(this.frame.texts, this.control, canvas.clientHeight);
    this.picture.draw(this.control.camera, { ...size, inset: this.inset(size.width / size.height) });
    this.hud.place(this.control.camera);
    this.panel.showView(this.control.fixed, this.control.isFree);
    const { sentNs, stateAgeMs } = this.frame;
    this.#whenDrawn(() => this.#finish(beginMs, isNew && stateAgeMs > 0 ? Number(sentNs) * 1e-6 - stateAgeMs : null));
    this.#ask();
  }

  // The camera whose picture is in a corner, if somebody wants it.
  inset(aspect) {
    if (!this.frame.choices.includes("overlay.camera")) return null;
    return this.control.mounted(this.picture.bodies.instances, aspect);
  }

  #showNewest() {
    this.newestBytes = this.#newest;
    this.frame = this.link.decode("SceneFrame", this.newestBytes);
    this.#newest = null;
    this.picture.show(this.frame);
    this.hud.show(this.frame);
    this.panel.showFrame(this.frame);
  }

  size(scale = this.scale.value) {
    const pixels = Math.min(devicePixelRatio, 2) * scale;
    return { width: Math.max(16, Math.round(canvas.clientWidth * pixels)),
      height: Math.max(16, Math.round(canvas.clientHeight * pixels)) };
  }

  // `stateMs`: when the state that is shown arrived, by the bridge's clock; null: it is not new.
  #finish(beginMs, stateMs) {
    const now = performance.now();
    --this.#inWork;
    // Since the last picture was finished, or this one was begun.
    if (++this.frames > FIRST_FRAMES) this.scale.update(now - Math.max(beginMs, this.#finishedMs));
    this.#finishedMs = now;
    if (stateMs !== null) {
      const ms = performance.timeOrigin + now - this.#offsetMs - stateMs;
      this.latencies.push(ms);
      if (this.latencies.length > 500) this.latencies.shift();
      this.panel.showLatency(ms);
    }
    this.#wanted ||= this.picture.sky.isUnfinished;
    this.#ask();
  }

  // The GPU's process draws behind this one. One channel for all pictures: what is made for each of them is memory that
  // the browser takes its time to give back.
  #whenDrawn(then) {
    const gl = this.picture.renderer.getContext();
    this.#inGpu.push({ fence: gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0), then });
    gl.flush();
    if (this.#inGpu.length === 1) this.#turns.port2.postMessage(0);
  }

  #seeWhetherDrawn() {
    const gl = this.picture.renderer.getContext(), [{ fence, then }] = this.#inGpu;
    if (!gl.isContextLost() && gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) {
      setTimeout(() => this.#turns.port2.postMessage(0), 1);
      return;
    }
    gl.deleteSync(fence);
    this.#inGpu.shift();
    if (this.#inGpu.length > 0) this.#turns.port2.postMessage(0);
    then();
  }

  // How far this clock is before the bridge's: by the quickest of a few questions.
  async #measureClock() {
    await this.link.served;
    let least = Infinity;
    for (let i = 0; i < 8; ++i) {
      const asked = performance.timeOrigin + performance.now();
      const { now_ms: there } = await this.link.call("/clock");
      const answered = performance.timeOrigin + performance.now();
      if (answered - asked >= least) continue;
      least = answered - asked;
      this.#offsetMs = 0.5 * (asked + answered) - there;
    }
  }

  #listen() {
    new ResizeObserver(() => this.wish()).observe(canvas);
    canvas.addEventListener("pointerdown", (event) => { this.#down = { x: event.clientX, y: event.clientY, ms: event.timeStamp }; });
    canvas.addEventListener("pointerup", (event) => {
      const down = this.#down;
      if (!down || event.timeStamp - down.ms > CLICK_MS) return;
      if (Math.hypot(event.clientX - down.x, event.clientY - down.y) <= CLICK_PX) this.#pick(event);
    });
    addEventListener("keydown", (event) => this.#press(event));
  }

  #pick({ clientX, clientY }) {
    const box = canvas.getBoundingClientRect();
    const found = this.picture.pick(this.control.camera, (clientX - box.left) / box.width, (clientY - box.top) / box.height);
    this.panel.select(found && !found.isScenery ? found.name : "");
    this.wish();
  }

  // The keys of the OpenGL viewer.
  #press({ key, target, ctrlKey, altKey, metaKey }) {
    if (ctrlKey || altKey || metaKey || /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName)) return;
    const overlay = this.assets.overlays.find((one) => one.key === key.toUpperCase());
    const { panel } = this;
    if (/^[1-9]$/.test(key) && this.assets.cameras[key - 1]) this.control.choose(this.assets.cameras[key - 1].name);
    else if (key === "0") this.control.choose("");
    else if (key === "x" && panel.selected) panel.toggle(`hide.${panel.selected}`);
    else if (key === "b" && panel.selected) panel.toggle(`transparent.${panel.selected}`);
    else if (key === "/" && panel.selected) panel.toggle(`highlight.${panel.selected}`);
    else if (key === "Backspace") panel.showAll();
    else if (overlay) panel.toggle(`overlay.${overlay.name}`);
  }
}

function start(key) {
  document.getElementById("ask").hidden = true;
  const page = new Page(key);
  window.page = page;  // for whoever looks into it from the browser's console, and for tests
  page.begun.catch((error) => {
    if (error.message === "refused") {
      askForKey("This key is not the session's.");
    } else {
      page.panel.say(error.message, true);
      throw error;
    }
  });
}

// Who opens the page without the key can type it.
function askForKey(why) {
  const ask = document.getElementById("ask");
  ask.hidden = false;
  document.getElementById("why").textContent = why;
  ask.onsubmit = (event) => {
    event.preventDefault();
    address.set("key", document.getElementById("key").value.trim());
    location.hash = address.toString();
    location.reload();
  };
}

if (address.get("key")) start(address.get("key"));
else askForKey("The bridge prints the address with the key.");
