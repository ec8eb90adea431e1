"""Pictures for textures: noise, lettering and signs, solar cells; as PNG files, the same bits each time."""
import math
import struct
import zlib

# Letters as strokes on a grid 4 wide and 6 high; a blank separates the points, a semicolon the strokes.
LETTERS = {
    "A": "00 04 26 44 40;02 42", "B": "00 06 36 45 44 33 03;33 42 41 30 00", "C": "41 30 10 01 05 16 36 45",
    "D": "00 06 36 45 41 30 00", "E": "40 00 06 46;03 33", "F": "00 06 46;03 33", "G": "45 36 16 05 01 10 30 41 43 23",
    "H": "00 06;40 46;03 43", "I": "10 30;20 26;16 36", "J": "01 10 30 41 46", "K": "00 06;46 02;13 40", "L": "06 00 40",
    "M": "00 06 23 46 40", "N": "00 06 40 46", "O": "10 01 05 16 36 45 41 30 10", "P": "00 06 36 45 44 33 03",
    "Q": "10 01 05 16 36 45 41 30 10;22 40", "R": "00 06 36 45 44 33 03;23 40",
    "S": "01 10 30 41 42 33 13 04 05 16 36 45", "T": "06 46;26 20", "U": "06 01 10 30 41 46", "V": "06 20 46",
    "W": "06 10 23 30 46", "X": "00 46;06 40", "Y": "06 23 46;23 20", "Z": "06 46 00 40",
    "0": "10 01 05 16 36 45 41 30 10;01 45", "1": "15 26 20;10 30", "2": "05 16 36 45 44 00 40",
    "3": "05 16 36 45 44 33 42 41 30 10 01;13 33", "4": "30 36 02 42", "5": "46 06 03 33 42 41 30 10 01",
    "6": "45 36 16 05 01 10 30 41 42 33 03", "7": "06 46 20", "8": "13 04 05 16 36 45 44 33 13 02 01 10 30 41 42 33",
    "9": "01 10 30 41 45 36 16 05 04 13 43", "-": "13 33", "/": "00 46", ".": "19 20", ":": "21 22;24 25", "+": "13 33;22 24",
    ">": "05 43 01", "<": "45 03 41", "(": "36 25 21 30", ")": "16 25 21 10", "_": "00 40", " ": "",
}
LETTERS["."] = "20 20"


class Picture:
    """Colours from 0 to 1, as they are shown (sRGB) or as plain numbers."""

    def __init__(self, width, height, color=(1.0, 1.0, 1.0)):
        self.width, self.height = width, height
        self.rows = [[color] * width for _ in range(height)]

    def blend(self, x, y, color, alpha):
        if 0 <= x < self.width and 0 <= y < self.height and alpha > 0.0:
            old = self.rows[y][x]
            alpha = min(alpha, 1.0)
            self.rows[y][x] = tuple(o + alpha * (c - o) for o, c in zip(old, color))

    def fill(self, x0, y0, x1, y1, color):
        for y in range(max(0, math.floor(y0)), min(self.height, math.ceil(y1))):
            cover_y = min(y + 1, y1) - max(y, y0)
            for x in range(max(0, math.floor(x0)), min(self.width, math.ceil(x1))):
                self.blend(x, y, color, cover_y * (min(x + 1, x1) - max(x, x0)))

    def stroke(self, points, width, color):
        """A line with round ends, smooth at its edges."""
        boxes = {}
        for (ax, ay), (bx, by) in zip(points, points[1:] if len(points) > 1 else points):
            reach = width / 2 + 1
            dx, dy = bx - ax, by - ay
            square = dx * dx + dy * dy
            for y in range(math.floor(min(ay, by) - reach), math.ceil(max(ay, by) + reach) + 1):
                for x in range(math.floor(min(ax, bx) - reach), math.ceil(max(ax, bx) + reach) + 1):
                    px, py = x + 0.5 - ax, y + 0.5 - ay
                    t = min(1.0, max(0.0, (px * dx + py * dy) / square)) if square > 0.0 else 0.0
                    alpha = width / 2 + 0.5 - math.hypot(px - t * dx, py - t * dy)
                    if alpha > boxes.get((x, y), 0.0):
                        boxes[(x, y)] = alpha
        for (x, y), alpha in boxes.items():
            self.blend(x, y, color, alpha)

    def text(self, x, y, height, text, color, weight=0.14, align="left"):
        """Capital letters; (x, y): the lower end of the line."""
        unit = height / 6.0
        advance = 5.6 * unit
        if align == "middle":
            x -= (len(text) * advance - 1.6 * unit) / 2
        for letter in text.upper():
            for line in filter(None, LETTERS[letter].split(";")):
                points = [(x + int(p[0]) * unit, y - int(p[1]) * unit) for p in line.split()]
                self.stroke(points, weight * height, color)
            x += advance

    def png(self):
        raw = bytearray()
        before = bytes(3 * self.width)
        for row in self.rows:
            line = bytes(min(255, max(0, int(c * 255.0 + 0.5))) for pixel in row for c in pixel)
            # Each line as the difference to the one above, where that packs better.
            up = bytes((a - b) & 255 for a, b in zip(line, before))
            if sum(min(c, 256 - c) for c in up) < sum(min(c, 256 - c) for c in line):
                raw += b"\2" + up
            else:
                raw += b"\0" + line
            before = line

        def chunk(kind, data):
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

        head = struct.pack(">IIBBBBB", self.width, self.height, 8, 2, 0, 0, 0)
        return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(raw), 9)) + chunk(b"IEND", b"")


