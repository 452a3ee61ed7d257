#!/usr/bin/env python3
"""Renders every shipped scene with an earlier program and with this one, and counts the values that differ.

same_pictures.py PROGRAM --base COMMIT   builds COMMIT in a folder that is then deleted (some minutes), and compares
same_pictures.py PROGRAM --before OLD    compares with a program that is there already

For changes that are meant to change no picture. Prints for each scene how many of its values (R, G, B and their
variances) differ and by how many units in the last place at most; exit status 1 if any differs by more than
--ulps (0: not a single bit).
"""
import argparse
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

ROOT = pathlib.Path(__file__).resolve().parent.parent
COMPRESSIONS = {0: 1, 2: 1, 3: 16}  # none, a line each and 16 lines each by zlib: lines of a block


def exr_values(path):
    """{channel: list of the bits of its values}, of a file of float channels in lines, as `cuticle render` writes it."""
    data = path.read_bytes()
    at, header = 8, {}
    while data[at]:
        name, kind = data[at:].split(b"\0", 2)[:2]
        at += len(name) + len(kind) + 2
        size = struct.unpack_from("<i", data, at)[0]
        header[name.decode()] = data[at + 4 : at + 4 + size]
        at += 4 + size
    at += 1
    channels, c = [], header["channels"]
    while c[0]:
        name, c = c.split(b"\0", 1)
        if struct.unpack_from("<i", c)[0] != 2:
            sys.exit(f"{path}: channel {name.decode()} holds no binary32")
        channels.append(name.decode())
        c = c[16:]
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height, lines = x1 - x0 + 1, y1 - y0 + 1, COMPRESSIONS[header["compression"][0]]
    values = {name: [] for name in channels}
    for offset in struct.unpack_from(f"<{-(-height // lines)}Q", data, at):
        y, size = struct.unpack_from("<2i", data, offset)
        rows = min(lines, y1 + 1 - y)
        block = data[offset + 8 : offset + 8 + size]
        if size < rows * width * 4 * len(channels):
            block = unpack(zlib.decompress(block))
        for row in range(rows):
            for i, name in enumerate(channels):
                values[name] += struct.unpack_from(f"<{width}i", block, (row * len(channels) + i) * width * 4)
    return values


def unpack(block):
    """Undoes OpenEXR's differences and its sorting of bytes by even and odd places."""
    out, last = bytearray(len(block)), 128
    for i, b in enumerate(block):
        last = last + b - 128 & 255 if i else b
        out[i] = last
    half = (len(out) + 1) // 2
    mixed = bytearray(len(out))
    mixed[0::2], mixed[1::2] = out[:half], out[half:]
    return mixed


def ordered(bits):
    """Floats in order as whole numbers in order: neighbours differ by 1."""
    return bits if bits >= 0 else -(bits & 0x7FFFFFFF)


def compare(before, after):
    a, b = exr_values(before), exr_values(after)
    if a.keys() != b.keys() or any(len(a[c]) != len(b[c]) for c in a):
        sys.exit(f"{after}: other channels or another size than {before}")
    distances = [abs(ordered(x) - ordered(y)) for c in a for x, y in zip(a[c], b[c]) if x != y]
    return sum(map(len, a.values())), len(distances), max(distances, default=0)


def build(commit, folder):
    subprocess.run(["git", "-C", ROOT, "worktree", "add", "--detach", folder, commit], check=True)
    subprocess.run(["cmake", "--preset", "release"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", "--preset", "release", "--target", "cuticle"], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL)
    return folder / "build" / "release" / "cuticle"


def render(program, scene, picture, arguments):
    subprocess.run([program, "render", scene, "--spp", str(arguments.spp), "--quick", "--variance", "--quiet", "-o", picture],
                   check=True, stderr=subprocess.DEVNULL)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--base", metavar="COMMIT")
    parser.add_argument("--before", type=pathlib.Path, metavar="OLD")
    parser.add_argument("--spp", type=int, default=8, help="samples per pixel, of a quarter of the resolution (default: 8)")
    parser.add_argument("--ulps", type=int, default=0, help="the largest difference that passes (default: 0)")
    arguments = parser.parse_args()
    if (arguments.base is None) == (arguments.before is None):
        parser.error("give either --base or --before")
    failed = False
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        try:
            before = arguments.before or build(arguments.base, folder / "base")
            print("| scene | values | differ | by ulps at most |\n| --- | --- | --- | --- |")
            for scene in sorted((ROOT / "scenes").glob("*.pbrt")):
                render(before.resolve(), scene, folder / "before.exr", arguments)
                render(arguments.program.resolve(), scene, folder / "after.exr", arguments)
                count, differ, ulps = compare(folder / "before.exr", folder / "after.exr")
                print(f"| {scene.stem} | {count} | {differ} | {ulps} |", flush=True)
                failed |= ulps > arguments.ulps
        finally:
            if arguments.base:
                subprocess.run(["git", "-C", ROOT, "worktree", "remove", "--force", folder / "base"], check=False)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
