// Text over the picture: the scene's lines in its corners, labels at places, graphs. Names come from the bus: text only.

import * as THREE from "three";

const CORNERS = ["top-left", "top-right", "bottom-left", "bottom-right"];
const STYLES = ["small", "body", "title", "badge"];
const TEXT_MS = 100;  // figures that change with every frame could not be read

const toCode = (linear) => Math.round(255 * Math.min(1, Math.max(0, linear)) ** (1 / 2.2));
const cssColor = ([r, g, b]) => `rgb(${toCode(r)} ${toCode(g)} ${toCode(b)})`;

function element(className, text = "", color = null) {
  const made = document.createElement("div");
  made.className = className;
  made.textContent = text;
  if (color) made.style.color = cssColor(color);
  return made;
}

export class Hud {
  #shown = ""; #shownMs = 0; #labels = [];

  constructor(root) {
    this.root = root;
    this.corners = CORNERS.map((name) => root.appendChild(element(`corner ${name}`)));
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
    this.corners.forEach((corner, i) => corner.replaceChildren(...texts.filter(({ anchor }) => anchor === i).map((line) => {
      const made = element(STYLES[line.style], line.text, line.style === 3 ? null : line.color);
      if (line.style === 3) made.style.background = cssColor(line.color);
      return made;
    }), ...(i === 1 ? [this.graphs] : [])));
    this.graphs.replaceChildren(...graphs.map((graph) => this.#graph(graph)));
  }

  #graph({ title, values, most, color }) {
    const made = element("graph");
    made.append(element("small", title, color));
    const canvas = made.appendChild(document.createElement("canvas"));
    canvas.width = 2 * values.length;
    canvas.height = 52;
    const pen = canvas.getContext("2d", { willReadFrequently: true });
    pen.fillStyle = cssColor(color);
    values.forEach((value, i) => {
      const height = 52 * Math.min(1, Math.max(0, value / most));
      pen.fillRect(2 * i, 52 - height, 1.8, height);
    });
    return made;
  }

  // After each picture: labels stand above their places. One that would cover another moves up.
  place(camera) {
    const { clientWidth: width, clientHeight: height } = this.root;
    this.root.style.setProperty("--unit", `${Math.max(height, 460) / 460}px`);
    while (this.labels.children.length < this.#labels.length) this.labels.append(element("label"));
    const taken = [];
    [...this.labels.children].forEach((child, i) => {
      const label = this.#labels[i];
      const p = label && new THREE.Vector3(...label.at).project(camera);
      child.hidden = !p || p.z > 1 || Math.abs(p.x) > 1 || Math.abs(p.y) > 1;
      if (child.hidden) return;
      if (child.textContent !== label.text) child.textContent = label.text;
      child.style.color = cssColor(label.color);
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
