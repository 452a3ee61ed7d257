#!/usr/bin/env python3
"""Uses the program as a new user would, wrong inputs too: cli_test.py PROGRAM"""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = os.path.abspath(sys.argv.pop(1))
SCENE = """LookAt 0 0 3 0 0 0 0 1 0 Camera "perspective" "float fov" 40
Film "image" "integer xresolution" 20 "integer yresolution" 10 "string filename" "named.exr"
Sampler "halton" "integer pixelsamples" 4
WorldBegin LightSource "infinite" Material "hair"
Shape "curve" "point P" [-1 0 0 0 1 0 0 -1 0 1 0 0] "float width" .2
WorldEnd
"""


class CommandLine(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self.folder.name)
        (self.path / "scene.pbrt").write_text(SCENE)

    def tearDown(self):
        self.folder.cleanup()

    def run_program(self, *words, **options):
        return subprocess.run([PROGRAM, *words], cwd=self.path, capture_output=True, text=True, timeout=120, **options)

    def ok(self, *words):
        run = self.run_program(*words)
        self.assertEqual(run.returncode, 0, run.stderr)
        return run

    def fails(self, *words, says):
        run = self.run_program(*words)
        self.assertEqual(run.returncode, 1, f"{words}: {run.stdout} {run.stderr}")
        for text in [says] if isinstance(says, str) else says:
            self.assertIn(text, run.stderr)
        self.assertEqual(run.stderr.count("error:"), 1, run.stderr)
        return run

    def scene(self, text, name="bad.pbrt"):
        (self.path / name).write_text(text)
        return name

    def test_help_at_each_level(self):
        self.assertIn("render", self.ok("--help").stdout)
        for command in ["render", "groom", "compare", "convert"]:
            text = self.ok(command, "--help").stdout
            self.assertIn("Example", text, command)
        for option in ["--spp", "--threads", "--crop", "--seed", "--integrator", "--quiet", "--strict", "--stats",
                       "--variance", "--outfile", "--nthreads", "--cropwindow", "--quick", "--compat"]:
            self.assertIn(option, self.ok("render", "--help").stdout)

    def test_default_output_is_the_films(self):
        run = self.ok("render", "scene.pbrt")
        self.assertTrue((self.path / "named.exr").exists())
        self.assertIn("named.exr", run.stdout)
        self.assertEqual(run.stderr, "")  # no progress where it is no terminal

    def test_quiet_says_nothing(self):
        run = self.ok("render", "scene.pbrt", "--quiet", "-o", "a.png")
        self.assertEqual(run.stdout + run.stderr, "")
        self.assertEqual((self.path / "a.png").read_bytes()[:4], b"\x89PNG")

    def test_stats_name_what_was_promised(self):
        self.ok("render", "scene.pbrt", "-o", "a.exr", "--stats", "s.json", "--spp", "3", "--threads", "1")
        stats = json.loads((self.path / "s.json").read_text())
        for key in ["parse_s", "build_s", "render_s", "spp", "width", "height", "rays", "shadow_rays", "curves",
                    "peak_rss_mb", "nan_samples", "threads", "isa"]:
            self.assertIn(key, stats)
        self.assertEqual([stats[k] for k in ["spp", "width", "height", "curves", "threads", "nan_samples"]], [3, 20, 10, 1, 1, 0])
        self.assertGreater(stats["rays"], 20 * 10 * 3 - 1)

    def test_pbrts_spellings(self):
        self.ok("render", "scene.pbrt", "--outfile", "a.exr", "--nthreads", "2", "--cropwindow", "0", "0.5", "0", "1")
        self.ok("render", "scene.pbrt", "--quick", "--outfile", "b.exr", "--stats", "s.json")
        stats = json.loads((self.path / "s.json").read_text())
        self.assertEqual((stats["width"], stats["height"], stats["spp"]), (5, 2, 1))

    def test_seed_and_threads(self):
        for name, words in {"a": ["--threads", "1"], "b": ["--threads", "2"], "c": ["--seed", "5"]}.items():
            self.ok("render", "scene.pbrt", "--quiet", "-o", f"{name}.exr", *words)
        same = json.loads(self.ok("compare", "a.exr", "b.exr", "--json").stdout)
        self.assertEqual(same["mse"], 0)
        self.assertGreater(json.loads(self.ok("compare", "a.exr", "c.exr", "--json").stdout)["mse"], 0)

    def test_variance_channels(self):
        self.ok("render", "scene.pbrt", "--variance", "-o", "a.exr", "--seed", "1")
        self.ok("render", "scene.pbrt", "--variance", "-o", "b.exr", "--seed", "2")
        self.assertIn("rejected_pixels", json.loads(self.ok("compare", "a.exr", "b.exr", "--json").stdout))

    def test_compare_fails_beyond_its_threshold(self):
        self.ok("render", "scene.pbrt", "-o", "a.exr")
        self.ok("render", "scene.pbrt", "-o", "b.exr", "--seed", "5")
        run = self.run_program("compare", "a.exr", "b.exr", "--max-mse", "1e-12")
        self.assertEqual(run.returncode, 1)
        self.assertIn("beyond", run.stdout)
        self.ok("compare", "a.exr", "a.exr", "--max-mse", "0", "--error-image", "e.png")

    def test_convert(self):
        self.ok("render", "scene.pbrt", "-o", "a.exr")
        self.ok("convert", "a.exr", "a.png")
        self.assertEqual((self.path / "a.png").read_bytes()[:4], b"\x89PNG")

    def test_groom_writes_what_render_reads(self):
        self.ok("groom", "hair-cube", "--strands", "100", "-o", "cube.pbrt.gz")
        name = self.scene(SCENE.replace('Shape "curve" "point P" [-1 0 0 0 1 0 0 -1 0 1 0 0] "float width" .2',
                                        'Include "cube.pbrt.gz"'), "cube.pbrt")
        self.ok("render", name, "-o", "a.exr", "--stats", "s.json", "--spp", "1")
        self.assertGreater(json.loads((self.path / "s.json").read_text())["curves"], 99)

    def test_mistakes_on_the_command_line(self):
        for words in [[], ["rendr"], ["render"], ["render", "scene.pbrt", "--ssp", "4"], ["render", "scene.pbrt", "--spp", "0"],
                      ["render", "scene.pbrt", "--spp", "many"], ["render", "scene.pbrt", "--crop", "0", "1"],
                      ["render", "scene.pbrt", "--compat", "blender"]]:
            run = self.run_program(*words)
            self.assertEqual(run.returncode, 1, words)
            self.assertNotEqual(run.stderr, "", words)
        self.fails("render", "no.pbrt", says="no.pbrt")
        self.fails("render", ".", says="error:")
        self.fails("render", "scene.pbrt", "-o", "a.bmp", says=".exr or .png")
        self.fails("render", "scene.pbrt", "-o", "nowhere/a.exr", says="nowhere")
        self.fails("render", "scene.pbrt", "--integrator", "pth", says=["pth", "path"])
        self.fails("render", "scene.pbrt", "--crop", "0.5", "0.5", "0", "1", says="crop window")
        self.fails("compare", "no.exr", "no.exr", says="no.exr")
        self.fails("groom", "head", "--strands", "-5", "-o", "a.pbrt", says="strands")

    def test_mistakes_in_a_scene(self):
        def bad(text, says):
            self.fails("render", self.scene(text), says=says)

        bad(SCENE.replace("Shape", "Shpae"), ["bad.pbrt:5:1: error:", "Shape"])
        bad(SCENE.replace('"hair"', '"hiar"'), ["bad.pbrt:4:", "hair"])
        bad(SCENE.replace('"curve"', '"curv"'), ["bad.pbrt:5:", "curve"])
        bad(SCENE.replace('"infinite"', '"infinte"'), ["bad.pbrt:4:", "infinite"])
        bad(SCENE.replace('"float width" .2', '"float width" "thick"'), "bad.pbrt:5:")
        bad(SCENE.replace('"perspective"', '"prespective"'), ["bad.pbrt:1:", "perspective"])
        bad(SCENE.replace('"halton"', '"haltn"'), ["bad.pbrt:3:", "halton"])
        bad(SCENE.replace('"image"', '"rgb"'), "v4")
        bad(SCENE.replace("1 0 0]", "1 0 0"), "bad.pbrt:")
        bad('Include "bad.pbrt"', "bad.pbrt:1:")
        bad("\0\1\2", "bad.pbrt")

    def test_strict_turns_a_warning_into_an_error(self):
        name = self.scene(SCENE.replace('Material "hair"', 'Material "hair" "float bta_m" .3'))
        run = self.ok("render", name, "-o", "a.exr")
        self.assertIn("bta_m", run.stderr)
        self.fails("render", name, "-o", "a.exr", "--strict", says="bta_m")

    def test_a_failed_render_leaves_the_old_picture(self):
        self.ok("render", "scene.pbrt", "-o", "a.exr")
        before = (self.path / "a.exr").read_bytes()
        self.fails("render", self.scene(SCENE.replace("WorldEnd", "WrldEnd")), "-o", "a.exr", says="WorldEnd")
        self.assertEqual((self.path / "a.exr").read_bytes(), before)

    def test_interrupt_writes_what_there_is(self):
        process = subprocess.Popen([PROGRAM, "render", "scene.pbrt", "--spp", "10000000", "-o", "a.exr"], cwd=self.path,
                                   stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        time.sleep(1.5)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertRegex(errors, r"stopped after \d+ of 10000000 samples")
        self.assertTrue((self.path / "a.exr").exists())

    def test_isa_is_chosen_by_the_environment(self):
        for isa in ["sse2", "avx2"]:
            run = self.run_program("render", "scene.pbrt", "-o", f"{isa}.exr", "--stats", "s.json",
                                   env={**os.environ, "CUTICLE_ISA": isa})
            if run.returncode == 0:  # an old processor says that it cannot
                self.assertEqual(json.loads((self.path / "s.json").read_text())["isa"], isa)
            else:
                self.assertIn(isa, run.stderr)
        run = self.run_program("render", "scene.pbrt", "-o", "a.exr", env={**os.environ, "CUTICLE_ISA": "mmx"})
        self.assertEqual(run.returncode, 1)
        self.assertIn("mmx", run.stderr)


unittest.main()
