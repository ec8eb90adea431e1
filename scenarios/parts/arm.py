"""How a light-weight arm looks, millimetres: the links of service_robot.scad, whose sizes these are. A link's frame lies in
its joint, z is the axis."""
import math

from visual import materials as m
from visual import pictures, shapes
from visual.model import Material, Model
from visual.shapes import Frame, facing

REACH, LINK_R, JOINT_R, JOINT_H = 200, 35, 45, 90

SHELL = Material("shell", (0.76, 0.77, 0.78), 0.0, 0.55, coat=(1.0, 0.14))
ACCENT = Material("accent", (0.03, 0.15, 0.42), 0.2, 0.36)
SEAM = Material("seam", (0.02, 0.02, 0.022), 0.0, 0.6)


def ring(radius, z0, z1, depth=1.2, bevel=0.5):
    """A band about z that stands out of a tube of that radius."""
    return shapes.turned([(radius - 0.5, z0), (radius + depth, z0), (radius + depth, z1), (radius - 0.5, z1)], 28, bevel)


def screws(model, radius, z, count, diameter, frame, up=True):
    for k in range(count):
        place = frame.turned(360.0 * (k + 0.5) / count).at(radius, 0, z)
        model.add(m.SCREW, shapes.screw(diameter, 8), place if up else facing(place.origin, shapes.scale(-1.0, place.z)))


def link_along():
    """Turns about its own tube."""
    model = Model()
    model.add(SEAM, shapes.turned([(0, -2), (33, -2), (33, 9), (33.5, 9)], 28, 0.0))
    shell = [(34, 8), (40, 8), (40, 24), (LINK_R, 34), (LINK_R, 138), (38.5, 156), (38.5, 162), (30, 165), (0, 165)]
    model.add(SHELL, shapes.revolve(shapes.rounded(shell, [0, 1.5, 6, 12, 14, 3, 1.5, 1, 0], 2, closes=False), 28))
    model.add(ACCENT, ring(LINK_R, 44, 50, 0.6, 0.3))
    model.add(SEAM, ring(LINK_R, 92, 93.6, 0.15, 0.0))
    screws(model, 36.8, 8.2, 4, 3.0, Frame(), up=False)
    sheet = pictures.Sheet(128, 64, 3.0)
    label = m.labels(sheet)
    box = sheet.plate(30, 14, [("LWR-S", 0.42), ("7 DOF", 0.24)], (0.93, 0.93, 0.93), (0.05, 0.06, 0.09), frame=False)
    for s in (0, 180):
        model.add(label, wrapped(30, 14, LINK_R + 0.15, 116, s, box))
    return model


def wrapped(width, height, radius, z, degrees, uv, strips=6):
    """A label around a tube."""
    rows = []
    for v, dz in ((uv[3], -height / 2), (uv[1], height / 2)):
        row = []
        for i in range(strips + 1):
            angle = math.radians(degrees) + width / radius * (i / strips - 0.5)
            c, s = math.cos(angle), math.sin(angle)
            row.append(((radius * c, radius * s, z + dz), (c, s, 0.0), (uv[0] + (uv[2] - uv[0]) * i / strips, v)))
        rows.append(row)
    return shapes.grid(rows)


def joint(model, length):
    """A housing across the arm, and the tube that leaves it along y."""
    half = JOINT_H / 2
    housing = [(0, -half), (JOINT_R, -half), (JOINT_R, half), (0, half)]
    model.add(SHELL, shapes.revolve(shapes.rounded(housing, [0, 10, 10, 0], 3, closes=False), 28))
    for s in (-1, 1):
        cover = facing((0, 0, s * half), (0, 0, s))
        model.add(ACCENT, shapes.turned([(29, -0.5), (29, 1.2), (0, 1.2)], 24, 0.6), cover)
        model.add(m.ALUMINIUM, shapes.turned([(12, 1), (12, 2.4), (9, 2.4), (9, 1.4), (0, 1.4)], 16, 0.3), cover)
        screws(model, 24, 1.2, 4, 2.8, cover)
    model.add(SEAM, ring(JOINT_R, -0.8, 0.8, 0.12, 0.0))
    tube = facing((0, 0, 0), (0, 1, 0))
    neck = [(42, 30), (42, 44), (LINK_R, 60), (LINK_R, length - 16), (39, length - 9), (39, length), (0, length)]
    model.add(SHELL, shapes.revolve(shapes.rounded(neck, [0, 4, 10, 8, 4, 1.2, 0], 2, closes=False), 28), tube)
    return tube


