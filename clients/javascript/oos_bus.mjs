// A node of the VR-OOS bus in JavaScript, on npm's zeromq, @bufbuild/protobuf and hash-wasm (Node 18 or later). The
// protocol is docs/reference/bus_protocol.md.

import dgram from "node:dgram";
import { randomBytes } from "node:crypto";
import { EventEmitter } from "node:events";
import { readFileSync } from "node:fs";
import path from "node:path";
import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import { Context, Dealer, Reply, Router } from "zeromq";
import { CONTROL, EVENT, LATEST, MAX_DATAGRAM_BYTES, SERVICE, STATE, hash32, readEnvelope, writeEnvelope }
  from "./envelope.mjs";
import { loadKeys, makeOpener, makeSealer, senderKey, z85 } from "./security.mjs";
import { canonical, matches, mergeParts, ruleOf, typeOf } from "./topics.mjs";

export * from "./envelope.mjs";
export * from "./topics.mjs";
export { create, createFileRegistry, fromBinary, toBinary, toJson } from "@bufbuild/protobuf";
export * as wkt from "@bufbuild/protobuf/wkt";

const PROTOCOL_VERSION = 1;
const HEARTBEAT_MS = 50, HELLO_MS = 500, EAGER_HELLO_MS = 100, DEAD_AFTER_MS = 350, ASK_AGAIN_MS = 300;
const BEHIND_TOO_LONG_MS = 200, BETWEEN_REPAIRS_MS = 50;
const EVENT_CREDIT = 1024n, EVENTS_KEPT = 4096;
const MAX_TOPICS_TOLD = 30;  // keeps a heartbeat within one datagram
const EVENT_TOPIC = hash32("event");

const Control = typeOf("oos.Control");

// {registry, session, keys} of the `oos run` of this user on this machine.
export function runningSession() {
  const runtime = process.env.XDG_RUNTIME_DIR;
  const folder = runtime ? path.join(runtime, "vr_oos") : `/tmp/vr_oos-${process.getuid()}`;
  const note = JSON.parse(readFileSync(path.join(folder, "session.json"), "utf8"));
  return { registry: note.registry, session: BigInt(note.session), keys: note.keys || null };
}

const classOf = (body) => body.startsWith("sub") || body.startsWith("state") ? STATE
  : body.startsWith("ev") ? EVENT : body.startsWith("parameter") ? SERVICE : CONTROL;

const larger = (a, b) => (a > b ? a : b);
const smaller = (a, b) => (a < b ? a : b);
const settled = (account) => account.start + account.received + account.dropped;
// Nodes of one machine share a clock.
const MACHINE_ID = process.env.OOS_MACHINE_ID || readFileSync("/proc/sys/kernel/random/boot_id", "utf8").trim();

const digests = new Map();
function digestOf(type) {
  if (!digests.has(type)) digests.set(type, hash32(canonical(type)));
  return digests.get(type);
}

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

// A LATEST message. Its body is decoded when it is first asked for: whoever shows 30 a second does not pay for 1000. It
// throws when the bytes are no such message.
class Latest {
  #type; #payloads; #body = null;

  constructor({ name, writer, rule }, { sequence, publishNs }, parts) {
    Object.assign(this, { topic: name, writer, sequence, publishNs });
    this.#type = typeOf(rule.type);
    this.#payloads = Array.from({ length: parts.size }, (_, i) => parts.get(i));
  }

  get body() {
    this.#body ??= mergeParts(this.#type, this.#payloads.map((payload) => fromBinary(this.#type, payload)));
    return this.#body;
  }
}

// subscribe() and advertise() first, then await start(). Keys: the run's key directory; null is to say that nothing is
// encrypted. With keys, the name is that of a key, or begins with it and a '-': "client-1". Emits "message" ({topic,
// writer, sequence, body, key, publishNs}), "roster" (names of the living) when somebody comes or goes, and "refused"
// (why).
export class Node extends EventEmitter {
  #options; #instance = randomBytes(8).readBigUInt64LE(); #boot = BigInt(Date.now()) * 1_000_000n;
  #patterns = []; #read = new Set(); #sequences = new Map();
  #peers = new Map(); #gone = new Set(); #topics = new Map(); #partial = new Map(); #newest = new Map();
  #readers = new Map(); #calls = new Map(); #nextRequest = 0n;
  #context = new Context(); #router; #registry; #data; #beats; #timers = [];
  #keys; #sessionKey = null; #sealer = null; #allowList = null;
  #roster = 0n; #isWelcomed = false; #isClosed = false; #welcome = null;
  #events = []; #numEvents = 0n;  // the last that this node emitted; how many in all
  refused = 0;
  figures = new Map();  // LATEST, by topic: {isWritten, sent, received, dropped}

