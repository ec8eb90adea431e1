"""A node of the VR-OOS bus in Python, on Debian's python3-zmq, python3-protobuf and python3-xxhash.

The protocol is docs/reference/bus_protocol.md. One thread does everything: call poll() at least every 0.1 s, for it also
sends heartbeats; a node that is silent for 0.35 s is dead to the others. The package `proto` is what protoc makes of the
repository's proto/: on PYTHONPATH, or where `./dev build` leaves it.
"""

import dataclasses
import json
import os
import pathlib
import secrets
import socket
import struct
import sys
import time
import zlib

import xxhash
import zmq
from google.protobuf import descriptor

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "build/release/clients/stubs"))
from proto import bus_pb2, device_pb2, haptic_pb2, logic_pb2, physics_pb2  # noqa: E402

LATEST, STATE, EVENT, SERVICE, CONTROL = range(1, 6)
PROTOCOL_VERSION = 1
TOPICS = json.loads((ROOT / "clients/topics.json").read_text())["rules"]
TYPES = {m.DESCRIPTOR.full_name: m for module in (device_pb2, haptic_pb2, logic_pb2, physics_pb2)
         for m in vars(module).values() if hasattr(m, "DESCRIPTOR") and hasattr(m, "FromString")}

HEARTBEAT_S, HELLO_S, EAGER_HELLO_S, DEAD_AFTER_S, ASK_AGAIN_S = 0.05, 0.5, 0.1, 0.35, 0.3
EVENT_CREDIT = 1024
MAX_DATAGRAM_BYTES = 1200
MAX_STAMPS = 16

# Magic, version, class, part, parts, topic, digest, session, node, stamps of two traces, flags, boot, sequence, publish
# time, payload bytes, CRC-32, and two traces' id and origin.
HEAD = struct.Struct("<IBBBBIIQIBBHQQqIIQqQq")
MAGIC, VERSION, CRC_AT = 0x534F4F56, 1, 60
SEALED_BIT, HISTORY_MASK, SEAL_BYTES = 0x8000, 0x07FF, 24


def hash32(text):
    """Topic ids, node ids and schema digests: the low half of xxHash3."""
    return xxhash.xxh3_64_intdigest(text) & 0xFFFFFFFF


@dataclasses.dataclass
class Envelope:
    topic_class: int
    topic: int = 0
    digest: int = 0
    session: int = 0
    node: int = 0
    boot: int = 0
    sequence: int = 0
    publish_ns: int = 0
    part: int = 0
    parts: int = 1
    stamps: bytes = b""  # of both traces, as on the wire
    num_stamps: tuple = (0, 0)
    traces: tuple = (0, 0, 0, 0)  # id and origin of each
    history: bytes = b""  # earlier samples, behind the payload

    def write(self, payload, seal=None):
        """`seal` encrypts what is behind the stamps: (topic_class, clear, body) -> bytes."""
        e = self
        flags = len(e.history) | (SEALED_BIT if seal else 0)
        head = HEAD.pack(MAGIC, VERSION, e.topic_class, e.part, e.parts, e.topic, e.digest, e.session, e.node,
                         *e.num_stamps, flags, e.boot, e.sequence, e.publish_ns, len(payload), 0, *e.traces) + e.stamps
        if seal:
            return head + seal(e.topic_class, head, payload + e.history)
        rest = head[CRC_AT + 4:] + payload + e.history
        return head[:CRC_AT] + struct.pack("<I", zlib.crc32(rest, zlib.crc32(head[:CRC_AT]))) + rest


def read_envelope(data, unseal=None):
    """(Envelope, payload), or None for whatever is no sound envelope. With `unseal` ((envelope, clear, body) -> bytes or
    None) only sealed ones are sound, without it only those in the clear."""
    if len(data) < HEAD.size:
        return None
    (magic, version, topic_class, part, parts, topic, digest, session, node, direct, other, flags, boot, sequence,
     publish_ns, payload_bytes, crc, *traces) = HEAD.unpack_from(data)
    start, history = HEAD.size + 5 * (direct + other), flags & HISTORY_MASK
    if (magic != MAGIC or version != VERSION or not LATEST <= topic_class <= CONTROL or part >= parts
            or max(direct, other) > MAX_STAMPS or flags & ~HISTORY_MASK != (SEALED_BIT if unseal else 0)
            or len(data) != start + payload_bytes + history + (SEAL_BYTES if unseal else 0)):
        return None
    envelope = Envelope(topic_class, topic, digest, session, node, boot, sequence, publish_ns, part, parts,
                        data[HEAD.size:start], (direct, other), tuple(traces))
    if unseal:
        body = unseal(envelope, data[:start], data[start:])
        if body is None:
            return None
    elif zlib.crc32(data[CRC_AT + 4:], zlib.crc32(data[:CRC_AT])) == crc:
        body = data[start:]
    else:
        return None
    envelope.history = body[payload_bytes:]
    return envelope, body[:payload_bytes]


