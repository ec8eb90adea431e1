"""Prints where the objects of the running session are, twice a second: example_follow.py [SECONDS]."""

import sys
import time

import oos_bus


def main(seconds):
    with oos_bus.Node("client-follow", *oos_bus.running_session()) as node:
        node.subscribe("physics/state")
        node.subscribe("logic/status")
        node.start()
        end, next_print, newest = time.monotonic() + seconds, 0.0, None
        while time.monotonic() < end:
            for message in node.poll():
                if message.topic == "logic/status":
                    print(f"step {message.body.step}: {message.body.hint}", flush=True)
                else:
                    newest = message.body
            if newest and time.monotonic() >= next_print:
                next_print = time.monotonic() + 0.5
                poses = zip(newest.object, (newest.x_wo[i + 4:i + 7] for i in range(0, len(newest.x_wo), 7)))
                print(f"tick {newest.tick}  " + "  ".join(
                    f"object {i} at {x:.3f} {y:.3f} {z:.3f} m" for i, (x, y, z) in poses), flush=True)


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 10.0)
