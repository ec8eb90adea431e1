"""A part of a picture: surfaces with materials, written as GLB (metres)."""
import json
import math
import struct

from visual import shapes


class Material:
    """`tile`: the side of a repeated texture, mm; 0: the surfaces have coordinates of their own. `coat`: the share that clear
    lacquer covers, and its roughness. `glow`: light of its own; 1 is a white wall in the sun."""

    def __init__(self, name, color, metallic, roughness, base=None, surface=None, normal=None, tile=0.0, occludes=False,
                 coat=(0.0, 0.0), glow=(0.0, 0.0, 0.0)):
        self.coat, self.glow = coat, glow
        self.name, self.color, self.metallic, self.roughness = name, color, metallic, roughness
        self.base, self.surface, self.normal, self.tile, self.occludes = base, surface, normal, tile, occludes


class Text:
    """A file that is not a picture."""

    def __init__(self, text):
        self.text = text

    def data(self):
        return self.text.encode()

    def what(self):
        return "text"


class Model:
    """`joints`: names of what a skin goes with. `rest`: a pose for each, axes and origin, of its frame in the mesh frame at rest;
    without it all are the mesh frame."""

    def __init__(self, joints=(), rest=None):
        self.rest = rest
        self.parts = {}  # material name: (material, vertex index, vertices, triangles)
        self.joints = list(joints)
        self.variants = {}  # name: {material name: the material that takes its place}

    def add(self, material, surface, frame=None, shares=None):
        """`shares` of a skin: a function of the texture coordinates that returns {joint: share}; at most four."""
        _, index, vertices, triangles = self.parts.setdefault(material.name, (material, {}, [], []))
        if frame is not None:
            surface = surface.placed(frame)
        has_texture = material.base or material.surface or material.normal
        places = []
        for p, n, uv in surface.vertices:
            given = uv
            if not has_texture:
                uv = (0.0, 0.0)
            elif material.tile > 0.0:
                u, v = uv if uv is not None else _across(p, n)
                uv = (u / material.tile, v / material.tile)
            elif uv is None:
                raise SystemExit(f"{material.name}: a surface without texture coordinates")
            n = shapes.unit(n)
            key = tuple(round(c, 4) + 0.0 for c in p) + tuple(round(c, 3) + 0.0 for c in n) + tuple(round(c, 5) + 0.0 for c in uv)
            if self.joints:
                key += self._weights(shares(given) if callable(shares) else shares)
            if key not in index:
                index[key] = len(vertices)
                vertices.append(key)
            places.append(index[key])
        for a, b, c in surface.triangles:
            t = (places[a], places[b], places[c])
            p = [vertices[i][:3] for i in t]
            area = shapes.cross(shapes.sub(p[1], p[0]), shapes.sub(p[2], p[0]))
            if len(set(t)) == 3 and math.sqrt(shapes.dot(area, area)) > 1e-7:
                triangles.append(t)
        return self

    def _weights(self, shares):
        pairs = [(self.joints.index(name), round(share, 4)) for name, share in shares.items() if round(share, 4) > 0.0]
        pairs += [(0, 0.0)] * (4 - len(pairs))
        return tuple(number for number, _ in pairs) + tuple(share for _, share in pairs)

    def _bind(self, name):
        """Of a joint, column by column: the mesh frame's pose in its own at rest, R^T and -R^T p."""
        axes, origin = self.rest[name] if self.rest else (((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0))
        columns = [[axes[row][column] for row in range(3)] + [0.0] for column in range(3)]
        columns.append([-1e-3 * shapes.dot(axis, origin) + 0.0 for axis in axes] + [1.0])
        return struct.pack("<16f", *(c for column in columns for c in column))

    def what(self):
        return f"{self.num_triangles()} triangles"

    def num_triangles(self):
        return sum(len(part[3]) for part in self.parts.values())

    def data(self):
        blob, views, accessors, primitives, materials, images = bytearray(), [], [], [], [], {}

        def view(data, target=None):
            blob.extend(bytes(-len(blob) % 4))
            views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(data), **({"target": target} if target else {})})
            blob.extend(data)
            return len(views) - 1

        def accessor(data, target, **rest):
            accessors.append({"bufferView": view(data, target), **rest})
            return len(accessors) - 1

        def texture(picture):
            if id(picture) not in images:
                images[id(picture)] = (len(images), view(picture.png()))
            return {"index": images[id(picture)][0]}

        for material, _, vertices, triangles in self.parts.values():
            count = len(vertices)
            points = [[_single(c * 1e-3) for c in v[:3]] for v in vertices]
            attributes = {
                "POSITION": accessor(b"".join(struct.pack("<3f", *p) for p in points), 34962, componentType=5126, count=count,
                                     type="VEC3", min=[min(p[i] for p in points) for i in range(3)],
                                     max=[max(p[i] for p in points) for i in range(3)]),
                "NORMAL": accessor(b"".join(struct.pack("<3f", *shapes.unit(v[3:6])) for v in vertices), 34962,
                                   componentType=5126, count=count, type="VEC3"),
            }
            if material.base or material.surface or material.normal:
                attributes["TEXCOORD_0"] = accessor(b"".join(struct.pack("<2f", *v[6:8]) for v in vertices), 34962,
                                                    componentType=5126, count=count, type="VEC2")
            if self.joints:
                attributes["JOINTS_0"] = accessor(b"".join(struct.pack("<4B", *v[8:12]) for v in vertices), 34962,
                                                  componentType=5121, count=count, type="VEC4")
                attributes["WEIGHTS_0"] = accessor(b"".join(struct.pack("<4f", *v[12:]) for v in vertices), 34962,
                                                   componentType=5126, count=count, type="VEC4")
            kind, code = (5123, "<3H") if count < 65536 else (5125, "<3I")
            indices = accessor(b"".join(struct.pack(code, *t) for t in triangles), 34963, componentType=kind,
                               count=3 * len(triangles), type="SCALAR")
            materials.append(_entry(material, texture))
            primitives.append({"attributes": attributes, "indices": indices, "material": len(materials) - 1, "mode": 4})
            mappings = []
            for number, others in enumerate(self.variants.values()):
                if material.name in others:
                    materials.append(_entry(others[material.name], texture))
                    mappings.append({"material": len(materials) - 1, "variants": [number]})
            if mappings:
                primitives[-1]["extensions"] = {VARIANTS: {"mappings": mappings}}
        blob.extend(bytes(-len(blob) % 4))
        document = {"asset": {"version": "2.0", "generator": "scenarios/tools/make_visuals.py"}, "scene": 0,
                    "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": primitives}],
                    "materials": materials, "accessors": accessors, "bufferViews": views,
                    "buffers": [{"byteLength": len(blob)}]}
        if images:
            document["textures"] = [{"source": number, "sampler": 0} for number, _ in images.values()]
            document["images"] = [{"bufferView": place, "mimeType": "image/png"} for _, place in images.values()]
            document["samplers"] = [{"magFilter": 9729, "minFilter": 9985, "wrapS": 10497, "wrapT": 10497}]
        if self.joints:
            accessors.append({"bufferView": view(b"".join(self._bind(name) for name in self.joints)), "componentType": 5126, "count": len(self.joints),
                              "type": "MAT4"})
            blob.extend(bytes(-len(blob) % 4))
            document["buffers"][0]["byteLength"] = len(blob)
            document["nodes"] = [{"mesh": 0, "skin": 0}] + [{"name": name} for name in self.joints]
            document["scenes"][0]["nodes"] = list(range(len(self.joints) + 1))
            document["skins"] = [{"joints": list(range(1, len(self.joints) + 1)), "inverseBindMatrices": len(accessors) - 1}]
        used = sorted({name for entry in materials for name in entry.get("extensions", {})} | ({VARIANTS} if self.variants else set()))
        if used:
            document["extensionsUsed"] = used
        if self.variants:
            document["extensions"] = {VARIANTS: {"variants": [{"name": name} for name in self.variants]}}
        text = json.dumps(document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(blob), 0x004E4942) + bytes(blob)
        return struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body


