#!/usr/bin/env python3
"""Says how the target of a tracked head sits on it: eyes_rpy_deg of the scenario's <user>, from what ART's DTrack sends while someone looks
straight ahead, along the room's y axis, for two seconds.

    /usr/bin/python3 clients/python/aim_head.py 5000 3             # the port, and the number of the body
    /usr/bin/python3 clients/python/aim_head.py 5000 3 0 0 90      # rpy_deg of <user>, where the tracker's axes are not the room's
"""
import math
import socket
import sys

FRAMES = 120  # two seconds


def turn(roll_deg, pitch_deg, yaw_deg):
    """Rows of R_z(yaw) R_y(pitch) R_x(roll), as in scenario files."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(math.radians(a)), math.sin(math.radians(a))) for a in (roll_deg, pitch_deg, yaw_deg))
    return [[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr]]


def angles_deg(R):
    """Roll, pitch and yaw of a rotation."""
    return [math.degrees(math.atan2(R[2][1], R[2][2])), math.degrees(-math.asin(max(-1.0, min(1.0, R[2][0])))),
            math.degrees(math.atan2(R[1][0], R[0][0]))]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def transposed(R):
    return [list(row) for row in zip(*R)]


def matrix_of(datagram, body):
    """R_TB of a body's "6d" or "6di" entry; None: it is not tracked."""
    for line in datagram.split("\n"):
        if not line.startswith(("6d ", "6di ")):
            continue
        blocks = [block.split("]")[0].split() for block in line.split("[")[1:]]
        for head, _, columns in zip(blocks[0::3], blocks[1::3], blocks[2::3]):
            is_tracked = float(head[1]) > 0.0 if line.startswith("6di") else float(head[1]) >= 0.0
            if int(head[0]) == body and is_tracked:
                b = [float(word) for word in columns]
                return [[b[0], b[3], b[6]], [b[1], b[4], b[7]], [b[2], b[5], b[8]]]
    return None


def mean(matrices):
    """The sum's x axis, and its y axis at a right angle to that: of turns that are nearly alike."""
    sums = [[sum(R[i][j] for R in matrices) for j in range(3)] for i in range(3)]
    x, y = ([sums[i][j] for i in range(3)] for j in (0, 1))
    length = math.sqrt(sum(a * a for a in x))
    x = [a / length for a in x]
    along = sum(a * b for a, b in zip(x, y))
    y = [b - along * a for a, b in zip(x, y)]
    length = math.sqrt(sum(a * a for a in y))
    y = [a / length for a in y]
    z = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
    return transposed([x, y, z])


def aim(matrices_TB, rpy_RT_deg=(0.0, 0.0, 0.0)):
    """Angles of R_BH where R_RH = R_RT R_TB R_BH is the identity."""
    return angles_deg(transposed(product(turn(*rpy_RT_deg), mean(matrices_TB))))


def main(words):
    if len(words) not in (2, 5):
        print(__doc__, file=sys.stderr)
        return 2
    try:
        port, body, rpy = int(words[0]), int(words[1]), [float(word) for word in words[2:]] or [0.0, 0.0, 0.0]
        listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        listener.bind(("", port))
        listener.settimeout(5.0)
        seen = []
        for _ in range(5 * FRAMES):
            R = matrix_of(listener.recv(65536).decode("ascii", "replace"), body)
            if R is not None:
                seen.append(R)
            if len(seen) == FRAMES:
                break
        else:
            raise ValueError(f"body {body} was seen in {len(seen)} of {5 * FRAMES} frames; is that its number?")
    except (OSError, ValueError) as error:
        print(f"aim_head.py: {error}", file=sys.stderr)
        return 1
    print('eyes_rpy_deg="' + " ".join(f"{angle:.2f}" for angle in aim(seen, rpy)) + '"')
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
