"""Surfaces of bevelled parts, in millimetres: vertices with normals and texture coordinates, and triangles.

A bevel is one strip whose normals turn from one face's to the other's: it catches the light like a rounded edge and costs
two triangles. Outlines run so that the material is on their left; the outline of a hole runs the other way round.
"""
import math


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(s, a):
    return (s * a[0], s * a[1], s * a[2])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(dot(a, a))
    return scale(1.0 / length, a) if length > 0.0 else a


class Frame:
    """Where a surface is put: axes x, y, z (columns) and origin."""

    def __init__(self, origin=(0.0, 0.0, 0.0), x=(1.0, 0.0, 0.0), y=(0.0, 1.0, 0.0)):
        self.origin, self.x, self.y, self.z = origin, x, y, cross(x, y)

    def point(self, p):
        return add(self.origin, self.vector(p))

    def vector(self, v):
        return add(add(scale(v[0], self.x), scale(v[1], self.y)), scale(v[2], self.z))

    def at(self, x, y, z):
        return Frame(self.point((x, y, z)), self.x, self.y)

    def turned(self, degrees):
        """About its own z."""
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        return Frame(self.origin, self.vector((c, s, 0.0)), self.vector((-s, c, 0.0)))


def facing(origin, z, x=(1.0, 0.0, 0.0)):
    """A frame whose z is given, and whose x is as near as it can be to the given one."""
    z = unit(z)
    y = cross(z, x)
    if dot(y, y) < 1e-6:
        y = cross(z, (0.0, 1.0, 0.0))
    y = unit(y)
    return Frame(origin, cross(y, z), y)


class Surface:
    def __init__(self):
        self.vertices = []  # position, normal, texture coordinates or None
        self.triangles = []

    def vertex(self, p, n, uv=None):
        self.vertices.append((p, n, uv))
        return len(self.vertices) - 1

    def quad(self, a, b, c, d):
        self.triangles += [(a, b, c), (a, c, d)]

    def join(self, other):
        base = len(self.vertices)
        self.vertices += other.vertices
        self.triangles += [tuple(base + i for i in t) for t in other.triangles]
        return self

    def placed(self, frame):
        out = Surface()
        out.vertices = [(frame.point(p), frame.vector(n), uv) for p, n, uv in self.vertices]
        out.triangles = list(self.triangles)
        return out

    def mirrored_x(self):
        out = Surface()
        out.vertices = [((-p[0], p[1], p[2]), (-n[0], n[1], n[2]), uv) for p, n, uv in self.vertices]
        out.triangles = [(a, c, b) for a, b, c in self.triangles]
        return out


def grid(rows, closes=False):
    """Rows of (position, normal, uv); the surface's outside is along row x column. `closes`: the last column is the first."""
    surface = Surface()
    index = [[surface.vertex(*v) for v in row] for row in rows]
    columns = len(rows[0])
    for i in range(len(rows) - 1):
        for j in range(columns if closes else columns - 1):
            k = (j + 1) % columns
            surface.quad(index[i][j], index[i][k], index[i + 1][k], index[i + 1][j])
    return surface


def rounded(points, radius, steps=1, closes=True):
    """The polyline with its corners rounded: a list of (point, normal), the normal to the right of the way."""
    count = len(points)
    radii = radius if isinstance(radius, (list, tuple)) else [radius] * count
    out = []

    def direction(i):
        a, b = points[i % count], points[(i + 1) % count]
        length = math.hypot(b[0] - a[0], b[1] - a[1])
        return (b[0] - a[0]) / length, (b[1] - a[1]) / length

    for i in range(count):
        p = points[i]
        if not closes and i in (0, count - 1):
            d = direction(0 if i == 0 else count - 2)
            out.append((p, (d[1], -d[0])))
            continue
        d0, d1 = direction(i - 1), direction(i)
        n0, n1 = (d0[1], -d0[0]), (d1[1], -d1[0])
        turn = math.atan2(d0[0] * d1[1] - d0[1] * d1[0], d0[0] * d1[0] + d0[1] * d1[1])
        r = radii[i]
        if abs(turn) < 1e-6:
            out.append((p, n0))
            continue
        if r <= 0.0:
            out += [(p, n0), (p, n1)]
            continue
        back = r * math.tan(abs(turn) / 2.0)
        side = r if turn > 0.0 else -r
        start = (p[0] - back * d0[0], p[1] - back * d0[1])
        middle = (start[0] - side * n0[0], start[1] - side * n0[1])
        for k in range(steps + 1):
            angle = turn * k / steps
            c, s = math.cos(angle), math.sin(angle)
            n = (c * n0[0] - s * n0[1], s * n0[0] + c * n0[1])
            out.append(((middle[0] + side * n[0], middle[1] + side * n[1]), n))
    return out


