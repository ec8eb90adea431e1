// Text over the picture: the scene's lines in its corners, labels at places, graphs. Names come from the bus: text only.

import * as THREE from "three";

const CORNERS = ["top-left", "top-right", "bottom-left", "bottom-right"];
const STYLES = ["small", "body", "title", "badge"];
const TEXT_MS = 100;  // figures that change with every frame could not be read

const toCode = (linear) => Math.round(255 * Math.min(1, Math.max(0, linear)) ** (1 / 2.2));
const cssColor = ([r, g, b]) => `rgb(${toCode(r)} ${toCode(g)} ${toCode(b)})`;

// Sets what is different: a text that is set anew is a new node each time.
function dress(made, className, text = "", color = "", background = "") {
  if (made.className !== className) made.className = className;
  if (made.textContent !== text) made.textContent = text;
  for (const [name, value] of [["color", color], ["background", background]]) {
    if ((made.dataset[name] ?? "") === value) continue;
    made.dataset[name] = value;
    made.style[name] = value;
  }
  return made;
}
const element = (className) => dress(document.createElement("div"), className);

// As many children as there are items, each filled with its item.
function fill(parent, items, make, show) {
  while (parent.children.length > items.length) parent.lastChild.remove();
  while (parent.children.length < items.length) parent.append(make());
  items.forEach((item, i) => show(parent.children[i], item));
}

function makeGraph() {
  const made = element("graph");
  made.append(element("small"), document.createElement("canvas"));
  return made;
}

function showGraph({ children: [head, canvas] }, { title, values, most, color }) {
  dress(head, "small", title, cssColor(color));
  const width = 2 * values.length, height = 52;
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const pen = canvas.getContext("2d", { willReadFrequently: true });
  pen.clearRect(0, 0, width, height);
  pen.fillStyle = cssColor(color);
  values.forEach((value, i) => {
    const high = height * Math.min(1, Math.max(0, value / most));
    pen.fillRect(2 * i, height - high, 1.8, high);
  });
}

function showLine(made, { style, text, color }) {
  const isBadge = style === 3;
  dress(made, STYLES[style], text, isBadge ? "" : cssColor(color), isBadge ? cssColor(color) : "");
}

export class Hud {
  #shown = ""; #shownMs = 0; #labels = []; #unit = 0;

  constructor(root) {
    this.root = root;
    this.corners = CORNERS.map((name) => root.appendChild(element(`corner ${name}`)));
    this.lines = this.corners.map((corner) => corner.appendChild(element("lines")));
    this.graphs = this.corners[1].appendChild(element("graphs"));
    this.labels = root.appendChild(element("labels"));
  }

  show({ texts, graphs, labels }) {
    this.#labels = labels;
    const now = performance.now();
    if (now - this.#shownMs < TEXT_MS) return;
    const said = JSON.stringify([texts, graphs]);
    if (said === this.#shown) return;
    this.#shown = said;
    this.#shownMs = now;
    this.lines.forEach((lines, i) => fill(lines, texts.filter(({ anchor }) => anchor === i), () => element(""), showLine));
    fill(this.graphs, graphs, makeGraph, showGraph);
    this.corners.forEach((corner) => { corner.hidden = [...corner.children].every((part) => part.children.length === 0); });
  }

  // After each picture: labels stand above their places. One that would cover another moves up.
  place(camera) {
    const { clientWidth: width, clientHeight: height } = this.root;
    const unit = Math.max(height, 460) / 460;
    if (unit !== this.#unit) this.root.style.setProperty("--unit", `${unit}px`);
    this.#unit = unit;
    while (this.labels.children.length < this.#labels.length) this.labels.append(element("label"));
    const taken = [];
    [...this.labels.children].forEach((child, i) => {
      const label = this.#labels[i];
      const p = label && new THREE.Vector3(...label.at).project(camera);
      child.hidden = !p || p.z > 1 || Math.abs(p.x) > 1 || Math.abs(p.y) > 1;
      if (child.hidden) return;
      dress(child, "label", label.text, cssColor(label.color));
      const x = Math.min(width - child.offsetWidth / 2, Math.max(child.offsetWidth / 2, (0.5 + 0.5 * p.x) * width));
      let y = (0.5 - 0.5 * p.y) * height - 10;
      while (taken.some((one) => Math.abs(one.y - y) < child.offsetHeight && Math.abs(one.x - x) < child.offsetWidth)) {
        y -= child.offsetHeight;
      }
      taken.push({ x, y });
      child.style.transform = `translate(-50%, -100%) translate(${x}px, ${y}px)`;
    });
  }
}
