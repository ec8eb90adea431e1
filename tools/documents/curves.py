"""Charts of measured values, as SVG: how they are distributed, or one for each series."""
from math import log10

COLOURS = ["#4477aa", "#ee6677", "#228833", "#ccbb44", "#66ccee", "#aa3377"]
WIDTH, HEIGHT, LEFT, TOP, BOTTOM, RIGHT = 720, 360, 56, 16, 44, 250
LEAST, MOST = 0.1, 10.0
POINTS = 200


def quantile(values, share):
    return values[min(int(share * len(values)), len(values) - 1)]


def write_shares(path, label, series):
    """The share of values below each value, from LEAST to MOST on a logarithmic axis; `series`: name to values."""
    def x(value):
        span = WIDTH - LEFT - RIGHT
        decades = log10(MOST / LEAST)
        return LEFT + span * log10(min(max(value, LEAST), MOST) / LEAST) / decades

    def y(share):
        return HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM)

    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="12">',
             f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>']
    for value in [0.1, 0.2, 0.5, 1, 2, 5, 10]:
        parts.append(f'<path d="M{x(value):.1f} {y(0):.1f}V{y(1):.1f}" stroke="#dddddd"/>'
                     f'<text x="{x(value):.1f}" y="{y(0) + 16:.1f}" text-anchor="middle">{value:g}</text>')
    for share in [0, 0.25, 0.5, 0.75, 1]:
        parts.append(f'<path d="M{x(LEAST):.1f} {y(share):.1f}H{x(MOST):.1f}" stroke="#dddddd"/>'
                     f'<text x="{LEFT - 6}" y="{y(share) + 4:.1f}" text-anchor="end">{share:g}</text>')
    parts.append(f'<text x="{(x(LEAST) + x(MOST)) / 2:.1f}" y="{HEIGHT - 8}" text-anchor="middle">{label}</text>')
    parts.append(f'<text transform="translate(14 {y(0.5):.1f}) rotate(-90)" text-anchor="middle">share below</text>')
    for i, (name, values) in enumerate((name, sorted(values)) for name, values in series.items() if values):
        colour = COLOURS[i % len(COLOURS)]
        points = " ".join(f"{x(quantile(values, k / POINTS)):.1f},{y(k / POINTS):.1f}" for k in range(POINTS + 1))
        parts.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2"/>'
                     f'<text x="{WIDTH - RIGHT + 12}" y="{TOP + 14 + 18 * i}" fill="{colour}">{name}</text>')
    parts.append("</svg>\n")
    path.write_text("\n".join(parts), encoding="utf-8")


def write_bars(path, label, values):
    """A bar from 0 for each name of `values`."""
    row, right, left = 30, 40, 220
    height = TOP + row * len(values) + BOTTOM
    scale = (WIDTH - left - right) / (max(values.values(), default=0.0) or 1.0)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" font-family="sans-serif" font-size="12">',
             f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
             f'<path d="M{left} {TOP}V{height - BOTTOM}" stroke="#888888"/>',
             f'<text x="{(left + WIDTH - right) / 2:.1f}" y="{height - 12}" text-anchor="middle">{label}</text>']
    for i, (name, value) in enumerate(values.items()):
        y = TOP + row * i
        parts.append(f'<rect x="{left}" y="{y + 5}" width="{value * scale:.1f}" height="{row - 10}" fill="{COLOURS[i % len(COLOURS)]}"/>'
                     f'<text x="{left - 8}" y="{y + 19}" text-anchor="end">{name}</text>'
                     f'<text x="{left + value * scale + 6:.1f}" y="{y + 19}">{value:.3g}</text>')
    parts.append("</svg>\n")
    path.write_text("\n".join(parts), encoding="utf-8")
