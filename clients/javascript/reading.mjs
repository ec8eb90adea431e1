// Receiving from peers: LATEST by datagrams, STATE and EVENT by subscription.

import { fromBinary } from "@bufbuild/protobuf";
import { LATEST, STATE, hash32, isLatest, readEnvelope } from "./envelope.mjs";
import { EVENT_TOPIC, Members } from "./members.mjs";
import { findRule, matches, mergeParts, message, typeOf } from "./topics.mjs";

const RESUBSCRIBE_AFTER_MS = 300, BEHIND_TOO_LONG_MS = 200, BETWEEN_REPAIRS_MS = 50;

const larger = (a, b) => (a > b ? a : b);
export const settled = (account) => account.start + account.received + account.dropped;

export class Reading extends Members {
  _patterns = [];
  _read = new Set();
  _partial = new Map();
  _newest = new Map();
  _calls = new Map();

  _wants(topic) { return this._read.has(topic) || this._patterns.some((pattern) => matches(pattern, topic)); }

  // Subscribes, and again when changes or events that the peer's heartbeat announces stay away too long.
  _subscribeIfDue(peer, now) {
    const wantsState = peer.record.topics.some((one) =>
      one.isWritten && one.topicClass === STATE && this._wants(one.name));
    const wantsEvents = this._wants("event");
    if (!peer.isAlive || !(wantsState || wantsEvents)) return;
    if (peer.announcedVersion <= peer.stateVersion && peer.announcedEvents <= this._place(peer)) peer.inStepMs = now;
    else if (now - peer.inStepMs > BEHIND_TOO_LONG_MS) peer.isSubscribed = false;
    if (peer.isSubscribed || now - peer.subscribedMs < RESUBSCRIBE_AFTER_MS) return;
    peer.subscribedMs = now;
    this._send(peer.dealer, "subscribe", { name: this._options.name, instance: this._instance, wantsState, wantsEvents,
      readings: this._readings(peer) });
  }

  // Sequence number of the peer's last event that is settled: received, or counted as lost.
  _place(peer) {
    const account = peer.accounts.get(EVENT_TOPIC);
    return account ? settled(account) : 0n;
  }

  _readings(peer) { return [...peer.accounts].map(([topic, account]) => ({ topic, ...account })); }

  _acknowledge(peer, resend) {
    peer.acked = [this._place(peer), peer.stateVersion];
    this._send(peer.dealer, "eventAck", { sequence: peer.acked[0], resend, stateVersion: peer.acked[1],
      instance: this._instance, readings: this._readings(peer) });
  }

  _takePeer(peer, bytes) {
    if (isLatest(bytes)) {  // a datagram that came by ZeroMQ
      this._takeData(bytes);
      return;
    }
    const { case: kind, value } = this._open(bytes);
    const events = peer.accounts.get(EVENT_TOPIC);
    if (kind === "subscribeAck") {
      this._takeSubscribeAck(peer, value);
    } else if (kind === "stateSnapshot" && peer.isSubscribed) {
      this._takeSnapshot(peer, value);
    } else if (kind === "stateDelta" && value.version > peer.stateVersion) {
      const account = peer.accounts.get(hash32(value.topic));
      if (account && value.version === peer.stateVersion + 1n) {
        peer.stateVersion = value.version;
        ++account.received;
        this._takeState(peer.record.name, value);
      } else {  // a gap: a new snapshot repairs it
        peer.isSubscribed = false;
        peer.subscribedMs = -Infinity;
      }
    } else if (kind === "event" && events && value.sequence > settled(events)) {
      this._takeEvent(peer, events, value);
    } else if (kind === "eviction") {  // was too slow for the writer; subscribes again after RESUBSCRIBE_AFTER_MS
      peer.isSubscribed = false;
      peer.subscribedMs = performance.now();
    } else if (kind === "parameterReply") {
      this._calls.get(value.request)?.(value);
    }
    if (peer.acked[0] !== this._place(peer) || peer.acked[1] !== peer.stateVersion) this._acknowledge(peer, false);
  }

