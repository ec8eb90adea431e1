// Pictures of the page against those of the OpenGL renderer. Environment variable PAGE_COMPARE: the program.

import { writeFileSync } from "node:fs";
import path from "node:path";
import { createInterface } from "node:readline";
import { spawnBound } from "../../../clients/javascript/testing/spawn_bound.mjs";
import { scenarioFolder } from "./processes.mjs";

// Five views of a scenario: its standing cameras, then the first one's, turned about its target.
export function viewsOf(assets) {
  const standing = assets.cameras.filter(({ isMounted }) => !isMounted).map(({ name, eyeM, targetM, verticalFovRad }) =>
    ({ name, eye: eyeM, target: targetM, fov: verticalFovRad }));
  const [first] = standing;
  for (let turn = 1; standing.length < 5; ++turn) {
    const [x, y, z] = first.eye.map((value, i) => value - first.target[i]);
    const angle = 1.1 * turn;
    const eye = [x * Math.cos(angle) - y * Math.sin(angle), x * Math.sin(angle) + y * Math.cos(angle), z]
      .map((value, i) => value + first.target[i]);
    standing.push({ ...first, name: `${first.name}_turned_${turn}`, eye });
  }
  return standing.slice(0, 5);
}

// The page's canvas and what is seen at each pixel.
async function photograph(page, view, { width, height }) {
  return page.evaluate(async ([{ eye, target, fov }, w, h]) => {
    const { picture, control, frame } = window.page;
    control.cameras = [{ name: "", eyeM: eye, targetM: target, verticalFovRad: fov, object: -1, isMounted: false, up: [0, 0, 0] }];
    control.fixed = "";
    control.isFree = false;
    control.update(frame.step, picture.bodies.instances, w / h);
    const { camera } = control;
    picture.draw(camera, { width: w, height: h, isStill: true, inset: window.page.inset(w / h) });
    const blob = new Promise((resolve) => picture.renderer.domElement.toBlob(resolve));
    const ids = picture.readIds(camera, w, h);  // before the page draws its own next picture
    const bytes = new Uint8Array(await (await blob).arrayBuffer());
    const rows = [];  // from the upper left corner
    for (let y = h - 1; y >= 0; --y) rows.push(...ids.subarray(y * w, (y + 1) * w));
    return { png: Array.from(bytes), ids: rows };
  }, [view, width, height]);
}

// Of each view: {view, flip, same_ids, same_ids_inside}. Pictures go to `folder`.
export async function compare(page, scenario, views, { folder, width = 640, height = 360, options = [] }) {
  const child = spawnBound(process.env.PAGE_COMPARE, ["--scenario", scenarioFolder(scenario), "--keep", path.join(folder, "gl"),
    ...options], { stdio: ["pipe", "pipe", "inherit"] });
  const lines = createInterface({ input: child.stdout })[Symbol.asyncIterator]();
  const results = [];
  for (const view of views) {
    const { png, ids } = await photograph(page, view, { width, height });
    const title = `${scenario.replaceAll("/", "_")}-${view.name}`;
    const files = [path.join(folder, `${title}.png`), path.join(folder, `${title}.ids`)];
    writeFileSync(files[0], Buffer.from(png));
    writeFileSync(files[1], Buffer.from(Uint16Array.from(ids).buffer));
    child.stdin.write(`${[view.name, ...view.eye, ...view.target, view.fov, width, height, ...files].join(" ")}\n`);
    const { value, done } = await lines.next();
    if (done) throw new Error("page_compare ended");
    results.push(JSON.parse(value));
  }
  child.stdin.end();
  return results;
}
