"""A hand device that breaks a rule of docs/reference/device_protocol.md, for tests of `oos device check`.

    /usr/bin/python3 tests/bad_device.py PORT millimetres|stalls|deaf|deadless
"""
import math
import os
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "clients", "python"))
import oos_device  # noqa: E402

PORT, FAULT = int(sys.argv[1]), sys.argv[2]
device = oos_device.Device("bad device", FAULT, port=PORT)
held = [0.0] * 9  # the newest command that had a force
count = 0
while True:
    now_s = time.monotonic()
    unit = 1000.0 if FAULT == "millimetres" else 1.0
    place = (unit * 0.05 * math.sin(6.0 * now_s), 0.0, 0.0)
    velocity = (unit * 0.3 * math.cos(6.0 * now_s), 0.0, 0.0)
    if FAULT == "deaf":  # it listens, and says that it applies nothing
        device.receive()
        device.command = oos_device.OFF
        device.heard_s = now_s
        device.receive = lambda: None
    device.exchange(place, velocity_m_per_s=velocity)
    if FAULT == "deaf":
        del device.receive
    if FAULT == "deadless":  # without commands it goes on as before
        held = device.command if any(device.command[:3]) else held
        oos_device.OFF = held
    count += 1
    pause_s = 0.15 if FAULT == "stalls" and count % 300 == 0 else 1e-3
    time.sleep(max(0.0, now_s + pause_s - time.monotonic()))
