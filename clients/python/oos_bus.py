"""A node of the VR-OOS bus in Python, on Debian's python3-zmq, -protobuf, -xxhash and -cryptography.

The protocol is docs/reference/bus_protocol.md. One thread does everything: call poll() at least every 0.1 s, for it
also sends heartbeats; a node that is silent for 0.35 s is dead to the others.
"""

import collections
import dataclasses
import functools
import json
import os
import pathlib
import secrets
import socket
import time

import zmq
import zmq.utils.z85

from oos_envelope import (CONTROL, EVENT, LATEST, MAX_DATAGRAM_BYTES, SERVICE, STATE, Envelope, Keys, Opener, Sealer,
                          hash32, read_envelope, sender_key)
from oos_topics import TYPES, canonical, matches, merge_parts, rule_of
from proto import bus_pb2, logic_pb2  # oos_topics knows where it is

PROTOCOL_VERSION = 1
HEARTBEAT_S, HELLO_S, EAGER_HELLO_S, DEAD_AFTER_S, ASK_AGAIN_S = 0.05, 0.5, 0.1, 0.35, 0.3
BEHIND_TOO_LONG_S, BETWEEN_REPAIRS_S = 0.2, 0.05
EVENT_CREDIT, EVENTS_KEPT = 1024, 4096
MAX_TOPICS_TOLD = 30  # keeps a heartbeat within one datagram
EVENT_TOPIC = hash32("event")


@functools.cache
def machine_id():
    """Nodes of one machine share a clock."""
    return os.environ.get("OOS_MACHINE_ID") or pathlib.Path("/proc/sys/kernel/random/boot_id").read_text().strip()


def running_session():
    """(registry, session, key directory) of the `oos run` of this user on this machine."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    folder = os.path.join(runtime, "vr_oos") if runtime else f"/tmp/vr_oos-{os.getuid()}"
    note = json.loads(pathlib.Path(folder, "session.json").read_text())
    return note["registry"], int(note["session"]), note.get("keys") or None


@dataclasses.dataclass
class Message:
    topic: str
    writer: str
    sequence: int
    body: object  # protobuf message
    key: str = ""  # of a STATE value
    publish_ns: int = 0  # of a LATEST message, on the writer's clock


class Refused(Exception):
    """The registry, or the owner of a parameter, said no; the text says why."""


class _Peer:
    def __init__(self, record, dealer, opener):
        self.record, self.dealer, self.opener, self.node = record, dealer, opener, hash32(record.name)
        self.data, self.heartbeat = (
            (host, int(port)) for host, port in (e.rsplit(":", 1) for e in (record.data_endpoint,
                                                                            record.heartbeat_endpoint)))
        self.is_alive = self.is_subscribed = self.has_snapshot = False
        self.heard_s = self.asked_s = self.repaired_s = self.in_step_s = 0.0
        self.accounts = {}  # topic id -> [count before the first that was meant for us, received, dropped]
        self.state_version = self.told_version = self.told_events = 0
        self.acked = (0, 0)

    def place(self):
        """The last event that is settled: received, or given up."""
        return sum(self.accounts.get(EVENT_TOPIC, (0,)))

    def readings(self):
        return [bus_pb2.Reading(topic=topic, start=start, received=received, dropped=dropped)
                for topic, (start, received, dropped) in self.accounts.items()]


@dataclasses.dataclass
class _Reader:
    """Somebody who reads this node's events."""
    start: int
    instance: int
    sent: int = 0
    acked: int = 0