  _takeSubscribeAck(peer, { starts, nextEvent }) {
    peer.isSubscribed = true;
    peer.inStepMs = performance.now();
    peer.acked = [-1n, -1n];  // acknowledge at once
    for (const { topic, start } of starts) {
      if (!peer.accounts.has(topic)) peer.accounts.set(topic, { start, received: 0n, dropped: 0n });
    }
    const events = peer.accounts.get(EVENT_TOPIC);  // what the writer does not keep any more is lost
    if (events) events.dropped += larger(0n, nextEvent - 1n - settled(events));
  }

  _takeSnapshot(peer, { version, entries, counts }) {
    if (peer.hasSnapshot && version < peer.stateVersion) return;
    for (const entry of [...entries].sort((a, b) => Number(a.version - b.version))) {
      if (!peer.hasSnapshot || entry.version > peer.stateVersion) this._takeState(peer.record.name, entry);
    }
    peer.hasSnapshot = true;
    peer.stateVersion = version;
    for (const { topic, count } of counts) {  // changes that newer ones have overtaken
      const account = peer.accounts.get(topic);
      if (account) account.dropped += larger(0n, count - settled(account));
    }
  }

  _takeEvent(peer, account, { sequence, event }) {
    const now = performance.now();
    if (sequence === settled(account) + 1n) {
      ++account.received;
      if (!this._wants("event")) return;
      this.emit("message", { topic: "event", writer: peer.record.name, sequence, body: event ?? message("event", {}) });
    } else if (now - peer.repairedMs > BETWEEN_REPAIRS_MS) {
      peer.repairedMs = now;
      this._acknowledge(peer, true);
    }
  }

  // The message, or null if the bytes are not of that type; `refused` counts those.
  _decode(type, bytes) {
    try {
      return fromBinary(type, bytes);
    } catch {
      ++this.refused;
      return null;
    }
  }

  _takeState(writer, { topic, key, value, version }) {
    const rule = this._wants(topic) && findRule(topic);
    const body = rule && this._decode(typeOf(rule.type), value);
    if (body) this.emit("message", { topic, writer, key, sequence: version, body });
  }

  _takeData(bytes) {
    const found = readEnvelope(bytes, this._unsealer());
    if (!found || found.envelope.session !== this._options.session || found.envelope.topicClass !== LATEST) {
      ++this.refused;
      return;
    }
    const { envelope, payload } = found;
    const topic = this._topics.get(envelope.topic);
    const isNewer = (a, b) => a.boot > b.boot || (a.boot === b.boot && a.sequence > b.sequence);
    if (!topic?.isWanted) return;
    if (!topic.digests.includes(envelope.digest)) {
      ++this.refused;
      return;
    }
    const newest = this._newest.get(topic.name);
    if (newest && !isNewer(envelope, newest)) return;  // overtaken by a newer one, or a repetition
    let partial = this._partial.get(topic.name);
    if (partial && isNewer(partial.envelope, envelope)) return;
    if (!partial || isNewer(envelope, partial.envelope)) partial = { envelope, parts: new Map() };
    if (envelope.parts !== partial.envelope.parts) {
      ++this.refused;
      return;
    }
    const body = this._decode(topic.type, payload);
    if (!body) return;
    this._partial.set(topic.name, partial);
    partial.parts.set(envelope.part, body);
    if (partial.parts.size < envelope.parts) return;
    this._partial.delete(topic.name);
    const figures = this._figuresOf(topic.name, false);
    if (newest?.boot === envelope.boot) figures.dropped += envelope.sequence - newest.sequence - 1n;
    ++figures.received;
    this._newest.set(topic.name, envelope);
    this.emit("message", { topic: topic.name, writer: topic.writer, sequence: envelope.sequence,
      publishNs: envelope.publishNs,
      body: mergeParts(topic.type, Array.from({ length: envelope.parts }, (_, i) => partial.parts.get(i))) });
  }
}
