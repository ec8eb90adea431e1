"""How the two-finger gripper looks, millimetres, in the frame of gripper.scad, whose sizes these are."""
import math

from visual import details, pictures, shapes
from visual import materials as m
from visual.model import Model
from visual.shapes import Frame, facing

BEVEL = 0.4
PAD, FINGER, FINGER_TOP = (5, 20, 15), (9, 20), 66
PALM, PALM_BOTTOM, CHAMFER = (116, 46, 44), 58, 6
WRIST_R, WRIST_H = 20, 30


def palm():
    model = Model()
    sheet = pictures.Sheet(256, 256, 4.0)
    label = m.labels(sheet)
    low, high = PALM_BOTTOM, PALM_BOTTOM + PALM[2]
    model.add(m.HOUSING, shapes.profiled(PALM[:2], [(-CHAMFER, low), (0, low + CHAMFER), (0, high - CHAMFER), (-CHAMFER, high)],
                                         BEVEL, BEVEL, start=False, end=True))
    model.add(m.STEEL, shapes.box((PALM[0] - 12, 10, 5), low - 4, BEVEL))
    wrist = [(WRIST_R, high - 1), (WRIST_R, high + WRIST_H), (0, high + WRIST_H)]
    model.add(m.ALUMINIUM, shapes.turned(wrist, 48, BEVEL))
    for z in (high + 3, high + 24):
        model.add(m.BLACK, shapes.turned([(WRIST_R + 0.02, z), (WRIST_R + 0.9, z), (WRIST_R + 0.9, z + 3), (WRIST_R + 0.02, z + 3)],
                                         48, 0.3))
    # Joints of the housing, covers on its sides, screws, the maker's plate, a light.
    for s in (-1, 1):
        front = facing((0, s * (PALM[1] / 2), (low + high) / 2), (0, s, 0), (-s, 0, 0))
        model.add(m.GREY, shapes.box((66, 24, 0.8), 0, 0.35, bottom=False), front)
        details.screws(model, [(x, y, 0.8) for x in (-29, 29) for y in (-8.5, 8.5)], 2.6, front)
        details.screws(model, [(x, y, 0) for x in (-50, 50) for y in (-12, 12)], 3.6, front)
        model.add(label, shapes.decal(42, 13, sheet.plate(42, 13, [("GRIPPER 2F-80", 0.34), ("SERVICER ARM 1", 0.24)],
                                                          (0.92, 0.92, 0.92), (0.035, 0.037, 0.042), frame=False)),
                  front.at(0, 0, 0.86))
        model.add(m.GREEN_LIGHT, shapes.turned([(2, 0), (2, 0.8), (0, 0.8)], 12, 0.3), front.at(40, 0, 0))
        end = facing((s * PALM[0] / 2, 0, (low + high) / 2), (s, 0, 0), (0, s, 0))
        details.screws(model, [(x, y, 0) for x in (-17, 17) for y in (-11, 11)], 3.2, end)
        stripes = sheet.hazard(30, 6, 6.0)
        model.add(label, shapes.decal(30, 6, stripes), end.at(0, -10, 0.06))
    details.screws(model, [(x, y, high) for x in (-44, 44) for y in (-13, 13)], 3.6, Frame())
    for k in range(8):
        arm = Frame((0, 0, high)).turned(22.5 + 45 * k)
        details.screws(model, [(WRIST_R + 5.5, 0, 0)], 2.6, arm)
    # Its cable, from the housing up along the wrist.
    plug = facing((38, 0, high), (0, 0, 1))
    model.add(m.NICKEL, shapes.turned([(8, 0), (8, 2), (6.5, 2), (6.5, 10), (5, 11), (5, 17), (0, 17)], 18, 0.4), plug)
    path = shapes.smooth_path([(38, 0, high + 16), (38, 0, high + 24), (34, 1, high + 34), (27, 3, high + 42), (22, 4, high + 56)], 5)
    model.add(m.RUBBER, shapes.tube(path, 3.2, 10))
    return model


