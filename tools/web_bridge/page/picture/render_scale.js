// At which share of its width and height the picture is drawn, so that it takes no longer than it may. It decides by the
// median of a few pictures, so single slow ones change nothing.

const LEAST = 0.3, STEP = 0.05, WINDOW = 9;
const RESERVE = 0.85;  // it goes up only if the next step is expected to take this share of the time, so it does not swing

const FIRST = 0.6;  // a slow machine shows its first picture sooner, a quick one has full size a second later

export class RenderScale {
  #steps = Math.round(FIRST / STEP); #times = [];

  constructor(budgetMs) { this.budgetMs = budgetMs; }

  get value() { return this.#steps * STEP; }

  // How long the newest picture took.
  update(ms) {
    this.#times.push(ms);
    if (this.#times.length < WINDOW) return;
    const middle = this.#times.sort((a, b) => a - b)[Math.floor(WINDOW / 2)];
    this.#times = [];
    if (middle > this.budgetMs) {
      const fitting = Math.floor(this.#steps * Math.sqrt(this.budgetMs / middle));
      this.#steps = Math.max(Math.round(LEAST / STEP), Math.min(fitting, this.#steps - 1));
    } else if (this.#steps < Math.round(1 / STEP)) {
      const larger = (this.#steps + 1) / this.#steps;
      if (middle * larger * larger < RESERVE * this.budgetMs) ++this.#steps;
    }
  }
}
