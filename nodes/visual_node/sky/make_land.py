#!/usr/bin/env python3
"""Writes land.bits from the npm package world-atlas 2.0.2, which has Natural Earth's coasts (public domain):

    npm pack world-atlas@2.0.2 && tar xzf world-atlas-2.0.2.tgz
    make_land.py package/land-50m.json land.bits

1440 x 720 bits, most significant first: rows from the south pole, columns from 180 degrees west. Needs python3-pil.
"""
import json
import sys

from PIL import Image, ImageDraw

WIDTH, HEIGHT = 1440, 720


def main():
    topology = json.load(open(sys.argv[1], encoding="utf-8"))
    scale, translate = topology["transform"]["scale"], topology["transform"]["translate"]
    arcs = []
    for arc in topology["arcs"]:
        x = y = 0
        points = []
        for dx, dy in arc:
            x, y = x + dx, y + dy
            points.append((x * scale[0] + translate[0], y * scale[1] + translate[1]))
        arcs.append(points)

    def ring(indices):
        points = []
        for index in indices:
            for lon, lat in arcs[index] if index >= 0 else arcs[~index][::-1]:
                if points:  # no leap at 180 degrees
                    lon += 360.0 * round((points[-1][0] - lon) / 360.0)
                points.append((lon, lat))
        if abs(points[-1][0] - points[0][0]) > 180.0:  # around the south pole
            points += [(points[-1][0], -91.0), (points[0][0], -91.0)]
        return points

    def fill(indices, value):
        for turn in (-360.0, 0.0, 360.0):
            draw.polygon([((lon + turn + 180.0) / 360.0 * WIDTH - 0.5, (lat + 90.0) / 180.0 * HEIGHT - 0.5)
                          for lon, lat in ring(indices)], fill=value)

    image = Image.new("1", (WIDTH, HEIGHT), 0)
    draw = ImageDraw.Draw(image)
    for geometry in topology["objects"]["land"]["geometries"]:
        polygons = geometry["arcs"] if geometry["type"] == "MultiPolygon" else [geometry["arcs"]]
        for polygon in polygons:
            fill(polygon[0], 1)
            for hole in polygon[1:]:
                fill(hole, 0)
    with open(sys.argv[2], "wb") as out:
        out.write(image.tobytes())


main()
