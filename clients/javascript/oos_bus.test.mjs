// The JavaScript client against the vectors, and against a live node in C++ (environment variable CLIENTS_PEER).

import assert from "node:assert/strict";
import { once } from "node:events";
import { chmodSync, chownSync, mkdirSync, mkdtempSync, readFileSync, renameSync, rmSync, symlinkSync, unlinkSync,
  writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { createInterface } from "node:readline";
import { afterEach, test } from "node:test";
import { fileURLToPath } from "node:url";
import { LATEST, Node as BusNode, canonical, create, digestOf, hash32, matches, message, readEnvelope, runningSession,
  toBinary, typeOf, writeEnvelope } from "./oos_bus.mjs";
import { loadKeys, makeOpener, makeSealer, senderKey, z85 } from "./security.mjs";
import { spawnBound } from "./testing/spawn_bound.mjs";

const vectors = (name) => JSON.parse(readFileSync(new URL(`../vectors/${name}`, import.meta.url), "utf8"));
const fromHex = (hex) => Buffer.from(hex, "hex");

// Closes the nodes that a failed test leaves open: they would keep this process from ending.
const open = new Set();
class Node extends BusNode {
  constructor(options) {
    super(options);
    open.add(this);
  }
}
afterEach(async () => {
  for (const node of open) await node.close();
  open.clear();
});

test("ids and digests equal those of the bus", () => {
  const { topics, schemas } = vectors("hashes.json");
  for (const topic of topics) assert.equal(hash32(topic.name), topic.id);
  for (const schema of schemas) {
    const shape = canonical(typeOf(schema.type));
    assert.ok(`${shape} `.startsWith(`${schema.canonical} `), shape);  // fields may have been added
    assert.equal(hash32(schema.canonical), schema.digest);
  }
});

test("envelopes are read and written alike", () => {
  const { sound, refused } = vectors("envelopes.json");
  for (const row of sound) {
    const { envelope, payload } = readEnvelope(fromHex(row.bytes));
    assert.equal(payload.toString("hex"), row.payload);
    const fields = { class: envelope.topicClass, part: envelope.part, parts: envelope.parts, topic: envelope.topic,
      digest: envelope.digest, session: `${envelope.session}`, node: envelope.node, boot: `${envelope.boot}`,
      sequence: `${envelope.sequence}`, publish_ns: `${envelope.publishNs}`, num_stamps: envelope.numStamps,
      traces: envelope.traces.map(String), history: envelope.history.toString("hex") };
    for (const [field, value] of Object.entries(fields)) assert.deepEqual(value, row[field], `${row.name}: ${field}`);
    assert.equal(writeEnvelope(envelope, payload).toString("hex"), row.bytes);
  }
  for (const row of refused) assert.equal(readEnvelope(fromHex(row.bytes)), null, row.name);
});

test("sealed datagrams are opened and sealed alike", () => {
  const { session_key, instance, sender_key, sealed } = vectors("envelopes.json");
  const key = senderKey(fromHex(session_key), BigInt(instance));
  assert.equal(key.toString("hex"), sender_key);
  for (const row of sealed) {
    const data = fromHex(row.bytes);
    let opener = makeOpener(key);
    const unseal = (envelope, clear, body) => opener(envelope.topicClass, clear, body);
    const { envelope, payload } = readEnvelope(data, unseal);
    assert.equal(payload.toString("hex"), row.payload);
    assert.equal(envelope.history.toString("hex"), row.history);
    assert.equal(readEnvelope(data, unseal), null, "came before");
    const before = BigInt(row.counter) - 1n;
    assert.equal(writeEnvelope(envelope, payload, makeSealer(key, [before, before])).toString("hex"), row.bytes);
    for (let i = 0; i < data.length; ++i) {  // every byte counts
      const forged = Buffer.from(data);
      forged[i] ^= 1;
      opener = makeOpener(key);
      assert.equal(readEnvelope(forged, unseal), null);
    }
  }
});

test("the replay window takes each counter once", () => {
  const sealer = makeSealer(Buffer.alloc(32)), opener = makeOpener(Buffer.alloc(32));
  const nothing = Buffer.alloc(0);
  const sealed = Array.from({ length: 200 }, (_, n) => sealer(1, nothing, Buffer.from([n])));
  for (const [n, expected] of [[5, true], [5, false], [3, true], [3, false], [80, true], [17, true], [16, false],
    [199, true], [80, false], [198, true], [198, false]]) {
    assert.equal(opener(1, nothing, sealed[n]) !== null, expected, `${n}`);
  }
  const far = makeSealer(Buffer.alloc(32), [1n << 63n, 0n])(1, nothing, Buffer.from([0]));
  assert.ok(opener(1, nothing, far), "no gap is too large");
  assert.equal(opener(1, nothing, far), null);
});

test("keys are written in Z85", () => {
  assert.equal(z85(fromHex("864fd26fb559f75b")), "HelloWorld");  // the example of ZeroMQ RFC 32
});

test("a star in a pattern stands for any text", () => {
  for (const [pattern, text, expected] of [["device/*/state", "device/right/state", true], ["*", "", true],
    ["contacts/*", "contacts/a/b", true], ["event", "events", false], ["a*b*c", "a-b-c", true], ["a*b", "ab", true],
    ["ab*ba", "aba", false], ["device/*/state", "device/state", false], ["a.c", "abc", false]]) {
    assert.equal(matches(pattern, text), expected, `${pattern} ${text}`);
  }
});

const STRANGER = 65534;

function withFolder(body) {
  const folder = mkdtempSync(path.join(tmpdir(), "clients-"));
  try {
    return body(folder);
  } finally {
    rmSync(folder, { recursive: true });
  }
}

test("the session is taken from a folder of this user alone", () => withFolder((folder) => {
  const before = process.env.XDG_RUNTIME_DIR;
  process.env.XDG_RUNTIME_DIR = folder;
  try {
    const place = path.join(folder, "vr_oos"), elsewhere = path.join(folder, "elsewhere");
    mkdirSync(place, { mode: 0o700 });
    writeFileSync(path.join(place, "session.json"), '{"registry": "tcp://127.0.0.1:1", "session": "7", "keys": ""}');
    assert.deepEqual(runningSession(), { registry: "tcp://127.0.0.1:1", session: 7n, keys: null });
    chmodSync(place, 0o755);
    assert.throws(runningSession, /vr_oos is not a directory .* of this user alone/, "others may enter");
    chmodSync(place, 0o700);
    renameSync(place, elsewhere);
    symlinkSync(elsewhere, place);
    assert.throws(runningSession, /vr_oos is not a directory/, "a link");
    unlinkSync(place);
    if (process.geteuid() === 0) {
      renameSync(elsewhere, place);
      chownSync(place, STRANGER, STRANGER);
    } else {
      symlinkSync("/", place);
    }
    assert.throws(runningSession, /vr_oos is not a directory/, "another user's");
  } finally {
    if (before === undefined) delete process.env.XDG_RUNTIME_DIR;
    else process.env.XDG_RUNTIME_DIR = before;
  }
}));

test("keys of another user are refused", { skip: process.geteuid() !== 0 && "only root can give a file away" }, () =>
  withFolder((folder) => {
    for (const name of ["allowed", "client.key"]) writeFileSync(path.join(folder, name), "", { mode: 0o600 });
    chownSync(path.join(folder, "client.key"), STRANGER, STRANGER);
    assert.throws(() => loadKeys(folder, "client"), /client.key belongs to user 65534/);
  }));

let session;  // the peer's, as `oos run` notes down its own

async function withPeer(words, body) {
  const peer = spawnBound(process.env.CLIENTS_PEER, words, { stdio: ["ignore", "pipe", "inherit"] });
  const exit = once(peer, "exit");
  const lines = createInterface({ input: peer.stdout });
  const said = [];
  try {
    const [first] = await once(lines, "line");
    lines.on("line", (line) => said.push(line));
    const where = JSON.parse(first);
    session = first;
    for (const [name, digest] of Object.entries(where.digests)) assert.equal(digestOf(typeOf(name)), digest, name);
    await body({ ...where, keys: where.keys || null, session: BigInt(where.session) }, async () => {
      const [status] = await exit;
      assert.equal(status, 0, said.join("\n"));
    });
  } finally {
    peer.kill("SIGKILL");
  }
}

// The next message that meets the condition.
function until(node, condition, timeoutMs = 40_000) {
  return new Promise((resolve, reject) => {
    const late = setTimeout(() => reject(new Error(`it never came; alive: ${node.alive()}`)), timeoutMs);
    node.on("message", function take(received) {
      if (!condition(received)) return;
      clearTimeout(late);
      node.off("message", take);
      resolve(received);
    });
  });
}

async function everything(words) {
  await withPeer(words, async (where, peerIsContent) => {
    const node = new Node({ name: "client", isObserver: false, ...where });
    for (const topic of ["physics/state", "haptic/right/proxy", "logic/status", "event"]) node.subscribe(topic);
    node.advertise("device/right/state");
    const proxy = until(node, (m) => m.topic === "haptic/right/proxy" && m.body.cycle > 0n);  // comes by ZeroMQ
    const logic = until(node, (m) => m.topic === "logic/status");
    const physics = until(node, (m) => m.topic === "physics/state");
    await node.start();
    await proxy;

    // STATE is there for a late joiner; LATEST comes whole although it takes several datagrams.
    assert.equal((await logic).body.step, "before the client joined");
    const { body, sequence } = await physics;
    assert.deepEqual(body.object, Array.from({ length: 40 }, (_, i) => i));
    assert.deepEqual(body.xWo.slice(7 * 39 + 4), [39, 0.5 * Number(body.tick % 100n), -1]);
    assert.ok((await until(node, (m) => m.topic === "physics/state")).sequence > sequence);

    // Events both ways; the answer comes with a change of state.
    while (node.numEventReaders === 0) await until(node, (m) => m.topic === "physics/state");
    const answer = until(node, (m) => m.topic === "event" && m.body.name === "greeting");
    const change = until(node, (m) => m.topic === "logic/status");
    node.emitEvent("greeting", "hello");
    assert.equal((await answer).body.detail, "hello, client");
    assert.equal((await change).body.step, "greeted");

    assert.ok((await node.setParameter("peer", "gain", 2.5)).tick > 0n);
    await assert.rejects(node.setParameter("peer", "gain", 99), /out of range/);
    await assert.rejects(node.setParameter("peer", "gian", 1), /gain/);

    let isSeen = false;
    const seen = until(node, (m) => m.topic === "event" && m.body.name === "hand_seen").then(() => { isSeen = true; });
    const hand = message("device/right/state",
      { xWd: [1, 0, 0, 0, 0.1, 0.2, 0.3], vWd: [0, 0, 0, 0, 0, 0], isEngaged: true });
    while (!isSeen) {  // one datagram may be lost
      node.publish("device/right/state", hand);
      await until(node, (m) => m.topic === "physics/state");
    }
    await seen;

    // What was sent since the first that came was received or is counted as lost.
    const newest = await until(node, (m) => m.topic === "physics/state");
    const { received, dropped } = node.figures.get("physics/state");
    assert.equal(received + dropped, newest.sequence - sequence + 1n);
    await node.close();
    await peerIsContent();
  });
}

test("a malformed payload is refused and counted", () => withPeer([], async (where) => {
  const topic = "physics/state", type = typeOf("oos.PhysicsState");
  const node = new Node({ name: "client", ...where });
  for (const each of [topic, "logic/status"]) node.subscribe(each);
  await node.start();
  const first = await until(node, (m) => m.topic === topic);
  const sound = toBinary(type, create(type, { tick: 1n }));
  // Refusals caused by a datagram with a sound envelope and this content.
  const numRefused = (payload, fields = {}) => {
    const before = node.refused, { boot, sequence } = node._newest.get(topic);
    node._takeData(writeEnvelope({ topicClass: LATEST, topic: hash32(topic), digest: digestOf(type),
      session: where.session, node: hash32("peer"), boot, sequence: sequence + 1n, publishNs: 0n, ...fields },
      payload));
    return node.refused - before;
  };
  assert.equal(numRefused(Buffer.from([255, 255, 255])), 1);
  assert.equal(numRefused(sound, { digest: 1 }), 1, "another schema");
  assert.equal(numRefused(sound, { part: 1, parts: 2 }), 0);
  assert.equal(numRefused(sound, { part: 2, parts: 3 }), 1, "of two parts, or of three?");
  const before = node.refused;
  node._takeState("peer", { topic: "logic/status", key: "", value: Buffer.from([255, 255, 255]), version: 99n });
  assert.equal(node.refused, before + 1);
  const later = await until(node, (m) => m.topic === topic && m.sequence > first.sequence);
  assert.equal(later.body.object.length, 40);
  await node.close();
}));

test("an unreachable peer does not stop a client", () => withPeer([], async (where) => {
  const topic = "device/right/state";
  const far = new Node({ name: "client-far", ...where });
  const near = new Node({ name: "client-near", isObserver: false, ...where });
  far.subscribe(topic);
  near.advertise(topic);
  const nowhere = "255.255.255.255:9";  // sending there is not permitted
  far._record = () => ({ ...Node.prototype._record.call(far), dataEndpoint: nowhere, heartbeatEndpoint: nowhere });
  await far.start();
  await near.start();
  while (near.alive().length < 2) await once(near, "roster");
  assert.equal(near.publish(topic, message(topic, {})), 2, "the peer and the far one");
  const figures = near.figures.get(topic);
  while (figures.sent + figures.dropped < 2n) await new Promise(setImmediate);
  assert.deepEqual([figures.sent, figures.dropped], [1n, 1n]);
  await near.close();
  await far.close();
}));

test("a node that receives an unknown node's heartbeat while it closes still ends", () => withPeer([], async (where) => {
  const node = new Node({ name: "client", ...where });
  const stranger = new Node({ name: "client-stranger", ...where });
  await node.start();
  const closing = node.close(), timers = [...node._timers];
  node._takeHeartbeat(stranger._wrap("heartbeat", stranger._heartbeat(false)));
  await closing;
  assert.deepEqual(node._timers, timers, "no new request to the registry is scheduled");
}));

test("a record without addresses is refused", () => withPeer([], async (where) => {
  const node = new Node({ name: "client", ...where });
  await node.start();
  for (const dataEndpoint of ["", "127.0.0.1", "127.0.0.1:port", "127.0.0.1:70000", "somewhere:4000"]) {
    const before = node.refused;
    node._add({ name: "nowhere", instance: 1n, boot: 1n, topics: [], observedPatterns: [], dataEndpoint,
      heartbeatEndpoint: "127.0.0.1:4000", routerEndpoint: "tcp://127.0.0.1:4", publicKey: "" });
    assert.equal(node.refused, before + 1, dataEndpoint);
  }
  await node.close();
}));

test("a client receives and sends every class of message in the clear", () => everything([]));

test("a client receives and sends every class of message encrypted", async () => {
  const folder = mkdtempSync(path.join(tmpdir(), "clients-"));
  await everything([path.join(folder, "keys")]).finally(() => rmSync(folder, { recursive: true }));
});

test("a client without a key is not let in", async () => {
  const folder = mkdtempSync(path.join(tmpdir(), "clients-"));
  await withPeer([path.join(folder, "keys")], async (where) => {
    const stranger = new Node({ name: "client", ...where, keys: null });
    await assert.rejects(stranger.start(1000), /no answer/);
    await stranger.close();
    assert.throws(() => new Node({ name: "intruder", ...where }), /no key for intruder/);
  }).finally(() => rmSync(folder, { recursive: true }));
});

// Runs an example with the peer's session as the running one, and as if on another machine (own clock).
function runExample(name, ...words) {
  const folder = mkdtempSync(path.join(tmpdir(), "clients-"));
  mkdirSync(path.join(folder, "vr_oos"), { mode: 0o700 });
  writeFileSync(path.join(folder, "vr_oos", "session.json"), session);
  const example = spawnBound(process.execPath, [fileURLToPath(new URL(name, import.meta.url)), ...words],
    { stdio: ["ignore", "pipe", "inherit"],
      env: { ...process.env, XDG_RUNTIME_DIR: folder, OOS_MACHINE_ID: "elsewhere" } });
  let said = "";
  example.stdout.on("data", (text) => { said += text; });
  return once(example, "close").then(([status]) => {
    rmSync(folder, { recursive: true });
    assert.equal(status, 0, said);
    return said;
  });
}

test("the following example prints the step and the poses", () => withPeer([], async () => {
  const said = await runExample("example_follow.mjs", "1");
  assert.match(said, /step before the client joined/);
  assert.match(said, /tick \d+  object 0 at 0.000 \d.*object 39 at 39.000 [\d.]+ -1.000 m/);
}));

test("the publishing example moves on its circle", () => withPeer([], async (where) => {
  const node = new Node({ name: "client-watch", ...where });
  node.subscribe("device/right/state");
  await node.start();
  const example = runExample("example_publish.mjs", "right", "0.25");
  const { writer, body } = await until(node, () => true);
  assert.equal(writer, "client-publish-js");
  assert.ok(Math.abs(Math.hypot(body.xWd[4], body.xWd[5]) - 0.05) < 1e-9);
  await example;
  await node.close();
}));

test("a second node of the same name is refused by name", async () => {
  await withPeer([], async (where) => {
    const first = new Node({ name: "client-twin", ...where });
    await first.start();
    const second = new Node({ name: "client-twin", ...where });
    await assert.rejects(second.start(), /twin/);
    await second.close();
    await first.close();
  });
});

test("a topic that is not in the table is refused", () => {
  assert.throws(() => new Node({ name: "client-stranger", keys: null }).subscribe("phsyics/state"), /phsyics\/state/);
});
