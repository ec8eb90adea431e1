#!/usr/bin/env python3
"""Writes meshes/module.obj and meshes/plug.obj of the scenario `two_hands` (metres). Needs Python alone.

Both are touched and seen. tools/mesh_tool.py checks that they are closed, manifold and turned outwards.
"""
import math
import os

SIDES = 64

# The module: a bar along x with a grip at one end and a round socket at the other, mouth at the origin, z out of it.
SOCKET_R = 0.0111 / math.cos(math.pi / SIDES)  # 22.2 mm, nowhere narrower
SOCKET_DEPTH = 0.0255
CHAMFER = 0.0025
HALF_Y = 0.02
BOTTOM = -0.05
GRIP_TOP = 0.045
GRIP = (-0.22, -0.20)
X0, X1 = -0.23, 0.03
SQUARE = 0.02

# The plug: 1.6 mm thinner than the socket, a cone at its tip (origin, z towards the grip), a collar and a grip.
PLUG_R = 0.0103
CONE = (0.006, 0.005)
PLUG_L = 0.028
COLLAR = (0.017, 0.034)
GRIP_HALF = (0.01, 0.015)
GRIP_Z = 0.110


class Mesh:
    def __init__(self):
        self.points, self.index, self.faces = [], {}, []

    def at(self, *p):
        key = tuple(round(c * 1e7) for c in p)
        if key not in self.index:
            self.index[key] = len(self.points)
            self.points.append(p)
        return self.index[key]

    def face(self, *points):
        """A convex polygon, counter-clockwise from outside."""
        ids = [self.at(*p) for p in points]
        for i in range(1, len(ids) - 1):
            self.faces.append((ids[0], ids[i], ids[i + 1]))

    def write(self, name):
        folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), "meshes")
        with open(os.path.join(folder, name), "w", encoding="ascii") as out:
            for p in self.points:
                out.write("v %.7f %.7f %.7f\n" % p)
            for f in self.faces:
                out.write("f %d %d %d\n" % tuple(i + 1 for i in f))


def ring(radius, z):
    return [(radius * math.cos(2 * math.pi * i / SIDES), radius * math.sin(2 * math.pi * i / SIDES), z)
            for i in range(SIDES)]


def wall(mesh, lower, upper):
    """Between two rings, outside is away from the axis."""
    for i in range(SIDES):
        j = (i + 1) % SIDES
        mesh.face(lower[i], lower[j], upper[j], upper[i])


def square_around(mesh, inner, half_x, half_y, z):
    """The face z from a ring to a rectangle, seen from +z."""
    corners = [(half_x, half_y, z), (-half_x, half_y, z), (-half_x, -half_y, z), (half_x, -half_y, z)]
    quarter = SIDES // 4
    for side in range(4):
        for i in range(side * quarter, (side + 1) * quarter):
            mesh.face(inner[i], corners[side], inner[(i + 1) % SIDES])
    for side in range(4):  # between two corners; they meet on the axes
        mesh.face(inner[((side + 1) * quarter) % SIDES], corners[side], corners[(side + 1) % 4])


def module():
    mesh = Mesh()
    cuts = [X0, GRIP[0], GRIP[1], -SQUARE, SQUARE, X1]
    for a, b in zip(cuts, cuts[1:]):
        mesh.face((a, -HALF_Y, BOTTOM), (b, -HALF_Y, BOTTOM), (b, -HALF_Y, 0), (a, -HALF_Y, 0))
        mesh.face((b, HALF_Y, BOTTOM), (a, HALF_Y, BOTTOM), (a, HALF_Y, 0), (b, HALF_Y, 0))
        mesh.face((a, HALF_Y, BOTTOM), (b, HALF_Y, BOTTOM), (b, -HALF_Y, BOTTOM), (a, -HALF_Y, BOTTOM))
        if (a, b) == GRIP:
            mesh.face((a, -HALF_Y, 0), (b, -HALF_Y, 0), (b, -HALF_Y, GRIP_TOP), (a, -HALF_Y, GRIP_TOP))
            mesh.face((b, HALF_Y, 0), (a, HALF_Y, 0), (a, HALF_Y, GRIP_TOP), (b, HALF_Y, GRIP_TOP))
            mesh.face((a, HALF_Y, 0), (a, -HALF_Y, 0), (a, -HALF_Y, GRIP_TOP), (a, HALF_Y, GRIP_TOP))
            mesh.face((b, -HALF_Y, 0), (b, HALF_Y, 0), (b, HALF_Y, GRIP_TOP), (b, -HALF_Y, GRIP_TOP))
            mesh.face((a, -HALF_Y, GRIP_TOP), (b, -HALF_Y, GRIP_TOP), (b, HALF_Y, GRIP_TOP), (a, HALF_Y, GRIP_TOP))
        elif (a, b) != (-SQUARE, SQUARE):
            mesh.face((a, -HALF_Y, 0), (b, -HALF_Y, 0), (b, HALF_Y, 0), (a, HALF_Y, 0))
    mesh.face((X0, HALF_Y, BOTTOM), (X0, -HALF_Y, BOTTOM), (X0, -HALF_Y, 0), (X0, HALF_Y, 0))
    mesh.face((X1, -HALF_Y, BOTTOM), (X1, HALF_Y, BOTTOM), (X1, HALF_Y, 0), (X1, -HALF_Y, 0))
    mouth, below = ring(SOCKET_R + CHAMFER, 0.0), ring(SOCKET_R, -CHAMFER)
    floor = ring(SOCKET_R, -SOCKET_DEPTH)
    square_around(mesh, mouth, SQUARE, HALF_Y, 0.0)
    wall(mesh, mouth, below)  # turned inwards: the axis is outside
    wall(mesh, below, floor)
    mesh.face(*floor)
    mesh.write("module.obj")


def plug():
    mesh = Mesh()
    rings = [ring(CONE[0], 0.0), ring(PLUG_R, CONE[1]), ring(PLUG_R, PLUG_L), ring(COLLAR[0], PLUG_L),
             ring(COLLAR[0], COLLAR[1])]
    mesh.face(*reversed(rings[0]))
    for lower, upper in zip(rings, rings[1:]):
        wall(mesh, lower, upper)
    top = rings[-1]
    x, y = GRIP_HALF
    corners = [(x, y), (-x, y), (-x, -y), (x, -y)]
    z = COLLAR[1]
    quarter = SIDES // 4
    for side in range(4):  # the collar's upper face around the grip
        corner = corners[side] + (z,)
        for i in range(side * quarter, (side + 1) * quarter):
            mesh.face(top[i], top[(i + 1) % SIDES], corner)
        mesh.face(top[((side + 1) * quarter) % SIDES], corners[(side + 1) % 4] + (z,), corner)
    for side in range(4):
        a, b = corners[side], corners[(side + 1) % 4]
        mesh.face(a + (z,), b + (z,), b + (GRIP_Z,), a + (GRIP_Z,))
    mesh.face(*[c + (GRIP_Z,) for c in corners])
    mesh.write("plug.obj")


module()
plug()
