// Measured figures as tables. Environment variable FIGURES: the folder for them, docs/performance/page when they are to
// be quoted; without it nothing is written.

import { mkdirSync, writeFileSync } from "node:fs";
import path from "node:path";

const cell = (value) => {
  const text = typeof value === "number" ? String(Number(value.toPrecision(6))) : value;
  return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
};

// `rows`: the first are the heads of the columns.
export function writeTable(name, rows) {
  if (!process.env.FIGURES) return;
  mkdirSync(process.env.FIGURES, { recursive: true });
  writeFileSync(path.join(process.env.FIGURES, `${name}.csv`), rows.map((row) => `${row.map(cell).join(",")}\n`).join(""));
}

export const medianOf = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];
