// Who a node is and who the others are: registry, roster, heartbeats.

import { readFileSync } from "node:fs";
import { isIPv4 } from "node:net";
import { LATEST, STATE, hash32 } from "./envelope.mjs";
import { Links, PROTOCOL_VERSION } from "./links.mjs";
import { makeOpener, makeSealer, senderKey } from "./security.mjs";
import { canonical, digestOf, findRule, ruleOf, typeOf } from "./topics.mjs";

const HELLO_MS = 500, EAGER_HELLO_MS = 100, DEAD_AFTER_MS = 350;
const MAX_TOPICS_IN_HEARTBEAT = 30;  // keeps a heartbeat within one datagram
export const EVENT_TOPIC = hash32("event");

// Nodes of one machine share a clock.
const MACHINE_ID = process.env.OOS_MACHINE_ID || readFileSync("/proc/sys/kernel/random/boot_id", "utf8").trim();

// {host, port} of "127.0.0.1:4000".
function addressOf(endpoint) {
  const [host, port] = endpoint.split(":");
  if (!isIPv4(host) || !(port > 0 && port < 65536)) throw new Error(`'${endpoint}' is not IPv4:PORT`);
  return { host, port: Number(port) };
}

export class Members extends Links {
  figures = new Map();  // LATEST, by topic: {isWritten, sent, received, dropped}
  _peers = new Map();
  _gone = new Set();
  _topics = new Map();
  _timers = [];
  _sessionKey = null;
  _roster = 0n;
  _isWelcomed = false;
  _welcome = null;

  // With keys, the `unseal` of readEnvelope: opens a datagram with the key of the node named in its envelope.
  _unsealer() {
    return this._keys && ((envelope, clear, body) => [...this._peers.values()].find((peer) =>
      peer.node === envelope.node)?.opener?.(envelope.topicClass, clear, body));
  }

  _record() {
    const { name, session, bind, isObserver } = this._options;
    const schemas = new Map();
    const declare = (topic, isWritten) => {
      const rule = ruleOf(topic);
      if (rule.class !== LATEST && rule.class !== STATE) return [];
      const shape = canonical(typeOf(rule.type));
      schemas.set(hash32(shape), shape);
      return [{ name: topic, topicClass: rule.class, messageType: rule.message_type, schemaDigest: hash32(shape),
        isWritten }];
    };
    const topics = [...[...this._read].flatMap((topic) => declare(topic, false)),
      ...[...this._sequences.keys()].flatMap((topic) => declare(topic, true))];
    return { name, instance: this._instance, boot: this._boot, session, protocolVersion: PROTOCOL_VERSION,
      processId: process.pid, machineId: MACHINE_ID, dataEndpoint: `${bind}:${this._data.address().port}`,
      heartbeatEndpoint: `${bind}:${this._beats.address().port}`, routerEndpoint: this._router.socket.lastEndpoint,
      topics, observedPatterns: this._patterns, isObserver, readsEvents: this._read.has("event"),
      schemas: [...schemas].map(([digest, text]) => ({ digest, canonical: text })) };
  }

  _hello(isGoodbye) {
    return this._send(this._registry, "hello", { node: this._record(), knownRoster: this._roster, isGoodbye,
      isMember: this._isWelcomed });
  }

  _helloAgain(delayMs = 0) {
    if (this._closing) return;
    clearTimeout(this._timers[1]);
    this._timers[1] = setTimeout(() => {
      this._hello(false);
      this._helloAgain(this._isWelcomed ? HELLO_MS : EAGER_HELLO_MS);
    }, delayMs);
  }

  _takeRegistry(bytes) {
    const body = this._open(bytes);
    if (body.case === "refusal") {
      this._welcome.reject(new Error(body.value.why));
      if (this._isWelcomed) this.emit("refused", body.value.why);
    } else if (body.case === "roster") {
      if (!this._isWelcomed && body.value.boot !== 0n) this._boot = body.value.boot;
      this._isWelcomed = true;
      for (const instance of body.value.fenced) this._fenceOff(instance);
      if (this._keys && !this._sealer) {
        this._sessionKey = body.value.sessionKey;
        this._sealer = makeSealer(senderKey(this._sessionKey, this._instance));
      }
      this._welcome.resolve();
      if (body.value.isUnchanged) return;
      this._roster = body.value.version;
      for (const record of body.value.nodes) this._add(record);
    }
  }

