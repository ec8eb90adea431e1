// What the page shows beside the picture, kept up to date from the bus.

const MAX_EVENTS = 30;
const MAX_FORCES = 100;  // between two statuses
const norm = (values) => Math.hypot(...values);

export class Status {
  #beginMs = performance.now(); #entered = new Map(); #forces = new Map(); #events = []; #figures = new Map();
  #logic = null; #node = null;

  constructor(description) { this.description = description; }

  // The node of a session that begins; null: it is over.
  attach(node) {
    this.#node = node;
    if (!node) return;
    this.#beginMs = performance.now();
    for (const one of [this.#entered, this.#forces, this.#figures]) one.clear();
    this.#events = [];
    this.#logic = null;
  }

  apply({ topic, writer, body }) {
    const [kind, ...rest] = topic.split("/");
    const role = rest.slice(0, -1).join("/");
    if (topic === "logic/status") this.#takeLogic(body);
    else if (kind === "device" && topic.endsWith("/command")) this.#force(role).force = norm(body.fDoW.slice(0, 3));
    else if (kind === "haptic") this.#force(role).isInContact = body.isInContact;
    else if (kind === "figures") this.#figures.set(writer, body.name.map((name, i) => [name, body.value[i]]));
    else if (topic === "event") this.addEvent(body.source, body.name, body.detail);
  }

  // Keeps the present forces for the plot.
  sample() {
    for (const one of this.#forces.values()) {
      one.course.push(Number(one.force.toFixed(2)));
      if (one.course.length > MAX_FORCES) one.course.shift();
    }
  }

  #force(role) {
    if (!this.#forces.has(role)) this.#forces.set(role, { role, force: 0, isInContact: false, course: [] });
    return this.#forces.get(role);
  }

  #seconds() { return (performance.now() - this.#beginMs) / 1000; }

  addEvent(source, name, detail) {
    this.#events.push({ time_s: this.#seconds(), source, name, detail });
    if (this.#events.length > MAX_EVENTS) this.#events.shift();
  }

  #takeLogic(body) {
    if (body.step !== this.#logic?.step) this.#entered.set(body.step, this.#seconds());
    this.#logic = body;
  }

  // A step is done once the procedure is in a later one or at its end.
  #steps() {
    const names = this.description.steps;
    const now = names.indexOf(this.#logic?.step);
    const isOver = this.#logic?.isFinal && !this.#logic.isFailed;
    return names.map((name, i) => ({ name,
      state: isOver || i < now ? "done" : i === now ? (this.#logic.isFailed ? "failed" : "now") : "ahead" }));
  }

  // The courses of forces are those since the last call.
  take() {
    const logic = this.#logic;
    const hands = [...this.#forces.values()].map((hand) => ({ ...hand }));
    for (const one of this.#forces.values()) one.course = [];
    return {
      title: this.description.title ?? "",
      caption: logic?.hint ?? "",
      outcome: logic?.isFailed ? `failed: ${logic.why}` : logic?.isFinal ? "completed" : "",
      steps: this.#steps(),
      hands,
      nodes: (this.#node?.records() ?? []).map((record) => ({ name: record.name, isAlive: record.isAlive,
        isObserver: record.isObserver, figures: this.#figures.get(record.name) ?? [] })),
      events: this.#events,
    };
  }
}
