"""play_dtrack.py against a socket of this process."""
import math
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

import play_dtrack

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "play_dtrack.py")
FIRST = "fr 1\nts 10.000000\n6d 1 [3 1.000][100.000 0.000 0.000][1 0 0 0 1 0 0 0 1] "
SECOND = "fr 2\nts 10.250000\n6d 0"


def listener():
    heard = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    heard.bind(("127.0.0.1", 0))
    heard.settimeout(20)
    return heard, heard.getsockname()[1]


class PlayDtrackTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.name = os.path.join(folder.name, "head.dtrack")

    def test_a_recording_is_played_as_lines_of_the_tracker_at_its_own_times(self):
        with open(self.name, "w", encoding="ascii") as file:
            file.write(FIRST + "\n\n" + SECOND + "\n\n")
        self.assertEqual([its_s for _, its_s in play_dtrack.recorded(self.name)], [0.0, 0.25])
        heard, port = listener()
        self.addCleanup(heard.close)
        play_dtrack.play(play_dtrack.recorded(self.name), "127.0.0.1", port)
        self.assertEqual(heard.recv(65536), FIRST.replace("\n", "\r\n").encode() + b"\r\n")
        self.assertEqual(heard.recv(65536), SECOND.replace("\n", "\r\n").encode() + b"\r\n")

    def test_datagrams_without_times_come_sixty_a_second(self):
        with open(self.name, "w", encoding="ascii") as file:
            file.write("fr 1\n\nfr 2\n\n")
        self.assertEqual([its_s for _, its_s in play_dtrack.recorded(self.name)], [0.0, 1.0 / 60.0])

    def test_what_is_recorded_can_be_played(self):
        probe, port = listener()
        probe.close()
        child = subprocess.Popen([sys.executable, SCRIPT, "record", str(port), self.name])
        self.addCleanup(child.kill)
        sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(sender.close)
        end_s = time.monotonic() + 20
        while time.monotonic() < end_s and self.is_free(port):
            pass  # until it listens
        for text in (FIRST, SECOND):
            sender.sendto(text.replace("\n", "\r\n").encode() + b"\r\n", ("127.0.0.1", port))
        # It begins its file after it listens.
        has_both = lambda: os.path.exists(self.name) and len(list(play_dtrack.recorded(self.name))) == 2
        while time.monotonic() < end_s and not has_both():
            pass
        child.send_signal(signal.SIGINT)
        self.assertEqual(child.wait(20), 0)
        self.assertEqual([text for text, _ in play_dtrack.recorded(self.name)], [FIRST, SECOND])

    # By the kernel's table: a socket that tries the port would be in the listener's way.
    @staticmethod
    def is_free(port):
        with open("/proc/net/udp", encoding="ascii") as table:
            return not any(line.split()[1].endswith(f":{port:04X}") for line in table.readlines()[1:])

    def test_a_simulated_head_is_a_rotation_and_counts_its_frames(self):
        frames = play_dtrack.nodding()
        for number in range(3):
            text, its_s = next(frames)
            self.assertAlmostEqual(its_s, number / 60.0)
            self.assertTrue(text.startswith(f"fr {number}\n"))
            columns = [float(word) for word in text.split("[")[3].rstrip("] ").split()]
            x, y = columns[0:3], columns[3:6]
            self.assertAlmostEqual(sum(a * a for a in x), 1.0, places=5)
            self.assertAlmostEqual(sum(a * b for a, b in zip(x, y)), 0.0, places=5)

    def test_a_simulated_flystick_goes_round_and_closes_in_every_second_round(self):
        frames = play_dtrack.circling()
        blocks = [next(frames)[0].split("[") for _ in range(8 * 60)]
        for block in blocks:
            x, y, _ = (float(word) for word in block[2].rstrip("]").split())
            self.assertAlmostEqual(math.hypot(x, y), 30.0, places=2)
        keys = [block[4].rstrip("] ").split() for block in blocks]
        self.assertEqual({key[0] for key in keys}, {"1"})
        self.assertEqual([float(keys[number][2]) for number in (0, 239, 240, 479)], [0.0, 0.0, -1.0, -1.0])

    def test_wrong_words_say_how_it_is_called(self):
        run = subprocess.run([sys.executable, SCRIPT, "dance"], capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 2)
        self.assertIn("record 5000", run.stderr)


if __name__ == "__main__":
    unittest.main()
