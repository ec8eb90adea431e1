"""The Python client against the vectors, and against a live node in C++: oos_bus_test.py PEER [OPTIONS OF unittest]."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock

import oos_bus
import oos_envelope
import oos_topics
from proto import bus_pb2, device_pb2, physics_pb2

VECTORS = pathlib.Path(__file__).resolve().parents[1] / "vectors"
PEER = sys.argv.pop(1)
PATIENCE_S = 40.0


class Vectors(unittest.TestCase):
    def test_ids_and_digests_are_those_of_the_bus(self):
        hashes = json.loads((VECTORS / "hashes.json").read_text())
        for topic in hashes["topics"]:
            self.assertEqual(oos_envelope.hash32(topic["name"]), topic["id"])
        for schema in hashes["schemas"]:
            shape = oos_topics.canonical(oos_topics.TYPES[schema["type"]].DESCRIPTOR)
            self.assertTrue((shape + " ").startswith(schema["canonical"] + " "), shape)  # fields may have been added
            self.assertEqual(oos_envelope.hash32(schema["canonical"]), schema["digest"])

    def test_envelopes_are_read_and_written_alike(self):
        vectors = json.loads((VECTORS / "envelopes.json").read_text())
        for row in vectors["sound"]:
            envelope, payload = oos_envelope.read_envelope(bytes.fromhex(row["bytes"]))
            self.assertEqual(payload.hex(), row["payload"])
            fields = (envelope.topic_class, envelope.part, envelope.parts, envelope.topic, envelope.digest,
                    str(envelope.session), envelope.node, str(envelope.boot), str(envelope.sequence),
                    str(envelope.publish_ns), list(envelope.num_stamps), [str(t) for t in envelope.traces],
                    envelope.history.hex())
            self.assertEqual(fields, tuple(row[k] for k in (
                "class", "part", "parts", "topic", "digest", "session", "node", "boot", "sequence", "publish_ns",
                "num_stamps", "traces", "history")))
            self.assertEqual(envelope.write(payload).hex(), row["bytes"])
        for row in vectors["refused"]:
            self.assertIsNone(oos_envelope.read_envelope(bytes.fromhex(row["bytes"])), row["name"])

    def test_sealed_datagrams_are_opened_and_sealed_alike(self):
        vectors = json.loads((VECTORS / "envelopes.json").read_text())
        key = oos_envelope.sender_key(bytes.fromhex(vectors["session_key"]), int(vectors["instance"]))
        self.assertEqual(key.hex(), vectors["sender_key"])
        for row in vectors["sealed"]:
            data = bytes.fromhex(row["bytes"])
            opener, sealer = oos_envelope.Opener(key), oos_envelope.Sealer(key)

            def unseal(envelope, clear, body):
                return opener(envelope.topic_class, clear, body)

            envelope, payload = oos_envelope.read_envelope(data, unseal)
            self.assertEqual((payload.hex(), envelope.history.hex()), (row["payload"], row["history"]))
            self.assertIsNone(oos_envelope.read_envelope(data, unseal), "came before")
            sealer.counters = [int(row["counter"]) - 1] * 2
            self.assertEqual(envelope.write(payload, sealer).hex(), row["bytes"])
            for i in range(len(data)):  # every byte counts
                forged = data[:i] + bytes([data[i] ^ 1]) + data[i + 1:]
                opener = oos_envelope.Opener(key)
                self.assertIsNone(oos_envelope.read_envelope(forged, unseal))

    def test_the_replay_window_takes_each_counter_once(self):
        key = bytes(32)
        sealer, opener = oos_envelope.Sealer(key), oos_envelope.Opener(key)
        sealed = [sealer(oos_envelope.LATEST, b"", bytes([n])) for n in range(200)]
        for n, expected in ((5, True), (5, False), (3, True), (3, False), (80, True), (17, True), (16, False),
                            (199, True), (80, False), (198, True), (198, False)):
            self.assertEqual(opener(oos_envelope.LATEST, b"", sealed[n]) is not None, expected, n)

    def test_a_star_in_a_pattern_stands_for_any_text(self):
        for pattern, text, expected in (("device/*/state", "device/right/state", True), ("*", "", True),
                                        ("contacts/*", "contacts/a/b", True), ("event", "events", False),
                                        ("a*b*c", "a-b-c", True), ("a*b", "ab", True), ("ab*ba", "aba", False),
                                        ("device/*/state", "device/state", False)):
            self.assertEqual(oos_topics.matches(pattern, text), expected, (pattern, text))


def foreign_folder(test):
    """A folder that is another user's."""
    if os.geteuid() != 0:
        return pathlib.Path("/")
    folder = tempfile.TemporaryDirectory()
    test.addCleanup(folder.cleanup)
    os.chown(folder.name, 65534, 65534)
    return pathlib.Path(folder.name)


