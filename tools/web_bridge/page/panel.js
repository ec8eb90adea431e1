// Beside the picture: procedure, plots, what to show, parameters, nodes, events, the session, the recording. Names and
// details come from the bus: text only.

import { Plot } from "./plots.js";

const MARKS = { done: "✓", now: "▸", failed: "✗", ahead: "·" };
const COLORS = ["#ffb347", "#57c98a", "#6ec6ff", "#ff8fb1"];
const byId = (id) => document.getElementById(id);

function row(className, mark, text) {
  const item = document.createElement("li");
  item.className = className;
  const left = item.appendChild(document.createElement("span"));
  left.className = "mark";
  left.textContent = mark;
  item.appendChild(document.createElement("span")).textContent = text;
  return item;
}

// Replaces the list only when it has changed.
function fill(list, items) {
  const text = JSON.stringify(items);
  if (list.dataset.shown === text) return false;
  list.dataset.shown = text;
  list.replaceChildren(...items.map((item) => row(...item)));
  return true;
}

// A text that is set anew is a new node, even if it is the same.
function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

const timeText = (s) => `${Math.floor(s / 60)}:${(s % 60).toFixed(1).padStart(4, "0")}`;

export class Panel {
  #hands = new Map(); #latency; #t1 = null; #isSeeking = false; #choices = new Set(); #parameters = "";

