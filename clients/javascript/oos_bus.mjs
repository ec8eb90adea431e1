// A node of the VR-OOS bus in JavaScript, on npm's zeromq, @bufbuild/protobuf and hash-wasm (Node 18 or later). The
// protocol is docs/reference/bus_protocol.md; the message types come from what protoc makes of the repository's proto/.

import dgram from "node:dgram";
import { randomBytes } from "node:crypto";
import { EventEmitter } from "node:events";
import { readFileSync } from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { create, createFileRegistry, fromBinary, toBinary } from "@bufbuild/protobuf";
import { FileDescriptorSetSchema } from "@bufbuild/protobuf/wkt";
import { Context, Dealer, Router } from "zeromq";
import { CONTROL, EVENT, LATEST, MAX_DATAGRAM_BYTES, SERVICE, STATE, canonical, hash32, matches, readEnvelope,
  writeEnvelope } from "./envelope.mjs";

export * from "./envelope.mjs";

const PROTOCOL_VERSION = 1;
const HEARTBEAT_MS = 50, HELLO_MS = 500, EAGER_HELLO_MS = 100, DEAD_AFTER_MS = 350, ASK_AGAIN_MS = 300;
const EVENT_CREDIT = 1024n;

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../..");
const STUBS = process.env.OOS_STUBS ?? path.join(ROOT, "build/release/clients/stubs");
export const descriptors = fromBinary(FileDescriptorSetSchema, readFileSync(path.join(STUBS, "oos.desc")));
const types = createFileRegistry(descriptors);
export const typeOf = (name) => types.getMessage(name);
const Control = typeOf("oos.Control");

const RULES = JSON.parse(readFileSync(path.join(ROOT, "clients/topics.json"), "utf8")).rules;

// The first line of topics.json that matches.
export function ruleOf(topic) {
  const rule = RULES.find((one) => matches(one.pattern, topic));
  if (!rule) throw new Error(`no rule in clients/topics.json matches topic '${topic}'`);
  return rule;
}

// A message of the topic's type, with the fields given: message("device/right/state", {isEngaged: true}).
export const message = (topic, fields) => create(typeOf(ruleOf(topic).type), fields);

// {registry, session} of the `oos run` of this user on this machine.
export function runningSession() {
  const runtime = process.env.XDG_RUNTIME_DIR;
  const folder = runtime ? path.join(runtime, "vr_oos") : `/tmp/vr_oos-${process.getuid()}`;
  const note = JSON.parse(readFileSync(path.join(folder, "session.json"), "utf8"));
  return { ...note, session: BigInt(note.session) };
}

// The message that was sent in parts: lists joined in order, the rest as in the first part.
function mergeParts(type, parts) {
  for (const field of type.fields.filter((one) => one.fieldKind === "list")) {
    for (const part of parts.slice(1)) parts[0][field.localName].push(...part[field.localName]);
  }
  return parts[0];
}

const classOf = (body) => body.startsWith("sub") || body.startsWith("state") ? STATE
  : body.startsWith("event") ? EVENT : body.startsWith("parameter") ? SERVICE : CONTROL;

const addressOf = (endpoint) => ({ host: endpoint.split(":")[0], port: Number(endpoint.split(":")[1]) });

// ZeroMQ allows one send at a time on a socket; these are quick or are dropped.
class Link {
  #busy = Promise.resolve();
  constructor(socket) { this.socket = socket; }
  send(frames) {
    const done = this.#busy.then(() => this.socket.send(frames)).then(() => true, () => false);
    this.#busy = done;
    return done;
  }
}

// subscribe() and advertise() first, then await start(). Emits "message" ({topic, writer, sequence, body, key,
// publishNs}), "roster" (names of the living) when somebody comes or goes, and "refused" (why).
export class Node extends EventEmitter {
  #options; #instance = randomBytes(8).readBigUInt64LE(); #boot = BigInt(Date.now()) * 1_000_000n;
  #patterns = []; #read = new Set(); #sequences = new Map();
  #peers = new Map(); #gone = new Set(); #topics = new Map(); #partial = new Map(); #newest = new Map();
  #readers = new Map(); #calls = new Map(); #nextRequest = 0n;
  #context = new Context(); #router; #registry; #data; #beats; #timers = [];
  #roster = 0n; #isWelcomed = false; #isClosed = false; #welcome = null;
  refused = 0; eventsDropped = 0;