def jaw(is_right=False):
    model = Model()
    b, (px, py, pz), f = 1.5, PAD, FINGER[0]
    outline = [(-px - f, FINGER_TOP), (-px - f, -pz / 2 + 4), (-px - f + 4, -pz / 2), (-b, -pz / 2), (0, -pz / 2 + b),
               (0, pz / 2 - b), (-b, pz / 2), (-px, pz / 2 + 4), (-px, FINGER_TOP)]
    across = Frame((0, 0, 0), (1, 0, 0), (0, 0, 1))
    ring = shapes.rounded(outline, BEVEL)
    made = [(m.STEEL_SATIN, shapes.extruded([ring], -FINGER[1] / 2, FINGER[1] / 2, BEVEL).placed(across))]
    pad = facing((0.05, 0, 0), (1, 0, 0), (0, 1, 0))
    made.append((m.PAD, shapes.decal(18.4, 11.2, (0, 0, 18.4 / 2.4, 11.2 / 2.4)).placed(pad)))
    back = facing((-px - f, 0, 0), (-1, 0, 0), (0, -1, 0))
    for y in (22, 34):
        made.append((m.SCREW, shapes.screw(4.0).placed(back.at(0, y, 0))))
    for s in (-1, 1):
        side = facing((0, s * FINGER[1] / 2, 0), (0, s, 0), (1, 0, 0))
        for z in (-3.5, 3.5):
            made.append((m.SCREW, shapes.screw(2.2, 8).placed(facing((-3.4, s * FINGER[1] / 2, z), (0, s, 0)))))
        made.append((m.BLACK, shapes.box((4, 34, 0.5), 0, 0.2, bottom=False).placed(
            facing((-px - f / 2, s * FINGER[1] / 2, 34), (0, s, 0), (1, 0, 0)))))
    for material, surface in made:
        model.add(material, surface.mirrored_x() if is_right else surface)
    return model


def jaw_cables():
    """From the palm to its jaws: skins that bend as the hand opens."""
    model = Model(["palm", "jaw_left", "jaw_right"])
    for s, name in ((-1, "jaw_left"), (1, "jaw_right")):
        path = shapes.smooth_path([(s * 30, -20, PALM_BOTTOM + 1), (s * 30, -20, PALM_BOTTOM - 5), (s * 33, -26, PALM_BOTTOM - 15),
                                   (s * 26, -29, 35), (s * 16, -23, 30), (s * 10.5, -15, 31), (s * 10.5, -9.8, 31)], 3)
        length = sum(math.dist(a, b) for a, b in zip(path, path[1:]))

        def shares(uv, name=name, length=length):
            t = uv[1] / length
            t = t * t * (3.0 - 2.0 * t)
            return {"palm": 1.0 - t, name: t}

        model.add(m.RUBBER, shapes.tube(path, 2.0, 7, has_ends=False), shares=shares)
        sleeve = facing((s * 30, -20, PALM_BOTTOM + 0.5), (0, 0, -1))
        model.add(m.NICKEL, shapes.turned([(3.4, 0), (3.4, 3), (2.6, 4), (2.6, 7), (0, 7)], 9, 0.3), sleeve, {"palm": 1.0})
        plug = facing((s * 10.5, -FINGER[1] / 2 + 0.1, 31), (0, -1, 0))
        model.add(m.NICKEL, shapes.turned([(3.2, 0), (3.2, 2), (2.6, 3), (2.6, 5.5), (0, 5.5)], 9, 0.3), plug, {name: 1.0})
    return model


PARTS = {
    folder + "/meshes/" + name + ".glb": make
    for folder in ("module_replacement", "peg_in_hole")
    for name, make in {"palm": palm, "jaw_left": jaw, "jaw_right": lambda: jaw(True), "jaw_cables": jaw_cables}.items()
}
