"""How the parts of `peg_in_hole` look, millimetres; peg_in_hole.scad is what is touched, whose sizes these are."""
from visual import materials as m
from visual import pictures, shapes
from visual.model import Model
from visual.shapes import Frame, facing

BEVEL = 0.4
PEG_R, PEG_L, PEG_CHAMFER, COLLAR_R, GRIP = 10, 60, 1.5, 16, (20, 30, 44)
HOLE_DEPTH, HOLE_CHAMFER, BLOCK = 40, 2, (30, 30, 45)


def hole(clearance=0.5, text="20.5"):
    model = Model()
    radius = PEG_R + clearance / 2
    outer = shapes.rounded(shapes.rectangle(BLOCK[0], BLOCK[1]), BEVEL)
    top = [p for p, _ in shapes.hole(shapes.circle(radius + HOLE_CHAMFER + 0.4, 64))]
    model.add(m.ALODINE, shapes.extruded([outer], -BLOCK[2], 0, BEVEL, top=False))
    model.add(m.ALODINE, shapes.cap([shapes._inset(outer, BEVEL), top], 0, True))
    bore = [(radius + HOLE_CHAMFER + 0.4, 0), (radius + HOLE_CHAMFER, 0), (radius, -HOLE_CHAMFER), (radius, -HOLE_DEPTH), (0, -HOLE_DEPTH)]
    model.add(m.STEEL, shapes.revolve(shapes.rounded(bore, [0, 0.2, 0.2, 0, 0], closes=False), 64))
    sheet = pictures.Sheet(128, 64, 5.0)
    label = m.labels(sheet)
    box = sheet.plate(20, 10, [("H7  " + text, 0.5)])
    for s in (-1, 1):
        model.add(label, shapes.decal(20, 10, box), facing((0, s * 15.05, -20), (0, s, 0), (-s, 0, 0)))
    return model


def hole_tight():
    return hole(0.1, "20.1")


def peg():
    model = Model()
    line = [(0, 0), (PEG_R - PEG_CHAMFER, 0), (PEG_R, PEG_CHAMFER), (PEG_R, PEG_L), (COLLAR_R, PEG_L), (COLLAR_R, PEG_L + 5), (0, PEG_L + 5)]
    model.add(m.STEEL, shapes.turned(line, 64, 0.3))
    model.add(m.ALUMINIUM, shapes.box(GRIP, PEG_L + 4, BEVEL))
    sheet = pictures.Sheet(128, 64, 4.0)
    label = m.labels(sheet)
    box = sheet.plate(24, 12, [("PEG 20", 0.5)], (0.92, 0.92, 0.92), (0.05, 0.10, 0.30))
    for s in (-1, 1):
        model.add(label, shapes.decal(24, 12, box), facing((s * 10.05, 0, 96), (s, 0, 0), (0, s, 0)))
    return model


def table():
    model = Model()
    slots = [shapes.hole(shapes.rounded(shapes.rectangle(8, 68, x, 0), BEVEL)) for x in (-30, 30)]
    outer = shapes.rounded(shapes.rectangle(260, 180), BEVEL)
    model.add(m.BLACK, shapes.extruded([outer] + slots, -4, 0, BEVEL, bottom=False, bottom_bevel=0.0))
    model.add(m.BLACK, shapes.extruded([outer], -15, -4, 0.0, top=False, bottom_bevel=BEVEL))
    for x in (-30, 30):
        model.add(m.ALUMINIUM, shapes.decal(8, 68), Frame((x, 0, -4)))
    sheet = pictures.Sheet(512, 128, 3.0)
    label = m.labels(sheet)
    stripes = sheet.hazard(150, 6)
    for k in (0, 180):
        model.add(label, shapes.decal(150, 6, stripes), Frame().turned(k).at(0, -82, 0.05))
    box = sheet.plate(60, 12, [("PEG IN HOLE", 0.5)], (0.92, 0.92, 0.92), (0.03, 0.03, 0.034), frame=False)
    model.add(label, shapes.decal(60, 12, box), Frame((0, -66, 0.05)))
    for k, (x, y) in enumerate((x, y) for x in (-118, 118) for y in (-78, 78)):
        model.add(m.SCREW, shapes.screw(6.0), Frame((x, y, 0)).turned(25.0 * k))
    return model


PARTS = {"peg_in_hole/meshes/" + name + ".glb": make
         for name, make in {"hole": hole, "hole_tight": hole_tight, "peg": peg, "table": table}.items()}
