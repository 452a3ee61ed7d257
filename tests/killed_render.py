#!/usr/bin/env python3
"""Kills a render at random moments (kill -9), resumes it, and compares the picture with that of an undisturbed run.

killed_render.py PROGRAM [--kills N] [--spp N] [--checkpoint SECONDS] [--threads N] [--seed N] [--scene FILE]

The undisturbed run is rendered first; its time T bounds the moments of the kills, so that about N of them fall into
the work. Exit status 1 where one bit of the pictures differs or where something is left behind. The test `render.killed` takes seconds; ten minutes of work, killed ten times:

    python3 tests/killed_render.py build/release/cuticle --kills 10 --spp 4000 --checkpoint 10
"""
import argparse
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

from same_pictures import exr_values

SCENE = """LookAt 0 1 6 0 0 0 0 1 0 Camera "perspective" "float fov" 40
Film "image" "integer xresolution" 96 "integer yresolution" 80
WorldBegin LightSource "infinite" "rgb L" [.6 .7 1] LightSource "point" "point from" [2 4 4] "rgb I" [30 28 24]
Texture "spots" "color" "imagemap" "string filename" "spots.pfm"
Include "hair.pbrt"
AttributeBegin Translate 0 -1.5 0 Material "matte" "texture Kd" "spots" Shape "disk" "float radius" 4 Rotate 90 1 0 0
AttributeEnd WorldEnd
"""
HAIR = """Material "hair" "float eumelanin" .6 "float beta_m" .25
Shape "groom" "string kind" "ball" "integer strands" 2000 "float width" .02
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--spp", type=int, default=4000)
    parser.add_argument("--checkpoint", type=float, default=10)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1, help="of the moments")
    parser.add_argument("--scene", type=os.path.abspath, help="a scene of your own")
    a = parser.parse_args()
    moments = random.Random(a.seed)
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder)
        (path / "hair.pbrt").write_text(HAIR)
        (path / "spots.pfm").write_bytes(b"PF\n2 1\n-1.0\n" + b"\0\0\x80\x3f" * 3 + b"\0\0\0\x3f" * 3)
        (path / "scene.pbrt").write_text(SCENE)
        words = [a.program, "render", a.scene or "scene.pbrt", "--spp", str(a.spp), "--threads", str(a.threads),
                 "--variance", "-q", "--checkpoint", str(a.checkpoint)]
        start = time.monotonic()
        subprocess.run([*words, "-o", "whole.exr"], cwd=path, check=True)
        whole = time.monotonic() - start
        print(f"undisturbed: {whole:.1f} s", flush=True)
        words += ["-o", "killed.exr", "--resume"]
        killed, work = 0, 0.0
        while True:
            start = time.monotonic()
            # The last run is left alone
            wait = None if killed == a.kills else moments.uniform(0, 2 * whole / a.kills)
            process = subprocess.Popen(words, cwd=path)
            try:
                status = process.wait(wait)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                process.wait()
                killed += 1
                part = path / "killed.exr.part"
                work += time.monotonic() - start
                print(f"killed after {time.monotonic() - start:.1f} s; part: "
                      f"{part.stat().st_size if part.exists() else 'none yet'} bytes", flush=True)
                continue
            work += time.monotonic() - start
            if status != 0:
                sys.exit(f"the resumed render ended with status {status}")
            break
        before, after = exr_values(path / "whole.exr"), exr_values(path / "killed.exr")
        values = sum(map(len, before.values()))
        differ = sum(x != y for c in before for x, y in zip(before[c], after[c]))
        left = sorted(f.name for f in path.iterdir() if f.name not in
                      ["scene.pbrt", "hair.pbrt", "spots.pfm", "whole.exr", "killed.exr"])
        print(f"{killed} kills, {work:.1f} s in all runs; {differ} of {values} values differ; left behind: {left}")
        if killed == 0 or differ or before.keys() != after.keys() or left:
            sys.exit(1)


main()
