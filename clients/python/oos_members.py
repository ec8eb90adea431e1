"""Who this node is and who the others are: registry, roster, heartbeats."""

import os
import time

import zmq

from oos_envelope import LATEST, STATE, Opener, Sealer, hash32, sender_key
from oos_links import PROTOCOL_VERSION, Links, machine_id, udp_address
from oos_topics import TYPES, canonical, rule_of
from proto import bus_pb2

MAX_TOPICS_IN_HEARTBEAT = 30  # keeps a heartbeat within one datagram
EVENT_TOPIC = hash32("event")


class Peer:
    def __init__(self, record, opener):
        self.record, self.opener, self.node = record, opener, hash32(record.name)
        self.data, self.heartbeat = udp_address(record.data_endpoint), udp_address(record.heartbeat_endpoint)
        self.is_alive = self.is_subscribed = self.has_snapshot = False
        self.heard_s = self.subscribed_s = self.repaired_s = self.in_step_s = 0.0
        self.accounts = {}  # topic id -> [count before the first that was meant for us, received, dropped]
        self.state_version = self.announced_version = self.announced_events = 0
        self.acked = (0, 0)

    def place(self):
        """Sequence number of the last event that is settled: received, or counted as lost."""
        return sum(self.accounts.get(EVENT_TOPIC, (0,)))

    def readings(self):
        return [bus_pb2.Reading(topic=topic, start=start, received=received, dropped=dropped)
                for topic, (start, received, dropped) in self.accounts.items()]


