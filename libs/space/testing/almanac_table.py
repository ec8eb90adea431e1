#!/usr/bin/env python3
"""Writes almanac.csv, the reference of almanac_test.cpp: almanac_table.py > almanac.csv

Sun and Moon are those of PyEphem (VSOP87 and the Moon of XEphem's libastro), the Earth's orientation is Skyfield's (the
nutation of NOVAS, UT1 from its built-in table). Neither uses ERFA. Debian packages: python3-ephem, python3-skyfield.
"""
import math

import ephem
import numpy
from skyfield.api import load
from skyfield.framelib import itrs

NUM_EPOCHS = 74
STEP_DAYS = 4.973  # a year, through all hours of the day


def direction(ra, dec):
    return numpy.array([math.cos(dec) * math.cos(ra), math.cos(dec) * math.sin(ra), math.sin(dec)])


def main():
    timescale = load.timescale(builtin=True)
    print("# Written by almanac_table.py with PyEphem", ephem.__version__, "and Skyfield; directions in the celestial frame")
    print("utc,sun_x,sun_y,sun_z,moon_x_km,moon_y_km,moon_z_km," + ",".join(f"R_CE_{i}{j}" for i in range(3) for j in range(3)))
    start = ephem.Date("2016/1/1 00:00:00")
    for k in range(NUM_EPOCHS):
        date = ephem.Date(round((start + k * STEP_DAYS) * 86400.0) / 86400.0)
        year, month, day, hour, minute, second = date.tuple()
        second = round(second)
        date = ephem.Date(f"{year}/{month}/{day} {hour}:{minute}:{second}")
        time = timescale.utc(year, month, day, hour, minute, second)
        of_date = time.M.T  # from the true equator and equinox of date to the celestial frame
        sun, moon = ephem.Sun(date), ephem.Moon(date)
        # g_ra and g_dec: apparent, from the Earth's centre, of date.
        sun_C = of_date @ direction(sun.g_ra, sun.g_dec)
        moon_C = of_date @ direction(moon.g_ra, moon.g_dec) * moon.earth_distance * 149597870.7
        R_CE = itrs.rotation_at(time).T
        utc = f"{year:04d}-{month:02d}-{day:02d}T{hour:02d}:{minute:02d}:{second:02d}Z"
        values = [f"{v:.9f}" for v in sun_C] + [f"{v:.1f}" for v in moon_C] + [f"{v:.9f}" for v in R_CE.flatten()]
        print(",".join([utc] + values))


main()
