#!/usr/bin/env python3
"""Renders a scene and compares it with its reference image, or makes the reference images anew.

image_test.py PROGRAM STEM                   test: scenes/STEM.pbrt against reference_images/STEM.exr
image_test.py --rewrite PROGRAM [STEM ...]   render the references; only for changes that are meant to change them.
                                             May be interrupted: the next run goes on where this one stopped
image_test.py --detects PROGRAM STEM [...]   print, as a table, which small changes of the scene each test notices

A test asks one of two questions. Is the picture right: with another seed and fewer samples than the reference. Both carry the variance
of every pixel, and the comparison is a z-test of blocks of pixels, corrected for their number; the means of the whole pictures must agree
as well. Or, has it changed: for scenes of the papers' figures, a window with the reference's own seed and samples. Random
numbers are the same, so nothing may differ but the last digits; what does has changed, and need not be wrong.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
FAILED = ROOT / "build" / "failed_images"
UNDER_WAY = ROOT / "build" / "references"
# Samples of the test and of the reference. A small picture serves as well: a quarter of the scene's resolution.
# Glass and lacquer near a lamp make rare bright paths: the materials take more.
# With 32 samples one block or more is beyond the z-test in half of all seeds of the rooms, and of heads of real hair,
# of which a pixel sees many hairs.
SAMPLES = {"furnace": (128, 4), **{f"head-{style}": (128, 1024) for style in ["straight", "wavy", "dyed"]},
           "materials": (512, 2048), "quickstart": (128, 1024), "fur-ball": (128, 1024), "room": (128, 1024),
           "lantern-room-around": (128, 1024)}
DEFAULT = (32, 1024)
# Figures that are rendered: 200 pixels wide. Their numbers are kept in 7 bits, their variances in 3.
PAPER = re.compile(r"(marschner|deon|pharr)-(?!1\.20)")
PAPER_SAMPLES = (16, 128)
PAPER_BITS = 7
WINDOW = (0.36, 0.6, 0.3, 0.54)
# Relative MSE of the window: rounding to 7 bits is at most 2^-8 of a value, 1.53e-5 when squared.
CHANGED = 1.6e-5
# Hair is lit by rare bright paths: a pixel of 32 samples is far from normal, a block of 64 pixels is not.
BLOCK = 8
SIZE = {"furnace": []}
QUICK = ["--quick"]
# Small changes of a scene, for the table: what is replaced or added in Material "hair", or elsewhere
CHANGES = {"alpha + 1°": ("alpha", 2, lambda x: x + 1), "beta_m + .03": ("beta_m", 0.3, lambda x: x + 0.03),
           "beta_n + .03": ("beta_n", 0.3, lambda x: x + 0.03), "colour 5%": ("sigma_a|eumelanin", 1.3, lambda x: x * 1.05),
           "eta + .02": ("eta", 1.55, lambda x: x + 0.02), "light + 1%": ("light", 1, None), "one lobe more": ("lobes", 3, lambda x: x + 1)}


def run(*words):
    process = subprocess.run([str(w) for w in words], capture_output=True, text=True)
    return process.returncode, process.stdout + process.stderr


def check(*words):
    status, text = run(*words)
    if status != 0:
        sys.exit(text)


def samples_of(stem):
    return PAPER_SAMPLES if PAPER.match(stem) else SAMPLES.get(stem, DEFAULT)


def size_of(stem):
    return ["--shrink", 2] if PAPER.match(stem) else SIZE.get(stem, QUICK)


def scene_of(stem):
    return ROOT / "scenes" / f"{stem}.pbrt"


def reference_of(stem):
    return ROOT / "reference_images" / f"{stem}.exr"


def wrong(program, stem, scene):
    """What the z-test says against a scene's picture, or None."""
    picture = FAILED / f"{stem}.exr"
    FAILED.mkdir(parents=True, exist_ok=True)
    check(program, "render", scene, "--spp", samples_of(stem)[0], "--seed", 1, "--variance", "--quiet", "--strict", "-o", picture,
          *size_of(stem))
    status, text = run(program, "compare", picture, reference_of(stem), "--block", BLOCK, "--max-rejected", 0.0025, "--max-bias", 4.5)
    if status == 0:
        picture.unlink()
    return text if status != 0 else None


def changed(program, stem, scene):
    """By how much a window differs from the reference although it has its random numbers, or None."""
    if not PAPER.match(stem):
        return None
    with tempfile.TemporaryDirectory() as folder:
        picture = pathlib.Path(folder) / "window.exr"
        check(program, "render", scene, "--spp", samples_of(stem)[1], "--variance", "--quiet", "-o", picture, "--crop", *WINDOW,
              *size_of(stem))
        status, text = run(program, "compare", picture, reference_of(stem), "--max-relmse", CHANGED)
        return text.splitlines()[-1] if status != 0 else None


