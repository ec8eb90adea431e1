// A node of the VR-OOS bus in JavaScript, on npm's zeromq, @bufbuild/protobuf and hash-wasm (Node 18 or later).
//
//   const node = new Node({ name: "client-1", ...runningSession() });
//   node.subscribe("physics/state");
//   node.on("message", ({ topic, body }) => console.log(topic, body));
//   await node.start();
//
// The protocol (docs/reference/bus_protocol.md) is in links.mjs, members.mjs, reading.mjs and writing.mjs, each a layer
// on the one before.

import { lstatSync, readFileSync } from "node:fs";
import path from "node:path";
import { toBinary } from "@bufbuild/protobuf";
import { LATEST, MAX_DATAGRAM_BYTES, hash32, writeEnvelope } from "./envelope.mjs";
import { digestOf, ruleOf, typeOf } from "./topics.mjs";
import { Writing } from "./writing.mjs";

export * from "./envelope.mjs";
export * from "./topics.mjs";
export { create, createFileRegistry, fromBinary, toBinary, toJson } from "@bufbuild/protobuf";
export * as wkt from "@bufbuild/protobuf/wkt";

const HEARTBEAT_MS = 50;

// {registry, session, keys} of the `oos run` of this user on this machine.
export function runningSession() {
  const runtime = process.env.XDG_RUNTIME_DIR;
  const folder = runtime ? path.join(runtime, "vr_oos") : `/tmp/vr_oos-${process.geteuid()}`;
  const info = lstatSync(folder);
  if (!info.isDirectory() || info.uid !== process.geteuid() || info.mode & 0o077) {
    // Who can write there can direct this client to a session of their own.
    throw new Error(`${folder} is not a directory (no link) of this user alone, as 'oos run' makes it; the session ` +
      "noted there may be a trap: remove it, start the session again");
  }
  const note = JSON.parse(readFileSync(path.join(folder, "session.json"), "utf8"));
  return { registry: note.registry, session: BigInt(note.session), keys: note.keys || null };
}

// subscribe() and advertise() first, then await start(). Keys: the run's key directory, or null if the run is not
// encrypted. With keys, the name is a key's name, or that and a '-' and more: "client-1". Emits "message" ({topic,
// writer, sequence, body, key, publishNs}), "roster" (names of the live nodes) when a node joins or leaves, and
// "refused" (the reason).
export class Node extends Writing {
  #nextRequest = 0n;

  // Receives a LATEST or STATE topic, or "event"; a '*' stands for any text.
  subscribe(topic) {
    if (topic.includes("*")) this._patterns.push(topic);
    else this._read.add((ruleOf(topic), topic));
  }

  // Declares a LATEST topic that publish() will write.
  advertise(topic) {
    if (ruleOf(topic).class !== LATEST) throw new Error(`topic '${topic}' is not LATEST`);
    this._sequences.set(topic, 0n);
  }

  async start(timeoutMs = 30_000) {
    await this._openLinks();
    this._timers = [setInterval(() => this._beat(), HEARTBEAT_MS)];
    const welcome = new Promise((resolve, reject) => { this._welcome = { resolve, reject }; });
    this._helloAgain();
    const late = setTimeout(() => this._welcome.reject(new Error(
      `no answer from the registry ${this._options.registry} in ${timeoutMs} ms; is 'oos run' still there?`)), timeoutMs);
    await welcome.finally(() => clearTimeout(late));
  }

  alive() { return [...this._peers.values()].filter((peer) => peer.isAlive).map((peer) => peer.record.name); }
  records() { return [...this._peers.values()].map((peer) => ({ ...peer.record, isAlive: peer.isAlive })); }
  get numEventReaders() { return this._readers.size; }

  // Sends a LATEST message to all its readers; returns their number. Throws if it exceeds one datagram.
  publish(topic, body) {
    const sequence = this._sequences.get(topic) + 1n;
    this._sequences.set(topic, sequence);
    const type = typeOf(body.$typeName);
    const bytes = writeEnvelope({ ...this._stamp(), topicClass: LATEST, topic: hash32(topic), sequence,
      digest: digestOf(type) }, toBinary(type, body), this._sealer);
    if (bytes.length > MAX_DATAGRAM_BYTES) throw new Error(`${topic}: ${bytes.length} bytes exceed one datagram`);
    return this._sendToReaders(topic, bytes);
  }

  // Sends an event to all readers of events. The last 4096 are kept to be sent again to a reader that lost some.
  emitEvent(name, detail = "") {
    const event = { timeNs: process.hrtime.bigint(), source: this._options.name, name, detail };
    this._append(event);
  }

  // Sets a parameter. Resolves to the owner's ParameterReply; rejects with the reason if it refuses or does not answer.
  async setParameter(owner, name, value, { manner = 0, rampS = 0, timeoutMs = 1000 } = {}) {
    const request = ++this.#nextRequest;
    const peer = this._peers.get(owner);
    if (!peer?.isAlive) throw new Error(`no live node is called ${owner}; alive: ${this.alive().join(", ")}`);
    const answer = new Promise((resolve, reject) => {
      const late = setTimeout(() => reject(new Error(`${owner} did not answer in time`)), timeoutMs);
      this._calls.set(request, (reply) => {
        clearTimeout(late);
        if (reply.isAccepted) resolve(reply);
        else reject(new Error(reply.why));
      });
    });
    this._send(peer.dealer, "parameterRequest",
      { request, caller: this._options.name, callerInstance: this._instance,
        timeLeftNs: BigInt(timeoutMs) * 1_000_000n, change: { name, value, manner, rampS } });
    return answer.finally(() => this._calls.delete(request));
  }

  // Sends a goodbye, so that the others see that the node left and did not fail.
  close() { return (this._closing ??= this.#close()); }

  async #close() {
    if (!this._data) return;  // nothing was opened
    this._timers.forEach(clearTimeout);
    const bytes = this._wrap("heartbeat", this._heartbeat(true), this._sealer);
    await Promise.all([...this._peers.values()].map(({ heartbeat }) => new Promise((resolve) => {
      this._beats.send(bytes, heartbeat.port, heartbeat.host, resolve);
    })));
    if (this._registry) await this._hello(true);
    this._isClosed = true;
    for (const peer of this._peers.values()) peer.dealer.socket.close();
    this._closeLinks();
  }
}
