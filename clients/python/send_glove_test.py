"""send_glove.py against a socket of this process."""
import socket
import unittest

import send_glove


class SendGloveTest(unittest.TestCase):
    def test_a_line_has_the_hand_and_its_fifteen_angles(self):
        line = send_glove.datagram({3: [0.1 * i for i in range(15)]}).decode()
        self.assertTrue(line.startswith("glove 1 [3 0 0.1 0.2 "))
        self.assertTrue(line.endswith("1.4]\r\n"))
        self.assertEqual(len(line[line.index("[") + 1:line.index("]")].split()), 16)

    def test_what_is_no_hand_is_refused(self):
        with self.assertRaises(ValueError):
            send_glove.datagram({0: [0.0] * 14})
        with self.assertRaises(ValueError):
            send_glove.datagram({0: [90.0] * 15})  # degrees

    def test_it_sends_a_hand_that_opens_and_closes(self):
        heard = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(heard.close)
        heard.bind(("127.0.0.1", 0))
        heard.settimeout(20)
        send_glove.send("127.0.0.1", heard.getsockname()[1], seconds=0.03)
        lines = [heard.recv(65536).decode() for _ in range(3)]
        self.assertEqual(lines[0], send_glove.datagram({0: send_glove.fist(0.0)}).decode())
        self.assertNotEqual(lines[0], lines[2])


if __name__ == "__main__":
    unittest.main()
