// The page's skins, without a browser.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Skin } from "./page/picture/skin.js";

const HALF = Math.SQRT1_2;
const AT_REST = [1, 0, 0, 0, 0, 0, 0];

// Two vertices on the x axis, of the joints 0 at the origin and 1 at x = 1: one of the first, one half of each; one of none.
function made() {
  const vertices = new Float32Array([0.5, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0, 1, 0, 0, 0]);
  const weighted = new Float32Array([0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0.5, 0.5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
  const binds = new Float32Array([...AT_REST, 1, 0, 0, 0, -1, 0, 0]);
  return { vertices, skin: new Skin(vertices, weighted, binds) };
}

function near(vertices, at, wanted) {
  wanted.forEach((value, i) => assert.ok(Math.abs(vertices[at + i] - value) < 1e-6, `${i}: ${vertices[at + i]}, not ${value}`));
}

test("a skin whose joints are where it was made for lies as it was made", () => {
  const { vertices, skin } = made(), before = vertices.slice();
  assert.equal(skin.bend(new Float32Array([...AT_REST, 1, 0, 0, 0, 1, 0, 0]), vertices), true);
  assert.deepEqual(vertices, before);
});

test("a vertex goes with its joints by their weights, and its normal stays a unit vector", () => {
  const { vertices, skin } = made();
  // The second joint turns by 90 degrees about z, and has gone to (1, 1, 0): the vertex at x = 2 would be at (1, 2, 0).
  const turned = new Float32Array([...AT_REST, HALF, 0, 0, HALF, 1, 1, 0]);
  assert.equal(skin.bend(turned, vertices), true);
  near(vertices, 0, [0.5, 0, 0, 0, 1, 0]);
  near(vertices, 8, [1.5, 1, 0, -HALF, HALF, 0]);
  near(vertices, 16, [3, 0, 0, 0, 1, 0]);
  assert.equal(skin.bend(turned, vertices), false, "it is shown already");
});
