// Our recordings read by MCAP's own library. node --test; OOS names the built oos, SCENARIO a scenario to run, WORK_DIR a
// folder to write to.
import { before, test } from "node:test";
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdirSync, readFileSync, readdirSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import protobuf from "protobufjs";
import "protobufjs/ext/descriptor/index.js";

const require = createRequire(import.meta.url);
const { foxgloveMessageSchemas } = require("@foxglove/schemas/dist/internal/schemas.js");
const { generateProto } = require("@foxglove/schemas/dist/internal/generateProto.js");

const folder = join(process.env.WORK_DIR, "recording");
const run = join(folder, "run.mcap");
const view = join(folder, "view.mcap");

function oos(...words) {
  const { status, stdout, stderr } = spawnSync(process.env.OOS, words, { encoding: "utf8", cwd: folder });
  return { status, text: stdout + stderr };
}

before(() => {
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  // Whether the procedure comes to its end does not matter here.
  const { text } = oos("run", process.env.SCENARIO, "--without", "visual_node", "--rt", "off", "--duration", "4",
                       "--out", join(folder, "out"), "--record", run, "--split_MB", "0.3");
  assert.match(text, /recording in .*run\.mcap: \d+ messages/, text);
  const exported = oos("export", run, view);
  assert.equal(exported.status, 0, exported.text);
});

const recordings = () => {
  const own = join(folder, "out", "recording");
  return [...readdirSync(own).map((name) => join(own, name)), run, view];
};

async function open(path) {
  const bytes = readFileSync(path);
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, length) => new Uint8Array(bytes.subarray(Number(offset), Number(offset + length))),
  };
  return McapIndexedReader.Initialize({ readable });
}

// One decoder per schema, from the descriptors in the file.
function decoderOf(schema) {
  assert.equal(schema.encoding, "protobuf");
  return protobuf.Root.fromDescriptor(schema.data).lookupType(schema.name);
}

// {channel, schema, message, content} in the order of time, every payload decoded.
async function* messagesOf(path) {
  const reader = await open(path);
  const decoders = new Map();
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    if (!decoders.has(schema.id)) decoders.set(schema.id, decoderOf(schema));
    yield { channel, schema, message, content: decoders.get(schema.id).decode(message.data) };
  }
}

test("reading from the front with all checksums finds the same as reading by the index", async () => {
  const files = recordings();
  assert.ok(files.length > 6, `several files of some nodes: ${files}`);
  for (const path of files) {
    const reader = new McapStreamReader({ validateCrcs: true });
    reader.append(readFileSync(path));
    let streamed = 0;
    for (let record; (record = reader.nextRecord()); ) streamed += record.type === "Message" ? 1 : 0;
    assert.ok(reader.done(), path);
    let indexed = 0;
    let last = 0n;
    for await (const { message } of messagesOf(path)) {
      ++indexed;
      assert.ok(message.logTime >= last, path);
      last = message.logTime;
    }
    assert.equal(indexed, streamed, path);
  }
});

test("payloads decode by the embedded descriptors to plausible values", async () => {
  const seen = new Map();
  for await (const { channel, content } of messagesOf(run)) {
    seen.set(channel.topic, (seen.get(channel.topic) ?? 0) + 1);
    if (channel.topic === "physics/state") {
      assert.equal(content.x_wo.length, 7 * content.object.length);
      const [w, x, y, z] = content.x_wo;
      assert.ok(Math.abs(Math.hypot(w, x, y, z) - 1) < 1e-9, "a unit quaternion");
    }
    if (channel.topic.startsWith("taken/")) assert.ok(channel.metadata.has("reader"));
  }
  for (const topic of ["physics/state", "event", "taken/haptic_node/physics/state"]) {
    assert.ok(seen.get(topic) > 0, `${topic} among ${[...seen.keys()]}`);
  }
});

test("messages recorded by a reader equal those recorded by their writer", async () => {
  const sent = new Set();
  const taken = [];
  for await (const { channel, message, content } of messagesOf(run)) {
    if (channel.topic === "physics/state") sent.add(message.sequence);
    if (channel.topic === "taken/haptic_node/physics/state") taken.push([message, content]);
  }
  assert.ok(taken.length > 100);
  for (const [message, content] of taken) {
    assert.ok(sent.has(message.sequence), `sequence ${message.sequence}`);
    assert.equal(Number(content.sequence), message.sequence);
    assert.ok(message.logTime >= message.publishTime);
  }
});

