#!/usr/bin/env python3
"""Writes bright.stars from the npm package d3-celestial 0.7.35, and from Debian's astrometry-data-tycho2-07-littleendian:

    npm pack d3-celestial@0.7.35 && tar xzf d3-celestial-0.7.35.tgz
    make_bright_stars.py package/data/stars.14.json /usr/share/astrometry/index-tycho2-07.littleendian.fits bright.stars

The first has magnitudes, colours, and places of Hipparcos that are rounded to 0.0001 degrees, 0.36 arc seconds. A star has
Tycho-2's place, moved into what rounds to the first one's, where Tycho-2 has one about as bright within 0.1 arc seconds of that;
those of double stars may be others there. Stars brighter than magnitude 2 keep theirs: Tycho-2 has them up to 0.5" off. The format is described in star_file.hpp; the test StarFile.* writes the same bytes from what it reads.
"""
import itertools
import json
import math
import struct
import sys

STEPS = (1 << 24) - 1


def octahedral(x, y, z):
    total = abs(x) + abs(y) + abs(z)
    u, v = x / total, y / total
    if z < 0.0:
        u, v = math.copysign(1.0 - abs(v), u), math.copysign(1.0 - abs(u), v)
    return [math.floor((0.5 * part + 0.5) * STEPS + 0.5) for part in (u, v)]


def fits_tables(data):
    """The data of each table, by the name of its first column."""
    tables, at = {}, 0
    while at < len(data):
        cards = {}
        while "END" not in cards:
            for card in range(at, at + 2880, 80):
                text = data[card:card + 80].decode("latin-1")
                cards[text[:8].strip()] = text[10:].split("/")[0].strip(" '")
            at += 2880
        size = int(cards["NAXIS1"]) * int(cards["NAXIS2"]) if cards.get("NAXIS") == "2" else 0
        tables[cards.get("TTYPE1")] = data[at:at + size]
        at += (size + 2879) // 2880 * 2880
    return tables


def direction(feature):
    longitude, latitude = (math.radians(angle) for angle in feature["geometry"]["coordinates"])
    return (math.cos(latitude) * math.cos(longitude), math.cos(latitude) * math.sin(longitude), math.sin(latitude))


ARC_SECOND = math.pi / 180.0 / 3600.0
CELL = 4.0 * ARC_SECOND
ROUNDED_deg = 0.5e-4
SLACK_deg = 0.1 / 3600.0
SAME_MAGNITUDE = 1.5
TOO_BRIGHT = 2.0  # as kTooBright of tycho2.cpp


def refined(star, feature):
    """The star's place, in what rounds to the feature's; None: too far from there."""
    longitude, latitude = feature["geometry"]["coordinates"]
    aside = (math.degrees(math.atan2(star[1], star[0])) - longitude + 180.0) % 360.0 - 180.0
    above = math.degrees(math.asin(max(-1.0, min(1.0, star[2])))) - latitude
    if abs(above) > ROUNDED_deg + SLACK_deg or abs(aside) > ROUNDED_deg + SLACK_deg / math.cos(math.radians(latitude)):
        return None
    limited = [max(-ROUNDED_deg, min(ROUNDED_deg, part)) for part in (aside, above)]
    return direction({"geometry": {"coordinates": (longitude + limited[0], latitude + limited[1])}})


def places_of(features, tycho2):
    """The place of each star: in Tycho-2, or else its own."""
    places = [direction(feature) for feature in features]
    magnitudes = [float(feature["properties"]["mag"]) for feature in features]
    cells = {}  # in which a star within an arc second of one of ours may be
    for i, place in enumerate(places):
        if magnitudes[i] < TOO_BRIGHT:
            continue
        near = [{math.floor((part + step) / CELL) for step in (-ARC_SECOND, ARC_SECOND)} for part in place]
        for cell in itertools.product(*near):
            cells.setdefault(cell, []).append(i)
    tables = fits_tables(tycho2)
    *low, _, _, _, scale = struct.unpack("<7d", tables["kdtree_range_stars"])
    best = {}
    for steps, (vt,) in zip(struct.iter_unpack("<3I", tables["kdtree_data_stars"]), struct.iter_unpack(">f", tables["MAG_VT"])):
        star = [first + step / scale for first, step in zip(low, steps)]
        for i in cells.get(tuple(math.floor(part / CELL) for part in star), ()):
            distance = math.dist(star, places[i])
            if distance < best.get(i, (ARC_SECOND,))[0] and abs(vt - magnitudes[i]) < SAME_MAGNITUDE:
                place = refined(star, features[i])
                if place:
                    best[i] = (distance, place)
    print(f"{len(best)} of {len(places)} have Tycho-2's place")
    return [best[i][1] if i in best else place for i, place in enumerate(places)]


def record(feature, place):
    u, v = octahedral(*place)
    magnitude = math.floor((float(feature["properties"]["mag"]) + 2.0) * 1000.0 + 0.5)
    color = feature["properties"]["bv"]
    color = min(max(math.floor((float(color or 0.7) + 0.5) * 50.0 + 0.5), 0), 255)
    return magnitude, u.to_bytes(3, "little") + v.to_bytes(3, "little") + struct.pack("<HB", magnitude, color)


def main():
    features = json.load(open(sys.argv[1], encoding="utf-8"))["features"]
    with open(sys.argv[2], "rb") as tycho2:
        places = places_of(features, tycho2.read())
    records = sorted(record(feature, place) for feature, place in zip(features, places))
    with open(sys.argv[3], "wb") as out:
        out.write(b"OOSSTAR1" + struct.pack("<I", len(records)))
        for _, data in records:
            out.write(data)


main()
