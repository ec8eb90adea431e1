"""A scripted hand in place of device_bridge: draws a circle of 5 cm at 500 samples a second, then emits an event.

    oos run SCENARIO --without device_bridge
    example_publish.py ROLE [TURNS]
"""

import math
import sys
import time

import oos_bus
from proto import device_pb2

PERIOD_S, TURN_S, RADIUS_M = 0.002, 4.0, 0.05


def sample(t):
    """The hand at time t; D has the axes of W."""
    angle, speed = 2 * math.pi * t / TURN_S, 2 * math.pi * RADIUS_M / TURN_S
    return device_pb2.DeviceState(
        sample_ns=time.monotonic_ns(), is_engaged=True, is_simulated=True,
        x_wd=[1, 0, 0, 0, RADIUS_M * math.cos(angle), RADIUS_M * math.sin(angle), 0.1],
        v_wd=[0, 0, 0, -speed * math.sin(angle), speed * math.cos(angle), 0])


def main(role, turns):
    with oos_bus.Node("client-publish", *oos_bus.running_session(), is_observer=False) as node:
        topic = f"device/{role}/state"
        node.advertise(topic)
        node.start()
        begin = time.monotonic()
        while (t := time.monotonic() - begin) < turns * TURN_S:
            node.publish(topic, sample(t))
            node.poll(PERIOD_S)
        node.emit("circle_drawn", f"{turns:g} turns")


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 3)
