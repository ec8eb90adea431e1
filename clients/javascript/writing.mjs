// Sending to peers: LATEST and events. A client owns no STATE and no parameters.

import { EVENT_TOPIC } from "./members.mjs";
import { Reading, settled } from "./reading.mjs";
import { matches } from "./topics.mjs";

const EVENT_CREDIT = 1024n, EVENTS_KEPT = 4096;

const larger = (a, b) => (a > b ? a : b);
const smaller = (a, b) => (a < b ? a : b);

export class Writing extends Reading {
  _sequences = new Map();
  _readers = new Map();  // of its events
  _emitted = [];         // the newest events, kept to be sent again
  _numEvents = 0n;       // how many in all

  _sendToReaders(topic, bytes) {
    const readers = [...this._peers.values()].filter((peer) => peer.isAlive &&
      (peer.record.topics.some((one) => one.name === topic && !one.isWritten) ||
       peer.record.observedPatterns.some((pattern) => matches(pattern, topic))));
    const figures = this._figuresOf(topic, true);
    for (const { data } of readers) {
      this._data.send(bytes, data.port, data.host, (error) => { ++figures[error ? "dropped" : "sent"]; });
    }
    return readers.length;
  }

  _append(event) {
    this._emitted.push({ sequence: ++this._numEvents, event });
    if (this._emitted.length > EVENTS_KEPT) this._emitted.shift();
    for (const [routing, reader] of this._readers) this._pump(routing, reader);
  }

  _takeRouter(from, bytes) {
    const { case: kind, value } = this._open(bytes);
    const routing = from.toString("latin1");
    if (kind === "subscribe") {
      const reading = value.readings.find((one) => one.topic === EVENT_TOPIC);  // then it goes on
      const reader = { start: reading?.start ?? this._numEvents, instance: value.instance };
      if (value.wantsEvents) this._readers.set(routing, reader);
      this._rewind(routing, reader, reading ? settled(reading) : this._numEvents);
    } else if (kind === "eventAck") {
      const reader = this._readers.get(routing);
      if (!reader) {
        this._reply(routing, "eviction", { why: "not subscribed" });
        return;
      }
      reader.acked = larger(reader.acked, smaller(value.sequence, reader.sent));
      if (value.resend) this._rewind(routing, reader, value.sequence);
      this._pump(routing, reader);
    } else if (kind === "parameterRequest") {
      this._reply(routing, "parameterReply",
        { request: value.request, why: `${this._options.name} owns no parameters` });
    }
  }

  // Sends again from the event after `place`, or from the oldest that is kept.
  _rewind(routing, reader, place) {
    reader.sent = larger(this._numEvents - BigInt(this._emitted.length), smaller(place, this._numEvents));
    reader.acked = reader.sent;
    this._reply(routing, "subscribeAck", { instance: this._instance, nextEvent: reader.sent + 1n,
      starts: [{ topic: EVENT_TOPIC, start: reader.start }] });
    this._pump(routing, reader);
  }

  _pump(routing, reader) {
    const oldest = this._numEvents - BigInt(this._emitted.length) + 1n;
    if (reader.sent + 1n < oldest) {  // it is too far behind: the events between are no longer kept
      this._rewind(routing, reader, reader.sent);
      return;
    }
    while (reader.sent < this._numEvents && reader.sent < reader.acked + EVENT_CREDIT) {
      this._reply(routing, "event", this._emitted[Number(++reader.sent - oldest)]);
    }
  }
}
