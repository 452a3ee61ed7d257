#!/usr/bin/env python3
"""Renders a scene and compares it with its reference image, or makes the reference images anew.

image_test.py PROGRAM STEM        test: scenes/STEM.pbrt against reference_images/STEM.exr
image_test.py --rewrite PROGRAM [STEM ...]   render the references; only for changes that are meant to change them

The test renders with another seed and fewer samples than the reference. Both carry the variance of every pixel, and
the comparison is a z-test of blocks of pixels, corrected for their number; the means of the whole pictures must agree as well.
"""
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Samples of the test and of the reference. A small picture serves as well: a quarter of the scene's resolution.
# Glass and lacquer near a lamp make rare bright paths: the materials take more.
# With 32 samples one block or more is beyond the z-test in half of all seeds of the rooms.
SAMPLES = {"furnace": (128, 4), "materials": (512, 2048), "quickstart": (128, 1024), "room": (128, 1024),
           "lantern-room-around": (128, 1024)}
DEFAULT = (32, 1024)
# Hair is lit by rare bright paths: a pixel of 32 samples is far from normal, a block of 64 pixels is not.
BLOCK = 8
SIZE = {"furnace": []}
QUICK = ["--quick"]
FAILED = ROOT / "build" / "failed_images"


def run(*words):
    process = subprocess.run([str(w) for w in words], capture_output=True, text=True)
    return process.returncode, process.stdout + process.stderr


def check(*words):
    status, text = run(*words)
    if status != 0:
        sys.exit(text)


def test(program, stem):
    samples = SAMPLES.get(stem, DEFAULT)[0]
    reference = ROOT / "reference_images" / f"{stem}.exr"
    picture = FAILED / f"{stem}.exr"
    FAILED.mkdir(parents=True, exist_ok=True)
    check(program, "render", scene(stem), "--spp", samples, "--seed", 1, "--variance", "--quiet", "--strict", "-o", picture,
          *SIZE.get(stem, QUICK))
    status, text = run(program, "compare", picture, reference, "--block", BLOCK, "--max-rejected", 0.0025, "--max-bias", 4.5)
    print(text)
    if status != 0:
        run(program, "compare", picture, reference, "--error-image", FAILED / f"{stem}-error.png")
        sys.exit(f"{stem} differs from its reference: see build/failed_images")
    picture.unlink()


def scene(stem):
    return ROOT / "scenes" / f"{stem}.pbrt"


def rewrite(program, stems):
    for path in sorted((ROOT / "scenes").glob("*.pbrt")):
        stem = path.stem
        if stems and stem not in stems:
            continue
        print(stem, flush=True)
        target = ROOT / "reference_images" / f"{stem}.exr"
        if stem != "furnace":
            check(program, "render", path, "--spp", SAMPLES.get(stem, DEFAULT)[1], "--variance", "--quiet", "-o", target,
                  *SIZE.get(stem, QUICK))
            continue
        # Nothing may be seen in a furnace: its reference is the empty dome, 1 in every pixel with a variance of 0
        with tempfile.TemporaryDirectory() as folder:
            empty = pathlib.Path(folder) / "furnace.pbrt"
            text = path.read_text()
            empty.write_text("\n".join(line for line in text.splitlines() if not line.lstrip().startswith("Shape")))
            check(program, "render", empty, "--spp", 4, "--variance", "--quiet", "-o", target)


def main():
    words = sys.argv[1:]
    if len(words) >= 2 and words[0] == "--rewrite":
        rewrite(words[1], words[2:])
    elif len(words) == 2:
        test(*words)
    else:
        sys.exit(__doc__)


main()
