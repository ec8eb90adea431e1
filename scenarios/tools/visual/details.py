"""What several mock-ups are fitted with."""
import math

from visual import materials as m
from visual import pictures, shapes
from visual.shapes import Frame


def screws(model, places, diameter=4.0, frame=None, material=m.SCREW, sides=8):
    frame = frame or Frame()
    for k, (x, y, z) in enumerate(places):
        model.add(material, shapes.screw(diameter, sides), frame.at(x, y, z).turned(37.0 * k))


def blanket(width, height, frame, model, seed, pitch=132.0):
    """Insulation between seams, which pull it in; wrinkles are the renderer's."""
    nx, ny = max(4, round(width / 22)), max(4, round(height / 22))

    def depth(i, j):
        x, y = width * i / nx, height * j / ny
        columns, rows = max(1, round(width / pitch)), max(1, round(height / pitch))
        u = abs(math.sin(math.pi * columns * x / width)) ** 0.5
        v = abs(math.sin(math.pi * rows * y / height)) ** 0.5
        return 7.0 * min(u, v) ** 0.8 + 2.2 * pictures.noise(i, j, seed) * (min(u, v) > 0.2) - 1.0

    rows = []
    for j in range(ny + 1):
        row = []
        for i in range(nx + 1):
            dx = (depth(min(i + 1, nx), j) - depth(max(i - 1, 0), j)) / (2.0 * width / nx)
            dy = (depth(i, min(j + 1, ny)) - depth(i, max(j - 1, 0))) / (2.0 * height / ny)
            row.append(((width * (i / nx - 0.5), height * (j / ny - 0.5), depth(i, j)), shapes.unit((-dx, -dy, 1.0)), None))
        rows.append(row)
    model.add(m.FOIL, shapes.grid(rows), frame)
    # Buttons where seams cross.
    columns, lines = max(1, round(width / pitch)), max(1, round(height / pitch))
    for j in range(1, lines):
        for i in range(1, columns):
            model.add(m.WHITE, shapes.turned([(6.0, -1), (6.0, 0.4), (2, 1.4), (0, 1.4)], 12, 0.2),
                      frame.at(width * (i / columns - 0.5), height * (j / lines - 0.5), 0))


def bundle(model, points, count=5, radius=1.7, clamps=(), ties=(), material=m.CABLE, steps=4):
    """A harness that lies on the face; clamps and ties at shares of its way."""
    path = shapes.smooth_path(points, steps)
    spread = radius / math.sin(math.pi / count) if count > 2 else (radius if count == 2 else 0.0)
    frames = []
    for i, p in enumerate(path):
        t = shapes.unit(shapes.sub(path[min(i + 1, len(path) - 1)], path[max(i - 1, 0)]))
        side = shapes.unit(shapes.cross((0, 0, 1), t)) if abs(t[2]) < 0.95 else (1.0, 0.0, 0.0)
        frames.append((p, t, side, shapes.cross(t, side)))
    for k in range(count):
        strand = []
        for i, (p, t, side, up) in enumerate(frames):
            angle = 2.0 * math.pi * k / count + 0.24 * i
            strand.append(shapes.add(p, shapes.add(shapes.scale(spread * math.cos(angle), side),
                                                   shapes.scale(spread * math.sin(angle), up))))
        model.add((material, m.CABLE, m.CABLE_GREY, m.CABLE, m.CABLE_BLUE)[k % 5], shapes.tube(strand, radius, 5))
    whole = spread + radius
    for share in ties:
        p, t, side, up = frames[round(share * (len(frames) - 1))]
        ring = [(whole - 0.3, -1.4), (whole + 0.5, -1.4), (whole + 0.5, 1.4), (whole - 0.3, 1.4)]
        model.add(m.RUBBER, shapes.turned(ring, 10, 0.0), shapes.facing(p, t))
        model.add(m.RUBBER, shapes.box((3, 3, 2.4), 0, 0.3), shapes.facing(shapes.add(p, shapes.scale(whole, up)), up, side))
    for share in clamps:
        p, t, side, up = frames[round(share * (len(frames) - 1))]
        ring = [(whole, -3.5), (whole + 0.8, -3.5), (whole + 0.8, 3.5), (whole, 3.5)]
        model.add(m.WHITE, shapes.turned(ring, 12, 0.0), shapes.facing(p, t))
        foot = shapes.facing((p[0], p[1], 0.0), (0, 0, 1), side).at(whole + 4.0, 0, 0)
        model.add(m.WHITE, shapes.box((9, 7, 1.4), 0, 0.3, bottom=False), foot)
        model.add(m.SCREW, shapes.screw(3.5), foot.at(0.8, 0, 1.4))