def rectangle(width, height, x=0.0, y=0.0):
    return [(x - width / 2, y - height / 2), (x + width / 2, y - height / 2), (x + width / 2, y + height / 2),
            (x - width / 2, y + height / 2)]


def circle(radius, sides, x=0.0, y=0.0):
    """As `rounded` gives an outline."""
    out = []
    for i in range(sides):
        c, s = math.cos(2.0 * math.pi * i / sides), math.sin(2.0 * math.pi * i / sides)
        out.append(((x + radius * c, y + radius * s), (c, s)))
    return out


def hole(outline):
    """The outline of a hole in the material, from that of a solid."""
    return [(p, (-n[0], -n[1])) for p, n in reversed(outline)]


def revolve(profile, sides, is_full=True):
    """Of (point, normal) pairs in the half plane of radius and height, from the lower end; about z."""
    rows, way = [], 0.0
    for i, ((r, z), (nr, nz)) in enumerate(profile):
        if i > 0:
            way += math.hypot(r - profile[i - 1][0][0], z - profile[i - 1][0][1])
        row = []
        for j in range(sides + 1):
            angle = 2.0 * math.pi * (j % sides) / sides
            c, s = math.cos(angle), math.sin(angle)
            row.append(((r * c, r * s, z), (nr * c, nr * s, nz), (2.0 * math.pi * max(r, 5.0) * j / sides, -way)))
        rows.append(row)
    return grid(rows)


def smooth(points):
    """A line with the normals of a curve through its points, but for its ends."""
    out = []
    for i, p in enumerate(points):
        a, b = points[max(i - 1, 0)], points[min(i + 1, len(points) - 1)]
        length = math.hypot(b[0] - a[0], b[1] - a[1])
        out.append((p, ((b[1] - a[1]) / length, (a[0] - b[0]) / length)))
    return out


def turned(points, sides, bevel=0.0, steps=1):
    """A turned part from its outline (radius, height), open at the axis."""
    return revolve(rounded(points, [0.0] + [bevel] * (len(points) - 2) + [0.0], steps, closes=False), sides)


def cap(loops, z, up):
    """A plane at height z inside the first loop and outside the others; loops of 2D points."""
    ring = list(loops[0])
    for inner in loops[1:]:  # a bridge to each hole, the shortest that crosses nothing
        pairs = [(math.dist(p, q), i, k) for i, q in enumerate(ring) for k, p in enumerate(inner) if ring.count(q) == 1]
        best, start = next((i, k) for _, i, k in sorted(pairs) if _is_free(inner[k], ring[i], [ring] + loops[1:]))
        ring = ring[: best + 1] + [inner[(start + k) % len(inner)] for k in range(len(inner) + 1)] + ring[best:]
    surface = Surface()
    n = (0.0, 0.0, 1.0 if up else -1.0)
    index = {}
    for q in ring:
        if q not in index:
            index[q] = surface.vertex((q[0], q[1], z), n)
    triangles = _ears(ring)
    wanted = sum(_area(loop) for loop in loops)
    if abs(sum(_turn(*t) / 2.0 for t in triangles) - wanted) > 1e-6 * wanted:
        raise SystemExit("a flat end with holes cannot be cut into triangles: change its outlines")
    for a, b, c in triangles:
        surface.triangles.append((index[a], index[b], index[c]) if up else (index[a], index[c], index[b]))
    return surface


def _turn(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _area(loop):
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(loop, loop[1:] + loop[:1])) / 2.0


def _is_free(p, q, loops):
    for loop in loops:
        for i in range(len(loop)):
            a, b = loop[i], loop[(i + 1) % len(loop)]
            if p in (a, b) or q in (a, b):
                continue
            if _turn(p, q, a) * _turn(p, q, b) <= 0.0 and _turn(a, b, p) * _turn(a, b, q) <= 0.0:
                return False
    return True


