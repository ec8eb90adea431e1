// The JavaScript client against the vectors, and against a live node in C++ (environment variable CLIENTS_PEER).

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { readFileSync } from "node:fs";
import { createInterface } from "node:readline";
import { test } from "node:test";
import { Node, canonical, hash32, matches, message, readEnvelope, typeOf, writeEnvelope } from "./oos_bus.mjs";

const vectors = (name) => JSON.parse(readFileSync(new URL(`../vectors/${name}`, import.meta.url), "utf8"));
const fromHex = (hex) => Buffer.from(hex, "hex");

test("ids and digests are those of the bus", () => {
  const { topics, schemas } = vectors("hashes.json");
  for (const topic of topics) assert.equal(hash32(topic.name), topic.id);
  for (const schema of schemas) {
    const shape = canonical(typeOf(schema.type));
    assert.equal(shape, schema.canonical);
    assert.equal(hash32(shape), schema.digest);
  }
});

test("envelopes are read and written alike", () => {
  const { sound, refused } = vectors("envelopes.json");
  for (const row of sound) {
    const { envelope, payload } = readEnvelope(fromHex(row.bytes));
    assert.equal(payload.toString("hex"), row.payload);
    const told = { class: envelope.topicClass, part: envelope.part, parts: envelope.parts, topic: envelope.topic,
      digest: envelope.digest, session: `${envelope.session}`, node: envelope.node, boot: `${envelope.boot}`,
      sequence: `${envelope.sequence}`, publish_ns: `${envelope.publishNs}`, num_stamps: envelope.numStamps,
      traces: envelope.traces.map(String), history: envelope.history.toString("hex") };
    for (const [field, value] of Object.entries(told)) assert.deepEqual(value, row[field], `${row.name}: ${field}`);
    assert.equal(writeEnvelope(envelope, payload).toString("hex"), row.bytes);
  }
  for (const row of refused) assert.equal(readEnvelope(fromHex(row.bytes)), null, row.name);
});

test("patterns", () => {
  for (const [pattern, text, expected] of [["device/*/state", "device/right/state", true], ["*", "", true],
    ["contacts/*", "contacts/a/b", true], ["event", "events", false], ["a*b*c", "a-b-c", true], ["a*b", "ab", true],
    ["ab*ba", "aba", false], ["device/*/state", "device/state", false], ["a.c", "abc", false]]) {
    assert.equal(matches(pattern, text), expected, `${pattern} ${text}`);
  }
});

async function withPeer(body) {
  const peer = spawn(process.env.CLIENTS_PEER, { stdio: ["ignore", "pipe", "inherit"] });
  const exit = once(peer, "exit");
  const lines = createInterface({ input: peer.stdout });
  const said = [];
  try {
    const [first] = await once(lines, "line");
    lines.on("line", (line) => said.push(line));
    const where = JSON.parse(first);
    await body({ ...where, session: BigInt(where.session) }, async () => {
      const [status] = await exit;
      assert.equal(status, 0, said.join("\n"));
    });
  } finally {
    peer.kill("SIGKILL");
  }
}

// The next message that meets the condition.
function until(node, condition, timeoutMs = 20_000) {
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

test("everything a client does", async () => {
  await withPeer(async (where, peerIsContent) => {
    const node = new Node({ name: "client", isObserver: false, ...where });
    for (const topic of ["physics/state", "logic/status", "event"]) node.subscribe(topic);
    node.advertise("device/right/state");
    const logic = until(node, (m) => m.topic === "logic/status");
    const physics = until(node, (m) => m.topic === "physics/state");
    await node.start();

    // STATE is there for a late joiner; LATEST comes whole although it takes several datagrams.
    assert.equal((await logic).body.step, "before anybody came");
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
    await node.close();
    await peerIsContent();
  });
});

test("a second node of the same name is refused by name", async () => {
  await withPeer(async (where) => {
    const first = new Node({ name: "twin", ...where });
    await first.start();
    const second = new Node({ name: "twin", ...where });
    await assert.rejects(second.start(), /twin/);
    await second.close();
    await first.close();
  });
});

test("a topic that is not in the table is refused", () => {
  assert.throws(() => new Node({ name: "stranger" }).subscribe("phsyics/state"), /phsyics\/state/);
});