def test(program, stem):
    text = changed(program, stem, scene_of(stem))
    if text:
        print(text)
        sys.exit(f"{stem} has CHANGED: with the same random numbers its picture is another. If that is meant, render the reference "
                 f"anew (--rewrite)")
    # Denoised pictures have no variance of their own, and paths under a sky alone are too rare for few samples: of right pictures
    # of figures the z-test rejects up to 15% of the blocks.
    if PAPER.match(stem):
        return
    text = wrong(program, stem, scene_of(stem))
    if text:
        print(text)
        run(program, "compare", FAILED / f"{stem}.exr", reference_of(stem), "--error-image", FAILED / f"{stem}-error.png")
        sys.exit(f"{stem} is WRONG, it differs from its reference by more than chance: see build/failed_images")


def included(path):
    """The text of a scene with what it includes put in."""
    return re.sub(r'^Include "(.*)"$', lambda m: included(ROOT / "scenes" / m[1]), path.read_text(), flags=re.M)


def with_change(text, change):
    name, otherwise, f = CHANGES[change]
    if name == "light":
        return re.sub(r'("rgb (?:L|I)" \[)([^\]]*)', lambda m: m[1] + " ".join(str(float(x) * 1.01) for x in m[2].split()), text)
    given = re.search(rf'"(?:float|rgb|integer) ({name})" \[?([\d. ]+)\]?', text)
    if not given:
        kind = "integer" if name == "lobes" else "float"
        return re.sub(r'(Material "hair")', rf'\1 "{kind} {name.split("|")[-1]}" {f(otherwise)}', text)
    numbers = " ".join(str(f(float(x))) for x in given[2].split())
    return text[:given.start(2) - (text[given.start(2) - 1] == "[")] + f"[{numbers}] " + text[given.end():]


def detects(program, stems):
    print("| scene | " + " | ".join(CHANGES) + " |\n| --- |" + " --- |" * len(CHANGES))
    for stem in stems:
        cells = []
        for change in CHANGES:
            scene = ROOT / "scenes" / f".detects-{stem}.pbrt"
            scene.write_text(with_change(included(scene_of(stem)), change))
            try:
                cells.append(", ".join(word for word, seen in (("wrong", wrong(program, stem, scene)), ("changed", changed(program, stem, scene)))
                                       if seen) or "no")
            finally:
                scene.unlink()
        print(f"| {stem} | " + " | ".join(cells) + " |", flush=True)


def rewrite(program, stems):
    # Finished pictures lie in UNDER_WAY until all are there; a render that was stopped has its part beside it.
    UNDER_WAY.mkdir(parents=True, exist_ok=True)
    for path in sorted((ROOT / "scenes").glob("*.pbrt")):
        stem = path.stem
        picture = UNDER_WAY / f"{stem}.exr"
        if (stems and stem not in stems) or picture.exists():
            continue
        print(stem, flush=True)
        begun = UNDER_WAY / f"begun-{stem}.exr"
        if stem != "furnace":
            part = pathlib.Path(f"{begun}.part")
            check(program, "render", path, "--spp", samples_of(stem)[1], "--variance", "--quiet", "--checkpoint", 20, "-o", begun,
                  *size_of(stem), *(["--resume"] if part.exists() else []))
        else:
            # Nothing may be seen in a furnace: its reference is the empty dome, 1 in every pixel with a variance of 0
            with tempfile.TemporaryDirectory() as folder:
                empty = pathlib.Path(folder) / "furnace.pbrt"
                text = path.read_text()
                empty.write_text("\n".join(line for line in text.splitlines() if not line.lstrip().startswith("Shape")))
                check(program, "render", empty, "--spp", 4, "--variance", "--quiet", "-o", begun)
        check(program, "convert", begun, reference_of(stem), *(["--bits", PAPER_BITS] if PAPER.match(stem) else []))
        begun.rename(picture)
    for picture in UNDER_WAY.glob("*.exr"):
        picture.unlink()


def main():
    words = sys.argv[1:]
    if len(words) >= 2 and words[0] == "--rewrite":
        rewrite(words[1], words[2:])
    elif len(words) >= 3 and words[0] == "--detects":
        detects(words[1], words[2:])
    elif len(words) == 2:
        test(*words)
    else:
        sys.exit(__doc__)


main()