def _ears(ring):
    ring, triangles = list(ring), []
    ring = [p for i, p in enumerate(ring) if p != ring[i - 1]]
    while len(ring) > 3:
        best, best_shape = None, -1.0
        for i in range(len(ring)):
            a, b, c = ring[i - 1], ring[i], ring[(i + 1) % len(ring)]
            area = _turn(a, b, c)
            if area <= 1e-9:
                continue
            if any(_turn(a, b, p) > 1e-9 and _turn(b, c, p) > 1e-9 and _turn(c, a, p) > -1e-9
                   for p in ring if p not in (a, b, c)):
                continue
            sides = [math.dist(a, b), math.dist(b, c), math.dist(c, a)]
            shape = area / max(sides) ** 2
            if shape > best_shape:
                best, best_shape = i, shape
            if shape > 0.3:
                break
        if best is None:  # only corners without area are left
            best = min(range(len(ring)), key=lambda i: abs(_turn(ring[i - 1], ring[i], ring[(i + 1) % len(ring)])))
        triangles.append((ring[best - 1], ring[best], ring[(best + 1) % len(ring)]))
        ring.pop(best)
    triangles.append(tuple(ring))
    return [t for t in triangles if abs(_turn(*t)) > 1e-9]


def extruded(outlines, z0, z1, bevel=0.0, steps=1, top=True, bottom=True, bottom_bevel=None):
    """A plate between two heights. Outlines: (point, normal) pairs, the first the outside, the others holes. Bevelled edges
    need outlines whose corners are rounded by at least the bevel."""
    low = bevel if bottom_bevel is None else bottom_bevel
    profile = []  # inset, height, normal outwards and up
    profile += [(inset, z, n) for inset, z, n in _edge(low, steps, z0, -1)]
    profile += [(inset, z, n) for inset, z, n in reversed(_edge(bevel, steps, z1, 1))]
    surface = Surface()
    for outline in outlines:
        rows = []
        for inset, z, (n_out, n_up) in profile:
            way, row = 0.0, []
            closed = outline + outline[:1]
            for i, (p, n) in enumerate(closed):
                if i > 0:
                    way += math.dist(p, closed[i - 1][0])
                row.append(((p[0] - inset * n[0], p[1] - inset * n[1], z), (n_out * n[0], n_out * n[1], n_up), (way, -z)))
            rows.append(row)
        surface.join(grid(rows))
    for is_there, z, inset, up in ((bottom, z0, low, False), (top, z1, bevel, True)):
        if is_there:
            surface.join(cap([_inset(o, inset) for o in outlines], z, up))
    return surface


def _inset(outline, inset):
    out = []
    for p, n in outline:
        q = (round(p[0] - inset * n[0], 6), round(p[1] - inset * n[1], 6))
        if not out or q != out[-1]:
            out.append(q)
    return out[:-1] if len(out) > 1 and out[0] == out[-1] else out


def _edge(bevel, steps, z, side):
    """From the flat side (at z) to the wall."""
    if bevel <= 0.0:
        return [(0.0, z, (1.0, 0.0))]
    out = []
    for k in range(steps + 1):
        angle = 0.5 * math.pi * k / steps
        c, s = math.cos(angle), math.sin(angle)  # of the normal upwards and outwards
        out.append((bevel * (1.0 - s), z - side * bevel * (1.0 - c), (s, side * c)))
    return out


