// A person steers a hand from the page, as from the OpenGL viewer: right mouse button or arrow keys, Space, F1, F2.
// Sends what was done since the last message (`hand` of scene_stream/commands.hpp).

const KEYS = { ArrowRight: [0, 1], ArrowLeft: [0, -1], ArrowUp: [1, 1], ArrowDown: [1, -1], PageUp: [2, 1], PageDown: [2, -1] };
const NOTCH_PX = 100;     // of a wheel
const PERIOD_MS = 30;     // of messages
const MOST_UNANSWERED = 4;

export class HandControl {
  canSteer = false;  // a session that a person steers: the captions speak of the hand
  isClosed = false; showsNext = false; role = 0;
  #send; #element; #keys = new Set(); #drag = [0, 0]; #wheel = 0; #isDragged = false; #isActive = false; #last = null;
  #sentMs = 0; #timer = null; #unanswered = 0; #control = null; #heightPx = 1; #shift = false; #ctrl = false;

  constructor(element, send) {
    this.#element = element;
    this.#send = send;
    element.addEventListener("contextmenu", (event) => this.canSteer && event.preventDefault());
    // Before the camera's own listeners.
    element.addEventListener("pointerdown", (event) => this.#down(event), true);
    element.addEventListener("wheel", (event) => this.#turnWheel(event), { capture: true, passive: false });
    addEventListener("pointermove", (event) => this.#move(event), true);
    addEventListener("pointerup", (event) => this.#up(event), true);
    addEventListener("keydown", (event) => this.#press(event), true);
    addEventListener("keyup", (event) => this.#release(event), true);
    addEventListener("blur", () => this.#letGo());
  }

  // Once a picture: what it is seen through.
  update(texts, control, heightPx) {
    this.canSteer = texts.some(({ text }) => text.startsWith("hand "));
    this.#control = control;
    this.#heightPx = heightPx;
  }

  #down(event) {
    if (!this.canSteer || event.button !== 2) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    this.#isDragged = true;
    this.#last = [event.clientX, event.clientY];
    this.#wish(event);
  }
  #move(event) {
    if (!this.#isDragged) return;
    this.#drag[0] += event.clientX - this.#last[0];
    this.#drag[1] += this.#last[1] - event.clientY;
    this.#last = [event.clientX, event.clientY];
    this.#wish(event);
  }
  #up(event) {
    if (event.button === 2) this.#isDragged = false;
    this.#wish(event);
  }
  #turnWheel(event) {
    if (!this.#isDragged) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    this.#wheel -= event.deltaY / NOTCH_PX;
    this.#wish(event);
  }

  #press(event) {
    if (!this.canSteer || /^(INPUT|SELECT|TEXTAREA|BUTTON)$/.test(event.target.tagName)) return;
    const { key } = event;
    if (key === " " && !event.repeat) this.isClosed = !this.isClosed;
    else if (key === "F2" && !event.repeat) this.showsNext = !this.showsNext;
    else if (key === "Insert" && !event.repeat) ++this.role;
    else if (key in KEYS || key === "F1") this.#keys.add(key);
    else if (key !== "Shift" && key !== "Control") return;
    if (key !== "Shift" && key !== "Control") event.preventDefault();
    this.#wish(event);
  }
  #release(event) {
    this.#keys.delete(event.key);
    this.#wish(event);
  }
  #letGo() {
    this.#keys.clear();
    this.#isDragged = false;
    this.#plan();
  }

  #wish({ shiftKey, ctrlKey }) {
    this.#shift = shiftKey;
    this.#ctrl = ctrlKey;
    if (this.canSteer) this.#plan();
  }

  #plan() {
    this.#timer ??= setTimeout(() => {
      this.#timer = null;
      this.#tell();
    }, PERIOD_MS);
  }

  // While something is held the message goes on, so that the bridge knows that the person is there; and once more after.
  #tell() {
    const now = performance.now();
    const dtS = this.#isActive ? (now - this.#sentMs) / 1000 : 0;
    const axes = [0, 0, 0];
    for (const key of this.#keys) if (key in KEYS) axes[KEYS[key][0]] += KEYS[key][1];
    const isHeld = this.#isDragged || axes.some((value) => value !== 0);
    const isActive = isHeld || this.#keys.has("F1");
    if (this.#unanswered < MOST_UNANSWERED && this.#control) {
      const { camera, controls } = this.#control;
      const none = [0, 0, 0];
      const turn = [-axes[1], axes[0], axes[2]];  // an arrow to the right turns about the upward axis
      this.#sentMs = now;
      ++this.#unanswered;
      this.#send([isHeld, this.#ctrl, this.#shift, this.#keys.has("F1"), this.showsNext, this.isClosed, this.role,
        ...this.#drag, this.#wheel, ...(this.#ctrl ? none : axes), ...(this.#ctrl ? turn : none), dtS, this.#heightPx,
        ...camera.position.toArray(), ...controls.target.toArray(), camera.fov * Math.PI / 180].map(Number))
        .catch(() => {}).finally(() => { --this.#unanswered; });
      this.#drag = [0, 0];
      this.#wheel = 0;
    }
    const wasActive = this.#isActive;
    this.#isActive = isActive;
    if (isActive || wasActive) this.#plan();
  }
}
