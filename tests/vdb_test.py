#!/usr/bin/env python3
"""Reads what `cuticle volume -o x.vdb` writes, by OpenVDB's own Python module: vdb_test.py PROGRAM

Exit status 77 (skipped) where the module, which belongs to the system's Python, is not there."""
import json
import math
import os
import re
import sys
import unittest

from program_case import ProgramCase

try:
    import pyopenvdb as vdb
except ImportError:
    print("skipped: python3-openvdb is not there")
    sys.exit(77)

PROGRAM = os.path.abspath(sys.argv.pop(1))


class VdbFile(ProgramCase):
    program, scene_text = PROGRAM, ""

    def volume(self, *words):
        """A cube of parallel hairs, from -1 to 1, as grids by their names."""
        self.ok("groom", "hair-cube", "--strands", "900", "-o", "cube.hair", "-q")
        self.ok("volume", "cube.hair", "--cell", "0.1", "-o", "cube.vdb", *words)
        grids, _ = vdb.readAll(str(self.path / "cube.vdb"))
        return {grid.name: grid for grid in grids}

    @staticmethod
    def at(grid, *place):
        """The value at the vertex nearest to a place of the world."""
        return grid.getConstAccessor().getValue(tuple(round(x) for x in grid.transform.worldToIndex(place)))

    def test_names_and_places(self):
        grids = self.volume("--smooth", "0")
        self.assertEqual(set(grids), {"density", "distance"})
        self.assertEqual(grids["density"].gridClass, vdb.GridClass.FOG_VOLUME)
        self.assertEqual(grids["distance"].gridClass, vdb.GridClass.LEVEL_SET)
        for grid in grids.values():
            for size in grid.transform.voxelSize():
                self.assertAlmostEqual(size, 0.1, places=6)
        self.assertGreater(self.at(grids["density"], 0, 0, 0), 0)
        self.assertEqual(self.at(grids["density"], 1.3, 0, 0), 0)

    def test_mass_is_that_of_the_strands(self):
        grid = self.volume("--smooth", "0")["density"]
        total = sum(item.value for item in grid.citerOnValues()) * 0.1 ** 3
        # 900 cylinders of the length 2 and of the width that the manual says
        width = float(re.search(r"diameter of a hair at its root \[([\d.]+)\]", self.ok("groom", "hair-cube", "--help").stdout)[1])
        self.assertAlmostEqual(total / (900 * 2 * math.pi / 4 * width ** 2), 1, delta=1e-5)

    def test_values_are_those_of_the_dense_grid(self):
        """Far from hair nothing is kept of a density; a distance is kept everywhere in the box."""
        told = json.loads(self.ok("groom", "hair-cube", "--strands", "4", "-o", "cube.hair", "-q").stdout or
                          self.ok("volume", "cube.hair", "--cell", "0.05", "--smooth", "0", "-o", "cube.vdb", "--json").stdout)
        grids = {grid.name: grid for grid in vdb.readAll(str(self.path / "cube.vdb"))[0]}
        count = math.prod(told["resolution"])
        self.assertEqual(grids["distance"].activeVoxelCount(), count)
        self.assertLess(grids["density"].activeVoxelCount(), count / 10)
        self.assertAlmostEqual(sum(item.value for item in grids["density"].citerOnValues()) * 0.05 ** 3 / told["mass"], 1, delta=1e-5)

    def test_frames_of_a_simulation(self):
        """Stiff hair on a head that is moved evenly, without weight or air: after a while it has the head's velocity."""
        self.ok("groom", "hair-cube", "--strands", "100", "-o", "cube.hair", "-q")
        (self.path / "r.recipe").write_text(
            'Hair "hairfile" "string filename" "cube.hair"\nSimulation "strands" "float seconds" 1 "float fps" 4 "integer keys" 100 '
            '"integer points" 6 "vector3 gravity" [0 0 0] "float bending" 1e9 "float drag" 0 "float damping" 1\n'
            'Motion "keys" "float time" [0 1 2] "vector3 shift" [0 0 0 10 0 0 20 0 0]\n')
        self.ok("simulate", "r.recipe", "-o", "f/%d.hair", "--vdb", "f/%d.vdb", "--cell", "0.25", "-q")
        for frame, speed in ((0, 0), (4, 10)):  # at a key in between: the slope from its neighbour before to the one behind
            grids = {grid.name: grid for grid in vdb.readAll(str(self.path / f"f/{frame}.vdb"))[0]}
            self.assertEqual(set(grids), {"density", "velocity"})
            self.assertGreater(self.at(grids["density"], speed, 0, 0), 0)
            for there, right in zip(self.at(grids["velocity"], speed, 0, 0), (speed, 0, 0)):
                self.assertAlmostEqual(there, right, delta=0.2)

    def test_distance_is_openvdbs_own(self):
        """OpenVDB takes its own polygons from the density at the shell's value, and its own distance to them."""
        self.ok("groom", "hair-cube", "--strands", "900", "-o", "cube.hair", "-q")
        told = json.loads(self.ok("volume", "cube.hair", "--cell", "0.1", "-o", "cube.vdb", "--json").stdout)
        ours, density = (next(g for g in vdb.readAll(str(self.path / "cube.vdb"))[0] if g.name == name) for name in ("distance", "density"))
        try:
            points, triangles, quads = density.convertToPolygons(isovalue=told["iso"])
        except (NotImplementedError, ImportError, TypeError) as reason:
            self.skipTest(f"OpenVDB's module without numpy: {reason}")
        theirs = vdb.FloatGrid.createLevelSetFromPolygons(points, triangles=triangles, quads=quads, transform=density.transform, halfWidth=3)
        there, count, worst = theirs.getConstAccessor(), 0, 0
        for item in ours.citerOnValues():
            value, known = there.probeValue(item.min)
            if known and item.count == 1:
                count += 1
                worst = max(worst, abs(value - item.value))
        self.assertGreater(count, 5000)
        # Two ways to lay a surface through the same values: their vertices differ by a part of a cell of .1
        self.assertLess(worst, 0.03)

    def test_distance_is_that_to_the_cube(self):
        grid = self.volume()["distance"]
        for place, inside in [((0, 0, 0), True), ((0.8, 0, 0), True), ((1.3, 0, 0), False), ((0, 1.3, 1.3), False)]:
            # Of a cube of half a side 1: by the largest excess over the sides
            excess = [abs(round(x / 0.1) * 0.1) - 1 for x in place]
            true = sum(max(e, 0) ** 2 for e in excess) ** 0.5 if max(excess) > 0 else max(excess)
            value = self.at(grid, *place)
            self.assertEqual(value < 0, inside, place)
            self.assertAlmostEqual(value, true, delta=0.15, msg=str(place))  # the tent is a cell wide


if __name__ == "__main__":
    unittest.main()
