#!/usr/bin/env python3
"""Writes meshes/forearm.obj of `forearm.xml` (metres). Needs Python alone.

A forearm with its elbow: a round cone along y from the wrist (origin) to the elbow at y = -0.24, closed by half spheres.
It is touched and seen. tools/mesh_tool.py checks that it is closed, manifold and turned outwards.
"""
import math
import os

SIDES, RINGS = 48, 8
WRIST_R, ELBOW_R, LENGTH = 0.028, 0.045, 0.24


def profile():
    """Radius and y from the wrist's pole to the elbow's, poles left out."""
    points = []
    for i in range(1, RINGS + 1):
        a = 0.5 * math.pi * i / RINGS
        points.append((WRIST_R * math.sin(a), WRIST_R * math.cos(a)))
    for i in range(RINGS):
        a = 0.5 * math.pi * i / RINGS
        points.append((ELBOW_R * math.cos(a), -LENGTH - ELBOW_R * math.sin(a)))
    return points


def main():
    rings = profile()
    vertices = [(0.0, WRIST_R, 0.0)]
    for radius, y in rings:
        for i in range(SIDES):
            a = 2.0 * math.pi * i / SIDES
            vertices.append((radius * math.sin(a), y, radius * math.cos(a)))
    vertices.append((0.0, -LENGTH - ELBOW_R, 0.0))
    faces = []
    for i in range(SIDES):
        j = (i + 1) % SIDES
        faces.append((1, 2 + i, 2 + j))
        for r in range(len(rings) - 1):
            a, b = 2 + r * SIDES, 2 + (r + 1) * SIDES
            faces += [(a + i, b + i, b + j), (a + i, b + j, a + j)]
        last = 2 + (len(rings) - 1) * SIDES
        faces.append((last + i, len(vertices), last + j))
    folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), "meshes")
    with open(os.path.join(folder, "forearm.obj"), "w", encoding="ascii") as out:
        for v in vertices:
            out.write("v %.7f %.7f %.7f\n" % v)
        for f in faces:
            out.write("f %d %d %d\n" % f)


main()
