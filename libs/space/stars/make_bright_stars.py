#!/usr/bin/env python3
"""Writes bright.stars from the npm package d3-celestial 0.7.35:

    npm pack d3-celestial@0.7.35 && tar xzf d3-celestial-0.7.35.tgz
    make_bright_stars.py package/data/stars.14.json bright.stars

The format is described in star_file.hpp; the test StarFile.* writes the same bytes from what it reads.
"""
import json
import math
import struct
import sys

STEPS = (1 << 24) - 1


def octahedral(x, y, z):
    total = abs(x) + abs(y) + abs(z)
    u, v = x / total, y / total
    if z < 0.0:
        u, v = math.copysign(1.0 - abs(v), u), math.copysign(1.0 - abs(u), v)
    return [math.floor((0.5 * part + 0.5) * STEPS + 0.5) for part in (u, v)]


def record(feature):
    longitude, latitude = (math.radians(angle) for angle in feature["geometry"]["coordinates"])
    u, v = octahedral(math.cos(latitude) * math.cos(longitude), math.cos(latitude) * math.sin(longitude), math.sin(latitude))
    magnitude = math.floor((float(feature["properties"]["mag"]) + 2.0) * 1000.0 + 0.5)
    color = feature["properties"]["bv"]
    color = min(max(math.floor((float(color or 0.7) + 0.5) * 50.0 + 0.5), 0), 255)
    return magnitude, u.to_bytes(3, "little") + v.to_bytes(3, "little") + struct.pack("<HB", magnitude, color)


def main():
    features = json.load(open(sys.argv[1], encoding="utf-8"))["features"]
    records = sorted(record(feature) for feature in features)
    with open(sys.argv[2], "wb") as out:
        out.write(b"OOSSTAR1" + struct.pack("<I", len(records)))
        for _, data in records:
            out.write(data)


main()
