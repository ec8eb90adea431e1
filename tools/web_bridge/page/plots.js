// Courses over the last seconds: forces on the hands, latency.

const SAMPLES = 500;

export class Plot {
  #values = []; #least;

  // `least`: of the full height.
  constructor(parent, { title, unit, least, color }) {
    this.#least = least;
    Object.assign(this, { unit, color });
    this.box = document.createElement("div");
    this.box.className = "plot";
    const head = this.box.appendChild(document.createElement("div"));
    head.className = "plot-head";
    this.number = head.appendChild(document.createElement("b"));
    head.appendChild(document.createElement("span")).textContent = unit;
    this.title = head.appendChild(document.createElement("span"));
    this.title.textContent = title;
    this.note = head.appendChild(document.createElement("span"));
    this.note.className = "note";
    this.canvas = this.box.appendChild(document.createElement("canvas"));
    parent.append(this.box);
  }

  add(values) {
    this.#values.push(...values);
    if (this.#values.length > SAMPLES) this.#values.splice(0, this.#values.length - SAMPLES);
  }

  get newest() { return this.#values.at(-1); }

  draw() {
    const { canvas } = this;
    const width = Math.round(canvas.clientWidth * devicePixelRatio), height = Math.round(canvas.clientHeight * devicePixelRatio);
    if (width === 0) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const number = this.newest?.toFixed(1) ?? "–";
    if (this.number.textContent !== number) this.number.textContent = number;
    const top = Math.max(this.#least, ...this.#values);
    const pen = canvas.getContext("2d", { willReadFrequently: true });
    pen.clearRect(0, 0, width, height);
    pen.fillStyle = "#8b98a7";
    pen.font = `${11 * devicePixelRatio}px sans-serif`;
    pen.fillText(`${top.toFixed(top < 10 ? 1 : 0)} ${this.unit}`, 4 * devicePixelRatio, 13 * devicePixelRatio);
    pen.strokeStyle = this.color;
    pen.lineWidth = 1.5 * devicePixelRatio;
    pen.beginPath();
    this.#values.forEach((value, i) => {
      pen.lineTo(width * (1 - (this.#values.length - 1 - i) / (SAMPLES - 1)), (height - 1) * (1 - value / top));
    });
    pen.stroke();
  }
}
