"""oos_device.py against a bridge of a few lines; the bridge itself is tried in tests/devices_realtime_test.cpp."""
import os
import socket
import struct
import unittest
import zlib

import oos_device

FOLDER = os.path.dirname(os.path.abspath(__file__))


def command(sequence, numbers, flags=0, reflected=0):
    frame = struct.pack("<4sBBHIIqII9d", b"OOSD", 1, 3, 108, sequence, reflected, 5, flags, 0, *numbers)
    return frame + struct.pack("<I", zlib.crc32(frame))


class DeviceTest(unittest.TestCase):
    def setUp(self):
        self.bridge = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.bridge.bind(("127.0.0.1", 0))
        self.bridge.settimeout(10)
        self.device = oos_device.Device("arm", "A1", port=self.bridge.getsockname()[1], max_force_N=8.0)
        self.addCleanup(self.bridge.close)
        self.addCleanup(self.device.socket.close)

    def frame(self):
        frame, self.peer = self.bridge.recvfrom(512)
        self.assertEqual(zlib.crc32(frame[:-4]), struct.unpack("<I", frame[-4:])[0])
        self.assertEqual(struct.unpack_from("<H", frame, 6)[0], len(frame))
        return frame

    def test_states_and_commands_go_both_ways(self):
        self.device.exchange((0.1, 0.2, 0.3), velocity_m_per_s=(4, 5, 6), buttons=1)
        state = self.frame()
        self.assertEqual((len(state), state[5]), (212, 2))
        self.assertEqual(struct.unpack_from("<II7d", state, 24), (1, 1, 1, 0, 0, 0, 0.1, 0.2, 0.3))
        self.assertEqual(struct.unpack_from("<3d", state, 112), (4, 5, 6))
        self.bridge.sendto(command(7, range(1, 10), flags=1), self.peer)
        force_N, torque_Nm, grip_N, brake = self.device.exchange((0, 0, 0))
        self.assertEqual((force_N, torque_Nm, grip_N, brake), ([1, 2, 3], [4, 5, 6], 7, [8, 9]))
        description = self.frame()  # it was asked for one
        self.assertEqual((len(description), description[5]), (204, 1))
        self.assertEqual(description[24:28], b"arm\0")
        self.assertEqual(struct.unpack_from("<d", description, 128)[0], 8.0)
        state = self.frame()
        self.assertEqual(struct.unpack_from("<II", state, 8), (2, 7), "sequence, and the command that it had")
        self.assertEqual(struct.unpack_from("<3d", state, 152), (1, 2, 3), "what it applies")

    def test_without_commands_the_force_is_gone(self):
        self.device.exchange((0, 0, 0))
        self.frame()
        self.bridge.sendto(command(1, [5] * 9), self.peer)
        self.assertEqual(self.device.exchange((0, 0, 0))[0], [5, 5, 5])
        self.device.heard_s -= 0.07
        self.assertEqual(self.device.exchange((0, 0, 0)), ([0, 0, 0], [0, 0, 0], 0, [400, 4]))

    def test_damaged_and_foreign_frames_are_left_out(self):
        self.device.exchange((0, 0, 0))
        self.frame()
        good = command(1, [1] * 9)
        for bad in (b"", b"x" * 108, good[:-1], good[:50] + b"\1" + good[51:]):
            self.bridge.sendto(bad, self.peer)
        self.assertEqual(self.device.exchange((0, 0, 0))[0], [0, 0, 0])

    def test_the_client_is_as_short_as_the_how_to_says(self):
        with open(os.path.join(FOLDER, "oos_device.py"), encoding="utf-8") as file:
            self.assertLessEqual(len(file.readlines()), 60)


if __name__ == "__main__":
    unittest.main()