VARIANTS = "KHR_materials_variants"


def _entry(material, texture):
    look = {"baseColorFactor": [*material.color, 1.0], "metallicFactor": material.metallic, "roughnessFactor": material.roughness}
    entry = {"name": material.name, "pbrMetallicRoughness": look}
    if material.base:
        look["baseColorTexture"] = texture(material.base)
    if material.surface:
        look["metallicRoughnessTexture"] = texture(material.surface)
        if material.occludes:
            entry["occlusionTexture"] = texture(material.surface)
    if material.normal:
        entry["normalTexture"] = texture(material.normal)
    extensions = {}
    if material.coat[0] > 0.0:
        extensions["KHR_materials_clearcoat"] = {"clearcoatFactor": material.coat[0], "clearcoatRoughnessFactor": material.coat[1]}
    strength = max(material.glow)
    if strength > 0.0:
        entry["emissiveFactor"] = [c / max(strength, 1.0) for c in material.glow]
        if strength > 1.0:
            extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
    if extensions:
        entry["extensions"] = extensions
    return entry


def _single(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def _across(p, n):
    """Texture coordinates in mm of a place, seen along the axis nearest to its normal."""
    axis = max(range(3), key=lambda i: abs(n[i]))
    return [(p[1], -p[2]), (p[0], -p[2]), (p[0], -p[1])][axis]
