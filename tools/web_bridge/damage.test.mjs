// The bridge survives malformed messages of a node. Environment variable CLIENTS_PEER: a registry and a node.

import assert from "node:assert/strict";
import { once } from "node:events";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { createInterface } from "node:readline";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import protocol from "@foxglove/ws-protocol";
import WebSocket from "ws";
import { LATEST, Node, digestOf, hash32, message, typeOf, writeEnvelope } from "../../clients/javascript/oos_bus.mjs";
import { spawnBound } from "../../clients/javascript/testing/spawn_bound.mjs";

const PATIENCE = { signal: AbortSignal.timeout(100_000) };
const HAND = "device/left/state";
const SHEETS = new Map([["physics/sheet/flag", 0], ["physics/sheet/ghost", 1000]]);  // object, which may not be there

// A scenario of one object, as `oos check --json` prints it.
const DESCRIPTION = { name: "one", title: "One", steps: [], hands: [], meshes: [],
  objects: [{ name: "ball", mesh: 0, sheet_color: [1, 1, 1], X_WO: [1, 0, 0, 0, 0, 0, 0] }] };

async function firstLineOf(child) {
  const [line] = await once(createInterface({ input: child.stdout }), "line", PATIENCE);
  return JSON.parse(line);
}

test("a malformed payload, or one about an unknown object, does not end the bridge", PATIENCE, async (t) => {
  const folder = mkdtempSync(path.join(tmpdir(), "web_bridge-"));
  writeFileSync(path.join(folder, "oos"), `#!/bin/sh\necho '${JSON.stringify(DESCRIPTION)}'\n`, { mode: 0o700 });
  writeFileSync(path.join(folder, "scene_stream"), "#!/bin/sh\nexec sleep 1000\n", { mode: 0o700 });
  const peer = spawnBound(process.env.CLIENTS_PEER, [], { stdio: ["ignore", "pipe", "inherit"] });
  const children = [peer];
  t.after(() => {
    for (const child of children) child.kill("SIGKILL");
    rmSync(folder, { recursive: true });
  });
  const where = await firstLineOf(peer);
  const bridge = spawnBound(process.execPath, [fileURLToPath(new URL("bridge.mjs", import.meta.url)), folder, "--programs", folder,
    "--registry", where.registry, "--session", where.session, "--port", "0"],
  { stdio: ["ignore", "pipe", "inherit"] });
  children.push(bridge);
  const { websocket } = await firstLineOf(bridge);

  const node = new Node({ name: "client", registry: where.registry, session: BigInt(where.session), keys: null,
    isObserver: false });
  t.after(() => node.close());
  for (const topic of [HAND, ...SHEETS.keys()]) node.advertise(topic);
  await node.start();

  // A client's subscriptions make the bridge decode these messages.
  const seen = new Map([[HAND, 0], ["physics/state", 0], ["/viz/transforms", 0], ["/viz/scene", 0]]);
  const client = new protocol.FoxgloveClient({
    ws: new WebSocket(websocket, [protocol.FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
  const topics = new Map();
  client.on("error", () => {});  // an end of the bridge is reported below
  client.on("advertise", (channels) => {
    for (const { id, topic } of channels.filter((one) => seen.has(one.topic))) topics.set(client.subscribe(id), topic);
  });
  client.on("message", ({ subscriptionId }) => {
    const topic = topics.get(subscriptionId);
    seen.set(topic, seen.get(topic) + 1);
  });

  const digest = digestOf(typeOf("oos.DeviceState"));
  const garbage = () => writeEnvelope({ ...node._stamp(), topicClass: LATEST, topic: hash32(HAND), digest,
    sequence: node._sequences.get(HAND) + 1n }, Buffer.from([255, 255, 255]));
  const speaking = setInterval(() => {
    node._sendToReaders(HAND, garbage());
    node.publish(HAND, message(HAND, { isEngaged: true }));
    for (const [topic, object] of SHEETS) node.publish(topic, message(topic, { object, numColumns: 1, pW: [0, 0, 0] }));
  }, 10);
  t.after(() => clearInterval(speaking));
  let state = "running";
  bridge.once("exit", (status) => { state = `it ended with ${status}`; });
  while (state === "running" && [...seen.values()].some((count) => count < 5)) {
    PATIENCE.signal.throwIfAborted();
    await new Promise(setImmediate);
  }
  assert.equal(state, "running", JSON.stringify([...seen]));
  client.close();
});
