"""Writes what a camera of the running session sees, as camera.ppm: example_camera.py CAMERA [RATE_HZ [PICTURES]]."""

import sys

import oos_bus


def main(camera, rate_hz, pictures, viewer="visual_node"):
    with oos_bus.Node("client-camera", *oos_bus.running_session()) as node:
        topic = f"camera/{viewer}/{camera}"
        node.subscribe(topic)
        node.start()
        node.set_parameter(viewer, f"image.{camera}.rate_hz", rate_hz, timeout_s=5.0)
        count = 0
        while count < pictures:
            for message in node.poll():
                if message.topic != topic:
                    continue
                image, count = message.body, count + 1
                with open("camera.ppm", "wb") as file:
                    file.write(b"P6\n%d %d\n255\n" % (image.width, image.height) + image.rgb)
        node.set_parameter(viewer, f"image.{camera}.rate_hz", 0.0, timeout_s=5.0)
        print(f"{count} pictures; the newest is camera.ppm")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 2.0, int(sys.argv[3]) if len(sys.argv) > 3 else 20)