class SessionNote(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.place = pathlib.Path(folder.name, "vr_oos")
        self.enterContext(unittest.mock.patch.dict(os.environ, XDG_RUNTIME_DIR=folder.name))

    def write(self, folder):
        (folder / "session.json").write_text('{"registry": "tcp://127.0.0.1:1", "session": "7", "keys": ""}')

    def test_is_taken_from_a_folder_of_this_user_alone(self):
        self.place.mkdir(mode=0o700)
        self.write(self.place)
        self.assertEqual(oos_bus.running_session(), ("tcp://127.0.0.1:1", 7, None))

    def test_is_not_taken_where_others_may_enter(self):
        self.place.mkdir(mode=0o700)
        self.write(self.place)
        self.place.chmod(0o755)
        with self.assertRaisesRegex(PermissionError, "vr_oos is not a directory .* of this user alone"):
            oos_bus.running_session()

    def test_is_not_taken_through_a_link_or_from_another_user(self):
        elsewhere = self.place.with_name("elsewhere")
        elsewhere.mkdir(mode=0o700)
        self.write(elsewhere)
        for target in (elsewhere, foreign_folder(self)):
            self.place.symlink_to(target)
            with self.assertRaisesRegex(PermissionError, "vr_oos is not a directory"):
                oos_bus.running_session()
            self.place.unlink()
        if os.geteuid() == 0:
            elsewhere.rename(self.place)
            os.chown(self.place, 65534, 65534)
            with self.assertRaisesRegex(PermissionError, "vr_oos is not a directory"):
                oos_bus.running_session()


class KeyDirectory(unittest.TestCase):
    def test_of_another_user_is_refused(self):
        folder = foreign_folder(self)
        with unittest.mock.patch.object(pathlib.Path, "exists", return_value=True):
            with self.assertRaisesRegex(PermissionError, "belongs to user"):
                oos_envelope.Keys(folder, "client")


class LivePeer:
    """The tests that run twice: in the clear and encrypted."""

    def start_peer(self, *words):
        self.peer = subprocess.Popen([PEER, *words], stdout=subprocess.PIPE, text=True)
        self.addCleanup(self.peer.stdout.close)
        self.addCleanup(self.peer.wait)
        self.addCleanup(self.peer.kill)
        self.where = json.loads(self.peer.stdout.readline())

    def node(self, name="client", **options):
        registry, session, keys = (self.where[what] for what in ("registry", "session", "keys"))
        return oos_bus.Node(name, registry, int(session), keys or None, **options)

    def until(self, node, condition, timeout_s=PATIENCE_S):
        """Polls until condition(message) holds for one of the messages; returns it."""
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            for message in node.poll():
                if condition(message):
                    return message
        self.fail("it never came; alive: " + ", ".join(sorted(node.alive())))

    def place_in(self, node, topic):
        """(newest sequence, messages that were received or lost up to it)."""
        sequences, end = [], time.monotonic() + PATIENCE_S
        while not sequences:
            sequences = [message.sequence for message in node.poll() if message.topic == topic]
            self.assertLess(time.monotonic(), end, f"{topic} does not come; alive: {node.alive()}")
        return sequences[-1], node.received[topic] + node.dropped[topic]

    def test_digests_of_all_messages_are_those_of_the_peer(self):
        self.assertEqual({name: oos_envelope.hash32(oos_topics.canonical(oos_topics.TYPES[name].DESCRIPTOR))
                          for name in self.where["digests"]}, self.where["digests"])

    def test_a_client_receives_and_sends_every_class_of_message(self):
        node = self.node(is_observer=False)
        for topic in ("physics/state", "haptic/right/proxy", "logic/status", "event"):
            node.subscribe(topic)
        node.advertise("device/right/state")
        node.start()

        # STATE is there for a late joiner; LATEST comes whole although it takes several datagrams.
        logic = self.until(node, lambda m: m.topic == "logic/status")
        self.assertEqual((logic.body.step, logic.writer), ("before the client joined", "peer"))
        physics = self.until(node, lambda m: m.topic == "physics/state")
        self.assertEqual(list(physics.body.object), list(range(40)))
        self.assertEqual(physics.body.x_wo[7 * 39 + 4:7 * 40], [39.0, 0.5 * (physics.body.tick % 100), -1.0])
        later = self.until(node, lambda m: m.topic == "physics/state")
        self.assertGreater(later.sequence, physics.sequence)

        self.until(node, lambda m: m.topic == "haptic/right/proxy" and m.body.cycle > 0)  # comes by ZeroMQ

        first, first_count = self.place_in(node, "physics/state")

        # Events both ways; the answer comes with a change of state.
        end = time.monotonic() + PATIENCE_S
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

        # What was sent since then was received or is counted as lost.
        newest, count = self.place_in(node, "physics/state")
        self.assertEqual(count - first_count, newest - first)
        node.close()
        rest = self.peer.stdout.read()
        self.assertEqual(self.peer.wait(), 0, rest)

    def test_an_unreachable_peer_does_not_stop_a_client(self):
        with self.node("client-far") as far, self.node("client-near", is_observer=False) as near:
            far.subscribe("device/right/state")
            near.advertise("device/right/state")
            record = far._record()
            record.data_endpoint = record.heartbeat_endpoint = "255.255.255.255:9"  # sendto: permission denied
            far._record = lambda: record
            near.start()
            end = time.monotonic() + PATIENCE_S
            while len(near.alive()) < 2:  # the peer and the far one
                far.poll(0.01)
                near.poll(0.01)
                self.assertLess(time.monotonic(), end, "they never met")
            self.assertEqual(near.publish("device/right/state", device_pb2.DeviceState()), 1, "the peer")
            self.assertEqual((near.sent["device/right/state"], near.dropped["device/right/state"]), (1, 1))

    def test_a_record_without_addresses_is_refused(self):
        with self.node() as node:
            node.start()
            for endpoint in ("", "127.0.0.1", "127.0.0.1:port", "127.0.0.1:70000", "somewhere:4000"):
                before = node.refused
                node._add(bus_pb2.NodeRecord(name="nowhere", instance=1, data_endpoint=endpoint,
                                             heartbeat_endpoint="127.0.0.1:4000", router_endpoint="tcp://127.0.0.1:4"))
                self.assertEqual(node.refused, before + 1, endpoint)
            self.assertNotIn("nowhere", node._peers)

    def test_a_second_node_of_the_same_name_is_refused_by_name(self):
        with self.node("client-twin") as first:
            first.start()
            second = self.node("client-twin")
            end = time.monotonic() + PATIENCE_S
            with self.assertRaisesRegex(oos_bus.Refused, "twin"):
                while time.monotonic() < end:
                    first.poll(0.01)
                    try:
                        second.start(timeout_s=0.02)
                    except TimeoutError:
                        continue
            second.close()

    def test_a_topic_that_is_not_in_the_table_is_refused(self):
        node = self.node("client-stranger")
        with self.assertRaisesRegex(ValueError, "phsyics/state"):
            node.subscribe("phsyics/state")
        node.close()


class InTheClear(LivePeer, unittest.TestCase):
    def setUp(self):
        self.start_peer()

    def test_a_malformed_payload_is_refused_and_counted(self):
        topic = "physics/state"
        with self.node() as node:
            node.subscribe(topic)
            node.start()
            newest = self.until(node, lambda m: m.topic == topic)
            sound = physics_pb2.PhysicsState(tick=1).SerializeToString()

            def num_refused(payload, digest=oos_topics.digest_of(topic), **parts):
                """Refusals caused by a datagram with a sound envelope and this content."""
                before, (boot, sequence) = node.refused, node._newest[topic]
                node._take_data(oos_envelope.Envelope(
                    oos_envelope.LATEST, oos_envelope.hash32(topic), digest, node.session, oos_envelope.hash32("peer"),
                    boot, sequence + 1, **parts).write(payload))
                return node.refused - before

            self.assertEqual(num_refused(b"\xff\xff\xff"), 1)
            self.assertEqual(num_refused(sound, digest=1), 1, "another schema")
            self.assertEqual(num_refused(sound, part=1, parts=2), 0)
            self.assertEqual(num_refused(sound, part=2, parts=3), 1, "of two parts, or of three?")
            before = node.refused
            node.subscribe("logic/status")
            node._take_state(node._peers["peer"], bus_pb2.StateEntry(topic="logic/status", value=b"\xff\xff\xff"))
            self.assertEqual(node.refused, before + 1)
            later = self.until(node, lambda m: m.topic == topic and m.sequence > newest.sequence)
            self.assertEqual(list(later.body.object), list(range(40)))


class Encrypted(LivePeer, unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.start_peer(folder.name + "/keys")

    def run_example(self, name, *words):
        """Runs an example with the peer's session as the running one, and as if on another machine (own clock)."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        place = pathlib.Path(folder.name, "vr_oos", "session.json")
        place.parent.mkdir(mode=0o700)
        place.write_text(json.dumps(self.where))
        example = subprocess.Popen([sys.executable, pathlib.Path(__file__).with_name(name), *words], text=True,
                                   stdout=subprocess.PIPE,
                                   env=os.environ | {"XDG_RUNTIME_DIR": folder.name, "OOS_MACHINE_ID": "elsewhere"})
        self.addCleanup(example.stdout.close)
        self.addCleanup(example.wait)
        self.addCleanup(example.kill)
        return example

    def test_the_following_example_prints_the_step_and_the_poses(self):
        said, _ = self.run_example("example_follow.py", "0.7").communicate(timeout=PATIENCE_S)
        self.assertIn("step before the client joined", said)
        self.assertRegex(said, r"tick \d+  object 0 at 0.000 \d.*object 39 at 39.000 [\d.]+ -1.000 m")

    def test_the_publishing_example_moves_on_its_circle(self):
        with self.node("client-watch") as node:
            node.subscribe("device/right/state")
            node.start()
            example = self.run_example("example_publish.py", "right", "0.25")
            hand = self.until(node, lambda m: m.topic == "device/right/state")
            self.assertEqual(hand.writer, "client-publish")
            self.assertAlmostEqual(hand.body.x_wd[4] ** 2 + hand.body.x_wd[5] ** 2, 0.05 ** 2)
            while example.poll() is None:
                node.poll(0.02)
            self.assertEqual(example.returncode, 0)

    def test_a_client_without_a_key_is_not_let_in(self):
        with oos_bus.Node("client", self.where["registry"], int(self.where["session"]), None) as stranger:
            with self.assertRaises(TimeoutError):
                stranger.start(timeout_s=1.0)

    def test_a_key_is_valid_for_its_own_name_only(self):
        with self.assertRaisesRegex(FileNotFoundError, "intruder"):
            self.node("intruder")


if __name__ == "__main__":
    unittest.main()