class Members(Links):
    def __init__(self, name, registry, session, keys, bind, is_observer):
        super().__init__(name, registry, session, keys, bind)
        self.is_observer, self.topics = is_observer, {}  # topics: id -> name, writer, its schema digest
        self._peers, self._gone = {}, set()
        self._roster, self._is_welcomed, self._refusal, self._session_key = 0, False, None, None
        self._next_heartbeat = self._next_hello = 0.0
        self._polls = 0

    def _record(self):
        record = bus_pb2.NodeRecord(
            name=self.name, instance=self.instance, boot=self.boot, session=self.session,
            protocol_version=PROTOCOL_VERSION, process_id=os.getpid(), is_observer=self.is_observer,
            machine_id=machine_id(),
            data_endpoint="%s:%d" % self._data.getsockname(), heartbeat_endpoint="%s:%d" % self._beats.getsockname(),
            router_endpoint=self._router.last_endpoint.decode().rstrip("\0"), observed_patterns=self._patterns,
            reads_events="event" in self._read)
        schemas = {}
        for topic, is_written in [(t, False) for t in self._read] + [(t, True) for t in self._written.values()]:
            rule = rule_of(topic)
            if rule["class"] not in (LATEST, STATE):
                continue
            shape = canonical(TYPES[rule["type"]].DESCRIPTOR)
            schemas[hash32(shape)] = shape
            record.topics.add(name=topic, topic_class=rule["class"], message_type=rule["message_type"],
                              schema_digest=hash32(shape), is_written=is_written)
        for digest, shape in schemas.items():
            record.schemas.add(digest=digest, canonical=shape)
        return record

    def _hello(self, is_goodbye):
        self._send(self._registry, bus_pb2.Control(hello=bus_pb2.Hello(
            node=self._record(), known_roster=self._roster, is_goodbye=is_goodbye, is_member=self._is_welcomed)))

    def _take_registry(self, control):
        if control.HasField("refusal") and (control.refusal.is_fenced or not self._is_welcomed):
            self._refusal = control.refusal.why
        elif control.HasField("roster"):
            if not self._is_welcomed:
                self.boot = control.roster.boot or self.boot
            self._is_welcomed = True
            for instance in control.roster.fenced:
                self._fence_off(instance)
            if self._keys and not self._sealer:
                self._session_key = control.roster.session_key
                self._sealer = Sealer(sender_key(self._session_key, self.instance))
            if not control.roster.is_unchanged:
                self._roster = control.roster.version
                for record in control.roster.nodes:
                    self._add(record)

    def _add(self, record):
        known = self._peers.get(record.name)
        if (record.name == self.name or record.instance in self._gone or
                known and (known.record.instance == record.instance or record.boot <= known.record.boot)):
            return
        opener = Opener(sender_key(self._session_key, record.instance)) if self._session_key else None
        try:
            peer = Peer(record, opener)
            peer.dealer = self._dealer(record.router_endpoint, record.public_key.encode())
        except (ValueError, zmq.ZMQError):  # no addresses
            self.refused += 1
            return
        if known:
            self._forget(known)
        self._poller.register(peer.dealer, zmq.POLLIN)
        self._peers[record.name] = peer
        for topic in record.topics:
            if topic.is_written:
                self.topics[hash32(topic.name)] = (topic.name, record.name, topic.schema_digest)
        self._next_heartbeat = 0.0  # so that it knows of this node at once

    def _fence_off(self, instance):
        """Ignores that instance from now on: another node has taken its name."""
        self._gone.add(instance)
        for peer in [peer for peer in self._peers.values() if peer.record.instance == instance]:
            self._forget(peer)

    def _forget(self, peer):
        self._poller.unregister(peer.dealer)
        peer.dealer.close()
        del self._peers[peer.record.name]
        self.readers = {r: reader for r, reader in self.readers.items() if reader.instance != peer.record.instance}

    def _send_heartbeats(self, is_goodbye):
        if self._keys and not self._sealer:
            return  # no peer could read them
        figures = [bus_pb2.TopicFigures(topic=hash32(topic), is_written=topic in self._sequences,
                                        sent=self.sent[topic], received=self.received[topic],
                                        dropped=self.dropped[topic])
                   for topic in (*self._sequences, *self.received)]
        beat = self._wrap(bus_pb2.Control(heartbeat=bus_pb2.Heartbeat(
            name=self.name, instance=self.instance, wait_count=self._polls, refused=self.refused,
            is_goodbye=is_goodbye, sent_ns=time.monotonic_ns(), topics=figures[:MAX_TOPICS_IN_HEARTBEAT],
            sent=self.sent.total(), received=self.received.total(), dropped=self.dropped.total(),
            counts=[bus_pb2.TopicCount(topic=EVENT_TOPIC, count=self._num_events)])), self._sealer)
        for peer in self._peers.values():
            self._send_udp(self._beats, beat, peer.heartbeat)

    def _take_heartbeat(self, data):
        control = self._open(data, self._keys and self._unseal)
        if not control or not control.HasField("heartbeat") or control.heartbeat.instance in self._gone:
            return
        peer = self._peers.get(control.heartbeat.name)
        if not peer or peer.record.instance != control.heartbeat.instance:
            self._roster, self._next_hello = 0, min(self._next_hello, time.monotonic() + 0.02)  # ask who that is
            return
        if control.heartbeat.is_goodbye:
            self._gone.add(control.heartbeat.instance)
            self._forget(peer)
        else:
            peer.is_alive, peer.heard_s = True, time.monotonic()
            if peer.record.machine_id not in ("", machine_id()):
                self._answer_clock(peer, control.heartbeat.sent_ns)
            peer.announced_version = control.heartbeat.state_version
            peer.announced_events = max((c.count for c in control.heartbeat.counts if c.topic == EVENT_TOPIC), default=0)

    def _answer_clock(self, peer, sent_ns):
        """Answers a heartbeat from another machine with the times that comparing the clocks needs."""
        now_ns = time.monotonic_ns()
        self._send_udp(self._beats, self._wrap(bus_pb2.Control(clock_echo=bus_pb2.ClockEcho(
            name=self.name, instance=self.instance, heartbeat_sent_ns=sent_ns, received_ns=now_ns,
            answered_ns=now_ns)), self._sealer), peer.heartbeat)

    def _unseal(self, envelope, clear, body):
        for peer in self._peers.values():
            if peer.node == envelope.node and peer.opener:  # with the key of its present life
                return peer.opener(envelope.topic_class, clear, body)
        return None
