"""How the parts of `module_replacement` look, millimetres: finer than the collision meshes of module_replacement.scad, whose
sizes these are. Where a hand touches, both surfaces agree within 0.2 mm (visual_meshes_test)."""
import math

from visual import details, pictures, shapes
from visual import materials as m
from visual.model import Material, Model
from visual.shapes import Frame, facing

BEVEL = 0.4  # a rounded edge lies 0.41 of it inside the sharp one

# Of module_replacement.scad.
MODULE, MODULE_DEPTH, REAR_CHAMFER = 80, 100, 3
CAVITY, FLANGE, FLANGE_H, ENTRY, FLOOR = 81.6, 106, 4, 4, -100.5
BOSS_R, BOSS_H, SOCKET_R, SOCKET_DEPTH, SOCKET_CHAMFER = 21, 15, 11.106, 25.5, 2.5
BODY, FACE_T, OPENING, CAVITIES = (800, 600, 300), 12, 104, [(0, 0), (0, 190)]
POSTS, POST_H = [(165, 76), (165, -76), (40, 76), (40, -76), (-88, 76), (-88, -76)], 48
COVER_POST, COVER_POST_H = (340, 190), 60


def module():
    model = Model()
    sheet = pictures.Sheet(512, 512, 3.2)
    label = m.labels(sheet)
    model.add(m.ALUMINIUM, shapes.profiled((MODULE, MODULE), [(-REAR_CHAMFER, -MODULE_DEPTH), (0, REAR_CHAMFER - MODULE_DEPTH),
                                                             (0, 0)], BEVEL, BEVEL, start=False))
    top = shapes.rounded(shapes.rectangle(MODULE - 2 * BEVEL, MODULE - 2 * BEVEL), 0.0)
    model.add(m.ALUMINIUM, shapes.cap([[p for p, _ in top[::2]], [p for p, _ in shapes.hole(shapes.circle(BOSS_R, 64))]], 0, True))
    socket = [(BOSS_R, 0.0), (BOSS_R, BOSS_H - 1), (BOSS_R - 1, BOSS_H), (SOCKET_R + SOCKET_CHAMFER, BOSS_H),
              (SOCKET_R, BOSS_H - SOCKET_CHAMFER), (SOCKET_R, BOSS_H - SOCKET_DEPTH), (0.0, BOSS_H - SOCKET_DEPTH)]
    radii = [0, 0.3, 0.3, 0.3, 0.3, 0, 0]
    model.add(m.ORANGE, shapes.revolve(shapes.rounded(socket[:5], radii[:5], closes=False), 64))
    model.add(m.STEEL, shapes.revolve(shapes.rounded(socket[4:], [0, 0, 0], closes=False), 48))
    # The front plate: bars of colour, screws, plates with names.
    details.screws(model, [(x, y, 0) for x in (-35, 35) for y in (-35, 35)], 3.2)
    for s in (-1, 1):
        model.add(BLUE, shapes.box((9, 52, 1.0), 0, 0.35, bottom=False), Frame((s * 33, 0, 0)))
    model.add(label, shapes.decal(44, 9, sheet.plate(44, 9, [("PCM-2", 0.62)], ground=(0.08, 0.10, 0.16), ink=(0.9, 0.9, 0.9))),
              Frame((0, 30, 0.05)))
    model.add(label, shapes.decal(44, 9, sheet.plate(44, 9, [("28 V 120 W", 0.56)])), Frame((0, -30, 0.05)))
    # The sides, seen once the module is out.
    side = sheet.plate(62, 26, [("POWER CONTROL", 0.20), ("MODULE PCM-2", 0.20), ("SN 0017  MASS 1.7 KG", 0.13)])
    bars = sheet.barcode(30, 14, "0017-2014")
    arrows = sheet.plate(70, 7, [("INSERT THIS END  > > >", 0.55)], ground=(0.72, 0.10, 0.04), ink=(0.95, 0.95, 0.95), frame=False)
    pins = connector_face(sheet)
    for k in range(4):
        wall = Frame((0, 0, 0)).turned(90 * k)
        front = Frame(wall.point((0, -MODULE / 2 - 0.05, 0)), wall.x, (0, 0, 1))
        if k % 2 == 0:
            model.add(label, shapes.decal(62, 26, side), front.at(0, -28, 0))
        else:
            model.add(label, shapes.decal(30, 14, bars), front.at(-16, -24, 0))
        model.add(label, shapes.decal(70, 7, arrows), front.at(0, -84, 0))
    model.add(label, shapes.decal(60, 40, pins), facing((0, 0, -MODULE_DEPTH - 0.05), (0, 0, -1)))
    return model


