#!/usr/bin/env python3
"""Stands in for ART's DTrack: records the datagrams that one sends, plays them again, or plays a SIMULATED head or Flystick.

    /usr/bin/python3 clients/python/play_dtrack.py record 5000 head.dtrack       # until Ctrl-C
    /usr/bin/python3 clients/python/play_dtrack.py play head.dtrack 127.0.0.1 5000
    /usr/bin/python3 clients/python/play_dtrack.py nod 127.0.0.1 5000            # a head that looks from side to side
    /usr/bin/python3 clients/python/play_dtrack.py stick 127.0.0.1 5000          # a Flystick that goes round, its trigger held

A recording is text: datagrams as they came, each ended by an empty line. Time between two is that of their `ts` lines.
"""
import math
import socket
import sys
import time

RATE_HZ = 60.0
BODY = 3


def record(port, name):
    listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    listener.bind(("", port))
    with open(name, "wb") as out:
        try:
            while True:
                out.write(listener.recv(65536).replace(b"\r\n", b"\n").rstrip(b"\n") + b"\n\n")
                out.flush()  # whoever looks on, or ends it, has it whole
        except KeyboardInterrupt:
            pass


def time_of(datagram):
    """Seconds of its `ts` line; None if it has none."""
    for line in datagram.splitlines():
        words = line.split()
        if len(words) == 2 and words[0] == "ts":
            return float(words[1])
    return None


def recorded(name):
    """Pairs of a datagram and its time, from 0."""
    with open(name, encoding="ascii") as file:
        datagrams = [text for text in file.read().split("\n\n") if text.strip()]
    first_s = next((time_of(text) for text in datagrams if time_of(text) is not None), 0.0)
    for number, text in enumerate(datagrams):
        its_s = time_of(text)
        yield text, number / RATE_HZ if its_s is None else its_s - first_s


def nodding():
    number = 0
    while True:
        t = number / RATE_HZ
        yaw = 0.3 * math.sin(2.0 * math.pi * 0.2 * t)
        c, s = math.cos(yaw), math.sin(yaw)
        place_mm = (120.0 * math.sin(2.0 * math.pi * 0.1 * t), 0.0, 20.0 * math.sin(2.0 * math.pi * 0.3 * t))
        yield (f"fr {number}\nts {t:.6f}\n6dcal 1\n6d 1 [{BODY} 1.000][{place_mm[0]:.3f} {place_mm[1]:.3f} {place_mm[2]:.3f}]"
               f"[{c:.6f} {s:.6f} 0.000000 {-s:.6f} {c:.6f} 0.000000 0.000000 0.000000 1.000000] "), t
        number += 1


def circling():
    """A Flystick2 that goes round a circle of 30 mm in 4 s; its stick closes the jaws in every second round."""
    number = 0
    while True:
        t = number / RATE_HZ
        angle = 0.5 * math.pi * t
        closed = -1.0 if int(t / 4.0) % 2 else 0.0
        yield (f"fr {number}\nts {t:.6f}\n6df2 1 1 [0 1.000 6 2][{30.0 * math.cos(angle):.3f} {30.0 * math.sin(angle):.3f} 0.000]"
               f"[1.000000 0.000000 0.000000 0.000000 1.000000 0.000000 0.000000 0.000000 1.000000][1 0.00 {closed:.2f}] "), t
        number += 1


def play(frames, host, port):
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    begin_s = time.monotonic()
    for text, its_s in frames:
        time.sleep(max(0.0, begin_s + its_s - time.monotonic()))
        sender.sendto(text.rstrip("\n").replace("\n", "\r\n").encode("ascii") + b"\r\n", (host, port))


def main(words):
    try:
        if words[:1] == ["record"] and len(words) == 3:
            record(int(words[1]), words[2])
        elif words[:1] == ["play"] and len(words) == 4:
            play(recorded(words[1]), words[2], int(words[3]))
        elif words[:1] == ["nod"] and len(words) == 3:
            play(nodding(), words[1], int(words[2]))
        elif words[:1] == ["stick"] and len(words) == 3:
            play(circling(), words[1], int(words[2]))
        else:
            print(__doc__, file=sys.stderr)
            return 2
    except (OSError, ValueError) as error:
        print(f"play_dtrack.py: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        pass
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