class Node:
    """subscribe() and advertise() first, then start(), then poll() in a loop. Keys: the run's key directory; None is to
    say that nothing is encrypted. With keys, the name is that of a key, or begins with it and a '-': "client-1"."""

    def __init__(self, name, registry, session, keys, bind="127.0.0.1", is_observer=True):
        self.name, self.session, self.is_observer = name, session, is_observer
        self.instance, self.boot = secrets.randbits(64), time.time_ns()
        self.topics, self.readers, self.refused = {}, {}, 0
        self.sent, self.received, self.dropped = (collections.Counter() for _ in range(3))  # LATEST, by topic
        self._events, self._num_events = collections.deque(maxlen=EVENTS_KEPT), 0
        self._patterns, self._read, self._written, self._sequences = [], set(), {}, {}
        self._peers, self._gone, self._inbox, self._partial, self._newest = {}, set(), [], {}, {}
        self._roster, self._is_welcomed, self._refusal = 0, False, None
        self._polls = self._next_request = 0
        self._replies = {}
        self._next_heartbeat = self._next_hello = 0.0
        self._keys = Keys(keys, name) if keys else None
        self._session_key = self._sealer = None
        self._zmq = zmq.Context()
        self._data, self._beats = (self._udp(bind) for _ in range(2))
        self._router = self._socket(zmq.ROUTER, zmq.ROUTER_MANDATORY, zmq.ROUTER_HANDOVER)
        self._poller = zmq.Poller()
        if self._keys:
            self._router.curve_server, self._router.curve_secretkey = True, self._keys.secret
            self._router.zap_domain = b"bus"
            self._allow_list = self._socket(zmq.REP)
            self._allow_list.bind("inproc://zeromq.zap.01")
            self._poller.register(self._allow_list, zmq.POLLIN)
        self._router.bind(f"tcp://{bind}:*")
        self._registry = self._dealer(registry, self._keys and self._keys.registry)
        for each in (self._data, self._beats, self._router, self._registry):
            self._poller.register(each, zmq.POLLIN)

    @staticmethod
    def _udp(bind):
        udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        udp.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        udp.bind((bind, 0))
        udp.setblocking(False)
        return udp

    def _socket(self, kind, *switches):
        made = self._zmq.socket(kind)
        made.linger, made.maxmsgsize = 100, 16 << 20
        for switch in switches:
            made.setsockopt(switch, 1)
        return made

    def _dealer(self, endpoint, server_key):
        dealer = self._socket(zmq.DEALER, zmq.IMMEDIATE)
        if self._keys:
            dealer.curve_serverkey = server_key
            dealer.curve_publickey, dealer.curve_secretkey = self._keys.public, self._keys.secret
        dealer.routing_id = f"{self.name}#{self.instance}".encode()
        dealer.reconnect_ivl, dealer.reconnect_ivl_max = 20, 200
        dealer.connect(endpoint)
        return dealer

    # --- What a node reads and writes; before start().

    def subscribe(self, topic):
        """LATEST, STATE or "event"; with a '*' in it, whatever matches."""
        if "*" in topic:
            self._patterns.append(topic)
        else:
            rule_of(topic)
            self._read.add(topic)

    def advertise(self, topic):
        """A LATEST topic for publish()."""
        if rule_of(topic)["class"] != LATEST:
            raise ValueError(f"topic '{topic}' is not LATEST")
        self._written[hash32(topic)] = topic
        self._sequences[topic] = 0

    def start(self, timeout_s=30.0):
        end = time.monotonic() + timeout_s
        while not self._is_welcomed:
            self._run_once(0.01)
            if self._refusal is not None:
                raise Refused(self._refusal)
            if time.monotonic() > end:
                raise TimeoutError(f"no answer from the registry in {timeout_s} s; is `oos run` still there?")

    # --- Running.

    def poll(self, timeout_s=0.05):
        """The messages that have arrived; waits for the first of them."""
        end = time.monotonic() + timeout_s
        self._polls += 1
        if self._refusal is not None:  # another has taken this node's place
            raise Refused(self._refusal)
        while True:
            self._run_once(max(0.0, end - time.monotonic()) if not self._inbox else 0.0)
            if self._inbox or time.monotonic() >= end:
                taken, self._inbox = self._inbox, []
                return taken

    def alive(self):
        return {name for name, peer in self._peers.items() if peer.is_alive}

    def publish(self, topic, body):
        """Sends a LATEST message to everybody who reads it; returns how many. It has to fit into one datagram."""
        self._sequences[topic] += 1
        envelope = Envelope(LATEST, hash32(topic), hash32(canonical(body.DESCRIPTOR)), self.session, hash32(self.name),
                            self.boot, self._sequences[topic], time.monotonic_ns())
        data = envelope.write(body.SerializeToString(), self._sealer)
        if len(data) > MAX_DATAGRAM_BYTES:
            raise ValueError(f"{topic}: {len(data)} bytes do not fit into one datagram")
        readers = [peer for peer in self._peers.values() if peer.is_alive and (
            any(t.name == topic and not t.is_written for t in peer.record.topics) or
            any(matches(pattern, topic) for pattern in peer.record.observed_patterns))]
        for peer in readers:
            self._data.sendto(data, peer.data)
        self.sent[topic] += len(readers)
        return len(readers)

    def emit(self, name, detail=""):
        """Sends an event to all readers of events. The last 4096 are kept for a reader that lost some."""
        event = logic_pb2.Event(time_ns=time.monotonic_ns(), source=self.name, name=name, detail=detail)
        self._num_events += 1
        self._events.append(bus_pb2.EventItem(sequence=self._num_events, event=event))
        for routing, reader in self.readers.items():
            self._pump(routing, reader)

    def set_parameter(self, owner, name, value, manner=0, ramp_s=0.0, timeout_s=1.0):
        """The owner's bus_pb2.ParameterReply, or Refused. Messages that arrive meanwhile stay for poll()."""
        self._next_request += 1
        change = logic_pb2.ParameterChange(name=name, value=value, manner=manner, ramp_s=ramp_s)
        request = bus_pb2.ParameterRequest(request=self._next_request, caller=self.name, change=change,
                                           caller_instance=self.instance, time_left_ns=int(1e9 * timeout_s))
        end, is_sent = time.monotonic() + timeout_s, False
        while request.request not in self._replies:
            peer = self._peers.get(owner)
            if not is_sent and peer and peer.is_alive:
                is_sent = self._send(peer.dealer, bus_pb2.Control(parameter_request=request))
            if time.monotonic() > end:
                raise TimeoutError(f"{owner} " + ("did not answer in time" if is_sent else "is not there"))
            self._run_once(0.005)
        reply = self._replies.pop(request.request)
        if not reply.is_accepted:
            raise Refused(reply.why)
        return reply

    def close(self):
        """Says goodbye, so that nobody takes the end for a death."""
        self._send_heartbeats(True)
        self._hello(True)
        self._zmq.destroy()
        self._data.close()
        self._beats.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    # --- The protocol.

    def _run_once(self, timeout_s):
        now = time.monotonic()
        due = max(0.0, min(self._next_heartbeat, self._next_hello) - now)
        self._poller.poll(1000 * min(timeout_s, due))
        if self._keys:
            self._answer_who_may_come_in()
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
            self._ask(peer, now)

    def _answer_who_may_come_in(self):
        while self._allow_list.getsockopt(zmq.EVENTS) & zmq.POLLIN:
            version, request, _, _, _, mechanism, key = self._allow_list.recv_multipart()
            owner = self._keys.allowed.get(zmq.utils.z85.encode(key)) if mechanism == b"CURVE" else None
            self._allow_list.send_multipart([version, request, b"200" if owner else b"400", b"",
                                             (owner or "").encode(), b""])

    def _unseal(self, envelope, clear, body):
        for peer in self._peers.values():
            if peer.node == envelope.node and peer.opener:  # with the key of its present life
                return peer.opener(envelope.topic_class, clear, body)
        return None

    @staticmethod
    def _receive_udp(udp):
        try:
            return udp.recv(65536)
        except BlockingIOError:
            return None

    def _open(self, data, unseal=None):
        """The Control of a sound envelope of this session, else None, counted."""
        found = read_envelope(data, unseal)
        if found and found[0].session == self.session and found[0].topic_class != LATEST:
            try:
                return bus_pb2.Control.FromString(found[1])
            except Exception:  # DecodeError moves between versions of protobuf
                pass
        self.refused += 1
        return None

    def _take_from(self, dealer, take):
        while dealer.getsockopt(zmq.EVENTS) & zmq.POLLIN:
            control = self._open(dealer.recv_multipart()[-1])
            if control:
                take(control)

    def _wrap(self, control, sealer=None):
        body = control.WhichOneof("body")
        topic_class = (STATE if body.startswith("sub") or body.startswith("state") else
                       EVENT if body.startswith("ev") else SERVICE if body.startswith("parameter") else CONTROL)
        return Envelope(topic_class, digest=PROTOCOL_VERSION, session=self.session, node=hash32(self.name),
                        boot=self.boot, publish_ns=time.monotonic_ns()).write(control.SerializeToString(), sealer)

    def _send(self, dealer, control):
        try:
            dealer.send(self._wrap(control), zmq.DONTWAIT)
            return True
        except zmq.ZMQError:  # not connected yet, or gone
            return False

    def _reply(self, routing, control):
        try:
            self._router.send_multipart([routing, self._wrap(control)], zmq.DONTWAIT)
            return True
        except zmq.ZMQError:
            return False

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
        if known:
            self._forget(known)
        dealer = self._dealer(record.router_endpoint, record.public_key.encode())
        self._poller.register(dealer, zmq.POLLIN)
        opener = Opener(sender_key(self._session_key, record.instance)) if self._session_key else None
        self._peers[record.name] = _Peer(record, dealer, opener)
        for topic in record.topics:
            if topic.is_written:
                self.topics[hash32(topic.name)] = (topic.name, record.name)
        self._next_heartbeat = 0.0  # be heard by it at once

    def _fence_off(self, instance):
        """Another has taken its place: nothing of it counts any more."""
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
            return  # nobody could read them
        figures = [bus_pb2.TopicFigures(topic=hash32(topic), is_written=topic in self._sequences,
                                        sent=self.sent[topic], received=self.received[topic],
                                        dropped=self.dropped[topic])
                   for topic in (*self._sequences, *self.received)]
        beat = self._wrap(bus_pb2.Control(heartbeat=bus_pb2.Heartbeat(
            name=self.name, instance=self.instance, wait_count=self._polls, refused=self.refused,
            is_goodbye=is_goodbye, sent_ns=time.monotonic_ns(), topics=figures[:MAX_TOPICS_TOLD],
            sent=self.sent.total(), received=self.received.total(), dropped=self.dropped.total(),
            counts=[bus_pb2.TopicCount(topic=EVENT_TOPIC, count=self._num_events)])), self._sealer)
        for peer in self._peers.values():
            self._beats.sendto(beat, peer.heartbeat)

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
            peer.told_version = control.heartbeat.state_version
            peer.told_events = max((c.count for c in control.heartbeat.counts if c.topic == EVENT_TOPIC), default=0)

    def _answer_clock(self, peer, sent_ns):
        """What a node on another machine needs to compare the clocks."""
        now_ns = time.monotonic_ns()
        self._beats.sendto(self._wrap(bus_pb2.Control(clock_echo=bus_pb2.ClockEcho(
            name=self.name, instance=self.instance, heartbeat_sent_ns=sent_ns, received_ns=now_ns,
            answered_ns=now_ns)), self._sealer), peer.heartbeat)

    def _wants(self, topic):
        return topic in self._read or any(matches(pattern, topic) for pattern in self._patterns)

    def _ask(self, peer, now):
        """Subscribes, and once more when changes or events that the peer tells of have not come for a while."""
        wants_state = any(t.is_written and t.topic_class == STATE and self._wants(t.name) for t in peer.record.topics)
        wants_events = self._wants("event")
        if not peer.is_alive or not (wants_state or wants_events):
            return
        if peer.told_version <= peer.state_version and peer.told_events <= peer.place():
            peer.in_step_s = now
        elif now - peer.in_step_s > BEHIND_TOO_LONG_S:
            peer.is_subscribed = False
        if peer.is_subscribed or now - peer.asked_s < ASK_AGAIN_S:
            return
        if self._send(peer.dealer, bus_pb2.Control(subscribe=bus_pb2.Subscribe(
                name=self.name, instance=self.instance, wants_state=wants_state, wants_events=wants_events,
                readings=peer.readings()))):
            peer.asked_s = now

    def _acknowledge(self, peer, resend):
        acked = (peer.place(), peer.state_version)
        if self._send(peer.dealer, bus_pb2.Control(event_ack=bus_pb2.EventAck(
                sequence=acked[0], resend=resend, state_version=acked[1], instance=self.instance,
                readings=peer.readings()))):
            peer.acked = acked

    def _take_peer(self, peer, control):
        body = control.WhichOneof("body")
        if body == "subscribe_ack":
            peer.is_subscribed, peer.in_step_s = True, time.monotonic()
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
                peer.is_subscribed, peer.asked_s = False, 0.0
        elif body == "event" and EVENT_TOPIC in peer.accounts and control.event.sequence > peer.place():
            self._take_event(peer, control.event)
        elif body == "eviction":  # too slow for the writer; asks again after a while
            peer.is_subscribed, peer.asked_s = False, time.monotonic()
        elif body == "parameter_reply":
            self._replies[control.parameter_reply.request] = control.parameter_reply

    def _take_snapshot(self, peer, snapshot):
        if peer.has_snapshot and snapshot.version < peer.state_version:
            return
        for entry in snapshot.entries:
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

    def _take_state(self, peer, entry):
        if self._wants(entry.topic):
            body = TYPES[rule_of(entry.topic)["type"]].FromString(entry.value)
            self._inbox.append(Message(entry.topic, peer.record.name, entry.version, body, entry.key))

    @staticmethod
    def _is_key_of(key_name, routing):
        """A routing id, "<name>#<instance>", is the sender's own word; its key is not."""
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
        """Goes on after event `place`, or with the oldest that is kept."""
        reader.sent = reader.acked = max(self._num_events - len(self._events), min(place, self._num_events))
        self._reply(routing, bus_pb2.Control(subscribe_ack=bus_pb2.SubscribeAck(
            instance=self.instance, next_event=reader.sent + 1,
            starts=[bus_pb2.Reading(topic=EVENT_TOPIC, start=reader.start)])))
        self._pump(routing, reader)

    def _pump(self, routing, reader):
        oldest = self._num_events - len(self._events) + 1
        if reader.sent + 1 < oldest:  # nobody waited for it
            self._rewind(routing, reader, reader.sent)
            return
        while reader.sent < self._num_events and reader.sent < reader.acked + EVENT_CREDIT and \
                self._reply(routing, bus_pb2.Control(event=self._events[reader.sent + 1 - oldest])):
            reader.sent += 1

    def _take_data(self, data):
        found = read_envelope(data, self._keys and self._unseal)
        if not found or found[0].session != self.session or found[0].topic_class != LATEST:
            self.refused += 1
            return
        envelope, payload = found
        topic, writer = self.topics.get(envelope.topic, (None, None))
        age = (envelope.boot, envelope.sequence)
        if topic is None or not self._wants(topic) or age <= self._newest.get(topic, (0, 0)):
            return  # overtaken by a newer one, or a repetition
        parts = self._partial.setdefault(topic, {})
        if parts.get("age", age) > age:
            return
        if parts.get("age") != age:
            parts.clear()
            parts["age"] = age
        parts[envelope.part] = TYPES[rule_of(topic)["type"]].FromString(payload)
        if len(parts) == envelope.parts + 1:
            newest = self._newest.get(topic, age)
            if newest[0] == envelope.boot:
                self.dropped[topic] += max(0, envelope.sequence - newest[1] - 1)
            self.received[topic] += 1
            self._newest[topic] = age
            body = merge_parts([parts[i] for i in range(envelope.parts)])
            del self._partial[topic]
            self._inbox.append(Message(topic, writer, envelope.sequence, body, "", envelope.publish_ns))
