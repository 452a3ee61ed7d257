#!/usr/bin/env python3
"""Draws the small pictures that the scenes use: rose.png, a round church window, and lantern.png, what a pierced lantern sends
over all directions (theta from the zenith down the rows). Run it in the folder where they are to be."""
import math
import struct
import zlib


def write_png(name, width, height, colour):
    rows = b"".join(
        b"\0" + bytes(int(255 * min(max(v, 0), 1) + 0.5) for x in range(width) for v in colour(x + 0.5, y + 0.5))
        for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    with open(name, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def rose(x, y, size):
    u, v = 2 * x / size - 1, 2 * y / size - 1
    r, phi = math.hypot(u, v), math.atan2(u, -v) / (2 * math.pi) % 1
    lead = (0.02, 0.02, 0.02)
    if r > 0.97 or abs(r - 0.28) < 0.025 or abs(r - 0.66) < 0.025:
        return lead
    panes = 6 if r < 0.28 else 12 if r < 0.66 else 24
    pane = phi * panes
    # The bars between panes are as wide inside as outside
    if r > 0.06 and abs(pane - round(pane)) * 2 * math.pi * r / panes < 0.018:
        return lead
    red, blue, gold, green = (0.85, 0.1, 0.08), (0.1, 0.22, 0.85), (0.95, 0.7, 0.15), (0.1, 0.6, 0.3)
    if r < 0.28:
        return gold if r < 0.06 else (red, gold)[int(pane) % 2]
    if r < 0.66:
        petal = abs(pane % 1 - 0.5) < 0.42 * math.sin(math.pi * (r - 0.28) / 0.38)
        return (red if int(pane) % 2 else gold) if petal else blue
    return (blue, green, red, gold)[int(pane) % 4]


def lantern(x, y, width, height):
    row = int(y / height * 8)
    # Holes in staggered rows between the cap and the foot, which is of milky glass
    if not 1 <= row <= 5:
        glow = 0.13 if row > 5 else 0
        return (glow, 0.78 * glow, 0.42 * glow)
    holes = (8, 12, 12, 12, 8)[row - 1]
    across = (x / width * holes + 0.5 * (row % 2)) % 1 - 0.5
    down = y / height * 8 % 1 - 0.5
    # In equal units of angle: a cell is 1 / 8 of pi high, 2 pi sin(theta) / holes wide
    theta = math.pi * y / height
    across *= 16 * math.sin(theta) / holes
    r, phi = math.hypot(across, down), math.atan2(across, down)
    star = 0.24 + 0.12 * math.cos(5 * phi)
    light = min(max((star - r) * 18 + 0.5, 0), 1)
    return (light, 0.78 * light, 0.42 * light)


write_png("rose.png", 128, 128, lambda x, y: rose(x, y, 128))
write_png("lantern.png", 512, 256, lambda x, y: lantern(x, y, 512, 256))