def plug(model, frame, radius=7.0, length=22.0):
    """A round connector with its nut and backshell; the cable leaves along z."""
    model.add(m.NICKEL, shapes.turned([(radius + 2.5, 0), (radius + 2.5, 2), (radius - 0.4, 2)], 16, 0.3), frame)
    knurl = []
    for k in range(28):
        angle = 2.0 * math.pi * k / 28
        r = radius + (0.5 if k % 2 else -0.1)
        c, s = math.cos(angle), math.sin(angle)
        knurl.append(((r * c, r * s), (c, s)))
    model.add(m.NICKEL, shapes.extruded([knurl], 2, 10, 0.4, bottom=False), frame)
    model.add(m.ALODINE, shapes.turned([(radius - 1, 10), (radius - 1, 15), (radius - 3, length - 2), (radius - 3, length),
                                        (0, length)], 16, 0.4), frame)


def thruster(model, frame):
    """On a plate; z: the way of its plume."""
    model.add(m.WHITE, shapes.box((58, 58, 8), -2, 0.8, bottom=False), frame)
    screws(model, [(x, y, 6) for x in (-23, 23) for y in (-23, 23)], 4.5, frame)
    model.add(m.ALODINE, shapes.turned([(14, 6), (14, 16), (9, 19), (9, 26), (0, 26)], 20, 0.6), frame)
    model.add(m.NOZZLE, shapes.revolve(shapes.smooth([(6.0, 24), (5.2, 30), (8.5, 38), (13.0, 48), (17.5, 62), (20.0, 74)]), 20), frame)
    model.add(m.NOZZLE, shapes.turned([(20.0, 74), (19.2, 74.2)], 20), frame)
    model.add(m.NOZZLE, shapes.revolve(shapes.smooth([(19.2, 74.2), (16.6, 62), (12.2, 48), (7.6, 38), (4.0, 31), (0.0, 30)]), 20), frame)
    for s in (-1, 1):
        model.add(m.STEEL, shapes.turned([(4.5, 6), (4.5, 22), (3, 24), (0, 24)], 10, 0.3), frame.at(s * 20, 0, 0))
        model.add(m.STEEL, shapes.tube(shapes.smooth_path([(s * 20, 0, 20), (s * 17, 6, 28), (s * 11, 4, 27), (s * 8, 0, 24)], 3),
                                       1.2, 6), frame)


def handrail(model, a, b, height=42.0):
    """Along the face, from a to b."""
    way = shapes.sub(b, a)
    length = math.sqrt(shapes.dot(way, way))
    along = shapes.unit(way)
    frame = Frame(a, along, shapes.cross((0, 0, 1), along))
    path = [(0, 0, height), (length, 0, height)]
    outline = [((8 * math.cos(t), 5 * math.sin(t)), shapes.unit((math.cos(t) / 8, math.sin(t) / 5, 0))[:2])
               for t in (2 * math.pi * k / 18 for k in range(18))]
    model.add(m.GOLD_RAIL, shapes.extruded([outline], 0, length, 0.6),
              Frame(frame.point(path[0]), frame.y, (0, 0, 1)))
    for x in (24.0, length / 2, length - 24.0) if length > 260 else (24.0, length - 24.0):
        model.add(m.ALUMINIUM, shapes.profiled((20, 12), [(4, 0), (4, 4), (0, 9), (-2, height - 6), (1, height + 1)], 0.4, 0.4, end=True),
                  frame.at(x, 0, 0))
        screws(model, [(-10.5, 0, 4), (10.5, 0, 4)], 3.5, frame.at(x, 0, 0))


def frame_and_blankets(model, width, height, depth, frame, seed=40):
    """A body below z = 0: profiles at its corners, insulation between them, its underside."""
    for sx in (-1, 1):
        for sy in (-1, 1):
            model.add(m.GREY, shapes.box((24, 24, depth - 10), -depth, 0.8), frame.at(sx * (width / 2 - 12), sy * (height / 2 - 12), 0))
    for k in range(4):
        along, out = (width, height / 2) if k % 2 == 0 else (height, width / 2)
        side = frame.turned(90 * k)
        wall = Frame(side.point((0, -out + 9, -5 - depth / 2)), side.x, side.z)
        blanket(along - 50, depth - 12, wall, model, seed + k, 150.0)
    under = frame.at(0, 0, -depth + 6)
    model.add(m.FOIL, shapes.decal(width - 20, height - 20), Frame(under.origin, under.x, shapes.scale(-1.0, under.y)))