BLUE = Material("blue", (0.03, 0.10, 0.36), 0.1, 0.42)


def connector_face(sheet):
    """The rear: a connector's face, painted."""
    x, y, w, h, box = sheet.place(60, 40)
    p, s = sheet.picture, sheet.scale
    p.fill(x, y, x + w, y + h, (0.55, 0.55, 0.53))
    p.fill(x + 4 * s, y + 6 * s, x + w - 4 * s, y + h - 6 * s, (0.10, 0.10, 0.11))
    for j in range(5):
        for i in range(16 - j % 2):
            cx, cy = x + (8 + 2.95 * (i + 0.5 * (j % 2))) * s, y + (11 + 4.5 * j) * s
            p.stroke([(cx, cy)], 1.7 * s, (0.86, 0.70, 0.32))
    return box


def handle():
    model = Model()
    sheet = pictures.Sheet(128, 256, 6.0)
    label = m.labels(sheet)
    line = [(0, 0), (6, 0), (10.3, 5), (10.3, 28), (17, 28), (17, 34), (8, 34), (8, 60.0)]
    model.add(m.STEEL, shapes.turned(line, 64, 0.35))
    model.add(m.YELLOW, shapes.profiled((20, 30), [(-2, 60), (0, 62), (0, 108), (-2, 110)], 0.4, BEVEL, start=False, end=True))
    # Ribs for the fingers, the tool's name, and screws of the shells.
    for s in (-1, 1):
        wall = facing((s * 10.03, 0, 84), (s, 0, 0), (0, 1, 0))
        model.add(RIBBED, shapes.decal(24, 36, (0, 0, 24 / 3.0, 36 / 3.0)), wall)
    name = sheet.plate(15, 34, [], frame=False, ground=(0.05, 0.05, 0.05))
    x, y = int(name[0] * 128), int(name[1] * 256)
    for k, text in enumerate(("HANDLE", "TOOL", "HT-1")):
        sheet.picture.text(x + 7.5 * 6, y + (10 + 9 * k) * 6, 14, text, (0.93, 0.70, 0.05), align="middle")
    for s in (-1, 1):
        wall = facing((0, s * 15.04, 85), (0, s, 0))
        model.add(label, shapes.decal(15, 34, name), wall)
    return model


RIBBED = Material("ribs", (0.05, 0.05, 0.05), 0.0, 0.62, normal=pictures.ribs())


def cover_tabbed():
    model = Model()
    sheet = pictures.Sheet(256, 256, 6.0)
    label = m.labels(sheet)
    model.add(m.TAPE, shapes.box((44, 44, 2.0), 2.5, BEVEL))
    model.add(m.CLOTH_RED, shapes.profiled((6, 30), [(0, 4.5), (0, 29.5), (-1.5, 31)], 0.4, BEVEL, end=True))
    remove = sheet.plate(24, 14, [("LIFT", 0.5)], ground=(0.93, 0.93, 0.90), ink=(0.6, 0.04, 0.03))
    for s in (-1, 1):
        wall = facing((s * 3.04, 0, 16), (s, 0, 0), (0, s, 0))
        model.add(label, shapes.decal(24, 14, remove), wall)
    warning = sheet.plate(17, 38, [], frame=True)
    x, y = int(warning[0] * 256), int(warning[1] * 256)
    for k, text in enumerate(("MLI", "COVER", "BAY A")):
        sheet.picture.text(x + 8.5 * 6, y + (12 + 10 * k) * 6, 15, text, (0.06, 0.06, 0.06), align="middle")
    for s in (-1, 1):
        model.add(label, shapes.decal(17, 38, warning), Frame((s * 12.5, 0, 4.55)))
    return model


def lever():
    model = Model()
    ring = []  # a stadium in the plane of y and z, about the hinge
    for z, first in ((0.0, math.pi), (28.0, 0.0)):
        for k in range(17):
            angle = first + math.pi * k / 16.0
            n = (math.cos(angle), math.sin(angle))
            ring.append(((6 * n[0], z + 6 * n[1]), n))
    across = Frame((0, 0, 0), (0, 1, 0), (0, 0, 1))
    model.add(WHITE_LEVER, shapes.extruded([ring], -4, 4, 0.4), across)
    return model


WHITE_LEVER = Material("lever", (0.78, 0.78, 0.76), 0.0, 0.32)


