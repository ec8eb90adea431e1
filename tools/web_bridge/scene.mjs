// The present state of a scenario's objects, from the bus's messages, and the same as Foxglove's messages.
// A pose is [w, x, y, z, px, py, pz], as in `oos check --json` and on the bus.

const WORLD = "world";
const JAW_SIDE = { palm: 0, jaw_left: -0.5, jaw_right: 0.5 };

// X_WP moved by x along its own x axis.
function shiftedAlongX([w, x, y, z, px, py, pz], shift) {
  return [w, x, y, z, px + shift * (1 - 2 * (y * y + z * z)), py + shift * 2 * (x * y + w * z),
    pz + shift * 2 * (x * z - w * y)];
}

const isPose = (numbers) => numbers.length === 7 && numbers.every(Number.isFinite);

// Linear colour to sRGB.
export const toScreen = (linear) => linear.map((c) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));
const colorOf = (linear) => {
  const [r, g, b] = toScreen(linear);
  return { r, g, b, a: 1 };
};

const pointsOf = (flat) => Array.from({ length: flat.length / 3 }, (_, i) =>
  ({ x: flat[3 * i], y: flat[3 * i + 1], z: flat[3 * i + 2] }));

// Two triangles for each cell of a grid, both sides.
function gridIndices(numNodes, numColumns) {
  const indices = [];
  for (let a = 0; a + numColumns < numNodes; ++a) {
    if (a % numColumns === numColumns - 1) continue;
    const [b, c, d] = [a + 1, a + numColumns, a + numColumns + 1];
    indices.push(a, b, d, a, d, c, a, d, b, a, c, d);
  }
  return indices;
}

export class Scene {
  constructor(description) {  // of `oos check --json`
    this.description = description;
    this.poses = description.objects.map((object) => object.X_WO);
    this.lamps = new Map();   // object index -> linear colour
    this.sheets = new Map();  // object index -> {numColumns, positions}
    description.hands.forEach((hand, role) => this.#moveHand(role, hand.X_WD, hand.opening_m));
  }

  #has(object) { return object < this.description.objects.length; }

  #moveHand(role, X_WP, opening) {
    this.description.objects.forEach((object, i) => {
      if (object.role_index === role) this.poses[i] = shiftedAlongX(X_WP, JAW_SIDE[object.part] * opening);
    });
  }

  // Applies a message of the bus; true if an entity's appearance has changed, not only its pose. Ignores objects that the
  // scenario does not have.
  apply({ topic, body }) {
    if (topic === "physics/state") {
      body.object.forEach((object, i) => {
        const pose = body.xWo.slice(7 * i, 7 * i + 7);
        if (this.#has(object) && isPose(pose)) this.poses[object] = pose;
      });
    } else if (topic.startsWith("haptic/") && topic.endsWith("/proxy") && isPose(body.xWc)) {
      this.#moveHand(body.roleIndex, body.xWc, body.openingM);
    } else if (topic.startsWith("physics/sheet/") && this.#has(body.object)) {
      this.sheets.set(body.object, { numColumns: body.numColumns, positions: body.pW });
    } else if (topic === "logic/status") {
      for (const { object, red, green, blue } of body.lamps) this.lamps.set(object, [red, green, blue]);
      return body.lamps.length > 0;
    }
    return false;
  }

  // foxglove.FrameTransforms: every object's mesh frame in the world's.
  transforms(timestamp) {
    return { transforms: this.poses.map(([w, x, y, z, px, py, pz], i) => ({
      timestamp, parentFrameId: WORLD, childFrameId: this.description.objects[i].name,
      translation: { x: px, y: py, z: pz }, rotation: { x, y, z, w } })) };
  }

  // foxglove.SceneUpdate: every object's mesh, in its own frame.
  meshes(timestamp) {
    const entities = this.description.objects.map((object, i) => ({
      timestamp, frameId: object.name, id: object.name, frameLocked: true,
      triangles: (this.description.meshes[object.mesh] ?? []).map((part) => ({
        pose: { position: {}, orientation: { w: 1 } }, points: pointsOf(part.positions), indices: part.indices,
        color: colorOf(this.lamps.get(i) ?? object.base_color ?? part.base_color) })) }));
    return { entities: entities.filter((entity) => entity.triangles.length > 0) };
  }

  // The deformable sheets, in the world's frame.
  sheetMeshes() {
    return [...this.sheets].map(([object, { numColumns, positions }]) => ({ positions,
      indices: gridIndices(positions.length / 3, numColumns), base_color: this.description.objects[object].sheet_color }));
  }

  // foxglove.SceneUpdate of the sheets.
  sheetUpdate(timestamp) {
    return { entities: this.sheetMeshes().map(({ positions, indices, base_color }, i) => ({
      timestamp, frameId: WORLD, id: `sheet ${i}`,
      triangles: [{ pose: { position: {}, orientation: { w: 1 } }, points: pointsOf(positions), indices,
        color: colorOf(base_color) }] })) };
  }
}