def canonical(message):
    """The shape of a message type, whose hash is its schema digest: "1:uint64 6:repeated_uint32 7:{1:float}"."""
    kinds = {value: name[5:].lower() for name, value in vars(descriptor.FieldDescriptor).items()
             if name.startswith("TYPE_")}
    return " ".join(
        f"{field.number}:" + "repeated_" * (field.label == field.LABEL_REPEATED) +
        ("{" + canonical(field.message_type) + "}" if field.message_type else kinds[field.type])
        for field in sorted(message.fields, key=lambda field: field.number))


def matches(pattern, text):
    """'*' stands for any text, slashes included; every other character for itself."""
    first, *others = pattern.split("*")
    if not others:
        return text == pattern
    if not text.startswith(first) or len(text) < len(first) + len(others[-1]) or not text.endswith(others[-1]):
        return False
    at = len(first)
    for other in others[:-1]:
        at = text.find(other, at)
        if at < 0:
            return False
        at += len(other)
    return at <= len(text) - len(others[-1])


def rule_of(topic):
    """The first line of topics.json that matches."""
    for rule in TOPICS:
        if matches(rule["pattern"], topic):
            return rule
    raise ValueError(f"no rule in clients/topics.json matches topic '{topic}'")


def merge_parts(parts):
    """The message that was sent in parts: lists joined in order, the rest as in the first part."""
    whole = parts[0]
    for part in parts[1:]:
        for field, value in part.ListFields():
            if field.label == field.LABEL_REPEATED:
                getattr(whole, field.name).extend(value)
    return whole


def running_session():
    """(registry, session) of the `oos run` of this user on this machine."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    folder = os.path.join(runtime, "vr_oos") if runtime else f"/tmp/vr_oos-{os.getuid()}"
    note = json.loads(pathlib.Path(folder, "session.json").read_text())
    return note["registry"], int(note["session"])


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
    def __init__(self, record, dealer):
        self.record, self.dealer = record, dealer
        self.data, self.heartbeat = (
            (host, int(port)) for host, port in (e.rsplit(":", 1) for e in (record.data_endpoint,
                                                                            record.heartbeat_endpoint)))
        self.is_alive = self.has_left = self.is_subscribed = False
        self.heard_s = self.asked_s = 0.0
        self.state_version = self.next_event = self.acked_event = 0


class _Reader:
    """Somebody who reads this node's events."""
    def __init__(self):
        self.next_event, self.sent, self.acked = 1, 0, 0


