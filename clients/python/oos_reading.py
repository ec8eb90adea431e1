"""Receiving from peers: LATEST by datagrams, STATE and EVENT by subscription."""

import collections
import dataclasses
import time

from oos_envelope import LATEST, STATE, hash32, read_envelope
from oos_members import EVENT_TOPIC, Members
from oos_topics import TYPES, digest_of, matches, merge_parts, rule_of
from proto import bus_pb2

RESUBSCRIBE_AFTER_S, BEHIND_TOO_LONG_S, BETWEEN_REPAIRS_S = 0.3, 0.2, 0.05


@dataclasses.dataclass
class Message:
    topic: str
    writer: str
    sequence: int
    body: object  # protobuf message
    key: str = ""  # of a STATE value
    publish_ns: int = 0  # of a LATEST message, on the writer's clock


class Reading(Members):
    def __init__(self, *identity):
        super().__init__(*identity)
        self.received, self.dropped = (collections.Counter() for _ in range(2))  # LATEST, by topic
        self._patterns, self._read, self._inbox, self._partial, self._newest = [], set(), [], {}, {}
        self._replies = {}

    def _wants(self, topic):
        return topic in self._read or any(matches(pattern, topic) for pattern in self._patterns)

    def _subscribe_if_due(self, peer, now):
        """Subscribes, and again when changes or events that the peer's heartbeat announces stay away too long."""
        wants_state = any(t.is_written and t.topic_class == STATE and self._wants(t.name) for t in peer.record.topics)
        wants_events = self._wants("event")
        if not peer.is_alive or not (wants_state or wants_events):
            return
        if peer.announced_version <= peer.state_version and peer.announced_events <= peer.place():
            peer.in_step_s = now
        elif now - peer.in_step_s > BEHIND_TOO_LONG_S:
            peer.is_subscribed = False
        if peer.is_subscribed or now - peer.subscribed_s < RESUBSCRIBE_AFTER_S:
            return
        if self._send(peer.dealer, bus_pb2.Control(subscribe=bus_pb2.Subscribe(
                name=self.name, instance=self.instance, wants_state=wants_state, wants_events=wants_events,
                readings=peer.readings()))):
            peer.subscribed_s = now

    def _acknowledge(self, peer, resend):
        acked = (peer.place(), peer.state_version)
        if self._send(peer.dealer, bus_pb2.Control(event_ack=bus_pb2.EventAck(
                sequence=acked[0], resend=resend, state_version=acked[1], instance=self.instance,
                readings=peer.readings()))):
            peer.acked = acked

    def _take_peer(self, peer, control):
        body = control.WhichOneof("body")
        if body == "subscribe_ack":
            peer.is_subscribed, peer.in_step_s, peer.acked = True, time.monotonic(), None  # acknowledge at once
            for reading in control.subscribe_ack.starts:
                peer.accounts.setdefault(reading.topic, [reading.start, 0, 0])
            if EVENT_TOPIC in peer.accounts:  # what the writer does not keep any more is lost
                peer.accounts[EVENT_TOPIC][2] += max(0, control.subscribe_ack.next_event - 1 - peer.place())
        elif body == "state_snapshot" and peer.is_subscribed:
            self._take_snapshot(peer, control.state_snapshot)
        elif body == "state_delta" and control.state_delta.version > peer.state_version:
            account = peer.accounts.get(hash32(control.state_delta.topic))
            if account and control.state_delta.version == peer.state_version + 1:
                peer.state_version += 1
                account[1] += 1
                self._take_state(peer, control.state_delta)
            else:  # a gap: a new snapshot repairs it
                peer.is_subscribed, peer.subscribed_s = False, 0.0
        elif body == "event" and EVENT_TOPIC in peer.accounts and control.event.sequence > peer.place():
            self._take_event(peer, control.event)
        elif body == "eviction":  # was too slow for the writer; subscribes again after RESUBSCRIBE_AFTER_S
            peer.is_subscribed, peer.subscribed_s = False, time.monotonic()
        elif body == "parameter_reply":
            self._replies[control.parameter_reply.request] = control.parameter_reply

    def _take_snapshot(self, peer, snapshot):
        if peer.has_snapshot and snapshot.version < peer.state_version:
            return
        for entry in sorted(snapshot.entries, key=lambda one: one.version):
            if not peer.has_snapshot or entry.version > peer.state_version:
                self._take_state(peer, entry)
        peer.has_snapshot, peer.state_version = True, snapshot.version
        for count in snapshot.counts:  # changes that newer ones have overtaken
            if account := peer.accounts.get(count.topic):
                account[2] += max(0, count.count - sum(account))

    def _take_event(self, peer, item):
        now = time.monotonic()
        if item.sequence == peer.place() + 1:
            peer.accounts[EVENT_TOPIC][1] += 1
            if self._wants("event"):
                self._inbox.append(Message("event", peer.record.name, item.sequence, item.event))
        elif now - peer.repaired_s > BETWEEN_REPAIRS_S:
            peer.repaired_s = now
            self._acknowledge(peer, True)

    def _decode(self, topic, payload):
        """The message, or None if the bytes are not of the topic's type; `refused` counts those."""
        try:
            return TYPES[rule_of(topic)["type"]].FromString(payload)
        except Exception:  # DecodeError moves between versions of protobuf
            self.refused += 1
            return None

    def _take_state(self, peer, entry):
        if self._wants(entry.topic) and (body := self._decode(entry.topic, entry.value)) is not None:
            self._inbox.append(Message(entry.topic, peer.record.name, entry.version, body, entry.key))

    def _take_data(self, data):
        found = read_envelope(data, self._keys and self._unseal)
        if not found or found[0].session != self.session or found[0].topic_class != LATEST:
            self.refused += 1
            return
        envelope, payload = found
        topic, writer, digest = self.topics.get(envelope.topic, (None, None, None))
        if topic is None or not self._wants(topic):
            return
        # The digest may also be that of the writer's schema, which the registry found compatible with this client's.
        if envelope.digest != digest and envelope.digest != digest_of(topic):
            self.refused += 1
            return
        age = (envelope.boot, envelope.sequence)
        partial_age, num_parts, parts = self._partial.get(topic, ((0, 0), 0, {}))
        if age <= self._newest.get(topic, (0, 0)) or age < partial_age:
            return  # overtaken by a newer one, or a repetition
        if age > partial_age:
            num_parts, parts = envelope.parts, {}
        if envelope.parts != num_parts:
            self.refused += 1
            return
        if (body := self._decode(topic, payload)) is None:
            return
        parts[envelope.part] = body
        self._partial[topic] = age, num_parts, parts
        if len(parts) == num_parts:
            newest = self._newest.get(topic, age)
            if newest[0] == envelope.boot:
                self.dropped[topic] += max(0, envelope.sequence - newest[1] - 1)
            self.received[topic] += 1
            self._newest[topic] = age
            body = merge_parts([parts[i] for i in range(num_parts)])
            del self._partial[topic]
            self._inbox.append(Message(topic, writer, envelope.sequence, body, "", envelope.publish_ns))