  constructor(options) {  // {name, registry, session, bind, isObserver}
    super();
    this.#options = { bind: "127.0.0.1", isObserver: true, ...options };
  }

  // LATEST, STATE or "event"; with a '*' in it, whatever matches.
  subscribe(topic) {
    if (topic.includes("*")) this.#patterns.push(topic);
    else this.#read.add((ruleOf(topic), topic));
  }

  // A LATEST topic for publish().
  advertise(topic) {
    if (ruleOf(topic).class !== LATEST) throw new Error(`topic '${topic}' is not LATEST`);
    this.#sequences.set(topic, 0n);
  }

  async start(timeoutMs = 30_000) {
    const { bind, registry } = this.#options;
    this.#data = await this.#udp((bytes) => this.#takeData(bytes));
    this.#beats = await this.#udp((bytes) => this.#takeHeartbeat(bytes));
    this.#router = new Link(new Router({ context: this.#context, mandatory: true, handover: true, linger: 100,
      maxMessageSize: 16 << 20, sendTimeout: 0 }));
    await this.#router.socket.bind(`tcp://${bind}:*`);
    this.#registry = this.#dealer(registry);
    this.#receive(this.#router.socket, ([routing, ...rest]) => this.#takeRouter(routing, rest.at(-1)));
    this.#receive(this.#registry.socket, (frames) => this.#takeRegistry(frames.at(-1)));
    this.#timers = [setInterval(() => this.#beat(), HEARTBEAT_MS)];
    const welcome = new Promise((resolve, reject) => { this.#welcome = { resolve, reject }; });
    this.#helloAgain();
    const late = setTimeout(() => this.#welcome.reject(new Error(
      `no answer from the registry ${registry} in ${timeoutMs} ms; is 'oos run' still there?`)), timeoutMs);
    await welcome.finally(() => clearTimeout(late));
  }

  alive() { return [...this.#peers.values()].filter((peer) => peer.isAlive).map((peer) => peer.record.name); }
  records() { return [...this.#peers.values()].map((peer) => ({ ...peer.record, isAlive: peer.isAlive })); }
  get numEventReaders() { return this.#readers.size; }

  // Sends a LATEST message to everybody who reads it; returns how many. It has to fit into one datagram.
  publish(topic, body) {
    const sequence = this.#sequences.get(topic) + 1n;
    this.#sequences.set(topic, sequence);
    const type = typeOf(body.$typeName);
    const bytes = writeEnvelope({ ...this.#stamp(), topicClass: LATEST, topic: hash32(topic), sequence,
      digest: hash32(canonical(type)) }, toBinary(type, body));
    if (bytes.length > MAX_DATAGRAM_BYTES) throw new Error(`${topic}: ${bytes.length} bytes exceed one datagram`);
    const readers = [...this.#peers.values()].filter((peer) => peer.isAlive &&
      (peer.record.topics.some((one) => one.name === topic && !one.isWritten) ||
       peer.record.observedPatterns.some((pattern) => matches(pattern, topic))));
    for (const { data } of readers) this.#data.send(bytes, data.port, data.host);
    return readers.length;
  }

  // Sends an event to all readers of events. A reader that has 1024 unacknowledged misses it, counted.
  emitEvent(name, detail = "") {
    const event = { timeNs: process.hrtime.bigint(), source: this.#options.name, name, detail };
    for (const [routing, reader] of this.#readers) {
      const sequence = reader.next++;  // a dropped event leaves a gap that the reader sees
      if (reader.sent < reader.acked + EVENT_CREDIT) {
        reader.sent = sequence;
        this.#reply(routing, "event", { sequence, event });
      } else {
        ++this.eventsDropped;
      }
    }
  }

  // The owner's ParameterReply; rejects with its reason when it refuses.
  async setParameter(owner, name, value, { manner = 0, rampS = 0, timeoutMs = 1000 } = {}) {
    const request = ++this.#nextRequest;
    const peer = this.#peers.get(owner);
    if (!peer?.isAlive) throw new Error(`no live node is called ${owner}; alive: ${this.alive().join(", ")}`);
    const answer = new Promise((resolve, reject) => {
      const late = setTimeout(() => reject(new Error(`${owner} did not answer in time`)), timeoutMs);
      this.#calls.set(request, (reply) => {
        clearTimeout(late);
        if (reply.isAccepted) resolve(reply);
        else reject(new Error(reply.why));
      });
    });
    this.#send(peer.dealer, "parameterRequest",
      { request, caller: this.#options.name, change: { name, value, manner, rampS } });
    return answer.finally(() => this.#calls.delete(request));
  }

  // Says goodbye, so that nobody takes the end for a death.
  async close() {
    if (this.#isClosed) return;
    this.#timers.forEach(clearTimeout);
    const bytes = this.#seal("heartbeat", this.#heartbeat(true));
    await Promise.all([...this.#peers.values()].map(({ heartbeat }) => new Promise((resolve) => {
      this.#beats.send(bytes, heartbeat.port, heartbeat.host, resolve);
    })));
    await this.#hello(true);
    this.#isClosed = true;
    for (const peer of this.#peers.values()) peer.dealer.socket.close();
    this.#router.socket.close();
    this.#registry.socket.close();
    this.#data.close();
    this.#beats.close();
  }

  // --- The protocol.

  #udp(take) {
    return new Promise((resolve, reject) => {
      const udp = dgram.createSocket({ type: "udp4", recvBufferSize: 1 << 20 });
      udp.on("message", take).once("error", reject);
      udp.bind(0, this.#options.bind, () => resolve(udp));
    });
  }

  #dealer(endpoint) {
    const dealer = new Dealer({ context: this.#context, routingId: `${this.#options.name}#${this.#instance}`,
      immediate: true, linger: 100, reconnectInterval: 20, reconnectMaxInterval: 200, maxMessageSize: 16 << 20,
      sendTimeout: 0 });
    dealer.connect(endpoint);
    return new Link(dealer);
  }

  async #receive(socket, take) {
    try {
      for await (const frames of socket) if (!this.#isClosed) take(frames);
    } catch (error) {
      if (!this.#isClosed && !socket.closed) throw error;
    }
  }

  #stamp() {
    return { topic: 0, digest: PROTOCOL_VERSION, session: this.#options.session, node: hash32(this.#options.name),
      boot: this.#boot, sequence: 0n, publishNs: process.hrtime.bigint() };
  }

  #seal(kind, value) {
    return writeEnvelope({ ...this.#stamp(), topicClass: classOf(kind) },
      toBinary(Control, create(Control, { body: { case: kind, value } })));
  }

  // The body of a Control in a sound envelope of this session, else an empty one, counted.
  #open(bytes) {
    const found = readEnvelope(bytes);
    if (found && found.envelope.session === this.#options.session && found.envelope.topicClass !== LATEST) {
      try {
        return fromBinary(Control, found.payload).body;
      } catch { /* counted below */ }
    }
    ++this.refused;
    return { case: undefined };
  }

  #send(link, kind, value) { return link.send(this.#seal(kind, value)); }
  #reply(routing, kind, value) { return this.#router.send([Buffer.from(routing, "latin1"), this.#seal(kind, value)]); }

  #record() {
    const { name, session, bind, isObserver } = this.#options;
    const schemas = new Map();
    const declare = (topic, isWritten) => {
      const rule = ruleOf(topic);
      if (rule.class !== LATEST && rule.class !== STATE) return [];
      const shape = canonical(typeOf(rule.type));
      schemas.set(hash32(shape), shape);
      return [{ name: topic, topicClass: rule.class, messageType: rule.message_type, schemaDigest: hash32(shape),
        isWritten }];
    };
    const topics = [...[...this.#read].flatMap((topic) => declare(topic, false)),
      ...[...this.#sequences.keys()].flatMap((topic) => declare(topic, true))];
    return { name, instance: this.#instance, boot: this.#boot, session, protocolVersion: PROTOCOL_VERSION,
      processId: process.pid, dataEndpoint: `${bind}:${this.#data.address().port}`,
      heartbeatEndpoint: `${bind}:${this.#beats.address().port}`, routerEndpoint: this.#router.socket.lastEndpoint,
      topics, observedPatterns: this.#patterns, isObserver, readsEvents: this.#read.has("event"),
      schemas: [...schemas].map(([digest, text]) => ({ digest, canonical: text })) };
  }

  #hello(isGoodbye) {
    return this.#send(this.#registry, "hello", { node: this.#record(), knownRoster: this.#roster, isGoodbye });
  }

  #helloAgain(delayMs = 0) {
    clearTimeout(this.#timers[1]);
    this.#timers[1] = setTimeout(() => {
      this.#hello(false);
      this.#helloAgain(this.#isWelcomed ? HELLO_MS : EAGER_HELLO_MS);
    }, delayMs);
  }

  #takeRegistry(bytes) {
    const body = this.#open(bytes);
    if (body.case === "refusal") {
      this.#welcome.reject(new Error(body.value.why));
      if (this.#isWelcomed) this.emit("refused", body.value.why);
    } else if (body.case === "roster") {
      this.#isWelcomed = true;
      this.#welcome.resolve();
      if (body.value.isUnchanged) return;
      this.#roster = body.value.version;
      for (const record of body.value.nodes) this.#add(record);
    }
  }

  #add(record) {
    const known = this.#peers.get(record.name);
    if (record.name === this.#options.name || this.#gone.has(record.instance) ||
        (known && (known.record.instance === record.instance || record.boot <= known.record.boot))) {
      return;
    }
    if (known) this.#forget(known);
    const dealer = this.#dealer(record.routerEndpoint);
    const peer = { record, dealer, data: addressOf(record.dataEndpoint), heartbeat: addressOf(record.heartbeatEndpoint),
      isAlive: false, isSubscribed: false, heardMs: 0, askedMs: -Infinity, stateVersion: 0n, nextEvent: 0n };
    this.#peers.set(record.name, peer);
    for (const topic of record.topics.filter((one) => one.isWritten)) {
      this.#topics.set(hash32(topic.name), { name: topic.name, writer: record.name, rule: ruleOf(topic.name) });
    }
    this.#receive(dealer.socket, (frames) => this.#takePeer(peer, frames.at(-1)));
    this.#beat();  // be heard by it at once
  }

  #forget(peer) {
    peer.dealer.socket.close();
    this.#peers.delete(peer.record.name);
    this.emit("roster", this.alive());
  }

  #heartbeat(isGoodbye) {
    return { name: this.#options.name, instance: this.#instance, waitCount: BigInt(Math.round(performance.now())),
      refused: BigInt(this.refused), isGoodbye };
  }

  #beat() {
    const now = performance.now();
    const bytes = this.#seal("heartbeat", this.#heartbeat(false));
    for (const peer of this.#peers.values()) {
      this.#beats.send(bytes, peer.heartbeat.port, peer.heartbeat.host);
      if (peer.isAlive && now - peer.heardMs > DEAD_AFTER_MS) {
        peer.isAlive = peer.isSubscribed = false;
        this.emit("roster", this.alive());
      }
      this.#ask(peer, now);
    }
  }

  #takeHeartbeat(bytes) {
    const { case: kind, value: heartbeat } = this.#open(bytes);
    if (kind !== "heartbeat" || this.#gone.has(heartbeat.instance)) return;
    const peer = this.#peers.get(heartbeat.name);
    if (!peer || peer.record.instance !== heartbeat.instance) {
      this.#roster = 0n;  // ask who that is
      this.#helloAgain(20);
    } else if (heartbeat.isGoodbye) {
      this.#gone.add(heartbeat.instance);
      this.#forget(peer);
    } else {
      const isNew = !peer.isAlive;
      peer.isAlive = true;
      peer.heardMs = performance.now();
      if (isNew) this.emit("roster", this.alive());
      this.#ask(peer, peer.heardMs);
    }
  }

  #wants(topic) { return this.#read.has(topic) || this.#patterns.some((pattern) => matches(pattern, topic)); }

  #ask(peer, now) {
    const wantsState = peer.record.topics.some((one) =>
      one.isWritten && one.topicClass === STATE && this.#wants(one.name));
    const wantsEvents = this.#wants("event");
    if (!peer.isAlive || peer.isSubscribed || !(wantsState || wantsEvents) || now - peer.askedMs < ASK_AGAIN_MS) return;
    peer.askedMs = now;
    this.#send(peer.dealer, "subscribe",
      { name: this.#options.name, instance: this.#instance, wantsState, wantsEvents });
  }

  #takePeer(peer, bytes) {
    const { case: kind, value } = this.#open(bytes);
    const writer = peer.record.name;
    if (kind === "subscribeAck") {
      peer.isSubscribed = true;
      if (value.nextEvent > peer.nextEvent) peer.nextEvent = value.nextEvent;
    } else if (kind === "stateSnapshot") {
      peer.stateVersion = value.version;
      value.entries.forEach((entry) => this.#takeState(writer, entry));
    } else if (kind === "stateDelta" && value.version > peer.stateVersion) {
      if (value.version === peer.stateVersion + 1n) {
        peer.stateVersion = value.version;
        this.#takeState(writer, value);
      } else {  // a gap: a new snapshot repairs it
        peer.isSubscribed = false;
        peer.askedMs = -Infinity;
      }
    } else if (kind === "event" && value.sequence >= peer.nextEvent) {
      peer.nextEvent = value.sequence + 1n;
      this.#send(peer.dealer, "eventAck", { sequence: value.sequence });
      if (this.#wants("event")) {
        this.emit("message", { topic: "event", writer, sequence: value.sequence, body: value.event });
      }
    } else if (kind === "parameterReply") {
      this.#calls.get(value.request)?.(value);
    }
  }

  #takeState(writer, { topic, key, value, version }) {
    if (!this.#wants(topic)) return;
    this.emit("message", { topic, writer, key, sequence: version, body: fromBinary(typeOf(ruleOf(topic).type), value) });
  }

  #takeRouter(from, bytes) {
    const { case: kind, value } = this.#open(bytes);
    const routing = from.toString("latin1");
    if (kind === "subscribe") {
      const reader = this.#readers.get(routing) ?? { next: 1n, sent: 0n, acked: 0n };
      if (value.wantsEvents) this.#readers.set(routing, reader);
      this.#reply(routing, "subscribeAck", { instance: this.#instance, nextEvent: reader.next });
      if (value.wantsState) this.#reply(routing, "stateSnapshot", { version: 0n });  // this node keeps no state
    } else if (kind === "eventAck") {
      const reader = this.#readers.get(routing);
      if (reader && value.sequence > reader.acked && value.sequence <= reader.sent) reader.acked = value.sequence;
    } else if (kind === "parameterRequest") {
      this.#reply(routing, "parameterReply",
        { request: value.request, why: `${this.#options.name} owns no parameters` });
    }
  }

  #takeData(bytes) {
    const found = readEnvelope(bytes);
    if (!found || found.envelope.session !== this.#options.session || found.envelope.topicClass !== LATEST) {
      ++this.refused;
      return;
    }
    const { envelope, payload } = found;
    const topic = this.#topics.get(envelope.topic);
    const isNewer = (a, b) => a.boot > b.boot || (a.boot === b.boot && a.sequence > b.sequence);
    if (!topic || !this.#wants(topic.name)) return;
    const newest = this.#newest.get(topic.name);
    if (newest && !isNewer(envelope, newest)) return;  // overtaken by a newer one, or a repetition
    let partial = this.#partial.get(topic.name);
    if (partial && isNewer(partial.envelope, envelope)) return;
    if (!partial || isNewer(envelope, partial.envelope)) partial = { envelope, parts: new Map() };
    this.#partial.set(topic.name, partial);
    const type = typeOf(topic.rule.type);
    try {
      partial.parts.set(envelope.part, fromBinary(type, payload));
    } catch {
      ++this.refused;
      return;
    }
    if (partial.parts.size < envelope.parts) return;
    this.#partial.delete(topic.name);
    this.#newest.set(topic.name, envelope);
    const body = mergeParts(type, Array.from({ length: envelope.parts }, (_, i) => partial.parts.get(i)));
    this.emit("message", { topic: topic.name, writer: topic.writer, sequence: envelope.sequence, body,
      publishNs: envelope.publishNs });
  }
}
