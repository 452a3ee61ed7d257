#!/usr/bin/env python3
"""Frames of a simulation as scenes/videos/blender.py brings them into Blender: blender_test.py PROGRAM

Exit status 77 (skipped) where Blender is not installed."""
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import unittest

from program_case import ProgramCase

if shutil.which("blender", path="/usr/bin") is None:
    print("skipped: blender is not there")
    sys.exit(77)

PROGRAM = os.path.abspath(sys.argv.pop(1))
SCRIPT = pathlib.Path(__file__).resolve().parent.parent / "scenes/videos/blender.py"
ASK = """import bpy
bpy.context.scene.frame_set(3)
graph = bpy.context.evaluated_depsgraph_get()
for v in bpy.data.objects["points"].evaluated_get(graph).to_mesh().vertices: print("at", *v.co)
hair = bpy.data.objects["hair"].evaluated_get(graph).data
print("curves", len(hair.curves), len(hair.points), *hair.points[30].position, hair.points[30].radius)
"""


class Blender(ProgramCase):
    program, scene_text = PROGRAM, ""

    def blender(self, *words):
        run = subprocess.run(["/usr/bin/blender", "-b", "--python-exit-code", "1", *words], cwd=self.path, capture_output=True, text=True, timeout=100,
                             env={**os.environ, "PATH": "/usr/bin:" + os.environ["PATH"]})
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return run.stdout

    def test_strands_move_in_blender(self):
        (self.path / "r.recipe").write_text(
            'Hair "groom" "integer strands" 7\nSimulation "strands" "float seconds" 0.2 "integer keys" 7\n'
            'Motion "keys" "float time" [0 0.2] "vector3 turn" [0 0 0 0 40 0]\n')
        self.ok("simulate", "r.recipe", "-o", "f/%04d.hair", "-q")
        self.blender("--factory-startup", "-P", str(SCRIPT), "--", "f/%04d.hair", "0:4", "h.blend")
        said = self.blender(str(self.path / "h.blend"), "--python-expr", ASK)
        theirs = [[float(x) for x in line.split()[1:]] for line in said.splitlines() if line.startswith("at ")]
        data = (self.path / "f/0003.hair").read_bytes()
        strands, points = struct.unpack_from("<II", data, 4)
        ours = [struct.unpack_from("<3f", data, self.points_at(data, strands) + 12 * k) for k in range(points)]
        self.assertEqual(len(theirs), points)
        for (x, y, z), there in zip(ours, theirs):
            for a, b in zip((x / 100, -z / 100, y / 100), there):
                self.assertAlmostEqual(a, b, places=5)
        curves = next(line.split()[1:] for line in said.splitlines() if line.startswith("curves "))
        self.assertEqual([int(n) for n in curves[:2]], [7, points])
        for a, b in zip(theirs[30], curves[2:5]):
            self.assertAlmostEqual(a, float(b), places=5)
        self.assertTrue(1e-5 < float(curves[5]) < 1e-3, curves)  # half a hair's width, in metres

    @staticmethod
    def points_at(data, strands):
        return 128 + (2 * strands if data[12] & 1 else 0)


if __name__ == "__main__":
    unittest.main()
