#!/usr/bin/env python3
"""Turns what OpenSCAD wrote (OFF, millimetres) into the meshes of a scenario (metres), and checks them.

  mesh_tool.py obj OUT.obj IN.off     collision and plain visual meshes
  mesh_tool.py check FILE.obj...      closed, manifold, outward, no slivers

Only needed to regenerate meshes; Python's standard library is enough.
"""
import math
import sys

WELD_M = 1e-6


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def norm(a):
    return math.sqrt(dot(a, a))


def weld(points, faces):
    """Merges points closer than WELD_M (grid snap) and drops the triangles that collapse."""
    index, out, remap = {}, [], []
    for p in points:
        key = tuple(round(c / WELD_M) for c in p)
        if key not in index:
            index[key] = len(out)
            out.append(tuple(k * WELD_M for k in key))
        remap.append(index[key])
    tris = []
    for f in faces:
        t = tuple(remap[i] for i in f)
        if len(set(t)) == 3:
            tris.append(t)
    return out, tris


def triangulate(points, polygon):
    """Ear clipping in the polygon's plane; OpenSCAD's polygons are planar but need not be convex."""
    n = (0.0, 0.0, 0.0)
    for i in range(len(polygon)):
        a, b = points[polygon[i]], points[polygon[(i + 1) % len(polygon)]]
        c = cross(a, b)
        n = (n[0] + c[0], n[1] + c[1], n[2] + c[2])
    ring, tris = list(polygon), []
    while len(ring) > 3:
        for i in range(len(ring)):
            ia, ib, ic = ring[i - 1], ring[i], ring[(i + 1) % len(ring)]
            a, b, c = points[ia], points[ib], points[ic]
            if dot(cross(sub(b, a), sub(c, b)), n) <= 0.0:
                continue
            inside = False
            for j in ring:
                if j in (ia, ib, ic):
                    continue
                p = points[j]
                if all(dot(cross(sub(e1, e0), sub(p, e0)), n) >= 0.0 for e0, e1 in ((a, b), (b, c), (c, a))):
                    inside = True
                    break
            if not inside:
                tris.append((ia, ib, ic))
                ring.pop(i)
                break
        else:
            raise SystemExit("cannot triangulate a polygon: export the part again")
    tris.append(tuple(ring))
    return tris


def read_off(path):
    words = []
    with open(path) as file:
        for line in file:
            words += line.split("#")[0].split()
    if words[0] != "OFF":
        raise SystemExit(f"{path}: not an OFF file")
    num_points, num_faces = int(words[1]), int(words[2])
    at = 4
    points = []
    for _ in range(num_points):
        points.append(tuple(float(w) * 1e-3 for w in words[at : at + 3]))
        at += 3
    # OpenSCAD's order changes from run to run: sort, so that the same part gives the same file.
    order = sorted(range(num_points), key=lambda i: points[i])
    points = [points[i] for i in order]
    place = {old: new for new, old in enumerate(order)}
    faces = []
    for _ in range(num_faces):
        count = int(words[at])
        polygon = [place[int(w)] for w in words[at + 1 : at + 1 + count]]
        at += 1 + count
        first = polygon.index(min(polygon))
        polygon = polygon[first:] + polygon[:first]
        faces += triangulate(points, polygon) if count > 3 else [tuple(polygon)]
    faces.sort()
    return weld(points, faces)


def read_obj(path):
    points, faces = [], []
    with open(path) as file:
        for line in file:
            w = line.split()
            if w and w[0] == "v":
                points.append(tuple(float(x) for x in w[1:4]))
            elif w and w[0] == "f":
                faces.append(tuple(int(x.split("/")[0]) - 1 for x in w[1:4]))
    return points, faces


def check(path, points, tris):
    """Each directed edge once and its opposite once: closed, manifold, consistently oriented. Positive volume: outward."""
    edges = {}
    for t in tris:
        for i in range(3):
            e = (t[i], t[(i + 1) % 3])
            edges[e] = edges.get(e, 0) + 1
    problems = []
    bad = [e for e, n in edges.items() if n != 1 or edges.get((e[1], e[0])) != 1]
    if bad:
        problems.append(f"{len(bad)} edges are open, shared by more than two faces or turned; first at {points[bad[0][0]]}")
    # Around each vertex the faces must form one fan, else two solids touch in a point.
    fans = {}
    for t in tris:
        for i in range(3):
            fans.setdefault(t[i], {})[t[(i + 1) % 3]] = t[(i + 2) % 3]
    for v, ring in fans.items():
        start = next(iter(ring))
        at, steps = ring[start], 1
        while at != start and at in ring and steps <= len(ring):
            at, steps = ring[at], steps + 1
        if steps != len(ring):
            problems.append(f"the faces around {points[v]} are not one fan")
            break
    volume = sum(dot(points[a], cross(points[b], points[c])) for a, b, c in tris) / 6.0
    if volume <= 0.0:
        problems.append(f"faces look inward: volume {volume:.3e} m3")
    area = 0.0
    for a, b, c in tris:
        face_area = 0.5 * norm(cross(sub(points[b], points[a]), sub(points[c], points[a])))
        area += face_area
        if face_area <= 1e-14:
            problems.append(f"a triangle without area at {points[a]}")
            break
    low = [1e3 * min(p[i] for p in points) for i in range(3)]
    high = [1e3 * max(p[i] for p in points) for i in range(3)]
    print(
        f"{path}: {len(points)} points, {len(tris)} triangles, {volume * 1e6:.2f} cm3, {area * 1e4:.1f} cm2, box "
        + " x ".join(f"[{l:.2f}, {h:.2f}]" for l, h in zip(low, high))
        + " mm"
        + "".join("\n  PROBLEM: " + p for p in problems)
    )
    return not problems


def write_obj(path, points, tris):
    with open(path, "w") as file:
        file.write("# metres; generated by scenarios/build_meshes.sh\n")
        for p in points:
            file.write("v " + " ".join(f"{c:.6f}".rstrip("0").rstrip(".") or "0" for c in p) + "\n")
        for a, b, c in tris:
            file.write(f"f {a + 1} {b + 1} {c + 1}\n")


def main(arguments):
    verb, rest = arguments[0], arguments[1:]
    if verb == "obj":
        points, tris = read_off(rest[1])
        write_obj(rest[0], points, tris)
        return 0 if check(rest[0], points, tris) else 1
    if verb == "check":
        return 0 if all([check(path, *read_obj(path)) for path in rest]) else 1
    raise SystemExit(__doc__)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
