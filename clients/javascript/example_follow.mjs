// Prints where the objects of the running session are, twice a second: node example_follow.mjs [SECONDS]

import { Node, runningSession } from "./oos_bus.mjs";

const node = new Node({ name: "client-follow-js", ...runningSession() });
node.subscribe("physics/state");
node.subscribe("logic/status");
let newest;
node.on("message", ({ topic, body }) => {
  if (topic === "logic/status") console.log(`step ${body.step}: ${body.hint}`);
  else newest = body;
});
await node.start();
const printing = setInterval(() => {
  if (!newest) return;
  const poses = newest.object.map((object, i) => {
    const [x, y, z] = newest.xWo.slice(7 * i + 4, 7 * i + 7).map((value) => value.toFixed(3));
    return `object ${object} at ${x} ${y} ${z} m`;
  });
  console.log(`tick ${newest.tick}  ${poses.join("  ")}`);
}, 500);
setTimeout(() => {
  clearInterval(printing);
  node.close();
}, 1000 * Number(process.argv[2] ?? 10));