def switch_base():
    model = Model()
    sheet = pictures.Sheet(256, 256, 6.0)
    label = m.labels(sheet)
    outer = shapes.rounded(shapes.rectangle(34, 50), BEVEL)
    slot = shapes.hole(shapes.rounded(shapes.rectangle(12, 38), BEVEL))
    model.add(m.BLACK, shapes.extruded([outer, slot], 0, 9, BEVEL, bottom=False, bottom_bevel=0.0))
    for y, text, ground in ((-22, "ON", (0.05, 0.32, 0.10)), (22, "OFF", (0.50, 0.04, 0.03))):
        box = sheet.plate(12, 5, [(text, 0.62)], ground=ground, ink=(0.95, 0.95, 0.95), frame=False)
        model.add(label, shapes.decal(12, 5, box), Frame((0, y, 9.05)))
    box = sheet.plate(9.5, 26, [], ground=(0.035, 0.035, 0.04), frame=False)
    x, y = int(box[0] * 256), int(box[1] * 256)
    for k, text in enumerate("BAY A"):
        sheet.picture.text(x + 4.75 * 6, y + (6.4 + 4.4 * k) * 6, 17, text, (0.9, 0.9, 0.9), align="middle")
    model.add(label, shapes.decal(9.5, 26, box), Frame((-11.6, 0, 9.05)))
    details.screws(model, [(x, y, 9) for x in (-12.8, 12.8) for y in (-21.5, 21.5)], 3.0)
    # The pivot.
    pin = facing((-7, 0, 6), (1, 0, 0))
    model.add(m.STEEL, shapes.turned([(0, 0), (1.8, 0), (1.8, 14), (0, 14)], 12), pin)
    return model


def lamp():
    model = Model()
    model.add(m.NICKEL, shapes.turned([(0, 0), (11, 0), (11, 3), (8.9, 3), (8.9, 1.5), (0, 1.5)], 40, 0.5))
    dome = []
    for k in range(9):
        angle = 0.5 * math.pi * k / 8.0
        c, s = math.cos(angle), math.sin(angle)
        n = math.hypot(c, s / 0.8)
        dome.append(((8.5 * c, 2 + 6.8 * s), (c / n, s / 0.8 / n)))
    model.add(LENS, shapes.revolve([((8.5, 1.5), (1.0, 0.0))] + dome, 32))
    return model


LENS = Material("lens", (0.6, 0.6, 0.6), 0.0, 0.25)


def holder():
    model = Model()
    sheet = pictures.Sheet(256, 64, 5.0)
    label = m.labels(sheet)
    outer = shapes.rounded(shapes.rectangle(50, 50), BEVEL)
    model.add(m.GREY, shapes.extruded([outer, shapes.hole(shapes.circle(17.0, 48))], 0, 24, BEVEL, bottom=False, bottom_bevel=0.0,
                                      top=False).join(_rim(outer, 17.0)))
    bore = [(17.0, 24), (16.5, 24), (13.5, 21), (13.5, 4), (0, 4)]
    model.add(m.ALUMINIUM, shapes.revolve(shapes.rounded(bore, [0, 0.3, 0.3, 0, 0], closes=False), 48))
    details.screws(model, [(x, y, 24) for x in (-20, 20) for y in (-20, 20)], 4.0)
    box = sheet.plate(40, 9, [("HANDLE TOOL", 0.5)], ground=(0.85, 0.60, 0.04))
    model.add(label, shapes.decal(40, 9, box), facing((0, -25.05, 12), (0, -1, 0)))
    return model


def _rim(outer, radius):
    points = [p for p in shapes._inset(outer, BEVEL)]
    return shapes.cap([points, [p for p, _ in shapes.hole(shapes.circle(radius, 48))]], 24, True)


def bracket():
    """For the removed unit, and as a variant for the spare one."""
    model = Model()
    label, box, stripes = bracket_labels("REMOVED UNIT", (0.45, 0.03, 0.03))
    spare, _, _ = bracket_labels("SPARE UNIT", (0.02, 0.24, 0.10))
    material = m.RED
    model.variants["spare_unit"] = {material.name: m.GREEN, label.name: spare}
    outer = shapes.rounded(shapes.rectangle(116, 116), BEVEL)
    inner = shapes.hole(shapes.rounded(shapes.rectangle(60, 60), BEVEL))
    model.add(material, shapes.extruded([outer, inner], 0, 12, BEVEL, bottom=False, bottom_bevel=0.0))
    details.screws(model, [(x, y, 12) for x in (-50, 50) for y in (-50, 0, 50)], 4.0)
    model.add(label, shapes.decal(56, 12, box), Frame((0, -44, 12.05)))
    model.add(label, shapes.decal(60, 5, stripes), Frame((0, 34, 12.05)))
    for s in (-1, 1):
        model.add(label, shapes.decal(60, 5, stripes), Frame((s * 34, 0, 12.05)).turned(90))
    return model


