// A skin that goes with its joints: view::BendSkin of libs/view/appearance, over the page's vertices.

const POSE = 7, VERTEX = 8, WEIGHTED = 8;  // floats

// The matrix of a pose, quaternion first, row by row: 3 x 4.
function matrixOf(poses, at) {
  const [w, x, y, z, px, py, pz] = poses.subarray(at, at + POSE);
  return [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), px,
    2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), py,
    2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), pz];
}

function product(a, b) {
  const c = [];
  for (let row = 0; row < 12; row += 4) {
    for (let column = 0; column < 4; ++column) {
      c.push(a[row] * b[column] + a[row + 1] * b[4 + column] + a[row + 2] * b[8 + column] + (column === 3 ? a[row + 3] : 0));
    }
  }
  return c;
}

export class Skin {
  // Position, normal and texture coordinates of each vertex at rest; its joints and weights; poses of the joints' binding.
  constructor(vertices, weighted, binds) {
    this.rest = vertices.slice();
    this.weighted = weighted;
    this.binds = Array.from({ length: binds.length / POSE }, (_, joint) => matrixOf(binds, POSE * joint));
    this.shown = "";
  }

  // False: the posture is the one that is shown.
  bend(poses, vertices) {
    const posture = poses.join();
    if (posture === this.shown) return false;
    this.shown = posture;
    const moves = this.binds.map((bind, joint) => product(matrixOf(poses, POSE * joint), bind));
    for (let at = 0, from = 0; at < vertices.length; at += VERTEX, from += WEIGHTED) this.#bendVertex(moves, at, from, vertices);
    return true;
  }

  #bendVertex(moves, at, from, vertices) {
    const mixed = new Float64Array(12);
    for (let k = 0; k < 4; ++k) {
      const weight = this.weighted[from + 4 + k];
      if (weight === 0) continue;
      const move = moves[this.weighted[from + k]];
      for (let i = 0; i < 12; ++i) mixed[i] += weight * move[i];
    }
    if (!mixed.some((value) => value !== 0)) return;
    const [x, y, z, nx, ny, nz] = this.rest.subarray(at, at + 6);
    const normal = [0, 4, 8].map((row) => mixed[row] * nx + mixed[row + 1] * ny + mixed[row + 2] * nz);
    const length = Math.hypot(...normal);
    [0, 4, 8].forEach((row, i) => {
      vertices[at + i] = mixed[row] * x + mixed[row + 1] * y + mixed[row + 2] * z + mixed[row + 3];
      if (length > 0) vertices[at + 3 + i] = normal[i] / length;
    });
  }
}
