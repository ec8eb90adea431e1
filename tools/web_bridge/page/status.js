// Fills the page from the stream of /status.

import { View } from "./view.js";

const CURVE_SAMPLES = 200;  // 10 s
const MARKS = { done: "✓", now: "▸", failed: "✗", ahead: "·" };
const byId = (id) => document.getElementById(id);
const curves = new Map();  // by hand

// Text only: names and details come from the bus.
function row(className, mark, text) {
  const item = document.createElement("li");
  item.className = className;
  const left = document.createElement("span");
  left.className = "mark";
  left.textContent = mark;
  const right = document.createElement("span");
  right.textContent = text;
  item.append(left, right);
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

function curveOf(role) {
  if (!curves.has(role)) {
    const box = document.createElement("div");
    box.innerHTML = '<div class="force"><b></b><span>N</span><span class="role"></span><span class="touch"></span></div>' +
      '<canvas class="curve"></canvas>';
    box.querySelector(".role").textContent = role;
    byId("hands").append(box);
    curves.set(role, { box, values: [] });
  }
  return curves.get(role);
}

function draw({ box, values }) {
  const canvas = box.querySelector("canvas");
  const width = canvas.width = canvas.clientWidth * devicePixelRatio;
  const height = canvas.height = canvas.clientHeight * devicePixelRatio;
  const top = Math.max(10, ...values);
  const pen = canvas.getContext("2d");
  pen.strokeStyle = "#2c3642";
  pen.fillStyle = "#8b98a7";
  pen.font = `${11 * devicePixelRatio}px sans-serif`;
  pen.strokeRect(0, 0, width, height);
  pen.fillText(`${top.toFixed(0)} N`, 4 * devicePixelRatio, 13 * devicePixelRatio);
  pen.strokeStyle = "#ffb347";
  pen.lineWidth = 1.5 * devicePixelRatio;
  pen.beginPath();
  values.forEach((value, i) => {
    pen.lineTo(width * (1 - (values.length - 1 - i) / (CURVE_SAMPLES - 1)), height * (1 - value / top));
  });
  pen.stroke();
}

function showHand({ role, force, isInContact }) {
  const curve = curveOf(role);
  curve.values.push(force);
  if (curve.values.length > CURVE_SAMPLES) curve.values.shift();
  curve.box.querySelector("b").textContent = force.toFixed(1);
  curve.box.querySelector(".touch").textContent = isInContact ? "in contact" : "";
  draw(curve);
}

function show(status) {
  byId("title").textContent = status.title || "VR-OOS";
  byId("caption").textContent = status.outcome || status.caption;
  fill(byId("steps"), status.steps.map(({ name, state }) => [state, MARKS[state], name.replaceAll("_", " ")]));
  status.hands.forEach(showHand);
  fill(byId("nodes"), status.nodes.map(({ name, isAlive, isObserver }) =>
    [isAlive ? "alive" : "dead", isAlive ? "●" : "○", name + (isAlive ? (isObserver ? " (observer)" : "") : " (lost)")]));
  const events = byId("events");
  if (fill(events, status.events.map(({ time_s, source, name, detail }) =>
    ["", time_s.toFixed(1), `${source}: ${name} ${detail}`]))) {
    events.scrollTop = events.scrollHeight;
  }
}

const view = await View.create(byId("view"), await (await fetch("scene.json")).json());
const stream = new EventSource("status");
stream.onmessage = ({ data }) => {
  const status = JSON.parse(data);
  byId("link").textContent = "live";
  byId("link").className = "";
  show(status);
  view?.show(status);
};
stream.onerror = () => {
  byId("link").textContent = "the bridge does not answer";
  byId("link").className = "off";
};