def bracket_labels(text, ground):
    sheet = pictures.Sheet(256, 128, 3.5)
    box = sheet.plate(56, 12, [(text, 0.55)], ground=ground, ink=(0.95, 0.95, 0.95))
    return m.labels(sheet), box, sheet.hazard(60, 5, 6.0, (0.88, 0.88, 0.86), ground)


def cavity():
    model = Model()
    sheet = pictures.Sheet(512, 128, 4.0)
    label = m.labels(sheet)
    outer = shapes.rounded(shapes.rectangle(FLANGE, FLANGE), BEVEL)
    inner = shapes.hole(shapes.rounded(shapes.rectangle(CAVITY + 2 * ENTRY + 0.6, CAVITY + 2 * ENTRY + 0.6), BEVEL))
    model.add(m.GREY, shapes.extruded([outer, inner], 0, FLANGE_H, BEVEL, bottom=False, bottom_bevel=0.0, top=False))
    model.add(m.GREY, shapes.cap([shapes._inset(outer, BEVEL), [p for p, _ in shapes.hole(shapes.rounded(
        shapes.rectangle(CAVITY + 2 * ENTRY + 1, CAVITY + 2 * ENTRY + 1), 0.0))][::2]], FLANGE_H, True))
    model.add(m.ALUMINIUM, shapes.profiled((CAVITY, CAVITY), [(ENTRY + 0.5, FLANGE_H), (ENTRY, FLANGE_H), (0, 0), (0, FLOOR)],
                                           0.3, BEVEL, end=True))
    stripes = sheet.hazard(88, 5.4, 7.0)
    for k in range(4):
        model.add(label, shapes.decal(88, 5.4, stripes), Frame().turned(90 * k).at(0, -48.9, FLANGE_H + 0.05))
    details.screws(model, [(x, y, FLANGE_H) for x in (-48.5, 48.5) for y in (-48.5, 48.5)], 3.5)
    model.add(label, shapes.decal(60, 40, connector_face_wide(sheet)), Frame((0, 0, FLOOR + 0.05)))
    return model


def connector_face_wide(sheet):
    x, y, w, h, box = sheet.place(60, 20)
    p, s = sheet.picture, sheet.scale
    p.fill(x, y, x + w, y + h, (0.06, 0.06, 0.065))
    for j in range(3):
        for i in range(16):
            p.stroke([(x + (6 + 3.2 * i) * s, y + (5 + 5 * j) * s)], 1.6 * s, (0.75, 0.60, 0.25))
    return box


# --- Satellite ---------------------------------------------------------------------------------------------------

# What stands on the face for good: place, size, height.
STANDING = [(x, y, 12, 12, POST_H) for x, y in POSTS] + [(x, y, FLANGE, FLANGE, FLANGE_H) for x, y in CAVITIES] + [
    (*COVER_POST, 18, 18, COVER_POST_H), (-220, 120, 116, 116, 12), (-220, -120, 116, 116, 12), (260, -120, 50, 50, 24),
    (115, 0, 34, 50, 9), (75, 60, 20, 20, 5), (75, 190, 20, 20, 5), (-354, 20, 52, 130, 31), (354, 250, 54, 54, 10),
    (-16, -252, 22, 14, 40), (126, -252, 22, 14, 40), (55, -252, 176, 12, 8), (384, 84, 12, 22, 34), (384, 126, 12, 22, 34)]


