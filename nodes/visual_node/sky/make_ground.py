#!/usr/bin/env python3
"""Writes ground.png and lights.png from the pictures of the npm package three-globe 2.45.2:

    npm pack three-globe@2.45.2 && tar xzf three-globe-2.45.2.tgz
    make_ground.py package/example/img

1440 x 720 pixels, rows from the north pole, columns from 180 degrees west. ground.png: colours of the land, seen from above without clouds;
seas and lakes are transparent. lights.png: towns at night. Needs python3-pil and python3-numpy.
"""
import pathlib
import sys

import numpy as np
from PIL import Image

SIZE = (1440, 720)
HERE = pathlib.Path(__file__).parent


def read(name):
    return Image.open(pathlib.Path(sys.argv[1], name)).convert("RGB").resize(SIZE, Image.BOX)


def make_ground():
    is_water = np.asarray(read("earth-water.png"))[:, :, 0] > 127
    land = np.asarray(read("earth-blue-marble.jpg"))[~is_water]
    # The palette is that of the land alone; its last entry is the water.
    colors = Image.fromarray(land[None, :, :]).quantize(255, dither=Image.Dither.NONE)
    pixels = np.full(SIZE[::-1], 255, np.uint8)
    pixels[~is_water] = np.asarray(colors)[0]
    image = Image.fromarray(pixels, "P")
    image.putpalette((colors.getpalette() + [0] * 768)[:765] + [0, 0, 0])
    image.save(HERE / "ground.png", optimize=True, transparency=255)


def make_lights():
    # The picture has lights on a ground of moonlit blue, whose red is below 35; the brightest towns have about 125.
    night = np.asarray(Image.open(pathlib.Path(sys.argv[1], "earth-night.jpg")).convert("RGB")).astype(int)
    level = np.clip((night[:, :, 0] - 40) * 3, 0, 255).astype(np.uint8)
    coarse = np.asarray(Image.fromarray(level, "L").resize(SIZE, Image.BOX))
    Image.fromarray(coarse // 8 * 8, "L").save(HERE / "lights.png", optimize=True)


make_ground()
make_lights()
