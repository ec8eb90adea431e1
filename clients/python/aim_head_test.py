"""aim_head.py on targets that are mounted as the test says."""
import os
import random
import socket
import subprocess
import sys
import unittest

import aim_head

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "aim_head.py")


def line(R, body=3):
    columns = " ".join(f"{R[i][j]:.6f}" for j in range(3) for i in range(3))
    return f"fr 1\r\n6d 2 [0 1.000][9 9 9][1 0 0 0 1 0 0 0 1] [{body} 1.000][1 2 3][{columns}] \r\n"


class AimHeadTest(unittest.TestCase):
    def test_the_turn_is_that_of_scenario_files(self):
        # R_z(90) R_x(90): x to y, y to z, z to x.
        R = aim_head.turn(90.0, 0.0, 90.0)
        for row, want in zip(R, [[0, 0, 1], [1, 0, 0], [0, 1, 0]]):
            for a, b in zip(row, want):
                self.assertAlmostEqual(a, b)

    # Who looks straight ahead has the target at R_TB = R_TR R_HB; that sways by half a degree.
    def test_a_crooked_target_is_found_through_a_head_that_sways(self):
        chance = random.Random(1)
        want, room = (20.0, -35.0, 80.0), (0.0, 10.0, 90.0)
        R_TB = aim_head.product(aim_head.transposed(aim_head.turn(*room)), aim_head.transposed(aim_head.turn(*want)))
        swaying = [aim_head.product(R_TB, aim_head.turn(*(chance.gauss(0.0, 0.5) for _ in range(3)))) for _ in range(120)]
        read = [aim_head.matrix_of(line(R), 3) for R in swaying]
        for a, b in zip(aim_head.aim(read, room), want):
            self.assertAlmostEqual(a, b, delta=0.3)
        self.assertIsNone(aim_head.matrix_of(line(R_TB), 4))
        self.assertIsNone(aim_head.matrix_of("6d 1 [3 -1.0][0 0 0][0 0 0 0 0 0 0 0 0]", 3))

    def test_it_prints_the_attribute(self):
        probe = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
        probe.close()
        child = subprocess.Popen([sys.executable, SCRIPT, str(port), "3"], stdout=subprocess.PIPE, text=True)
        self.addCleanup(child.kill)
        sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(sender.close)
        text = line(aim_head.transposed(aim_head.turn(0.0, 0.0, -90.0))).encode()
        while child.poll() is None:
            sender.sendto(text, ("127.0.0.1", port))
        self.assertIn(child.stdout.read().split('"')[1].split()[2], ("-90.00",))
        child.stdout.close()
        self.assertEqual(child.returncode, 0)

    def test_a_body_that_is_never_seen_is_named(self):
        probe = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
        probe.close()
        child = subprocess.Popen([sys.executable, SCRIPT, str(port), "7"], stderr=subprocess.PIPE, text=True)
        self.addCleanup(child.kill)
        sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(sender.close)
        while child.poll() is None:
            sender.sendto(line(aim_head.turn(0.0, 0.0, 0.0)).encode(), ("127.0.0.1", port))
        self.assertIn("body 7 was seen in 0 of", child.stderr.read())
        child.stderr.close()

    def test_wrong_words_say_how_it_is_called(self):
        run = subprocess.run([sys.executable, SCRIPT], capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 2)
        self.assertIn("aim_head.py 5000 3", run.stderr)


if __name__ == "__main__":
    unittest.main()
