// The content of the page, kept up to date from the bus.

const MAX_EVENTS = 30;
const norm = (values) => Math.hypot(...values);

export class Status {
  #beginMs = performance.now(); #entered = new Map(); #forces = new Map(); #events = []; #figures = new Map();
  #logic = null;

  constructor(node, scene) {
    this.node = node;
    this.scene = scene;
  }

  apply({ topic, writer, body }) {
    const [kind, ...rest] = topic.split("/");
    const role = rest.slice(0, -1).join("/");
    if (topic === "logic/status") this.#takeLogic(body);
    else if (kind === "device" && topic.endsWith("/command")) this.#force(role).force = norm(body.fDoW.slice(0, 3));
    else if (kind === "haptic") this.#force(role).isInContact = body.isInContact;
    else if (kind === "figures") this.#figures.set(writer, body.name.map((name, i) => [name, body.value[i]]));
    else if (topic === "event") this.#addEvent(body.source, body.name, body.detail);
  }

  #force(role) {
    if (!this.#forces.has(role)) this.#forces.set(role, { role, force: 0, isInContact: false });
    return this.#forces.get(role);
  }

  #seconds() { return (performance.now() - this.#beginMs) / 1000; }

  #addEvent(source, name, detail) {
    this.#events.push({ time_s: this.#seconds(), source, name, detail });
    if (this.#events.length > MAX_EVENTS) this.#events.shift();
  }

  #takeLogic(body) {
    if (body.step !== this.#logic?.step) this.#entered.set(body.step, this.#seconds());
    this.#logic = body;
  }

  // A step is done once the procedure is in a later one or at its end.
  #steps() {
    const names = this.scene?.description.steps ?? [...this.#entered.keys()];
    const now = names.indexOf(this.#logic?.step);
    const isOver = this.#logic?.isFinal && !this.#logic.isFailed;
    return names.map((name, i) => ({ name,
      state: isOver || i < now ? "done" : i === now ? (this.#logic.isFailed ? "failed" : "now") : "ahead" }));
  }

  snapshot() {
    const logic = this.#logic;
    return {
      title: this.scene?.description.title ?? "",
      caption: logic?.hint ?? "waiting for the procedure",
      outcome: logic?.isFailed ? `failed: ${logic.why}` : logic?.isFinal ? "completed" : "",
      steps: this.#steps(),
      hands: [...this.#forces.values()],
      nodes: this.node.records().map((record) => ({ name: record.name, isAlive: record.isAlive,
        isObserver: record.isObserver, figures: this.#figures.get(record.name) ?? [] })),
      events: this.#events,
      poses: this.scene?.poses ?? [],
      lamps: [...(this.scene?.lamps ?? [])],
      sheets: this.scene?.sheetMeshes() ?? [],
    };
  }
}
