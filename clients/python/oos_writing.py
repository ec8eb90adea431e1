"""Sending to peers: LATEST and events (a client owns no STATE and no parameters), and one turn of the node's loop."""

import collections
import dataclasses
import time

import zmq

from oos_members import EVENT_TOPIC
from oos_reading import Reading
from oos_topics import matches
from proto import bus_pb2

EVENT_CREDIT, EVENTS_KEPT = 1024, 4096
HEARTBEAT_S, HELLO_S, EAGER_HELLO_S, DEAD_AFTER_S = 0.05, 0.5, 0.1, 0.35


@dataclasses.dataclass
class _Reader:
    """A peer that reads this node's events."""
    start: int
    instance: int
    sent: int = 0
    acked: int = 0


class Writing(Reading):
    def __init__(self, *identity):
        super().__init__(*identity)
        self.readers, self.sent = {}, collections.Counter()  # sent: LATEST, by topic
        self._written, self._sequences = {}, {}
        self._events, self._num_events = collections.deque(maxlen=EVENTS_KEPT), 0

    def _send_to_readers(self, topic, data):
        readers = [peer for peer in self._peers.values() if peer.is_alive and (
            any(t.name == topic and not t.is_written for t in peer.record.topics) or
            any(matches(pattern, topic) for pattern in peer.record.observed_patterns))]
        num_sent = sum(self._send_udp(self._data, data, peer.data) for peer in readers)
        self.sent[topic] += num_sent
        self.dropped[topic] += len(readers) - num_sent
        return num_sent

    def _append(self, event):
        self._num_events += 1
        self._events.append(bus_pb2.EventItem(sequence=self._num_events, event=event))
        for routing, reader in self.readers.items():
            self._pump(routing, reader)

    @staticmethod
    def _is_key_of(key_name, routing):
        """Whether a key of that name allows the name in a routing id, "<name>#<instance>": the sender chose the id itself."""
        return f"{routing.rpartition(b'#')[0].decode(errors='replace')}-".startswith(f"{key_name}-")

    def _take_router(self):
        while self._router.getsockopt(zmq.EVENTS) & zmq.POLLIN:
            routing, *_, data = self._router.recv_multipart(copy=False)
            routing, control = routing.bytes, self._open(data.bytes)
            if not control or self._keys and not self._is_key_of(data.get("User-Id"), routing):
                continue
            if control.HasField("subscribe"):
                self._take_subscribe(routing, control.subscribe)
            elif control.HasField("event_ack"):
                self._take_ack(routing, control.event_ack)
            elif control.HasField("parameter_request"):
                self._reply(routing, bus_pb2.Control(parameter_reply=bus_pb2.ParameterReply(
                    request=control.parameter_request.request, why=f"{self.name} owns no parameters")))

    def _take_subscribe(self, routing, subscribe):
        start = place = self._num_events
        for reading in subscribe.readings:
            if reading.topic == EVENT_TOPIC:  # goes on
                start, place = reading.start, reading.start + reading.received + reading.dropped
        reader = _Reader(start, subscribe.instance)
        if subscribe.wants_events:
            self.readers[routing] = reader
        self._rewind(routing, reader, place)

    def _take_ack(self, routing, ack):
        if routing not in self.readers:
            self._reply(routing, bus_pb2.Control(eviction=bus_pb2.Eviction(why="not subscribed")))
            return
        reader = self.readers[routing]
        reader.acked = max(reader.acked, min(ack.sequence, reader.sent))
        if ack.resend:
            self._rewind(routing, reader, ack.sequence)
        self._pump(routing, reader)

    def _rewind(self, routing, reader, place):
        """Sends again from the event after `place`, or from the oldest that is kept."""
        reader.sent = reader.acked = max(self._num_events - len(self._events), min(place, self._num_events))
        self._reply(routing, bus_pb2.Control(subscribe_ack=bus_pb2.SubscribeAck(
            instance=self.instance, next_event=reader.sent + 1,
            starts=[bus_pb2.Reading(topic=EVENT_TOPIC, start=reader.start)])))
        self._pump(routing, reader)

    def _pump(self, routing, reader):
        oldest = self._num_events - len(self._events) + 1
        if reader.sent + 1 < oldest:  # it is too far behind: the events between are no longer kept
            self._rewind(routing, reader, reader.sent)
            return
        while reader.sent < self._num_events and reader.sent < reader.acked + EVENT_CREDIT and \
                self._reply(routing, bus_pb2.Control(event=self._events[reader.sent + 1 - oldest])):
            reader.sent += 1

    def _run_once(self, timeout_s):
        now = time.monotonic()
        due = max(0.0, min(self._next_heartbeat, self._next_hello) - now)
        self._poller.poll(1000 * min(timeout_s, due))
        if self._keys:
            self._answer_authentication()
        for udp, take in ((self._data, self._take_data), (self._beats, self._take_heartbeat)):
            for data in iter(lambda: self._receive_udp(udp), None):
                take(data)
        self._take_from(self._registry, self._take_registry)
        for peer in list(self._peers.values()):
            self._take_from(peer.dealer, lambda control: self._take_peer(peer, control))
            if (peer.place(), peer.state_version) != peer.acked:
                self._acknowledge(peer, False)
        self._take_router()
        now = time.monotonic()
        if now >= self._next_hello:
            self._hello(False)
            self._next_hello = now + (HELLO_S if self._is_welcomed else EAGER_HELLO_S)
        if now >= self._next_heartbeat:
            self._send_heartbeats(False)
            self._next_heartbeat = now + HEARTBEAT_S
        for peer in self._peers.values():
            if peer.is_alive and now - peer.heard_s > DEAD_AFTER_S:
                peer.is_alive = peer.is_subscribed = False
            self._subscribe_if_due(peer, now)