def profiled(size, line, bevel=0.45, corner=0.45, start=None, end=None):
    """Walls about a rectangle that follow a line of (outwards, height) points; going up outside a solid, down inside a
    hole. start, end: whether the flat end there looks up; None: it stays open."""
    first, last = line[0], line[-1]
    way = 1.0 if last[1] > first[1] else -1.0
    line = [(first[0] - way * 5.0, first[1])] + line + [(last[0] - way * 5.0 if way > 0 or end is None else last[0] - 5.0, last[1])]
    rows = []
    for (out, z), (n_out, n_up) in rounded(line, bevel, closes=False)[1:-1]:
        outline = rounded(rectangle(size[0] + 2 * out, size[1] + 2 * out), corner)
        row, along = [], 0.0
        for i, (p, n) in enumerate(outline + outline[:1]):
            along += math.dist(p, row[-1][0][:2]) if row else 0.0
            row.append(((p[0], p[1], z), (n_out * n[0], n_out * n[1], n_up), (along, -z)))
        rows.append(row)
    surface = grid(rows)
    for row, up in ((rows[0], start), (rows[-1], end)):
        if up is not None:
            ring = []
            for v in row[:-1]:
                q = (round(v[0][0], 6), round(v[0][1], 6))
                if q not in ring:
                    ring.append(q)
            surface.join(cap([ring], row[0][0][2], up))
    return surface


def box(size, z0, bevel=0.45, **options):
    """Width and depth about the origin, height from z0 on."""
    return extruded([rounded(rectangle(size[0], size[1]), max(bevel, 0.0))], z0, z0 + size[2], bevel, **options)


def tube(path, radius, sides=8, has_ends=True):
    """Along points; its frame is carried along without twist."""
    tangents = []
    for i in range(len(path)):
        tangents.append(unit(sub(path[min(i + 1, len(path) - 1)], path[max(i - 1, 0)])))
    x = unit(cross(tangents[0], (0.3, 0.2, 0.93)))
    rows, way = [], 0.0
    for i, (p, t) in enumerate(zip(path, tangents)):
        x = unit(sub(x, scale(dot(x, t), t)))
        y = cross(t, x)
        way += math.dist(p, path[i - 1]) if i > 0 else 0.0
        r = radius[i] if isinstance(radius, list) else radius
        row = []
        for j in range(sides + 1):
            angle = 2.0 * math.pi * (j % sides) / sides
            n = add(scale(math.cos(angle), x), scale(math.sin(angle), y))
            row.append((add(p, scale(r, n)), n, (2.0 * math.pi * r * j / sides, way)))
        rows.append(row)
    surface = grid(rows)
    if has_ends:
        for i, n in ((0, scale(-1.0, tangents[0])), (len(path) - 1, tangents[-1])):
            middle = surface.vertex(path[i], n, (0.0, 0.0))
            ring = [surface.vertex(v[0], n, (0.0, 0.0)) for v in rows[i][:-1]]
            for j in range(sides):
                a, b = ring[j], ring[(j + 1) % sides]
                surface.triangles.append((middle, b, a) if i == 0 else (middle, a, b))
    return surface


def smooth_path(points, steps=6):
    """Catmull-Rom spline through points."""
    out = []
    for i in range(len(points) - 1):
        p = [points[max(0, min(len(points) - 1, i + k))] for k in (-1, 0, 1, 2)]
        for k in range(steps):
            t = k / steps
            w = ((-t**3 + 2 * t**2 - t) / 2, (3 * t**3 - 5 * t**2 + 2) / 2, (-3 * t**3 + 4 * t**2 + t) / 2, (t**3 - t**2) / 2)
            out.append(tuple(sum(w[m] * p[m][a] for m in range(4)) for a in range(3)))
    out.append(points[-1])
    return out


def decal(width, height, uv=(0.0, 0.0, 1.0, 1.0)):
    """A rectangle in the xy plane; uv: left, top, right, bottom."""
    surface = Surface()
    n = (0.0, 0.0, 1.0)
    u0, v0, u1, v1 = uv
    surface.quad(surface.vertex((-width / 2, -height / 2, 0.0), n, (u0, v1)),
                 surface.vertex((width / 2, -height / 2, 0.0), n, (u1, v1)),
                 surface.vertex((width / 2, height / 2, 0.0), n, (u1, v0)),
                 surface.vertex((-width / 2, height / 2, 0.0), n, (u0, v0)))
    return surface


def screw(diameter, sides=8):
    """Cap head with a hexagonal socket, standing on z = 0."""
    r, h, s = 0.8 * diameter, 0.55 * diameter, 0.45 * diameter
    out, up, down = (1.0, 0.0), (0.0, 1.0), (-0.9, 0.44)
    return revolve([((r, 0.0), out), ((r - 0.1 * diameter, h), up), ((s, h), up), ((s, h), down), ((0.0, 0.4 * h), down)], sides)