  constructor(options) {  // {name, registry, session, keys, bind, isObserver}
    super();
    if (options.keys === undefined) throw new Error("keys: a run's key directory, or null to say that there is none");
    this.#options = { bind: "127.0.0.1", isObserver: true, ...options };
    this.#keys = options.keys && loadKeys(options.keys, options.name);
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
      maxMessageSize: 16 << 20, sendTimeout: 0,
      ...(this.#keys && { curveServer: true, curveSecretKey: this.#keys.secretKey, zapDomain: "bus" }) }));
    if (this.#keys) await this.#answerWhoMayComeIn();
    await this.#router.socket.bind(`tcp://${bind}:*`);
    this.#registry = this.#dealer(registry, this.#keys?.registryKey);
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
      digest: digestOf(type) }, toBinary(type, body), this.#sealer);
    if (bytes.length > MAX_DATAGRAM_BYTES) throw new Error(`${topic}: ${bytes.length} bytes exceed one datagram`);
    const readers = [...this.#peers.values()].filter((peer) => peer.isAlive &&
      (peer.record.topics.some((one) => one.name === topic && !one.isWritten) ||
       peer.record.observedPatterns.some((pattern) => matches(pattern, topic))));
    for (const { data } of readers) this.#data.send(bytes, data.port, data.host);
    this.#figuresOf(topic, true).sent += BigInt(readers.length);
    return readers.length;
  }

  // Sends an event to all readers of events. The last 4096 are kept for a reader that lost some.
  emitEvent(name, detail = "") {
    const event = { timeNs: process.hrtime.bigint(), source: this.#options.name, name, detail };
    this.#events.push({ sequence: ++this.#numEvents, event });
    if (this.#events.length > EVENTS_KEPT) this.#events.shift();
    for (const [routing, reader] of this.#readers) this.#pump(routing, reader);
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
      { request, caller: this.#options.name, callerInstance: this.#instance,
        timeLeftNs: BigInt(timeoutMs) * 1_000_000n, change: { name, value, manner, rampS } });
    return answer.finally(() => this.#calls.delete(request));
  }

  // Says goodbye, so that nobody takes the end for a death.
  async close() {
    if (this.#isClosed) return;
    this.#timers.forEach(clearTimeout);
    const bytes = this.#wrap("heartbeat", this.#heartbeat(true), this.#sealer);
    await Promise.all([...this.#peers.values()].map(({ heartbeat }) => new Promise((resolve) => {
      this.#beats.send(bytes, heartbeat.port, heartbeat.host, resolve);
    })));
    await this.#hello(true);
    this.#isClosed = true;
    for (const peer of this.#peers.values()) peer.dealer.socket.close();
    this.#router.socket.close();
    this.#registry.socket.close();
    this.#allowList?.close();
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

  // libzmq asks whether a key that its owner has proven may come in [ZeroMQ RFC 27].
  async #answerWhoMayComeIn() {
    this.#allowList = new Reply({ context: this.#context, linger: 0 });
    await this.#allowList.bind("inproc://zeromq.zap.01");
    this.#receive(this.#allowList, ([version, request, , , , mechanism, key]) => {
      const owner = mechanism.toString() === "CURVE" && this.#keys.allowed.get(z85(key));
      return this.#allowList.send([version, request, owner ? "200" : "400", "", owner || "", ""]);
    });
  }

  #dealer(endpoint, serverKey) {
    const dealer = new Dealer({ context: this.#context, routingId: `${this.#options.name}#${this.#instance}`,
      immediate: true, linger: 100, reconnectInterval: 20, reconnectMaxInterval: 200, maxMessageSize: 16 << 20,
      sendTimeout: 0, ...(this.#keys && { curveServerKey: serverKey, curvePublicKey: this.#keys.publicKey,
        curveSecretKey: this.#keys.secretKey }) });
    dealer.connect(endpoint);
    return new Link(dealer);
  }

  async #receive(socket, take) {
    try {
      for await (const frames of socket) if (!this.#isClosed) await take(frames);
    } catch (error) {
      if (!this.#isClosed && !socket.closed) throw error;
    }
  }

  #stamp() {
    return { topic: 0, digest: PROTOCOL_VERSION, session: this.#options.session, node: hash32(this.#options.name),
      boot: this.#boot, sequence: 0n, publishNs: process.hrtime.bigint() };
  }

  #wrap(kind, value, sealer) {
    return writeEnvelope({ ...this.#stamp(), topicClass: classOf(kind) },
      toBinary(Control, create(Control, { body: { case: kind, value } })), sealer);
  }

  // For readEnvelope, with keys: opens a datagram with the key of the node that it says it is from.
  #unsealer() {
    return this.#keys && ((envelope, clear, body) => [...this.#peers.values()].find((peer) =>
      peer.node === envelope.node)?.opener?.(envelope.topicClass, clear, body));
  }

  // The body of a Control in a sound envelope of this session, else an empty one, counted.
  #open(bytes, unsealer) {
    const found = readEnvelope(bytes, unsealer);
    if (found && found.envelope.session === this.#options.session && found.envelope.topicClass !== LATEST) {
      try {
        return fromBinary(Control, found.payload).body;
      } catch { /* counted below */ }
    }
    ++this.refused;
    return { case: undefined };
  }

  #send(link, kind, value) { return link.send(this.#wrap(kind, value)); }
  #reply(routing, kind, value) { return this.#router.send([Buffer.from(routing, "latin1"), this.#wrap(kind, value)]); }

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
      processId: process.pid, machineId: MACHINE_ID, dataEndpoint: `${bind}:${this.#data.address().port}`,
      heartbeatEndpoint: `${bind}:${this.#beats.address().port}`, routerEndpoint: this.#router.socket.lastEndpoint,
      topics, observedPatterns: this.#patterns, isObserver, readsEvents: this.#read.has("event"),
      schemas: [...schemas].map(([digest, text]) => ({ digest, canonical: text })) };
  }

  #hello(isGoodbye) {
    return this.#send(this.#registry, "hello", { node: this.#record(), knownRoster: this.#roster, isGoodbye,
      isMember: this.#isWelcomed });
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
      if (!this.#isWelcomed && body.value.boot !== 0n) this.#boot = body.value.boot;
      this.#isWelcomed = true;
      for (const instance of body.value.fenced) this.#fenceOff(instance);
      if (this.#keys && !this.#sealer) {
        this.#sessionKey = body.value.sessionKey;
        this.#sealer = makeSealer(senderKey(this.#sessionKey, this.#instance));
      }
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
    const dealer = this.#dealer(record.routerEndpoint, record.publicKey);
    const opener = this.#sessionKey && makeOpener(senderKey(this.#sessionKey, record.instance));
    const peer = { record, dealer, opener, node: hash32(record.name), data: addressOf(record.dataEndpoint),
      heartbeat: addressOf(record.heartbeatEndpoint),
      isAlive: false, isSubscribed: false, hasSnapshot: false, heardMs: 0, askedMs: -Infinity, repairedMs: -Infinity,
      inStepMs: 0, accounts: new Map(), stateVersion: 0n, toldVersion: 0n, toldEvents: 0n, acked: [0n, 0n] };
    this.#peers.set(record.name, peer);
    for (const topic of record.topics.filter((one) => one.isWritten)) {
      this.#topics.set(hash32(topic.name), { name: topic.name, writer: record.name, rule: ruleOf(topic.name),
        isWanted: this.#wants(topic.name) });
    }
    this.#receive(dealer.socket, (frames) => this.#takePeer(peer, frames.at(-1)));
    this.#beat();  // be heard by it at once
  }

  // Another has taken its place: nothing of it counts any more.
  #fenceOff(instance) {
    this.#gone.add(instance);
    for (const peer of [...this.#peers.values()].filter((one) => one.record.instance === instance)) this.#forget(peer);
  }

  #forget(peer) {
    peer.dealer.socket.close();
    this.#peers.delete(peer.record.name);
    for (const [routing, reader] of this.#readers) {
      if (reader.instance === peer.record.instance) this.#readers.delete(routing);
    }
    this.emit("roster", this.alive());
  }

  #figuresOf(topic, isWritten) {
    if (!this.figures.has(topic)) this.figures.set(topic, { isWritten, sent: 0n, received: 0n, dropped: 0n });
    return this.figures.get(topic);
  }

  #heartbeat(isGoodbye) {
    const topics = [...this.figures].slice(0, MAX_TOPICS_TOLD).map(([name, of]) => ({ topic: hash32(name), ...of }));
    const total = (kind) => [...this.figures.values()].reduce((sum, of) => sum + of[kind], 0n);
    return { name: this.#options.name, instance: this.#instance, waitCount: BigInt(Math.round(performance.now())),
      isGoodbye, sentNs: process.hrtime.bigint(), topics, refused: BigInt(this.refused), sent: total("sent"),
      received: total("received"), dropped: total("dropped"),
      counts: [{ topic: EVENT_TOPIC, count: this.#numEvents }] };
  }

  #beat() {
    if (this.#keys && !this.#sealer) return;  // nobody could read it
    const now = performance.now();
    const bytes = this.#wrap("heartbeat", this.#heartbeat(false), this.#sealer);
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
    const { case: kind, value: heartbeat } = this.#open(bytes, this.#unsealer());
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
      if (peer.record.machineId && peer.record.machineId !== MACHINE_ID) this.#answerClock(peer, heartbeat.sentNs);
      peer.toldVersion = heartbeat.stateVersion;
      peer.toldEvents = heartbeat.counts.find((one) => one.topic === EVENT_TOPIC)?.count ?? 0n;
      if (isNew) this.emit("roster", this.alive());
      this.#ask(peer, peer.heardMs);
    }
  }

  // What a node on another machine needs to compare the clocks.
  #answerClock(peer, heartbeatSentNs) {
    const now = process.hrtime.bigint();
    const bytes = this.#wrap("clockEcho", { name: this.#options.name, instance: this.#instance, heartbeatSentNs,
      receivedNs: now, answeredNs: now }, this.#sealer);
    this.#beats.send(bytes, peer.heartbeat.port, peer.heartbeat.host);
  }

  #wants(topic) { return this.#read.has(topic) || this.#patterns.some((pattern) => matches(pattern, topic)); }

  // Subscribes, and once more when changes or events that the peer tells of have not come for a while.
  #ask(peer, now) {
    const wantsState = peer.record.topics.some((one) =>
      one.isWritten && one.topicClass === STATE && this.#wants(one.name));
    const wantsEvents = this.#wants("event");
    if (!peer.isAlive || !(wantsState || wantsEvents)) return;
    if (peer.toldVersion <= peer.stateVersion && peer.toldEvents <= this.#place(peer)) peer.inStepMs = now;
    else if (now - peer.inStepMs > BEHIND_TOO_LONG_MS) peer.isSubscribed = false;
    if (peer.isSubscribed || now - peer.askedMs < ASK_AGAIN_MS) return;
    peer.askedMs = now;
    this.#send(peer.dealer, "subscribe", { name: this.#options.name, instance: this.#instance, wantsState, wantsEvents,
      readings: this.#readings(peer) });
  }

  // The last event of the peer that is settled: received, or given up.
  #place(peer) {
    const account = peer.accounts.get(EVENT_TOPIC);
    return account ? settled(account) : 0n;
  }

  #readings(peer) { return [...peer.accounts].map(([topic, account]) => ({ topic, ...account })); }

  #acknowledge(peer, resend) {
    peer.acked = [this.#place(peer), peer.stateVersion];
    this.#send(peer.dealer, "eventAck", { sequence: peer.acked[0], resend, stateVersion: peer.acked[1],
      instance: this.#instance, readings: this.#readings(peer) });
  }

  #takePeer(peer, bytes) {
    const { case: kind, value } = this.#open(bytes);
    const events = peer.accounts.get(EVENT_TOPIC);
    if (kind === "subscribeAck") {
      this.#takeSubscribeAck(peer, value);
    } else if (kind === "stateSnapshot" && peer.isSubscribed) {
      this.#takeSnapshot(peer, value);
    } else if (kind === "stateDelta" && value.version > peer.stateVersion) {
      const account = peer.accounts.get(hash32(value.topic));
      if (account && value.version === peer.stateVersion + 1n) {
        peer.stateVersion = value.version;
        ++account.received;
        this.#takeState(peer.record.name, value);
      } else {  // a gap: a new snapshot repairs it
        peer.isSubscribed = false;
        peer.askedMs = -Infinity;
      }
    } else if (kind === "event" && events && value.sequence > settled(events)) {
      this.#takeEvent(peer, events, value);
    } else if (kind === "eviction") {  // too slow for the writer; asks again after a while
      peer.isSubscribed = false;
      peer.askedMs = performance.now();
    } else if (kind === "parameterReply") {
      this.#calls.get(value.request)?.(value);
    }
    if (peer.acked[0] !== this.#place(peer) || peer.acked[1] !== peer.stateVersion) this.#acknowledge(peer, false);
  }

  #takeSubscribeAck(peer, { starts, nextEvent }) {
    peer.isSubscribed = true;
    peer.inStepMs = performance.now();
    for (const { topic, start } of starts) {
      if (!peer.accounts.has(topic)) peer.accounts.set(topic, { start, received: 0n, dropped: 0n });
    }
    const events = peer.accounts.get(EVENT_TOPIC);  // what the writer does not keep any more is lost
    if (events) events.dropped += larger(0n, nextEvent - 1n - settled(events));
  }

  #takeSnapshot(peer, { version, entries, counts }) {
    if (peer.hasSnapshot && version < peer.stateVersion) return;
    for (const entry of entries) {
      if (!peer.hasSnapshot || entry.version > peer.stateVersion) this.#takeState(peer.record.name, entry);
    }
    peer.hasSnapshot = true;
    peer.stateVersion = version;
    for (const { topic, count } of counts) {  // changes that newer ones have overtaken
      const account = peer.accounts.get(topic);
      if (account) account.dropped += larger(0n, count - settled(account));
    }
  }

  #takeEvent(peer, account, { sequence, event }) {
    const now = performance.now();
    if (sequence === settled(account) + 1n) {
      ++account.received;
      if (!this.#wants("event")) return;
      this.emit("message", { topic: "event", writer: peer.record.name, sequence, body: event });
    } else if (now - peer.repairedMs > BETWEEN_REPAIRS_MS) {
      peer.repairedMs = now;
      this.#acknowledge(peer, true);
    }
  }

  #takeState(writer, { topic, key, value, version }) {
    if (!this.#wants(topic)) return;
    const body = fromBinary(typeOf(ruleOf(topic).type), value);
    this.emit("message", { topic, writer, key, sequence: version, body });
  }

  #takeRouter(from, bytes) {
    const { case: kind, value } = this.#open(bytes);
    const routing = from.toString("latin1");
    if (kind === "subscribe") {
      const reading = value.readings.find((one) => one.topic === EVENT_TOPIC);  // then it goes on
      const reader = { start: reading?.start ?? this.#numEvents, instance: value.instance };
      if (value.wantsEvents) this.#readers.set(routing, reader);
      this.#rewind(routing, reader, reading ? settled(reading) : this.#numEvents);
    } else if (kind === "eventAck") {
      const reader = this.#readers.get(routing);
      if (!reader) {
        this.#reply(routing, "eviction", { why: "not subscribed" });
        return;
      }
      reader.acked = larger(reader.acked, smaller(value.sequence, reader.sent));
      if (value.resend) this.#rewind(routing, reader, value.sequence);
      this.#pump(routing, reader);
    } else if (kind === "parameterRequest") {
      this.#reply(routing, "parameterReply",
        { request: value.request, why: `${this.#options.name} owns no parameters` });
    }
  }

  // Goes on after event `place`, or with the oldest that is kept.
  #rewind(routing, reader, place) {
    reader.sent = larger(this.#numEvents - BigInt(this.#events.length), smaller(place, this.#numEvents));
    reader.acked = reader.sent;
    this.#reply(routing, "subscribeAck", { instance: this.#instance, nextEvent: reader.sent + 1n,
      starts: [{ topic: EVENT_TOPIC, start: reader.start }] });
    this.#pump(routing, reader);
  }

  #pump(routing, reader) {
    const oldest = this.#numEvents - BigInt(this.#events.length) + 1n;
    if (reader.sent + 1n < oldest) {  // nobody waited for it
      this.#rewind(routing, reader, reader.sent);
      return;
    }
    while (reader.sent < this.#numEvents && reader.sent < reader.acked + EVENT_CREDIT) {
      this.#reply(routing, "event", this.#events[Number(++reader.sent - oldest)]);
    }
  }

  #takeData(bytes) {
    const found = readEnvelope(bytes, this.#unsealer());
    if (!found || found.envelope.session !== this.#options.session || found.envelope.topicClass !== LATEST) {
      ++this.refused;
      return;
    }
    const { envelope, payload } = found;
    const topic = this.#topics.get(envelope.topic);
    const isNewer = (a, b) => a.boot > b.boot || (a.boot === b.boot && a.sequence > b.sequence);
    if (!topic?.isWanted) return;
    const newest = this.#newest.get(topic.name);
    if (newest && !isNewer(envelope, newest)) return;  // overtaken by a newer one, or a repetition
    let partial = this.#partial.get(topic.name);
    if (partial && isNewer(partial.envelope, envelope)) return;
    if (!partial || isNewer(envelope, partial.envelope)) partial = { envelope, parts: new Map() };
    this.#partial.set(topic.name, partial);
    partial.parts.set(envelope.part, payload);
    if (partial.parts.size < envelope.parts) return;
    this.#partial.delete(topic.name);
    const figures = this.#figuresOf(topic.name, false);
    if (newest?.boot === envelope.boot) figures.dropped += envelope.sequence - newest.sequence - 1n;
    ++figures.received;
    this.#newest.set(topic.name, envelope);
    this.emit("message", new Latest(topic, envelope, partial.parts));
  }
}
