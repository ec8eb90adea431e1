#!/usr/bin/env python3
"""Writes ground.png, clouds.png and lights.png from the pictures of the npm package three-globe 2.45.2:

    npm pack three-globe@2.45.2 && tar xzf three-globe-2.45.2.tgz
    make_ground.py package/example

2048 x 1024 pixels, rows from the north pole, columns from 180 degrees west. ground.png: colours of the land, seen from above without clouds;
seas and lakes are transparent. clouds.png: the share of the ground that clouds hide, on a fair day. lights.png: towns at night, 1440 x 720.
Needs python3-pil and python3-numpy.
"""
import pathlib
import sys

import numpy as np
from PIL import Image

SIZE = (2048, 1024)
LIGHTS_SIZE = (1440, 720)
HERE = pathlib.Path(__file__).parent


def read(name):
    return Image.open(pathlib.Path(sys.argv[1], "img", name)).convert("RGB").resize(SIZE, Image.BOX)


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


def make_clouds():
    alpha = Image.open(pathlib.Path(sys.argv[1], "clouds", "clouds.png")).convert("RGBA").getchannel("A").resize(SIZE, Image.BOX)
    levels = 16
    image = Image.fromarray(np.round(np.asarray(alpha) / 255 * (levels - 1)).astype(np.uint8), "P")
    image.putpalette([grey for k in range(levels) for grey in [round(255 * k / (levels - 1))] * 3])
    image.save(HERE / "clouds.png", optimize=True)


def make_lights():
    # The picture has lights on a ground of moonlit blue, whose red is below 35; the brightest towns have about 125.
    night = np.asarray(Image.open(pathlib.Path(sys.argv[1], "img", "earth-night.jpg")).convert("RGB")).astype(int)
    level = np.clip((night[:, :, 0] - 40) * 3, 0, 255).astype(np.uint8)
    coarse = np.asarray(Image.fromarray(level, "L").resize(LIGHTS_SIZE, Image.BOX))
    Image.fromarray(coarse // 8 * 8, "L").save(HERE / "lights.png", optimize=True)


make_ground()
make_clouds()
make_lights()