def noise(x, y, seed):
    """In [0, 1), the same on every machine."""
    h = (x * 0x9E3779B1 ^ y * 0x85EBCA77 ^ seed * 0xC2B2AE3D) & 0xFFFFFFFF
    h = ((h ^ h >> 15) * 0x2C1B3C6D) & 0xFFFFFFFF
    h = ((h ^ h >> 12) * 0x297A2D39) & 0xFFFFFFFF
    h ^= h >> 15
    return (h & 0xFFFF) / 65536.0


def smooth_noise(x, y, cells_x, cells_y, seed):
    """Repeats itself after `cells`."""
    i, j = math.floor(x), math.floor(y)
    s, t = x - i, y - j
    s, t = s * s * (3.0 - 2.0 * s), t * t * (3.0 - 2.0 * t)

    def at(a, b):
        return noise(a % cells_x, b % cells_y, seed)

    low = at(i, j) + s * (at(i + 1, j) - at(i, j))
    high = at(i, j + 1) + s * (at(i + 1, j + 1) - at(i, j + 1))
    return low + t * (high - low)


def quantized(value, steps=32):
    """Fewer codes make smaller files; the eye sees none of it in roughness."""
    return math.floor(value * steps + 0.5) / steps


def brushed(size=128):
    """Occlusion, roughness, metal of metal brushed along u; a tile."""
    picture = Picture(size, size)
    for y in range(size):
        for x in range(size):
            grain = noise(0, y, 3) * 0.45 + 0.35 * smooth_noise(x / 32.0, y, size // 32, size, 5)
            cloud = smooth_noise(x / 32.0, y / 32.0, size // 32, size // 32, 7)
            picture.rows[y][x] = (1.0, quantized(0.62 + 0.30 * grain + 0.20 * cloud), 1.0)
    return picture


def weave(size=64):
    """Normals of woven cloth; a tile of 8 x 8 threads."""
    picture = Picture(size, size)
    step = size // 8
    for y in range(size):
        for x in range(size):
            is_over = (x // step + y // step) % 2 == 0
            along = ((x if is_over else y) % step + 0.5) / step - 0.5
            across = ((y if is_over else x) % step + 0.5) / step - 0.5
            tilt = (0.45 * along, 1.0 * across) if is_over else (1.0 * across, 0.45 * along)
            length = math.sqrt(tilt[0] ** 2 + tilt[1] ** 2 + 1.0)
            picture.rows[y][x] = ((128 + 127 * tilt[0] / length) / 255, (128 - 127 * tilt[1] / length) / 255,
                                  (128 + 127 / length) / 255)
    return picture


def ribs(size=32):
    """Normals of a ribbed grip; one rib across v."""
    picture = Picture(size, size)
    for y in range(size):
        tilt = 0.9 * math.sin(2.0 * math.pi * (y + 0.5) / size) * abs(math.sin(2.0 * math.pi * (y + 0.5) / size))
        length = math.sqrt(tilt * tilt + 1.0)
        picture.rows[y] = [(128 / 255, (128 - 127 * tilt / length) / 255, (128 + 127 / length) / 255)] * size
    return picture


def solar_cells(size=128):
    """Colour of one tile of 2 x 1 cells with cropped corners, busbars and fingers, on a carrier."""
    picture = Picture(size, size, (0.16, 0.15, 0.13))
    for cell in range(2):
        tint = 0.03 * cell
        x0, x1, y0, y1 = cell * size / 2 + 1.5, (cell + 1) * size / 2 - 1.5, 2.0, size - 2.0
        for y in range(size):
            for x in range(int(cell * size / 2), int((cell + 1) * size / 2)):
                edge = min(x + 0.5 - x0, x1 - x - 0.5, y + 0.5 - y0, y1 - y - 0.5)
                corner = min(x + 0.5 - x0, x1 - x - 0.5) + min(y + 0.5 - y0, y1 - y - 0.5) - 10.0
                alpha = min(edge, corner / 1.4)
                glow = 0.02 * smooth_noise(x / 16.0, y / 16.0, size // 16, size // 16, 11)
                picture.blend(x, y, (0.055 + tint + glow, 0.075 + tint + glow, 0.16 + 1.4 * tint + 2 * glow), alpha + 0.5)
        for y in range(4, size - 3, 4):
            picture.fill(x0 + 2, y, x1 - 2, y + 0.35, (0.24, 0.27, 0.36))
        for k in (0.28, 0.72):
            x = x0 + k * (x1 - x0)
            picture.fill(x - 0.6, y0 + 1, x + 0.6, y1 - 1, (0.62, 0.64, 0.68))
    return picture


class Sheet:
    """Labels side by side in one picture."""

    def __init__(self, width, height, px_per_mm):
        self.picture = Picture(width, height)
        self.scale = px_per_mm
        self.x = self.y = self.row = 0

    def place(self, width_mm, height_mm):
        """Room for a label: its corner in pixels, its size in pixels, and (left, top, right, bottom) in the texture."""
        w, h = math.ceil(width_mm * self.scale), math.ceil(height_mm * self.scale)
        if self.x + w > self.picture.width:
            self.x, self.y, self.row = 0, self.y + self.row, 0
        if self.y + h > self.picture.height:
            raise SystemExit("a sheet of labels is full: make it larger")
        x, y = self.x, self.y
        self.x += w + 2
        self.row = max(self.row, h + 2)
        box = ((x + 0.5) / self.picture.width, (y + 0.5) / self.picture.height, (x + w - 0.5) / self.picture.width,
               (y + h - 0.5) / self.picture.height)
        return x, y, w, h, box

    def plate(self, width_mm, height_mm, lines, ink=(0.05, 0.05, 0.06), ground=(0.86, 0.86, 0.84), frame=True, stripe=None):
        """A plate with lines of text: (text, share of the height)."""
        x, y, w, h, box = self.place(width_mm, height_mm)
        p = self.picture
        p.fill(x, y, x + w, y + h, ground)
        if frame:
            t = max(1.0, 0.35 * self.scale)
            for a in ((x, y, x + w, y + t), (x, y + h - t, x + w, y + h), (x, y, x + t, y + h), (x + w - t, y, x + w, y + h)):
                p.fill(*a, ink)
        left = x
        if stripe:
            left += 0.12 * w
            p.fill(x, y, left, y + h, stripe)
        total = sum(share for _, share in lines)
        room = (1.0 - total) / (len(lines) + 1)
        at = y
        for text, share in lines:
            size = share * h
            longest = 0.92 * (w - (left - x))
            size = min(size, longest / max(1, (5.6 * len(text) - 1.6)) * 6.0)
            at += (room + share) * h
            p.text(left + (w - (left - x)) / 2, at - 0.5 * (share * h - size), size, text, ink, align="middle")
        return box

    def hazard(self, width_mm, height_mm, pitch_mm=8.0, a=(0.9, 0.68, 0.03), b=(0.06, 0.06, 0.06)):
        x, y, w, h, box = self.place(width_mm, height_mm)
        pitch = pitch_mm * self.scale
        for j in range(h):
            for i in range(w):
                phase = ((i + j) % pitch) / pitch
                edge = min(abs(phase - 0.5), phase, 1.0 - phase) * pitch
                self.picture.blend(x + i, y + j, a, 1.0)
                side = edge if phase > 0.5 else -edge
                self.picture.blend(x + i, y + j, b, 0.5 + side)
        return box

    def marker(self, side_mm, code):
        """A square that a camera finds: 4 x 4 bits in a black frame."""
        x, y, w, h, box = self.place(side_mm, side_mm)
        self.picture.fill(x, y, x + w, y + h, (0.92, 0.92, 0.92))
        c = w / 8.0
        self.picture.fill(x + c, y + c, x + 7 * c, y + 7 * c, (0.04, 0.04, 0.04))
        for k in range(16):
            if code >> k & 1:
                i, j = k % 4, k // 4
                self.picture.fill(x + (2 + i) * c, y + (2 + j) * c, x + (3 + i) * c, y + (3 + j) * c, (0.92, 0.92, 0.92))
        return box

    def barcode(self, width_mm, height_mm, text, ground=(0.86, 0.86, 0.84)):
        x, y, w, h, box = self.place(width_mm, height_mm)
        ink = (0.05, 0.05, 0.06)
        self.picture.fill(x, y, x + w, y + h, ground)
        at = x + 0.06 * w
        k = 0
        while at < x + 0.94 * w:
            bar = (1 + int(3 * noise(k, len(text), 17))) * 0.009 * w
            if k % 2 == 0:
                self.picture.fill(at, y + 0.1 * h, min(at + bar, x + 0.94 * w), y + 0.62 * h, ink)
            at += bar
            k += 1
        self.picture.text(x + w / 2, y + 0.92 * h, 0.2 * h, text, ink, align="middle")
        return box
