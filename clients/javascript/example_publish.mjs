// A scripted hand in place of device_bridge: draws a circle of 5 cm at some 500 samples a second, then emits an event.
//
//   oos run SCENARIO --without device_bridge
//   node example_publish.mjs ROLE [TURNS]

import { Node, message, runningSession } from "./oos_bus.mjs";

const PERIOD_MS = 2, TURN_S = 4, RADIUS_M = 0.05;
const [role, turns = 3] = process.argv.slice(2);
const topic = `device/${role}/state`;

// The hand at time t; D has the axes of W.
function sample(t) {
  const angle = (2 * Math.PI * t) / TURN_S, speed = (2 * Math.PI * RADIUS_M) / TURN_S;
  return message(topic, {
    sampleNs: process.hrtime.bigint(), isEngaged: true, isSimulated: true,
    xWd: [1, 0, 0, 0, RADIUS_M * Math.cos(angle), RADIUS_M * Math.sin(angle), 0.1],
    vWd: [0, 0, 0, -speed * Math.sin(angle), speed * Math.cos(angle), 0],
  });
}

const node = new Node({ name: "client-publish-js", isObserver: false, ...runningSession() });
node.advertise(topic);
await node.start();
const begin = performance.now();
const drawing = setInterval(() => {
  const t = (performance.now() - begin) / 1000;
  if (t < turns * TURN_S) {
    node.publish(topic, sample(t));
    return;
  }
  clearInterval(drawing);
  node.emitEvent("circle_drawn", `${turns} turns`);
  node.close();
}, PERIOD_MS);
