"""What the parts of the mock-ups are made of. Colours are linear."""
from visual import pictures
from visual.model import Material

BRUSHED = pictures.brushed()

ALUMINIUM = Material("aluminium", (0.66, 0.67, 0.69), 1.0, 0.46, surface=BRUSHED, tile=60.0)
ALODINE = Material("alodine", (0.62, 0.55, 0.40), 1.0, 0.50, surface=BRUSHED, tile=60.0)
STEEL = Material("steel", (0.58, 0.57, 0.55), 1.0, 0.24)
NICKEL = Material("nickel", (0.60, 0.57, 0.50), 1.0, 0.34)
SCREW = Material("screw", (0.40, 0.39, 0.38), 1.0, 0.30)
BLACK = Material("anodised_black", (0.030, 0.031, 0.034), 0.25, 0.46)
GREY = Material("anodised_grey", (0.20, 0.21, 0.23), 0.70, 0.44)
ORANGE = Material("anodised_orange", (0.80, 0.22, 0.025), 0.45, 0.36)
RED = Material("anodised_red", (0.42, 0.035, 0.03), 0.50, 0.42)
GREEN = Material("anodised_green", (0.03, 0.22, 0.09), 0.50, 0.42)
YELLOW = Material("yellow", (0.80, 0.47, 0.02), 0.0, 0.42)
WHITE = Material("white_paint", (0.80, 0.80, 0.78), 0.0, 0.48)
RUBBER = Material("rubber", (0.022, 0.022, 0.024), 0.0, 0.80)
CABLE = Material("cable_white", (0.74, 0.74, 0.72), 0.0, 0.38)
CABLE_GREY = Material("cable_grey", (0.20, 0.21, 0.22), 0.0, 0.45)
CABLE_BLUE = Material("cable_blue", (0.05, 0.10, 0.32), 0.0, 0.40)
TAPE = Material("kapton", (0.62, 0.27, 0.03), 0.25, 0.30)
GOLD = Material("gold", (0.95, 0.70, 0.30), 1.0, 0.22)
DARK = Material("shade", (0.010, 0.010, 0.011), 0.0, 0.7)
GOLD_RAIL = Material("anodised_gold", (0.78, 0.50, 0.14), 0.8, 0.34)
LOOP = Material("loop", (0.020, 0.020, 0.022), 0.0, 0.95)
CARBON = Material("carbon", (0.030, 0.030, 0.032), 0.0, 0.40)
FOIL = Material("mli_gold", (0.94, 0.64, 0.25), 1.0, 0.28)
NOZZLE = Material("nozzle", (0.26, 0.22, 0.20), 1.0, 0.38)
MIRROR = Material("mirror", (0.90, 0.91, 0.93), 1.0, 0.10)
CLOTH_RED = Material("cloth_red", (0.55, 0.03, 0.025), 0.0, 0.85, normal=pictures.weave(), tile=10.0)
CELLS = Material("solar_cells", (1.0, 1.0, 1.0), 0.0, 0.40, base=pictures.solar_cells(), tile=60.0, coat=(1.0, 0.08))
HOUSING = Material("housing", (0.055, 0.058, 0.064), 0.35, 0.40)
STEEL_SATIN = Material("steel_satin", (0.56, 0.56, 0.55), 1.0, 0.36, surface=BRUSHED, tile=24.0)
PAD = Material("pad", (0.03, 0.03, 0.032), 0.0, 0.7, normal=pictures.ribs())
GREEN_LIGHT = Material("light_green", (0.02, 0.25, 0.05), 0.0, 0.3, glow=(0.1, 1.4, 0.3))


def labels(sheet):
    return Material("labels", (0.92, 0.92, 0.92), 0.0, 0.42, base=sheet.picture)
