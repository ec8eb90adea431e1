"""A hand device that carries out scenarios/touch by itself: a mass of 0.5 kg that a spring pulls along a path.

    /usr/bin/python3 clients/python/example_device.py &
    build/release/bin/oos run scenarios/touch --device right=udp:7460
"""
import sys
import time

from oos_device import Device

START = (-0.15, -0.05, 0.06)  # where the scenario has the hand in the beginning [m]
# Place [m] and speed on the way there [m/s]; the ball's radius is 10 mm.
PATH = [
    ((-0.15, 0.05, 0.06), 0.10), ((-0.15, 0.05, 0.004), 0.04),  # the pad
    ((-0.15, 0.05, 0.06), 0.10), ((-0.15, -0.07, 0.06), 0.10), ((-0.15, -0.07, 0.004), 0.05),  # down to the plane
    ((0.05, -0.07, 0.004), 0.08),  # along it, through the lever
    ((0.05, -0.07, 0.08), 0.10), ((-0.07, 0.07, 0.08), 0.10), ((-0.07, 0.07, 0.032), 0.05),
    ((0.08, 0.07, 0.032), 0.08),  # over the edge of the box, through the other lever
    ((0.08, 0.07, 0.12), 0.10), ((0.02, 0.0, 0.12), 0.10), ((0.02, 0.0, 0.04), 0.08),
    ((0.14, 0.0, 0.04), 0.06),  # the block, to the bumper
]
MASS_KG, STIFFNESS_N_PER_M, DAMPING_N_S_PER_M = 0.5, 600.0, 35.0


def main(port):
    device = Device("example in Python", "1", port=port, mass_kg=MASS_KG)
    place, target, path = list(START), list(START), list(PATH)
    speed, force, brake = [0.0] * 3, [0.0] * 3, [0.0] * 2
    begin_s = last_s = time.monotonic()
    while True:
        now_s = time.monotonic()
        step_s, last_s = min(now_s - last_s, 0.01), now_s
        way = [a - b for a, b in zip(path[0][0], target)] if path else [0.0] * 3
        length = sum(a * a for a in way) ** 0.5
        if device.heard_s == 0:
            begin_s = now_s
        starts = now_s - begin_s > 3.0  # the force needs a second to come
        velocity = [a / length * path[0][1] for a in way] if path and length > 1e-3 and starts else [0.0] * 3
        if path and length <= 1e-3:
            path.pop(0)
        for i in range(3):
            target[i] += velocity[i] * step_s
            pull = force[i] + STIFFNESS_N_PER_M * (target[i] - place[i]) + DAMPING_N_S_PER_M * velocity[i]
            drag = 1.0 + (DAMPING_N_S_PER_M + brake[0]) / MASS_KG * step_s  # implicit: stable however late a step is
            speed[i] = (speed[i] + pull / MASS_KG * step_s) / drag
            place[i] += speed[i] * step_s
        position = [a - b for a, b in zip(place, START)]
        force, _, _, brake = device.exchange(position, velocity_m_per_s=speed)
        time.sleep(max(0.0, now_s + 1e-3 - time.monotonic()))


main(int(sys.argv[1]) if len(sys.argv) > 1 else 7460)
