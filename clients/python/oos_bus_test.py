"""The Python client against the vectors, and against a live node in C++: oos_bus_test.py PEER [OPTIONS OF unittest]."""

import json
import pathlib
import subprocess
import sys
import time
import unittest

import oos_bus
from proto import device_pb2

VECTORS = pathlib.Path(__file__).resolve().parents[1] / "vectors"
PEER = sys.argv.pop(1)


class Vectors(unittest.TestCase):
    def test_ids_and_digests_are_those_of_the_bus(self):
        hashes = json.loads((VECTORS / "hashes.json").read_text())
        for topic in hashes["topics"]:
            self.assertEqual(oos_bus.hash32(topic["name"]), topic["id"])
        for schema in hashes["schemas"]:
            shape = oos_bus.canonical(oos_bus.TYPES[schema["type"]].DESCRIPTOR)
            self.assertEqual(shape, schema["canonical"])
            self.assertEqual(oos_bus.hash32(shape), schema["digest"])

    def test_envelopes_are_read_and_written_alike(self):
        vectors = json.loads((VECTORS / "envelopes.json").read_text())
        for row in vectors["sound"]:
            envelope, payload = oos_bus.read_envelope(bytes.fromhex(row["bytes"]))
            self.assertEqual(payload.hex(), row["payload"])
            told = (envelope.topic_class, envelope.part, envelope.parts, envelope.topic, envelope.digest,
                    str(envelope.session), envelope.node, str(envelope.boot), str(envelope.sequence),
                    str(envelope.publish_ns), list(envelope.num_stamps), [str(t) for t in envelope.traces],
                    envelope.history.hex())
            self.assertEqual(told, tuple(row[k] for k in (
                "class", "part", "parts", "topic", "digest", "session", "node", "boot", "sequence", "publish_ns",
                "num_stamps", "traces", "history")))
            self.assertEqual(envelope.write(payload).hex(), row["bytes"])
        for row in vectors["refused"]:
            self.assertIsNone(oos_bus.read_envelope(bytes.fromhex(row["bytes"])), row["name"])

    def test_patterns(self):
        for pattern, text, expected in (("device/*/state", "device/right/state", True), ("*", "", True),
                                        ("contacts/*", "contacts/a/b", True), ("event", "events", False),
                                        ("a*b*c", "a-b-c", True), ("a*b", "ab", True), ("ab*ba", "aba", False),
                                        ("device/*/state", "device/state", False)):
            self.assertEqual(oos_bus.matches(pattern, text), expected, (pattern, text))


class LivePeer(unittest.TestCase):
    def setUp(self):
        self.peer = subprocess.Popen([PEER], stdout=subprocess.PIPE, text=True)
        self.addCleanup(self.peer.stdout.close)
        self.addCleanup(self.peer.wait)
        self.addCleanup(self.peer.kill)
        self.where = json.loads(self.peer.stdout.readline())

    def node(self, name="client", **options):
        return oos_bus.Node(name, self.where["registry"], int(self.where["session"]), **options)

    def until(self, node, condition, timeout_s=20.0):
        """Polls until condition(message) holds for one of the messages; returns it."""
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            for message in node.poll():
                if condition(message):
                    return message
        self.fail("it never came; alive: " + ", ".join(sorted(node.alive())))

    def test_everything_a_client_does(self):
        node = self.node(is_observer=False)
        for topic in ("physics/state", "logic/status", "event"):
            node.subscribe(topic)
        node.advertise("device/right/state")
        node.start()

        # STATE is there for a late joiner; LATEST comes whole although it takes several datagrams.
        logic = self.until(node, lambda m: m.topic == "logic/status")
        self.assertEqual((logic.body.step, logic.writer), ("before anybody came", "peer"))
        physics = self.until(node, lambda m: m.topic == "physics/state")
        self.assertEqual(list(physics.body.object), list(range(40)))
        self.assertEqual(physics.body.x_wo[7 * 39 + 4:7 * 40], [39.0, 0.5 * (physics.body.tick % 100), -1.0])
        later = self.until(node, lambda m: m.topic == "physics/state")
        self.assertGreater(later.sequence, physics.sequence)

        # Events both ways; the answer comes with a change of state.
        end = time.monotonic() + 20.0
        while not node.readers and time.monotonic() < end:
            node.poll()
        node.emit("greeting", "hello")
        seen = {}
        while len(seen) < 2 and time.monotonic() < end:
            for message in node.poll():
                if message.topic == "event" and message.body.name == "greeting":
                    seen["event"] = message.body.detail
                if message.topic == "logic/status":
                    seen["step"] = message.body.step
        self.assertEqual(seen, {"event": "hello, client", "step": "greeted"})

        self.assertGreater(node.set_parameter("peer", "gain", 2.5).tick, 0)
        with self.assertRaisesRegex(oos_bus.Refused, "out of range"):
            node.set_parameter("peer", "gain", 99.0)
        with self.assertRaisesRegex(oos_bus.Refused, "gain"):
            node.set_parameter("peer", "gian", 1.0)

        hand = device_pb2.DeviceState(role_index=0, x_wd=[1, 0, 0, 0, 0.1, 0.2, 0.3], v_wd=[0] * 6, is_engaged=True)
        is_seen = False
        while not is_seen and time.monotonic() < end:  # one datagram may be lost
            node.publish("device/right/state", hand)
            is_seen = any(m.topic == "event" and m.body.name == "hand_seen" for m in node.poll(0.01))
        node.close()
        rest = self.peer.stdout.read()
        self.assertEqual(self.peer.wait(), 0, rest)

    def test_a_second_node_of_the_same_name_is_refused_by_name(self):
        with self.node("twin") as first:
            first.start()
            second = self.node("twin")
            end = time.monotonic() + 20.0
            with self.assertRaisesRegex(oos_bus.Refused, "twin"):
                while time.monotonic() < end:
                    first.poll(0.01)
                    try:
                        second.start(timeout_s=0.02)
                    except TimeoutError:
                        continue
            second.close()

    def test_a_topic_that_is_not_in_the_table_is_refused(self):
        node = self.node("stranger")
        with self.assertRaisesRegex(ValueError, "phsyics/state"):
            node.subscribe("phsyics/state")
        node.close()


if __name__ == "__main__":
    unittest.main()