class Node:
    """subscribe() and advertise() first, then start(), then poll() in a loop."""

    def __init__(self, name, registry, session, bind="127.0.0.1", is_observer=True):
        self.name, self.session, self.is_observer = name, session, is_observer
        self.instance, self.boot = secrets.randbits(64), time.time_ns()
        self.topics, self.readers, self.events_dropped, self.refused = {}, {}, 0, 0
        self._patterns, self._read, self._written, self._sequences = [], set(), {}, {}
        self._peers, self._gone, self._inbox, self._partial, self._newest = {}, set(), [], {}, {}
        self._roster, self._is_welcomed, self._refusal = 0, False, None
        self._polls = self._next_request = 0
        self._replies = {}
        self._next_heartbeat = self._next_hello = 0.0
        self._zmq = zmq.Context()
        self._data, self._beats = (self._udp(bind) for _ in range(2))
        self._router = self._socket(zmq.ROUTER, zmq.ROUTER_MANDATORY, zmq.ROUTER_HANDOVER)
        self._router.bind(f"tcp://{bind}:*")
        self._registry = self._dealer(registry)
        self._poller = zmq.Poller()
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

    def _dealer(self, endpoint):
        dealer = self._socket(zmq.DEALER, zmq.IMMEDIATE)
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
        data = Envelope(LATEST, hash32(topic), hash32(canonical(body.DESCRIPTOR)), self.session, hash32(self.name),
                        self.boot, self._sequences[topic], time.monotonic_ns()).write(body.SerializeToString())
        if len(data) > MAX_DATAGRAM_BYTES:
            raise ValueError(f"{topic}: {len(data)} bytes do not fit into one datagram")
        readers = [peer for peer in self._peers.values() if peer.is_alive and (
            any(t.name == topic and not t.is_written for t in peer.record.topics) or
            any(matches(pattern, topic) for pattern in peer.record.observed_patterns))]
        for peer in readers:
            self._data.sendto(data, peer.data)
        return len(readers)

    def emit(self, name, detail=""):
        """Sends an event to all readers of events. A reader that has 1024 unacknowledged misses it, counted."""
        event = logic_pb2.Event(time_ns=time.monotonic_ns(), source=self.name, name=name, detail=detail)
        for routing, reader in self.readers.items():
            item = bus_pb2.EventItem(sequence=reader.next_event, event=event)
            reader.next_event += 1  # a dropped event leaves a gap that the reader sees
            if reader.sent < reader.acked + EVENT_CREDIT and self._reply(routing, bus_pb2.Control(event=item)):
                reader.sent = item.sequence
            else:
                self.events_dropped += 1

    def set_parameter(self, owner, name, value, manner=0, ramp_s=0.0, timeout_s=1.0):
        """The owner's bus_pb2.ParameterReply, or Refused. Messages that arrive meanwhile stay for poll()."""
        self._next_request += 1
        change = logic_pb2.ParameterChange(name=name, value=value, manner=manner, ramp_s=ramp_s)
        request = bus_pb2.ParameterRequest(request=self._next_request, caller=self.name, change=change)
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
        for udp, take in ((self._data, self._take_data), (self._beats, self._take_heartbeat)):
            for data in iter(lambda: self._receive_udp(udp), None):
                take(data)
        self._take_from(self._registry, self._take_registry)
        for peer in list(self._peers.values()):
            self._take_from(peer.dealer, lambda control: self._take_peer(peer, control))
            if peer.next_event > peer.acked_event + 1:
                self._send(peer.dealer, bus_pb2.Control(event_ack=bus_pb2.EventAck(sequence=peer.next_event - 1)))
                peer.acked_event = peer.next_event - 1
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

    @staticmethod
    def _receive_udp(udp):
        try:
            return udp.recv(65536)
        except BlockingIOError:
            return None

    def _open(self, data):
        """The Control of a sound envelope of this session, else None, counted."""
        found = read_envelope(data)
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

    def _seal(self, control):
        body = control.WhichOneof("body")
        topic_class = (STATE if body.startswith("sub") or body.startswith("state") else
                       EVENT if body.startswith("event") else SERVICE if body.startswith("parameter") else CONTROL)
        return Envelope(topic_class, digest=PROTOCOL_VERSION, session=self.session, node=hash32(self.name),
                        boot=self.boot, publish_ns=time.monotonic_ns()).write(control.SerializeToString())

    def _send(self, dealer, control):
        try:
            dealer.send(self._seal(control), zmq.DONTWAIT)
            return True
        except zmq.ZMQError:  # not connected yet, or gone
            return False

    def _reply(self, routing, control):
        try:
            self._router.send_multipart([routing, self._seal(control)], zmq.DONTWAIT)
            return True
        except zmq.ZMQError:
            return False

    def _record(self):
        record = bus_pb2.NodeRecord(
            name=self.name, instance=self.instance, boot=self.boot, session=self.session,
            protocol_version=PROTOCOL_VERSION, process_id=os.getpid(), is_observer=self.is_observer,
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
            node=self._record(), known_roster=self._roster, is_goodbye=is_goodbye)))

    def _take_registry(self, control):
        if control.HasField("refusal"):
            self._refusal = control.refusal.why
        elif control.HasField("roster"):
            self._is_welcomed = True
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
        dealer = self._dealer(record.router_endpoint)
        self._poller.register(dealer, zmq.POLLIN)
        self._peers[record.name] = _Peer(record, dealer)
        for topic in record.topics:
            if topic.is_written:
                self.topics[hash32(topic.name)] = (topic.name, record.name)
        self._next_heartbeat = 0.0  # be heard by it at once

    def _forget(self, peer):
        self._poller.unregister(peer.dealer)
        peer.dealer.close()
        del self._peers[peer.record.name]

    def _send_heartbeats(self, is_goodbye):
        beat = self._seal(bus_pb2.Control(heartbeat=bus_pb2.Heartbeat(
            name=self.name, instance=self.instance, wait_count=self._polls, refused=self.refused,
            is_goodbye=is_goodbye)))
        for peer in self._peers.values():
            self._beats.sendto(beat, peer.heartbeat)

    def _take_heartbeat(self, data):
        control = self._open(data)
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

    def _wants(self, topic):
        return topic in self._read or any(matches(pattern, topic) for pattern in self._patterns)

    def _ask(self, peer, now):
        wants_state = any(t.is_written and t.topic_class == STATE and self._wants(t.name) for t in peer.record.topics)
        wants_events = self._wants("event")
        if not peer.is_alive or peer.is_subscribed or not (wants_state or wants_events) or \
                now - peer.asked_s < ASK_AGAIN_S:
            return
        if self._send(peer.dealer, bus_pb2.Control(subscribe=bus_pb2.Subscribe(
                name=self.name, instance=self.instance, wants_state=wants_state, wants_events=wants_events))):
            peer.asked_s = now

    def _take_peer(self, peer, control):
        body = control.WhichOneof("body")
        if body == "subscribe_ack":
            peer.is_subscribed = True
            peer.next_event = max(peer.next_event, control.subscribe_ack.next_event)
        elif body == "state_snapshot":
            peer.state_version = control.state_snapshot.version
            for entry in control.state_snapshot.entries:
                self._take_state(peer, entry)
        elif body == "state_delta" and control.state_delta.version > peer.state_version:
            if control.state_delta.version == peer.state_version + 1:
                peer.state_version += 1
                self._take_state(peer, control.state_delta)
            else:  # a gap: a new snapshot repairs it
                peer.is_subscribed, peer.asked_s = False, 0.0
        elif body == "event" and control.event.sequence >= peer.next_event:
            peer.next_event = control.event.sequence + 1
            if self._wants("event"):
                self._inbox.append(Message("event", peer.record.name, control.event.sequence, control.event.event))
        elif body == "parameter_reply":
            self._replies[control.parameter_reply.request] = control.parameter_reply

    def _take_state(self, peer, entry):
        if self._wants(entry.topic):
            body = TYPES[rule_of(entry.topic)["type"]].FromString(entry.value)
            self._inbox.append(Message(entry.topic, peer.record.name, entry.version, body, entry.key))

    def _take_router(self):
        while self._router.getsockopt(zmq.EVENTS) & zmq.POLLIN:
            routing, *_, data = self._router.recv_multipart()
            control = self._open(data)
            if not control:
                continue
            if control.HasField("subscribe"):
                reader = self.readers.setdefault(routing, _Reader()) if control.subscribe.wants_events else _Reader()
                self._reply(routing, bus_pb2.Control(subscribe_ack=bus_pb2.SubscribeAck(
                    instance=self.instance, next_event=reader.next_event)))
                if control.subscribe.wants_state:  # this node keeps no state
                    self._reply(routing, bus_pb2.Control(state_snapshot=bus_pb2.StateSnapshot(version=0)))
            elif control.HasField("event_ack") and routing in self.readers:
                reader = self.readers[routing]
                reader.acked = max(reader.acked, min(control.event_ack.sequence, reader.sent))
            elif control.HasField("parameter_request"):
                self._reply(routing, bus_pb2.Control(parameter_reply=bus_pb2.ParameterReply(
                    request=control.parameter_request.request, why=f"{self.name} owns no parameters")))

    def _take_data(self, data):
        found = read_envelope(data)
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
            self._newest[topic] = age
            body = merge_parts([parts[i] for i in range(envelope.parts)])
            del self._partial[topic]
            self._inbox.append(Message(topic, writer, envelope.sequence, body, "", envelope.publish_ns))
