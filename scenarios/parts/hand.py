"""A robotic hand with five fingers, right and left: the one source of its joints, of what is touched of it, and of its skin.

    scenarios/tools/make_visuals.py hand.xml hand_right.glb ...     writes them, as all parts

Millimetres and degrees. The palm's frame lies between the pads, as that of gripper.scad: straight fingers point along -z, and
close along -x against the thumb, which closes along x. The thumb of a right hand lies beside the palm at +y, and its first
joint turns it before the fingers. The four fingers are alike, as those of robotic hands often are.

A link's frame is at its joint: z is the axis, x points to the next joint, and flexing turns x towards y. A link is its own
mirror image in its plane z = 0, so both hands have the same links (libs/scene/expand_fingers.cpp).
"""
import math

from visual import materials as m
from visual import shapes
from visual.model import Model, Text

RADIUS = 8.0             # of a finger's links
THUMB_RADIUS = 9.0
FINGER = (45.0, 30.0, 26.0)
THUMB = (45.0, 38.0)     # beyond its metacarpal
KNUCKLES = (18.0, 75.0)  # x and z of the four fingers' first joints
PITCH = 22.0             # from finger to finger, along y
NAMES = ("index", "middle", "ring", "little")

OPPOSITION = (12.0, 20.0, 60.0)  # a point of its axis, which is z
METACARPAL = 36.0                # from there to the thumb's root
BESIDE, BEFORE = 150.0, 213.7    # where the root stands about that axis, beside the palm and before the fingers

PALM_LOW, PALM_HIGH = (-26.0, -44.0, 72.0), (34.0, 44.0, 118.0)
PALM_EDGE = 6.0
WRIST_RADIUS, WRIST_TOP = 24.0, 150.0

# How the pads touch: friction of rubber on metal, and its softness.
PAD = 'friction="0.8" stiffness_N_per_m="8000" damping_N_s_per_m="30"'

# Of each joint, from the palm outwards: limits and start, largest torque [Nm], servo's stiffness [Nm/rad] and damping [Nm s/rad],
# mass of the link [kg]. A fingertip presses with up to 15 N, as those of robotic hands of this size do; the thumb bears what
# four fingers press. Damping is about critical for the link and those after it, m l^2 / 3 each.
FINGER_JOINTS = ((-45, 90, 0, 1.5, 5.0, 0.08, 0.03), (-15, 100, 0, 0.8, 4.0, 0.03, 0.02), (-10, 80, 0, 0.5, 2.0, 0.01, 0.015))
THUMB_JOINTS = ((-5, 80, 0, 3.5, 20.0, 0.2, 0.04), (-50, 70, 0, 5.0, 20.0, 0.2, 0.04), (-15, 80, 0, 2.5, 10.0, 0.05, 0.03))

SIDES, RINGS = 24, 6     # of a link's mesh


# --- Joints. A pose is three columns of a rotation and an origin.