test("a recording names its scenario, platform and hosts", async () => {
  const reader = await open(run);
  const names = new Set(reader.metadataIndexes.map(({ name }) => name));
  for (const name of ["merged", "recording", "host", "versions", "topics", "scenario", "platform"]) {
    assert.ok(names.has(name), `${name} among ${[...names]}`);
  }
  const attachments = [];
  for await (const { name } of reader.readAttachments()) attachments.push(name);
  assert.ok(attachments.includes("scenario.xml"), `${attachments}`);
});

// The fields ("double x = 1" and so on) of a message in the text of a .proto file.
const kField = /^\s*(?:repeated )?([\w.]+) (\w+) = (\d+)(?: \[packed=\w+\])?;/gm;
const theirFields = (name) => new Map([...generateProto(foxgloveMessageSchemas[name], []).matchAll(kField)]
  .map(([, type, field, number]) => [field, { type: type.replace("foxglove.", ""), number: Number(number) }]));

test("view channels have the names, fields and numbers of Foxglove's schemas", async () => {
  const reader = await open(view);
  const roots = [...reader.schemasById.values()].filter(({ name }) => name.startsWith("foxglove."));
  assert.deepEqual(roots.map(({ name }) => name).sort(),
                   ["foxglove.FrameTransforms", "foxglove.Log", "foxglove.SceneUpdate"]);
  let compared = 0;
  for (const schema of roots) {
    for (const type of protobuf.Root.fromDescriptor(schema.data).lookup("foxglove").nestedArray) {
      if (!(type instanceof protobuf.Type)) continue;
      const theirs = theirFields(type.name);
      for (const field of type.fieldsArray) {
        const their = theirs.get(field.name);
        assert.ok(their, `${type.name}.${field.name} is not among ${[...theirs.keys()]}`);
        assert.equal(field.id, their.number, `${type.name}.${field.name}`);
        assert.equal(field.type.replace(/^.*\./, ""), their.type.replace(/^.*\./, ""), `${type.name}.${field.name}`);
        ++compared;
      }
    }
  }
  assert.ok(compared > 40, `${compared} fields`);
});

test("the exported view has meshes, frames at 30 to 60 Hz and events", async () => {
  const frames = new Map();
  const times = [];
  let models, lines = 0;
  const moved = new Set();
  for await (const { channel, message, content } of messagesOf(view)) {
    if (channel.topic === "/scene/models") models = content;
    if (channel.topic === "/log") ++lines;
    if (channel.topic !== "/tf") continue;
    times.push(Number(message.logTime) * 1e-9);
    for (const { parent_frame_id: parent, child_frame_id: child, translation, rotation } of content.transforms) {
      assert.equal(parent, "world");
      assert.ok(Math.abs(Math.hypot(rotation.x, rotation.y, rotation.z, rotation.w) - 1) < 1e-9);
      const before = frames.get(child);
      const moves = before && Math.hypot(before.x - translation.x, before.y - translation.y, before.z - translation.z) > 0;
      if (moves) moved.add(child);
      frames.set(child, translation);
    }
  }
  assert.ok(models.entities.length > 0);
  for (const { frame_id: frame, triangles } of models.entities) {
    assert.ok(frames.has(frame), frame);
    for (const { points, indices } of triangles) {
      assert.equal(indices.length % 3, 0);
      assert.ok(indices.length > 0 && Math.max(...indices) < points.length);
    }
  }
  assert.ok(moved.size > 0, "something moves");
  assert.ok(lines > 0, "events");
  const rate = (times.length - 1) / (times.at(-1) - times[0]);
  assert.ok(rate > 20 && rate < 61, `${rate} Hz`);
});

test("a recording differs from another run's and not from itself", () => {
  assert.equal(oos("diff", run, run).status, 0);
  assert.equal(oos("diff", run, view, "*").status, 0, "what is derived for viewers does not count");
  const own = join(folder, "out", "recording");
  const parts = readdirSync(own).filter((name) => name.startsWith("physics_node")).map((name) => join(own, name));
  assert.ok(parts.length >= 2, "split by size");
  const { status, text } = oos("diff", parts[0], parts[1], "physics/state");
  assert.equal(status, 1);
  assert.match(text, /first difference: physics\/state of physics_node, sequence \d+/);
});
