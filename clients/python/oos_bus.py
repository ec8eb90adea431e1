"""A node of the VR-OOS bus in Python, on Debian's python3-zmq, -protobuf, -xxhash and -cryptography.

    with oos_bus.Node("client-1", *oos_bus.running_session()) as node:
        node.subscribe("physics/state")
        node.start()
        for message in node.poll():
            print(message.topic, message.body)

One thread does everything: call poll() at least every 0.1 s, for it also sends heartbeats; a node that is silent for
0.35 s is dead to the others. The protocol (docs/reference/bus_protocol.md) is in oos_links, oos_members, oos_reading and
oos_writing, each a layer on the one before.
"""

import json
import os
import pathlib
import stat
import time

from oos_envelope import LATEST, MAX_DATAGRAM_BYTES, Envelope, hash32
from oos_reading import Message
from oos_topics import canonical, rule_of
from oos_writing import Writing
from proto import bus_pb2, logic_pb2  # oos_topics knows where it is

__all__ = ["Message", "Node", "Refused", "running_session"]


def running_session():
    """(registry, session, key directory) of the `oos run` of this user on this machine."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    folder = os.path.join(runtime, "vr_oos") if runtime else f"/tmp/vr_oos-{os.geteuid()}"
    info = os.lstat(folder)
    if not stat.S_ISDIR(info.st_mode) or info.st_uid != os.geteuid() or info.st_mode & 0o077:
        # Who can write there can direct this client to a session of their own.
        raise PermissionError(f"{folder} is not a directory (no link) of this user alone, as 'oos run' makes it; the "
                              "session noted there may be a trap: remove it, start the session again")
    note = json.loads(pathlib.Path(folder, "session.json").read_text())
    return note["registry"], int(note["session"]), note.get("keys") or None


class Refused(Exception):
    """The registry, or the owner of a parameter, refused; the text gives the reason."""


class Node(Writing):
    """subscribe() and advertise() first, then start(), then poll() in a loop. Keys: the run's key directory, or None if
    the run is not encrypted. With keys, the name is a key's name, or that and a '-' and more: "client-1"."""

    def __init__(self, name, registry, session, keys, bind="127.0.0.1", is_observer=True):
        super().__init__(name, registry, session, keys, bind, is_observer)
        self._next_request = 0

    def subscribe(self, topic):
        """Receives a LATEST or STATE topic, or "event"; a '*' stands for any text."""
        if "*" in topic:
            self._patterns.append(topic)
        else:
            rule_of(topic)
            self._read.add(topic)

    def advertise(self, topic):
        """Declares a LATEST topic that publish() will write."""
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

    def poll(self, timeout_s=0.05):
        """The messages that have arrived; waits at most `timeout_s` for the first of them."""
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
        """Sends a LATEST message to all its readers; returns their number. ValueError if it exceeds one datagram."""
        self._sequences[topic] += 1
        envelope = Envelope(LATEST, hash32(topic), hash32(canonical(body.DESCRIPTOR)), self.session, hash32(self.name),
                            self.boot, self._sequences[topic], time.monotonic_ns())
        data = envelope.write(body.SerializeToString(), self._sealer)
        if len(data) > MAX_DATAGRAM_BYTES:
            raise ValueError(f"{topic}: {len(data)} bytes do not fit into one datagram")
        return self._send_to_readers(topic, data)

    def emit(self, name, detail=""):
        """Sends an event to all readers of events. The last 4096 are kept to be sent again to a reader that lost some."""
        event = logic_pb2.Event(time_ns=time.monotonic_ns(), source=self.name, name=name, detail=detail)
        self._append(event)

    def set_parameter(self, owner, name, value, manner=0, ramp_s=0.0, timeout_s=1.0):
        """Sets a parameter; returns the owner's bus_pb2.ParameterReply or raises Refused; TimeoutError without an answer.
        Messages that arrive meanwhile stay for poll()."""
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
        """Sends a goodbye, so that the others see that the node left and did not fail."""
        self._send_heartbeats(True)
        self._hello(True)
        self._close_links()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