def about_z(degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return ((c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0))


def turn(R, v):
    return tuple(sum(R[k][i] * v[k] for k in range(3)) for i in range(3))


def times(A, B):
    """The pose B, given in the frame A."""
    return tuple(turn(A[0], column) for column in B[0]), shapes.add(A[1], turn(A[0], B[1]))


def flexing_along(x):
    """Axes of a link that points along -z and flexes along x or -x."""
    return ((0.0, 0.0, -1.0), (x, 0.0, 0.0), (0.0, -x, 0.0))


STRAIGHT = about_z(0.0)


def transposed(R):
    return tuple(tuple(R[k][i] for k in range(3)) for i in range(3))


def fingers():
    """Name, links' lengths and radius, joints, and the pose of each joint in the link before."""
    before = times((transposed(about_z(BEFORE)), (0.0, 0.0, 0.0)), (flexing_along(1.0), (0.0, 0.0, 0.0)))[0]
    yield "thumb", (METACARPAL,) + THUMB, THUMB_RADIUS, THUMB_JOINTS, (
        (about_z(BESIDE), OPPOSITION), (before, (METACARPAL, 0.0, 0.0)), (STRAIGHT, (THUMB[0], 0.0, 0.0)))
    for i, name in enumerate(NAMES):
        root = (flexing_along(-1.0), (KNUCKLES[0], PITCH * (1.5 - i), KNUCKLES[1]))
        yield name, FINGER, RADIUS, FINGER_JOINTS, (root, (STRAIGHT, (FINGER[0], 0.0, 0.0)), (STRAIGHT, (FINGER[1], 0.0, 0.0)))


def number(value):
    return f"{value if abs(value) > 1e-9 else 0.0:.6g}"


def numbers(values):
    return " ".join(number(v) for v in values)


def roll_pitch_yaw(R):
    """Degrees, about the fixed axes x, y, z (libs/scene/xml_numbers.hpp)."""
    cos_pitch = math.hypot(R[0][0], R[0][1])
    pitch = math.atan2(-R[0][2], cos_pitch)
    if cos_pitch < 1e-8:
        angles = (math.atan2(-R[2][1], R[1][1]), pitch, 0.0)
    else:
        angles = (math.atan2(R[1][2], R[2][2]), pitch, math.atan2(R[0][1], R[0][0]))
    return [math.degrees(a) for a in angles]


def mesh_name(length, radius):
    return f"phalanx_{length:.0f}_{radius:.0f}.obj"


def xml():
    out = ['<?xml version="1.0" encoding="UTF-8"?>',
           "<!-- Made by scenarios/parts/hand.py. A robotic hand with five fingers; a right one, of which a left one is the mirror",
           "     image. The metacarpal of the thumb lies in the palm, and touches nothing. -->",
           f"<hand {PAD}>"]
    for name, lengths, radius, joints, places in fingers():
        out.append(f'  <finger name="{name}">')
        for i, (length, (lower, upper, start, torque, k, d, mass), (R, p)) in enumerate(zip(lengths, joints, places)):
            place = f'position="{numbers(1e-3 * c for c in p)}" rpy_deg="{numbers(roll_pitch_yaw(R))}"'
            rest = (f'lower_deg="{lower}" upper_deg="{upper}" start_deg="{start}" torque_Nm="{torque:g}" '
                    f'servo_Nm_per_rad="{k:g}" servo_Nm_s_per_rad="{d:g}"')
            if name == "thumb" and i == 0:  # a bar of that length and radius, about its middle
                across = mass * (3.0 * radius**2 + length**2) / 12.0 * 1e-6
                inertia = numbers((0.5 * mass * radius**2 * 1e-6, across, across, 0, 0, 0))
                out += [f'    <joint {place} mass_kg="{mass}"', f'           inertia_kg_m2="{inertia}" center_of_mass_m="{number(0.5e-3 * length)} 0 0"',
                        f"           {rest}/>"]
                continue
            out += [f'    <joint {place} mass_kg="{mass}"', f"           {rest}>",
                    f'      <collision mesh="meshes/{mesh_name(length, radius)}" points="500"/>', "    </joint>"]
        out.append("  </finger>")
    out.append("</hand>")
    return Text("\n".join(out) + "\n")


# --- What is touched

def obj(points, faces):
    lines = ["v %.7f %.7f %.7f" % tuple(1e-3 * c for c in p) for p in points]
    lines += ["f %d %d %d" % tuple(i + 1 for i in f) for f in faces]
    return Text("\n".join(lines) + "\n")


def capsule(length, radius):
    """About the x axis, from the joint to the next one, round at both ends."""
    rings = []
    for i in range(1, RINGS + 1):
        a = 0.5 * math.pi * i / RINGS
        rings.append((-radius * math.cos(a), radius * math.sin(a)))
    for i in range(RINGS):
        a = 0.5 * math.pi * i / RINGS
        rings.append((length + radius * math.sin(a), radius * math.cos(a)))
    points, faces = [(-radius, 0.0, 0.0)], []
    for x, r in rings:
        points += [(x, r * math.cos(2.0 * math.pi * j / SIDES), r * math.sin(2.0 * math.pi * j / SIDES)) for j in range(SIDES)]
    points.append((length + radius, 0.0, 0.0))
    last = 1 + (len(rings) - 1) * SIDES
    for j in range(SIDES):
        k = (j + 1) % SIDES
        faces.append((0, 1 + k, 1 + j))
        for i in range(len(rings) - 1):
            a, b = 1 + i * SIDES, 1 + (i + 1) * SIDES
            faces += [(a + j, a + k, b + k), (a + j, b + k, b + j)]
        faces.append((last + j, last + k, len(points) - 1))
    return obj(points, faces)


def palm():
    """A box with chamfered edges."""
    (x0, y0, z0), (x1, y1, z1), c = PALM_LOW, PALM_HIGH, PALM_EDGE

    def ring(inset, z):
        a0, a1, b0, b1 = x0 + inset, x1 - inset, y0 + inset, y1 - inset
        return [(a0 + c, b0, z), (a1 - c, b0, z), (a1, b0 + c, z), (a1, b1 - c, z),
                (a1 - c, b1, z), (a0 + c, b1, z), (a0, b1 - c, z), (a0, b0 + c, z)]

    rings = [ring(c, z0), ring(0.0, z0 + c), ring(0.0, z1 - c), ring(c, z1)]
    points = [p for r in rings for p in r]
    faces = [(0, j + 1, j) for j in range(1, 7)]
    top = 24
    faces += [(top, top + j, top + j + 1) for j in range(1, 7)]
    for i in range(3):
        for j in range(8):
            k = (j + 1) % 8
            a, b = 8 * i, 8 * (i + 1)
            faces += [(a + j, a + k, b + k), (a + j, b + k, b + j)]
    return obj(points, faces)


# --- What is seen: one skin that bends with its joints

BLEND = 7.0  # mm before and after a joint within which the skin goes with both links


def mirrored(surface):
    flipped = shapes.Surface()
    flipped.vertices = [((p[0], -p[1], p[2]), (n[0], -n[1], n[2]), uv) for p, n, uv in surface.vertices]
    flipped.triangles = [(a, c, b) for a, b, c in surface.triangles]
    return flipped


def mirrored_pose(X):
    """As libs/scene/expand_fingers.cpp: M R diag(1, 1, -1)."""
    R, p = X
    flip = [(c[0], -c[1], c[2]) for c in R]
    return (flip[0], flip[1], shapes.scale(-1.0, flip[2])), (p[0], -p[1], p[2])


def skin(side):
    places = {}
    for name, lengths, radius, joints, chain in fingers():
        X = (STRAIGHT, (0.0, 0.0, 0.0))
        for i, place in enumerate(chain):
            X = times(X, place)
            places[f"{name}_{i + 1}"] = X
    is_left = side == "left"
    rest = {"palm": (STRAIGHT, (0.0, 0.0, 0.0)), **{n: mirrored_pose(X) if is_left else X for n, X in places.items()}}
    model = Model(list(rest), rest)

    def add(material, surface, shares):
        model.add(material, mirrored(surface) if is_left else surface, shares=shares)

    only_palm = {"palm": 1.0}
    middle = shapes.scale(0.5, shapes.add(PALM_LOW, PALM_HIGH))
    size = shapes.sub(PALM_HIGH, PALM_LOW)
    add(m.WHITE, shapes.box(size, PALM_LOW[2], 4.0).placed(shapes.Frame((middle[0], middle[1], 0.0))), only_palm)
    add(m.STEEL_SATIN, shapes.box((4.0, size[1] - 16.0, size[2] - 12.0), PALM_LOW[2] + 6.0, 1.2).placed(
        shapes.Frame((PALM_HIGH[0] + 1.2, middle[1], 0.0))), only_palm)
    wrist = [(WRIST_RADIUS, PALM_HIGH[2] - 1.0), (WRIST_RADIUS, WRIST_TOP), (0.0, WRIST_TOP)]
    add(m.ALUMINIUM, shapes.turned(wrist, 40, 1.0).placed(shapes.Frame((middle[0], 0.0, 0.0))), only_palm)
    for name, lengths, radius, joints, chain in fingers():
        add_finger(add, name, lengths, radius, places)
    return model


def add_finger(add, name, lengths, radius, places):
    """A tube round its joints, with a hard shell on the back of each link and a pad on its inner side."""
    links = [f"{name}_{i + 1}" for i in range(3)]
    ends = [0.0, lengths[0], lengths[0] + lengths[1], sum(lengths)]
    points, ways = [], []
    for i, link in enumerate(links):
        R, p = places[link]
        steps = 10
        for k in range(steps + (i == 2)):
            along = lengths[i] * k / steps
            points.append(shapes.add(p, shapes.scale(along, R[0])))
            ways.append(ends[i] + along)
    R, p = places[links[2]]
    radii = [radius] * len(points)
    for k in range(1, 7):  # the round tip
        a = 0.5 * math.pi * k / 6.0
        points.append(shapes.add(p, shapes.scale(lengths[2] + radius * math.sin(a), R[0])))
        radii.append(max(radius * math.cos(a), 0.05))
        ways.append(ends[3])

    def shares(uv):
        way = uv[1]
        for joint, at in ((1, ends[1]), (2, ends[2])):
            if abs(way - at) < BLEND:
                t = 0.5 + 0.5 * (way - at) / BLEND
                t = t * t * (3.0 - 2.0 * t)
                return {links[joint - 1]: 1.0 - t, links[joint]: t}
        if way < BLEND and name != "thumb":
            t = 0.5 + 0.5 * way / BLEND
            return {"palm": 1.0 - t, links[0]: t}
        return {links[0 if way < ends[1] else 1 if way < ends[2] else 2]: 1.0}

    add(m.CABLE_GREY, shapes.tube(points, radii, 20), shares)
    for i, link in enumerate(links):
        if name == "thumb" and i == 0:
            continue
        R, p = places[link]
        # Frame of the shell: its z along -y of the link, away from what is gripped; its x along the link.
        back = shapes.Frame(shapes.add(p, shapes.scale(0.5 * lengths[i], R[0])), R[0], shapes.scale(-1.0, R[2]))
        add(m.STEEL_SATIN, shapes.box((lengths[i] - 2.0 * BLEND, 1.1 * radius, 3.0), radius - 1.6, 1.0).placed(back), {link: 1.0})


PARTS = {
    "parts/hand.xml": xml,
    "parts/meshes/hand_palm.obj": palm,
    **{"parts/meshes/" + mesh_name(length, radius): lambda length=length, radius=radius: capsule(length, radius)
       for lengths, radius in ((FINGER, RADIUS), (THUMB, THUMB_RADIUS)) for length in lengths},
    "parts/meshes/hand_right.glb": lambda: skin("right"),
    "parts/meshes/hand_left.glb": lambda: skin("left"),
}