  // `act`: what a person asks for: set(name, isOn), view(name), parameter(name, value), call(service, request).
  constructor(act) {
    this.act = act;
    this.#latency = new Plot(byId("latency"), { title: "message to pixel", unit: "ms", least: 20, color: COLORS[2] });
    byId("start").onclick = () => act.call("/session/start");
    byId("stop").onclick = () => act.call("/session/stop");
    byId("play").onclick = () => act.call("/recording/control", { command: byId("play").dataset.next });
    byId("speed").onchange = () => act.call("/recording/control", { command: "speed", value: Number(byId("speed").value) });
    byId("seek").oninput = () => {
      this.#isSeeking = true;
      act.call("/recording/control", { command: "seek", value: Number(byId("seek").value) });
    };
    byId("seek").onchange = () => { this.#isSeeking = false; };
    byId("parameter").onsubmit = (event) => {
      event.preventDefault();
      act.parameter(byId("parameter-name").value.trim(), Number(byId("parameter-value").value));
    };
    byId("fold").onclick = () => document.body.classList.toggle("folded");
  }

  // What a session has: cameras, overlays, parts.
  begin({ cameras, overlays, instances, recordingS }) {
    byId("recording").hidden = !(recordingS > 0);
    byId("seek").max = recordingS;
    const button = (text, title, onclick) => {
      const made = document.createElement("button");
      Object.assign(made, { textContent: text.replaceAll("_", " "), title, onclick });
      return made;
    };
    const views = [["", "steps"], ...cameras.map(({ name }) => [name, name])];
    byId("views").replaceChildren(...views.map(([name, text]) => {
      const made = button(text, name ? `camera ${name}` : "the camera of each step", () => this.act.view(name));
      made.dataset.view = name;
      return made;
    }));
    byId("overlays").replaceChildren(...overlays.map(({ name, key, what }) => {
      const made = button(name, `${what} (${key})`, () => this.toggle(`overlay.${name}`));
      made.dataset.choice = `overlay.${name}`;
      return made;
    }));
    const parts = instances.filter(({ name, isScenery }) => name && !isScenery).map(({ name }) => name);
    byId("part").replaceChildren(...["", ...parts].map((name) => new Option(name || "no part", name)));
    byId("part").onchange = () => this.select(byId("part").value);
    for (const what of ["hide", "transparent", "highlight"]) {
      byId(what).onclick = () => this.selected && this.toggle(`${what}.${this.selected}`);
    }
    byId("show-all").onclick = () => this.showAll();
  }

  toggle(choice) { this.act.set(choice, !this.#choices.has(choice)); }
  get selected() { return [...this.#choices].find((one) => one.startsWith("select."))?.slice("select.".length) ?? ""; }
  select(name) {
    if (name) this.act.set(`select.${name}`, true);
    else if (this.selected) this.act.set(`select.${this.selected}`, false);
  }
  showAll() {
    for (const choice of this.#choices) if (/^(hide|transparent|highlight)\./.test(choice)) this.act.set(choice, false);
  }

  showView(fixed, isFree) {
    for (const made of byId("views").children) made.classList.toggle("on", !isFree && made.dataset.view === fixed);
  }

  showFrame({ choices, atS, isPlaying }) {
    const said = choices.join();
    if (said !== byId("overlays").dataset.shown) {
      byId("overlays").dataset.shown = said;
      this.#choices = new Set(choices);
      for (const made of byId("overlays").children) made.classList.toggle("on", this.#choices.has(made.dataset.choice));
      byId("part").value = this.selected;
      for (const what of ["hide", "transparent", "highlight"]) {
        byId(what).disabled = !this.selected;
        byId(what).classList.toggle("on", this.#choices.has(`${what}.${this.selected}`));
      }
    }
    if (byId("recording").hidden) return;
    if (!this.#isSeeking) byId("seek").value = atS;
    setText(byId("at"), `${timeText(atS)} / ${timeText(Number(byId("seek").max))}`);
    setText(byId("play"), isPlaying ? "pause" : "play");
    byId("play").dataset.next = isPlaying ? "pause" : "play";
  }

  showLatency(ms) { this.#latency.add([ms]); }

  showStatus(status) {
    setText(byId("title"), status.title || "VR-OOS");
    fill(byId("steps"), status.steps.map(({ name, state }) => [state, MARKS[state], name.replaceAll("_", " ")]));
    setText(byId("outcome"), status.outcome);
    status.hands.forEach((hand, i) => this.#showHand(hand, i));
    this.#showT1(status.nodes);
    this.#latency.draw();
    byId("session").hidden = status.state === "recording";
    setText(byId("state"), { none: "no session runs here", starting: "a session starts", stopping: "it stops",
      running: "a session runs" }[status.state] ?? "");
    byId("start").disabled = !status.canStart;
    byId("stop").disabled = !status.canStop;
    fill(byId("nodes"), status.nodes.map(({ name, isAlive, isObserver }) =>
      [isAlive ? "alive" : "dead", isAlive ? "●" : "○", name + (isAlive ? (isObserver ? " (observer)" : "") : " (lost)")]));
    if (fill(byId("events"), status.events.map(({ time_s, source, name, detail }) =>
      ["", time_s.toFixed(1), `${source}: ${name} ${detail}`]))) {
      byId("events").scrollTop = byId("events").scrollHeight;
    }
    const parameters = status.parameters.join();
    if (parameters !== this.#parameters) {
      this.#parameters = parameters;
      byId("parameter-names").replaceChildren(...status.parameters.map((name) => new Option(name, name)));
    }
  }

  #showHand({ role, isInContact, course }, i) {
    if (!this.#hands.has(role)) {
      this.#hands.set(role, new Plot(byId("hands"), { title: role, unit: "N", least: 10, color: COLORS[i % COLORS.length] }));
    }
    const plot = this.#hands.get(role);
    plot.add(course);
    plot.note.textContent = isInContact ? "in contact" : "";
    plot.draw();
  }

  // The force loop's mean latency over the bridge's last window.
  #showT1(nodes) {
    const figures = nodes.find(({ name }) => name === "device_bridge")?.figures ?? [];
    const t1 = figures.find(([name]) => name === "t1_mean_ms")?.[1];
    if (t1 === undefined) return;
    this.#t1 ??= new Plot(byId("latency"), { title: "force loop (t1)", unit: "ms", least: 3, color: COLORS[1] });
    this.#t1.add([t1]);
    this.#t1.draw();
  }

  say(text, isBad = false) {
    byId("link").textContent = text;
    byId("link").classList.toggle("off", isBad);
  }
}
