// The bridge on a live run of scenarios/touch, as a Foxglove client and a browser receive it. Environment variable OOS:
// the program, beside the nodes.

import assert from "node:assert/strict";
import { once } from "node:events";
import { existsSync, readFileSync, readdirSync, statSync } from "node:fs";
import path from "node:path";
import { after, before, test } from "node:test";
import protocol from "@foxglove/ws-protocol";
import WebSocket from "ws";
import { createFileRegistry, fromBinary, typeOf, wkt } from "../../clients/javascript/oos_bus.mjs";
import { lastingTouch } from "./testing/lasting_touch.mjs";
import { PATIENCE, Processes } from "./testing/processes.mjs";

const processes = new Processes();
const touch = lastingTouch(processes.folder);
let where;

before(async () => {
  await processes.startSession(touch);
  where = await processes.startBridge(touch);
});
after(() => processes.endAll());

// Subscribes to these channels and calls take(topic, message) for every message until it returns true. Messages are
// decoded by the descriptors that the channel advertises.
async function receive(topics, take) {
  const socket = new WebSocket(where.websocket, [protocol.FoxgloveClient.SUPPORTED_SUBPROTOCOL]);
  const client = new protocol.FoxgloveClient({ ws: socket });
  const types = new Map();
  await new Promise((resolve, reject) => {
    PATIENCE.signal.addEventListener("abort", () => reject(new Error(`it never came\n${processes.said.join("\n")}`)));
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

test("a bridge ends with the test that started it, also with one that is killed", PATIENCE, async () => {
  const equipment = new URL("./testing/processes.mjs", import.meta.url);
  const starter = processes.start(process.execPath, ["--input-type=module", "--eval", `
    process.env.TMPDIR = process.cwd();
    const { Processes } = await import("${equipment}");
    console.log((await new Processes().startBridge("touch")).websocket);`]);
  const url = await processes.lineOf(starter, (line) => line.startsWith("ws:"));
  const socket = new WebSocket(url, [protocol.FoxgloveClient.SUPPORTED_SUBPROTOCOL]);
  await once(socket, "open", PATIENCE);
  starter.kill("SIGKILL");
  await once(socket, "close", PATIENCE);
});

// Calls a service without parameters.
async function call(url, name) {
  const socket = new WebSocket(url, [protocol.FoxgloveClient.SUPPORTED_SUBPROTOCOL]);
  const client = new protocol.FoxgloveClient({ ws: socket });
  await new Promise((resolve, reject) => {
    PATIENCE.signal.addEventListener("abort", () => reject(new Error(`${name} never answered`)));
    client.on("error", reject);
    client.on("advertiseServices", (services) => client.sendServiceCallRequest({ callId: 1, encoding: "json",
      serviceId: services.find((one) => one.name === name).id,
      data: new DataView(new TextEncoder().encode("{}").buffer) }));
    client.on("serviceCallResponse", resolve);
    client.on("serviceCallFailure", reject);
  });
  client.close();
}

async function until(holds) {
  while (!holds()) {
    PATIENCE.signal.throwIfAborted();
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

test("a session that the page has started ends with the bridge, also with one that is killed", PATIENCE, async () => {
  const own = new Processes();  // where no session runs yet
  try {
    const bridge = await own.startBridge("touch");
    await call(bridge.websocket, "/session/start");
    const note = path.join(own.folder, "vr_oos/session.json");
    await until(() => existsSync(note));
    const { pid } = JSON.parse(readFileSync(note, "utf8"));
    bridge.child.kill("SIGKILL");
    await until(() => !existsSync(note));
    await until(() => !existsSync(`/proc/${pid}`) || readFileSync(`/proc/${pid}/stat`, "utf8").includes(") Z"));
    const { why } = JSON.parse(readFileSync(path.join(own.folder, "out", readdirSync(path.join(own.folder, "out"))[0],
      "report.json"), "utf8"));
    assert.equal(why, "interrupted");
  } finally {
    await own.endAll();
  }
});

// Waits for a message of a JSON channel that is good.
async function statusThat(isGood) {
  const socket = new WebSocket(where.websocket, [protocol.FoxgloveClient.SUPPORTED_SUBPROTOCOL]);
  const client = new protocol.FoxgloveClient({ ws: socket });
  try {
    return await new Promise((resolve, reject) => {
      PATIENCE.signal.addEventListener("abort", () => reject(new Error(`it never came\n${processes.said.join("\n")}`)));
      client.on("error", reject);
      client.on("advertise", (channels) => channels.filter(({ topic }) => topic === "/page/status")
        .forEach(({ id }) => client.subscribe(id)));
      client.on("message", ({ data }) => {
        const status = JSON.parse(new TextDecoder().decode(data));
        if (isGood(status)) resolve(status);
      });
    });
  } finally {
    client.close();
  }
}

test("the page's status has nodes, forces, steps and parameters", PATIENCE, async () => {
  const { nodes, hands, steps, parameters, canStop } = await statusThat((status) =>
    status.nodes.filter((node) => node.isAlive).length >= 5 && status.hands.some(({ course }) => course.length > 0));
  const names = nodes.map((node) => node.name);
  for (const name of ["device_bridge", "haptic_node", "physics_node", "logic_node"]) assert.ok(names.includes(name), name);
  assert.equal(hands[0].role, "right");
  assert.deepEqual(steps.map(({ name }) => name), ["press", "slide", "edge", "push_block"]);
  assert.ok(parameters.includes("haptic_node.force_cap_N"), parameters.join());
  assert.equal(canStop, true);
});

test("the page gets the scene as the viewers have it", PATIENCE, async () => {
  await statusThat(({ assets }) => assets !== "");
  const answer = await fetch(`${where.origin}/session/assets`, { headers: { Authorization: `Bearer ${where.key}` } });
  const assets = fromBinary(typeOf("oos.SceneAssets"), new Uint8Array(await answer.arrayBuffer()));
  assert.ok(assets.instances.some(({ name }) => name === "ball"));
  assert.ok(assets.overlays.length >= 17 && assets.stars.length >= 24 * 100_000 && assets.shaders.length > 15);
  let frame;
  await receive(["/page/frame"], (_, message) => (frame = message).step !== "" && frame.timeNs > 0n);
  assert.equal(frame.poses.length, 28 * assets.instances.length);
});

test("without the session's key there is a page and nothing else", PATIENCE, async () => {
  const page = await fetch(where.origin);
  const html = await page.text();
  assert.match(html, /<title>VR-OOS/);
  assert.ok(!html.includes(where.key) && !html.includes("ball"), "the page knows nothing of the session");
  assert.match(page.headers.get("content-security-policy"), /default-src 'none'/);
  const wrong = where.key.slice(0, -1) + (where.key.endsWith("A") ? "B" : "A");
  const headers = [{}, { Authorization: "Bearer " }, { Authorization: `Bearer ${wrong}` }, { Authorization: where.key },
    { Cookie: `key=${where.key}` }];
  for (const one of headers) {
    const answer = await fetch(`${where.origin}/session/assets`, { headers: one });
    assert.equal(answer.status, 401, JSON.stringify(one));
  }
  const asked = [where.websocket.replace(/\?.*/, ""), where.websocket.replace(where.key, wrong)];
  for (const url of asked) {
    const socket = new WebSocket(url, [protocol.FoxgloveClient.SUPPORTED_SUBPROTOCOL]);
    const [, answer] = await new Promise((resolve) => {
      socket.on("unexpected-response", (...all) => resolve(all));
      socket.on("open", () => resolve([null, { statusCode: "it is open" }]));
      socket.on("error", () => {});
    });
    assert.equal(answer.statusCode, 401, url);
  }
});

test("the key is the session's: whoever may not read its key directory cannot know it", async () => {
  const folder = path.join(processes.folder, "out/keys");
  assert.equal(statSync(folder).mode & 0o077, 0);
  const { viewerKey } = await import("./access.mjs");
  const note = JSON.parse(readFileSync(path.join(processes.folder, "vr_oos/session.json"), "utf8"));
  const session = BigInt(note.session);
  assert.equal(viewerKey({ session, keys: folder }), where.key);
  assert.notEqual(viewerKey({ session: session + 1n, keys: folder }), where.key, "another session has another");
  assert.notEqual(viewerKey(null), viewerKey(null), "a session without keys has one for each bridge");
});

test("as a lab starts it: told its session, with a name on the bus and a camera in its address", PATIENCE, async () => {
  const note = JSON.parse(readFileSync(path.join(processes.folder, "vr_oos/session.json"), "utf8"));
  const told = await processes.startBridge(touch, ["--registry", note.registry, "--session", note.session,
    "--keys", path.join(processes.folder, "out/keys"), "--bind", "127.0.0.1", "--name", "visual_node-phone", "--view", "a b"]);
  assert.equal(told.page, `${told.origin}/#key=${where.key}&view=a%20b`);
  await statusThat(({ nodes }) => nodes.some(({ name, isAlive }) => name === "visual_node-phone" && isAlive));
  await processes.end(told.child);
});

test("the server gives out the page's own files and packages, nothing else", PATIENCE, async () => {
  for (const good of ["", "main.js", "picture/picture.js", "npm/three/build/three.module.js"]) {
    assert.equal((await fetch(`${where.origin}/${good}`)).status, 200, good);
  }
  for (const bad of ["bridge.mjs", "..%2fbridge.mjs", "%2e%2e/bridge.mjs", "npm/ws/index.js", "npm/three/build/../package.json",
    "npm/three/build/%2e%2e/%2e%2e/ws/wrapper.mjs", "package.json", "session/", "%", "npm/three/build/"]) {
    assert.ok([400, 401, 404].includes((await fetch(`${where.origin}/${bad}`)).status), bad);
  }
  assert.equal((await fetch(where.origin, { method: "POST" })).status, 405);
});
