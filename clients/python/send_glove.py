#!/usr/bin/env python3
"""Sends the angles of fingers as a data glove's driver does, for a device `dtrack` with option glove.

    /usr/bin/python3 clients/python/send_glove.py fist 127.0.0.1 5001      # a SIMULATED hand that opens and closes

A driver of a glove of your own imports `datagram`. The format: docs/reference/glove_protocol.md.
"""
import math
import socket
import sys
import time

RATE_HZ = 100.0
FINGERS = ("thumb", "index", "middle", "ring", "little")


def datagram(hands):
    """The line for {number of the hand: 15 angles in rad, three for each of FINGERS, from the palm outwards}."""
    parts = []
    for number, angles in hands.items():
        if len(angles) != 3 * len(FINGERS):
            raise ValueError(f"hand {number}: {len(angles)} angles, and a hand has {3 * len(FINGERS)}")
        if not all(-math.pi <= angle <= math.pi for angle in angles):
            raise ValueError(f"hand {number}: angles are radians, from -pi to pi")
        parts.append("[" + " ".join([str(int(number))] + [f"{angle:.6g}" for angle in angles]) + "]")
    return ("glove " + " ".join([str(len(parts))] + parts) + "\r\n").encode("ascii")


def fist(share):
    """Angles of a hand that is open at 0 and a fist at 1; the thumb stands before the fingers."""
    bent = [1.2 * share, 1.4 * share, 0.9 * share]
    return [1.1, 0.5 * share, 0.6 * share] + 4 * bent


def send(host, port, seconds=math.inf):
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    begin_s = time.monotonic()
    number = 0
    while number / RATE_HZ < seconds:
        time.sleep(max(0.0, begin_s + number / RATE_HZ - time.monotonic()))
        share = 0.5 - 0.5 * math.cos(2.0 * math.pi * 0.25 * number / RATE_HZ)
        sender.sendto(datagram({0: fist(share)}), (host, port))
        number += 1
    sender.close()


def main(words):
    try:
        if words[:1] != ["fist"] or len(words) != 3:
            print(__doc__, file=sys.stderr)
            return 2
        send(words[1], int(words[2]))
    except (OSError, ValueError) as error:
        print(f"send_glove.py: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        pass
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