def link_across():
    model = Model()
    tube = joint(model, REACH - 3)
    model.add(ACCENT, ring(LINK_R, 150, 156, 0.6, 0.3), tube)
    # A cable beside the tube, held by two clips.
    path = [(LINK_R - 4, 0, 62), (LINK_R + 6, 0, 72), (LINK_R + 6, 0, 100), (LINK_R + 6, 0, 150), (LINK_R + 5, 0, 170), (LINK_R - 3, 0, 184)]
    model.add(m.RUBBER, shapes.tube(shapes.smooth_path(path, 3), 3.4, 6), tube)
    for z in (90, 140):
        model.add(m.BLACK, shapes.box((13, 12, 7), -3.5, 0.8), facing(tube.point((LINK_R + 4.5, 0, z)), tube.z, tube.x))
    return model


def wrist():
    model = Model()
    tube = joint(model, REACH / 2 - 3)
    model.add(ACCENT, ring(LINK_R, 70, 74, 0.6, 0.3), tube)
    return model


def flange():
    """The last link: a force-torque sensor and the plate that a gripper is screwed to at z = 45."""
    model = Model()
    model.add(SEAM, shapes.turned([(0, -2), (32, -2), (32, 4), (33, 4)], 28, 0.0))
    model.add(SHELL, shapes.revolve(shapes.rounded([(30, 3), (36, 3), (36, 14), (30, 16), (0, 16)], [0, 1.2, 2, 0, 0], 2, closes=False), 28))
    model.add(m.BLACK, shapes.turned([(31, 15), (33, 15), (33, 32), (0, 32)], 28, 0.6))
    sheet = pictures.Sheet(128, 32, 4.0)
    label = m.labels(sheet)
    box = sheet.plate(26, 7, [("FT-6  200 N", 0.6)], (0.9, 0.9, 0.9), (0.03, 0.03, 0.034), frame=False)
    for s in (-90, 90):
        model.add(label, wrapped(26, 7, 33.15, 23, s, box))
    model.add(m.ALUMINIUM, shapes.turned([(29, 32), (29, 39), (24, 41), (24, 45), (0, 45)], 28, 0.6))
    screws(model, 26.8, 38.5, 8, 2.6, Frame())
    plug = facing((0, -33, 23), (0, -1, 0))
    model.add(m.NICKEL, shapes.turned([(5, 0), (5, 6), (4, 7), (4, 12), (0, 12)], 16, 0.3), plug)
    path = [(0, -44, 23), (0, -52, 20), (0, -55, 6), (0, -50, -14), (2, -40, -34)]
    model.add(m.RUBBER, shapes.tube(shapes.smooth_path(path, 4), 2.6, 8))
    return model


def tool():
    """The last link of service_robot's arms: a cylinder that is touched."""
    model = Model()
    model.add(m.STEEL_SATIN, shapes.turned([(0, 0), (30, 0), (30, 80), (0, 80)], 64, 0.4))
    for z in (10, 70):
        model.add(m.BLACK, ring(30.05, z - 2, z + 2, 0.05, 0.0))
    screws(model, 22, 80, 6, 3.4, Frame())
    sheet = pictures.Sheet(128, 64, 3.0)
    label = m.labels(sheet)
    box = sheet.plate(36, 16, [("PROBE P-2", 0.4), ("PUSH HERE", 0.22)], (0.95, 0.95, 0.95), (0.55, 0.05, 0.03), frame=False)
    for s in (-90, 90):
        model.add(label, wrapped(36, 16, 30.1, 40, s, box))
    return model


LINKS = {"link_along": link_along, "link_across": link_across, "wrist": wrist}
PARTS = {"module_replacement/meshes/" + name + ".glb": make for name, make in {**LINKS, "flange": flange}.items()}
PARTS.update({"service_robot/meshes/" + name + ".glb": make for name, make in {**LINKS, "tool": tool}.items()})
