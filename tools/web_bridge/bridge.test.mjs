// The bridge on a live run of scenarios/touch, as a Foxglove client and a browser receive it. Environment variable OOS:
// the program, beside the nodes.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { createInterface } from "node:readline";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import protocol from "@foxglove/ws-protocol";
import WebSocket from "ws";
import { createFileRegistry, fromBinary, wkt } from "../../clients/javascript/oos_bus.mjs";

const SCENARIO = fileURLToPath(new URL("../../scenarios/touch", import.meta.url));
const PATIENCE = { signal: AbortSignal.timeout(150_000) };  // the first run of a scene cooks its structures
const folder = mkdtempSync(path.join(tmpdir(), "web_bridge-"));
const env = { ...process.env, XDG_RUNTIME_DIR: folder };
const said = [];
let run, bridge, where;

function start(program, words) {
  const child = spawn(program, words, { env, stdio: ["ignore", "pipe", "pipe"] });
  for (const input of [child.stdout, child.stderr]) createInterface({ input }).on("line", (line) => said.push(line));
  return child;
}

// The first line of a child's output that meets the condition.
function lineOf(child, condition) {
  return new Promise((resolve, reject) => {
    createInterface({ input: child.stdout }).on("line", (line) => condition(line) && resolve(line));
    child.once("exit", () => reject(new Error(said.join("\n"))));
    PATIENCE.signal.addEventListener("abort", () => reject(new Error(`too late\n${said.join("\n")}`)));
  });
}

before(async () => {
  run = start(process.env.OOS, ["run", SCENARIO, "--headless", "--without", "visual_node", "--rt", "off",
    "--out", path.join(folder, "out")]);
  await lineOf(run, (line) => line.startsWith("starting"));  // from here on the bridge finds the session
  bridge = start(process.execPath, [fileURLToPath(new URL("bridge.mjs", import.meta.url)), SCENARIO,
    "--oos", process.env.OOS, "--websocket_port", "0", "--page_port", "0"]);
  where = JSON.parse(await lineOf(bridge, (line) => line.startsWith("{")));
});

after(async () => {
  for (const child of [bridge, run].filter((one) => one && one.exitCode === null)) {
    child.kill("SIGTERM");
    await once(child, "exit");
  }
  rmSync(folder, { recursive: true });
});

// Subscribes to these channels and calls take(topic, message) for every message until it returns true. Messages are
// decoded by the descriptors that the channel advertises.
async function receive(topics, take) {
  const socket = new WebSocket(where.websocket, [protocol.FoxgloveClient.SUPPORTED_SUBPROTOCOL]);
  const client = new protocol.FoxgloveClient({ ws: socket });
  const types = new Map();
  await new Promise((resolve, reject) => {
    PATIENCE.signal.addEventListener("abort", () => reject(new Error(`it never came\n${said.join("\n")}`)));
    client.on("error", reject);
    client.on("advertise", (channels) => {
      for (const channel of channels.filter((one) => topics.includes(one.topic))) {
        assert.equal(channel.encoding, "protobuf");
        const set = fromBinary(wkt.FileDescriptorSetSchema, Buffer.from(channel.schema, "base64"));
        types.set(client.subscribe(channel.id), [channel.topic, createFileRegistry(set).getMessage(channel.schemaName)]);
      }
    });
    client.on("message", ({ subscriptionId, data }) => {
      const [topic, type] = types.get(subscriptionId);
      if (take(topic, fromBinary(type, new Uint8Array(data.buffer, data.byteOffset, data.byteLength)))) resolve();
    });
  });
  client.close();
}

test("a Foxglove client sees the ball move", PATIENCE, async () => {
  let first, meshes, ticks = 0, moved = 0;
  await receive(["/viz/scene", "/viz/transforms", "physics/state"], (topic, message) => {
    if (topic === "physics/state") ++ticks;
    if (topic === "/viz/scene") meshes = message.entities;
    if (topic === "/viz/transforms") {
      const ball = message.transforms.find((one) => one.childFrameId === "ball");
      assert.equal(ball.parentFrameId, "world");
      const { x, y, z } = ball.translation;
      first ??= [x, y, z];
      moved = Math.max(moved, Math.hypot(x - first[0], y - first[1], z - first[2]));
    }
    return moved > 0.01 && meshes && ticks > 10;
  });
  const ball = meshes.find((entity) => entity.id === "ball");
  assert.equal(ball.frameId, "ball");
  const [{ points, indices }] = ball.triangles;
  assert.ok(indices.length > 300 && indices.every((index) => index < points.length));
  for (const { x, y, z } of points) assert.ok(Math.abs(Math.hypot(x, y, z) - 0.01) < 2e-4, "20 mm across");
});

test("a client that joins late receives the procedure's state", PATIENCE, async () => {
  let status;
  await receive(["logic/status"], (_, message) => (status = message).step !== "");
  assert.ok(["press", "slide", "edge", "push_block"].includes(status.step), status.step);
});

test("a browser gets the page, the scene and live updates", PATIENCE, async () => {
  const page = await fetch(where.page);
  assert.match(await page.text(), /<title>VR-OOS/);
  const scene = await (await fetch(`${where.page}scene.json`)).json();
  assert.deepEqual(scene.steps, ["press", "slide", "edge", "push_block"]);
  assert.equal((await fetch(`${where.page}../bridge.mjs`)).status, 404);
  const stream = await fetch(`${where.page}status`);
  let text = "", status = null;
  for await (const chunk of stream.body) {
    text += Buffer.from(chunk).toString();
    const events = text.split("\n\n");
    text = events.pop();
    if (events.length > 0) status = JSON.parse(events.at(-1).replace(/^data: /, ""));
    if (status?.nodes.filter((node) => node.isAlive).length >= 5 && status.hands.length > 0) break;
  }
  const names = status.nodes.map((node) => node.name);
  for (const name of ["device_bridge", "haptic_node", "physics_node", "logic_node"]) assert.ok(names.includes(name), name);
  assert.equal(status.poses.length, scene.objects.length);
  assert.equal(status.hands[0].role, "right");
});