  _add(record) {
    const known = this._peers.get(record.name);
    if (record.name === this._options.name || this._gone.has(record.instance) ||
        (known && (known.record.instance === record.instance || record.boot <= known.record.boot))) {
      return;
    }
    let places;
    try {
      places = { data: addressOf(record.dataEndpoint), heartbeat: addressOf(record.heartbeatEndpoint),
        dealer: this._dealer(record.routerEndpoint, record.publicKey) };
    } catch {  // no addresses
      ++this.refused;
      return;
    }
    if (known) this._forget(known);
    const opener = this._sessionKey && makeOpener(senderKey(this._sessionKey, record.instance));
    const peer = { record, ...places, opener, node: hash32(record.name),
      isAlive: false, isSubscribed: false, hasSnapshot: false, heardMs: 0, subscribedMs: -Infinity, repairedMs: -Infinity,
      inStepMs: 0, accounts: new Map(), stateVersion: 0n, announcedVersion: 0n, announcedEvents: 0n, acked: [0n, 0n] };
    this._peers.set(record.name, peer);
    for (const { name, schemaDigest } of record.topics.filter((one) => one.isWritten)) {
      const rule = findRule(name);
      if (!rule) continue;
      const type = typeOf(rule.type);
      // The digest may also be that of the writer's schema, which the registry found compatible with this client's.
      this._topics.set(hash32(name), { name, writer: record.name, type, digests: [digestOf(type), schemaDigest],
        isWanted: this._wants(name) });
    }
    this._receive(peer.dealer.socket, (frames) => this._takePeer(peer, frames.at(-1)));
    this._beat();  // so that it knows of this node at once
  }

  // Ignores that instance from now on: another node has taken its name.
  _fenceOff(instance) {
    this._gone.add(instance);
    for (const peer of [...this._peers.values()].filter((one) => one.record.instance === instance)) this._forget(peer);
  }

  _forget(peer) {
    peer.dealer.socket.close();
    this._peers.delete(peer.record.name);
    for (const [routing, reader] of this._readers) {
      if (reader.instance === peer.record.instance) this._readers.delete(routing);
    }
    this.emit("roster", this.alive());
  }

  _figuresOf(topic, isWritten) {
    if (!this.figures.has(topic)) this.figures.set(topic, { isWritten, sent: 0n, received: 0n, dropped: 0n });
    return this.figures.get(topic);
  }

  _heartbeat(isGoodbye) {
    const topics = [...this.figures].slice(0, MAX_TOPICS_IN_HEARTBEAT).map(([name, of]) => ({ topic: hash32(name), ...of }));
    const total = (kind) => [...this.figures.values()].reduce((sum, of) => sum + of[kind], 0n);
    return { name: this._options.name, instance: this._instance, waitCount: BigInt(Math.round(performance.now())),
      isGoodbye, sentNs: process.hrtime.bigint(), topics, refused: BigInt(this.refused), sent: total("sent"),
      received: total("received"), dropped: total("dropped"),
      counts: [{ topic: EVENT_TOPIC, count: this._numEvents }] };
  }

  _beat() {
    if (this._keys && !this._sealer) return;  // no peer could read it
    const now = performance.now();
    const bytes = this._wrap("heartbeat", this._heartbeat(false), this._sealer);
    for (const peer of this._peers.values()) {
      this._beats.send(bytes, peer.heartbeat.port, peer.heartbeat.host);
      if (peer.isAlive && now - peer.heardMs > DEAD_AFTER_MS) {
        peer.isAlive = peer.isSubscribed = false;
        this.emit("roster", this.alive());
      }
      this._subscribeIfDue(peer, now);
    }
  }

  _takeHeartbeat(bytes) {
    const { case: kind, value: heartbeat } = this._open(bytes, this._unsealer());
    if (kind !== "heartbeat" || this._gone.has(heartbeat.instance)) return;
    const peer = this._peers.get(heartbeat.name);
    if (!peer || peer.record.instance !== heartbeat.instance) {
      this._roster = 0n;  // request the roster: it has the sender's record
      this._helloAgain(20);
    } else if (heartbeat.isGoodbye) {
      this._gone.add(heartbeat.instance);
      this._forget(peer);
    } else {
      const isNew = !peer.isAlive;
      peer.isAlive = true;
      peer.heardMs = performance.now();
      if (peer.record.machineId && peer.record.machineId !== MACHINE_ID) this._answerClock(peer, heartbeat.sentNs);
      peer.announcedVersion = heartbeat.stateVersion;
      peer.announcedEvents = heartbeat.counts.find((one) => one.topic === EVENT_TOPIC)?.count ?? 0n;
      if (isNew) this.emit("roster", this.alive());
      this._subscribeIfDue(peer, peer.heardMs);
    }
  }

  // Answers a heartbeat from another machine with the times that comparing the clocks needs.
  _answerClock(peer, heartbeatSentNs) {
    const now = process.hrtime.bigint();
    const bytes = this._wrap("clockEcho", { name: this._options.name, instance: this._instance, heartbeatSentNs,
      receivedNs: now, answeredNs: now }, this._sealer);
    this._beats.send(bytes, peer.heartbeat.port, peer.heartbeat.host);
  }
}