def face_map(width=512, height=384, step=2):
    """Of the face plate: how much of the sky each place sees, roughness with the marks of brush and hands, metal."""
    scale = width / BODY[0]
    w, h = width // step, height // step
    heights = [[0.0] * w for _ in range(h)]
    near = [[False] * w for _ in range(h)]
    for x, y, sx, sy, top in STANDING:
        left, right = (x - sx / 2 + BODY[0] / 2) * scale / step, (x + sx / 2 + BODY[0] / 2) * scale / step
        low, high = (BODY[1] / 2 - y - sy / 2) * scale / step, (BODY[1] / 2 - y + sy / 2) * scale / step
        reach = min(2.0 * top, 90.0) * scale / step
        for j in range(max(0, int(low - reach)), min(h, int(high + reach) + 1)):
            for i in range(max(0, int(left - reach)), min(w, int(right + reach) + 1)):
                near[j][i] = True
                if left <= i + 0.5 <= right and low <= j + 0.5 <= high:
                    heights[j][i] = max(heights[j][i], float(top))
    ways = [(math.cos(2 * math.pi * k / 12), math.sin(2 * math.pi * k / 12)) for k in range(12)]
    pixel = step / scale  # mm
    seen = [[1.0] * w for _ in range(h)]
    for j in range(h):
        for i in range(w):
            if not near[j][i]:
                continue
            lost = 0.0
            for c, s in ways:
                steepest = 0.0
                for far in (1.0, 2.0, 3.2, 5.0, 8.0, 12.5, 20.0, 30.0):
                    x, y = int(i + 0.5 + far * c), int(j + 0.5 + far * s)
                    if 0 <= x < w and 0 <= y < h and heights[y][x] > 0.0:
                        steepest = max(steepest, heights[y][x] / (far * pixel))
                lost += steepest * steepest / (1.0 + steepest * steepest)
            seen[j][i] = 1.0 - lost / len(ways)
    picture = pictures.Picture(width, height)
    for j in range(height):
        for i in range(width):
            x, y = min(max((i + 0.5) / step - 0.5, 0.0), w - 1.001), min(max((j + 0.5) / step - 0.5, 0.0), h - 1.001)
            a, b = int(x), int(y)
            u, v = x - a, y - b
            open_sky = (seen[b][a] * (1 - u) + seen[b][a + 1] * u) * (1 - v) + (seen[b + 1][a] * (1 - u) + seen[b + 1][a + 1] * u) * v
            grain = 0.30 * pictures.noise(i // 24, j, 31) + 0.25 * pictures.smooth_noise(i / 48.0, j, 99, 999, 33)
            marks = 0.30 * pictures.smooth_noise(i / 40.0, j / 40.0, 99, 99, 35) + 0.2 * pictures.smooth_noise(i / 11.0, j / 11.0, 99, 99, 37)
            picture.rows[j][i] = (pictures.quantized(max(open_sky, 0.12) ** 1.2), pictures.quantized(0.50 + 0.42 * grain + 0.62 * marks, 24), 1.0)
    return picture


def satellite():
    model = Model()
    sheet = pictures.Sheet(512, 512, 2.6)
    label = m.labels(sheet)
    half_x, half_y, depth = BODY[0] / 2, BODY[1] / 2, BODY[2]

    # The face plate, and what holds it: profiles at the corners, rails below, insulation between them.
    outlines = [shapes.rounded(shapes.rectangle(BODY[0], BODY[1]), BEVEL)]
    outlines += [shapes.hole(shapes.rounded(shapes.rectangle(OPENING, OPENING, x, y), BEVEL)) for x, y in CAVITIES]
    plate = shapes.extruded(outlines, -FACE_T, 0, BEVEL, bottom=False, bottom_bevel=0.0)
    plate.vertices = [(p, n, ((p[0] + half_x) / BODY[0], (half_y - p[1]) / BODY[1])) for p, n, _ in plate.vertices]
    model.add(Material("face", (0.50, 0.51, 0.53), 0.92, 0.52, surface=face_map(), occludes=True), plate)
    for sx in (-1, 1):
        for sy in (-1, 1):
            model.add(m.GREY, shapes.box((26, 26, depth - FACE_T), -depth, 0.8), Frame((sx * (half_x - 13), sy * (half_y - 13), 0)))
    for s in (-1, 1):
        model.add(m.GREY, shapes.box((BODY[0] - 52, 22, 22), -depth, 0.8), Frame((0, s * (half_y - 11), 0)))
        model.add(m.GREY, shapes.box((22, BODY[1] - 52, 22), -depth, 0.8), Frame((s * (half_x - 11), 0, 0)))
        model.add(m.GREY, shapes.box((BODY[0] - 52, 10, 16), -FACE_T - 16, 0.6), Frame((0, s * (half_y - 5), 0)))
        model.add(m.GREY, shapes.box((10, BODY[1] - 52, 16), -FACE_T - 16, 0.6), Frame((s * (half_x - 5), 0, 0)))
    middle, high = -FACE_T - 16 - (depth - FACE_T - 38) / 2, depth - FACE_T - 38
    for k, (width, out) in enumerate(((BODY[0], half_y), (BODY[1], half_x), (BODY[0], half_y), (BODY[1], half_x))):
        side = Frame().turned(90 * k)
        wall = Frame(side.point((0, -out + 10, middle)), side.x, (0, 0, 1))
        details.blanket(width - 54, high + 4, wall, model, 20 + k)
        # Screws along the profiles, tape along the edges of the insulation.
        details.screws(model, [(x, middle + y, 0) for x in (-(width / 2 - 13), width / 2 - 13) for y in (-90, 0, 90)], 6,
               Frame(side.point((0, -out, 0)), side.x, (0, 0, 1)))
        for y in (-(high / 2 - 4), high / 2 - 4):
            model.add(m.TAPE, shapes.box((width - 56, 14, 0.6), 3.6, 0.2, bottom=False), wall.at(0, y, 0))
    model.add(m.FOIL, shapes.decal(BODY[0] - 20, BODY[1] - 20), facing((0, 0, -depth + 8), (0, 0, -1)))

    # Hook-and-loop posts and the place for the cover.
    for x, y in POSTS:
        model.add(m.ALUMINIUM, shapes.box((12, 12, 34), 0, 0.4, bottom=False, top=False), Frame((x, y, 0)))
        model.add(m.LOOP, shapes.profiled((12, 12), [(0, 34), (0, POST_H)], 0.4, 0.4, end=True), Frame((x, y, 0)))
        for s in (-1, 1):
            model.add(m.ALUMINIUM, shapes.box((7, 12, 1.6), 0, 0.3, bottom=False), Frame((x + s * 9.5, y, 0)))
            details.screws(model, [(x + s * 9.8, y, 1.6)], 2.6, sides=8)
    x, y = COVER_POST
    model.add(m.GREY, shapes.box((18, 18, COVER_POST_H - 6), 0, 0.4, bottom=False), Frame((x, y, 0)))
    model.add(m.BLACK, shapes.box((32, 32, 6), COVER_POST_H - 6, 0.4), Frame((x, y, 0)))

    # Panels of the face: joints, screws along them.
    for (x, y), (w, h) in (((-308, 0), (0.9, 596)), ((304, 0), (0.9, 596)), ((-2, -198), (611, 0.9))):
        model.add(m.DARK, shapes.decal(w, h), Frame((x, y, 0.04)))
    places = [(x, y, 0) for x in range(-285, 300, 95) for y in (-286, 286)]
    places += [(s, y, 0) for s in (-316, -300, 296, 312) for y in range(-252, 260, 84)]
    places += [(x, y, 0) for x in range(-246, 290, 98) for y in (-206, -190)]
    details.screws(model, [p for p in places if not (p[0] > 270 and 170 < p[1] < 210)], 4.2)

    # Left: a painted panel with the harness's box. Right: mirrors that radiate heat.
    model.add(m.WHITE, shapes.box((68, 560, 1.2), 0, 0.4, bottom=False), Frame((-354, 0, 0)))
    box = Frame((-354, 20, 1.2))
    model.add(m.BLACK, shapes.box((52, 130, 30), 0, 0.8, bottom=False), box)
    details.screws(model, [(x, y, 30) for x in (-21, 21) for y in (-59, 0, 59)], 4, box)
    model.add(label, shapes.decal(38, 40, sheet.plate(38, 40, [("J-BOX", 0.2), ("28 V BUS", 0.14), ("A 3 2 1", 0.14)])), box.at(0, 28, 30.05))
    model.add(label, shapes.decal(36, 12, sheet.barcode(36, 12, "SV-4401")), box.at(0, -30, 30.05))
    for j in range(8):
        for i in range(3):
            model.add(m.MIRROR, shapes.box((24.2, 24.2, 0.5), 0, 0.2, bottom=False), Frame((327 + 25 * i, -150 + 25 * j, 0)))

    # The harness: from the box to the bays, the switch and the lamps.
    for y in (-25, 5, 35, 65):
        details.plug(model, facing((-328, y, 17), (1, 0, 0)), 6.5 if y != 5 else 8.0)
    details.bundle(model, [(-307, 5, 17), (-296, 5, 15), (-280, 8, 7), (-240, 10, 6), (-180, 8, 6), (-130, 6, 6), (-105, 2, 6), (-84, 0, 7),
                   (-66, 0, 9), (-52, 0, 9)], 6, 1.8, (0.38, 0.58, 0.78), (0.3, 0.48, 0.68, 0.88))
    details.bundle(model, [(-307, 35, 17), (-296, 35, 14), (-288, 32, 8), (-268, 24, 5), (-180, 24, 5), (-132, 26, 5), (-112, 44, 5),
                   (-108, 90, 5), (-108, 150, 5), (-98, 182, 6), (-78, 190, 8), (-52, 190, 9)], 4, 1.7, (0.46, 0.64, 0.82), (0.4, 0.56, 0.73))
    details.bundle(model, [(-307, -25, 17), (-296, -25, 14), (-288, -22, 8), (-272, -30, 4), (-140, -34, 4), (-90, -60, 4), (-70, -100, 4),
                   (-40, -116, 4), (60, -116, 4), (100, -110, 4), (113, -80, 4), (115, -48, 4), (115, -25, 5)], 3, 1.7,
           (0.3, 0.5, 0.66, 0.83), (0.25, 0.42, 0.6, 0.75))
    details.bundle(model, [(-307, 65, 17), (-296, 65, 12), (-290, 60, 6), (-282, 50, 4), (-150, 46, 4), (-124, 60, 4), (-122, 200, 4),
                   (-116, 244, 4), (-60, 253, 4), (60, 253, 4), (76, 244, 4), (75, 202, 4)], 2, 1.5, (0.3, 0.55, 0.7, 0.88), (0.45, 0.62, 0.8))
    details.bundle(model, [(75, 50, 3), (78, 38, 3), (92, 32, 3), (104, 26, 4), (110, 24, 5)], 2, 1.4)
    for y in (0, 190):
        details.plug(model, facing((-52, y, 9), (-1, 0, 0)), 6.0, 20)

    # Names, warnings, and squares that cameras find.
    for x, y, w, h, text, ground, ink in (
            (0, -70, 62, 12, "BAY A", (0.10, 0.12, 0.16), (0.92, 0.92, 0.92)),
            (20, 266, 62, 12, "BAY B", (0.10, 0.12, 0.16), (0.92, 0.92, 0.92)),
            (260, -160, 60, 10, "TOOL HT-1", (0.86, 0.86, 0.84), (0.05, 0.05, 0.06)),
            (-220, 196, 84, 12, "STOW OLD UNIT", (0.86, 0.86, 0.84), (0.50, 0.04, 0.03)),
            (350, 164, 60, 10, "STOW COVER", (0.86, 0.86, 0.84), (0.05, 0.05, 0.06)),
            (340, -182, 60, 10, "OSR - NO TOUCH", (0.88, 0.66, 0.03), (0.05, 0.05, 0.05))):
        model.add(label, shapes.decal(w, h, sheet.plate(w, h, [(text, 0.56)], ink, ground)), Frame((x, y, 0.06)))
    name = sheet.plate(150, 26, [("VR-OOS MOCK-UP 01", 0.46)], (0.04, 0.06, 0.10), (0.86, 0.86, 0.84), frame=False)
    model.add(label, shapes.decal(150, 26, name), Frame((-160, -246, 0.06)))
    panel = sheet.plate(74, 30, [("SERVICE PANEL 2", 0.2), ("TORQUE 2.5 NM", 0.16), ("SEQUENCE 1-44", 0.16)])
    model.add(label, shapes.decal(74, 30, panel), Frame((190, -250, 0.06)))
    for x, y, code in ((-270, 262, 0x53A9), (262, 262, 0x96C5), (262, -246, 0x3B5C), (-270, -246, 0xA36D), (70, -70, 0x5AC9)):
        side = 30 if code != 0x5AC9 else 20
        model.add(label, shapes.decal(side, side, sheet.marker(30, code)), Frame((x, y, 0.06)))
    stripes = sheet.hazard(120, 7, 9)
    for x in (-354,):
        for y in (-140, 150):
            model.add(label, shapes.decal(64, 7, (stripes[0], stripes[1], stripes[0] + 0.53 * (stripes[2] - stripes[0]), stripes[3])),
                      Frame((x, y, 1.3)))
    model.add(label, shapes.decal(56, 24, sheet.plate(56, 24, [("RADIATOR", 0.22), ("KEEP CLEAN", 0.18)], (0.5, 0.04, 0.03))),
              Frame((-354, -200, 1.3)))

    # Outside: rails for hands, thrusters, an antenna.
    details.handrail(model, (-40, -252, 0), (150, -252, 0))
    details.handrail(model, (384, 60, 0), (384, 150, 0), 36)
    for x, y in ((half_x, -210), (half_x, 210), (-half_x, -210), (-half_x, 210)):
        details.thruster(model, facing((x - 4, y, -80), (1 if x > 0 else -1, 0, 0.25), (0, 1, 0)))
    for x in (-250, 250):
        details.thruster(model, facing((x, -half_y + 4, -80), (0, -1, 0.25)))
    dish = Frame((half_x - 46, half_y - 50, 0))
    model.add(m.WHITE, shapes.box((54, 54, 10), 0, 0.8, bottom=False), dish)
    model.add(m.GOLD, shapes.box((34, 34, 1.5), 10, 0.3, bottom=False), dish)
    model.add(m.STEEL, shapes.turned([(2, 11), (2, 14), (0, 14)], 10, 0.2), dish.at(6, 0, 0))
    details.screws(model, [(x, y, 10) for x in (-22, 22) for y in (-22, 22)], 3.5, dish, sides=8)
    return model


def solar_wing():
    """Two panels on a yoke that leaves the satellite's side at negative x, turned to the sun."""
    model = Model()
    model.add(m.BLACK, shapes.box((60, 60, 12), 0, 0.8, bottom=False), facing((-BODY[0] / 2 + 2, 0, -150), (-1, 0, 0), (0, 1, 0)))
    model.add(m.GREY, shapes.turned([(20, 12), (20, 44), (14, 48), (14, 60), (0, 60)], 24, 0.8),
              facing((-BODY[0] / 2 + 2, 0, -150), (-1, 0, 0), (0, 1, 0)))
    tilt = math.radians(29)
    normal, up = (0, -math.sin(tilt), math.cos(tilt)), (0, math.cos(tilt), math.sin(tilt))
    wing = Frame((-BODY[0] / 2 - 60, 0, -150), (-1, 0, 0), (0, -up[1], -up[2]))
    assert shapes.dot(wing.z, normal) > 0.99
    for s in (-1, 1):
        model.add(m.BLACK, shapes.tube([(0, 0, 0), (60, s * 150, 0)], 7, 8), wing)
    model.add(m.BLACK, shapes.tube([(60, -190, 0), (60, 190, 0)], 7, 8), wing)
    for k in range(2):
        panel = wing.at(290 + 462 * k, 0, 0)
        model.add(m.CARBON, shapes.box((440, 480, 14), -7, 0.8), panel)
        cells = shapes.decal(432, 468, (0, 0, 432.0, 468.0))
        model.add(m.CELLS, cells, panel.at(0, 0, 7.1))
        for s in (-1, 1):
            model.add(m.ALUMINIUM, shapes.turned([(7, -22), (7, 22), (0, 22)], 12, 0.4),
                      facing(panel.point((-231, s * 150, 0)), panel.y, panel.x))
    return model


def servicer():
    """What the arm is mounted on: its frame is the mount's, z towards the arm; the body is behind it."""
    model = Model()
    sheet = pictures.Sheet(256, 128, 2.0)
    label = m.labels(sheet)
    w, h, d = 460, 420, 340
    details.frame_and_blankets(model, w, h, d, Frame((0, 0, -10)))
    model.add(m.ALUMINIUM, shapes.extruded([shapes.rounded(shapes.rectangle(w, h), 0.8)], -20, -8, 0.8), Frame())
    # The arm's seat, and lights on both sides.
    model.add(m.BLACK, shapes.turned([(70, -8), (70, 4), (52, 8), (52, 28), (0, 28)], 48, 1.2))
    for k in range(12):
        model.add(m.SCREW, shapes.screw(6), Frame().turned(30 * k).at(61, 0, 5))
    for s in (-1, 1):
        panel = Frame((s * 170, 20, -8))
        model.add(m.BLACK, shapes.box((84, 200, 16), 0, 1.0, bottom=False), panel)
        model.add(GLOW, shapes.box((72, 188, 1), 15.6, 0.4, bottom=False), panel)
    model.add(label, shapes.decal(110, 24, sheet.plate(110, 24, [("SERVICER 1", 0.5)], (0.9, 0.9, 0.9), (0.05, 0.07, 0.12))),
              Frame((0, -150, -7.9)))
    details.screws(model, [(x, y, -8) for x in (-215, -110, 110, 215) for y in (-196, 196)], 6)
    return model


GLOW = Material("light_panel", (0.95, 0.95, 0.92), 0.0, 0.6, glow=(2.0, 2.0, 1.9))


PARTS = {
    "module_replacement/meshes/" + name + ".glb": make
    for name, make in {"module": module, "handle": handle, "cover_tabbed": cover_tabbed, "lever": lever,
                       "switch_base": switch_base, "lamp": lamp, "holder": holder, "bracket": bracket,
                       "cavity": cavity, "satellite": satellite,
                       "solar_wing": solar_wing, "servicer": servicer}.items()
}
