#!/usr/bin/env python3
"""Renders every scene below a folder, quickly, and prints a table of what came of it: render_all.py FOLDER PROGRAM

Each .pbrt or .pbrt.gz file that has a WorldBegin (others are parts of scenes) is rendered with few samples and a
quarter of its resolution each way, into a folder that is then deleted. The table (Markdown) says for each: rendered
whole, rendered with which warnings, refused with which error. The exit status is 1 when a scene crashed the program,
hung it (--timeout) or lost samples that were not finite; a refusal with an error is no such failure.
"""
import argparse
import collections
import gzip
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import time


def is_scene(file):
    opened = gzip.open(file, "rb") if file.suffix == ".gz" else file.open("rb")
    with opened as stream:
        return re.search(rb"^\s*WorldBegin\b", stream.read(1 << 20), re.MULTILINE) is not None


def render(program, file, folder, arguments):
    """The outcome ("whole", "with warnings", "lacks files", "refused", "FAILED") and what there is to say of it."""
    stats = folder / "stats.json"
    stats.unlink(missing_ok=True)
    start = time.monotonic()
    try:
        run = subprocess.run([program, "render", file, "-o", folder / "picture.exr", "--stats", stats, "--quiet", "--quick",
                              "--spp", str(arguments.spp), "--crop", *map(str, arguments.crop)],
                             capture_output=True, text=True, errors="replace", timeout=arguments.timeout)
    except subprocess.TimeoutExpired:
        return "FAILED", f"not done after {arguments.timeout} s", time.monotonic() - start
    seconds = time.monotonic() - start
    lines = [re.sub(r"^\S*?([^/\s]+:\d+:\d+: )", r"\1", line) for line in run.stderr.splitlines()]
    errors = [line for line in lines if "error: " in line]
    if run.returncode == 1 and errors:
        return ("lacks files" if "No such file" in errors[0] else "refused"), errors[0], seconds
    if run.returncode != 0:
        return "FAILED", f"exit status {run.returncode}: {' '.join(lines[-2:])}", seconds
    lost = json.loads(stats.read_text())["nan_samples"]
    if lost:
        return "FAILED", f"{lost} samples were not finite", seconds
    warnings = [re.sub(r"^.*?warning: ", "", line) for line in lines if "warning: " in line and "more of this kind" not in line]
    lacks = any("No such file" in line for line in warnings)
    return ("lacks files" if lacks else "with warnings" if warnings else "whole"), "; ".join(warnings), seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--spp", type=int, default=1, help="samples per pixel (default: 1)")
    parser.add_argument("--crop", type=float, nargs=4, default=[0.25, 0.75, 0.25, 0.75], help="default: the middle quarter")
    parser.add_argument("--timeout", type=float, default=120, help="seconds for a scene (default: 120)")
    arguments = parser.parse_args()
    files = sorted(f for f in arguments.folder.rglob("*.pbrt*") if f.name.endswith((".pbrt", ".pbrt.gz")))
    counts = collections.Counter()
    print("| scene | rendered | what it says | s |\n| --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        for file in files:
            if not is_scene(file):
                counts["part of a scene"] += 1
                continue
            outcome, what, seconds = render(arguments.program.resolve(), file, pathlib.Path(folder), arguments)
            counts[outcome] += 1
            what = what.replace("|", "\\|")
            print(f"| {file.relative_to(arguments.folder)} | {outcome} | {what} | {seconds:.1f} |", flush=True)
    print("\n" + ", ".join(f"{counts[k]} {k}" for k in ["whole", "with warnings", "lacks files", "refused", "FAILED", "part of a scene"]))
    return 1 if counts["FAILED"] else 0


sys.exit(main())
