#!/usr/bin/env python3
"""Uses the program as a new user would, wrong inputs too: cli_test.py PROGRAM"""
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from program_case import ProgramCase

PROGRAM = os.path.abspath(sys.argv.pop(1))
SCENE = """LookAt 0 0 3 0 0 0 0 1 0 Camera "perspective" "float fov" 40
Film "image" "integer xresolution" 20 "integer yresolution" 10 "string filename" "named.exr"
Sampler "halton" "integer pixelsamples" 4
WorldBegin LightSource "infinite" Material "hair"
Shape "curve" "point P" [-1 0 0 0 1 0 0 -1 0 1 0 0] "float width" .2
WorldEnd
"""
MEMORY = 1 << 30  # of addresses: libraries and threads' stacks too


def full_disk():
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (200, 200))


def bounded_memory():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


class CommandLine(ProgramCase):
    program, scene_text = PROGRAM, SCENE

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
        for words in [["render", "scene.pbrt", "-o", "a.png"], ["groom", "hair-cube", "--strands", "9", "-o", "a.hair"],
                      ["goniometer", "--samples", "100"], ["figure", "pharr-1.16"]]:
            for spelling in ["-q", "--quiet"]:
                self.assertEqual(self.ok(*words, spelling).stdout, "", words)
        self.assertEqual((self.path / "a.png").read_bytes()[:4], b"\x89PNG")

    def test_log_and_verbosity(self):
        """Phases are told with -v, before or behind the command; the log keeps what was told."""
        for words in [["-v", "1", "--log", "log.txt", "render", "scene.pbrt"],
                      ["render", "scene.pbrt", "-v", "1", "--log", "log.txt"]]:
            run = self.ok(*words)
            for phase in ["reading", "building", "rendering", "samples 0 to 0", "samples 1 to 2"]:
                self.assertIn(phase, run.stderr)
                self.assertIn(phase, (self.path / "log.txt").read_text())
            (self.path / "log.txt").unlink()
        self.assertEqual(self.ok("render", "scene.pbrt").stderr, "")
        self.fails("render", "scene.pbrt", "--log", "nowhere/log.txt", says="nowhere/log.txt")
        for option in ["--log", "-v"]:
            self.assertIn(option, self.ok("--help").stdout)

    def test_stats_name_what_was_promised(self):
        self.ok("render", "scene.pbrt", "-o", "a.exr", "--stats", "s.json", "--spp", "3", "--threads", "1")
        stats = json.loads((self.path / "s.json").read_text())
        for key in ["parse_s", "build_s", "render_s", "spp", "width", "height", "rays", "shadow_rays", "curves",
                    "peak_rss_mb", "learned", "nan_samples", "threads", "isa"]:
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
        # Fewer bits: a smaller file, off by at most half of the last bit that is kept, relative to the power of two below
        self.ok("render", "scene.pbrt", "--variance", "-o", "a.exr")
        self.ok("convert", "a.exr", "b.exr", "--bits", "8")
        self.assertLess((self.path / "b.exr").stat().st_size, 0.8 * (self.path / "a.exr").stat().st_size)
        off = json.loads(self.ok("compare", "b.exr", "a.exr", "--json").stdout)["relative_mse"]
        self.assertTrue(0 < off < 2 ** -16, off)

    def test_a_crop_window_is_compared_with_its_part(self):
        """A window has the random numbers of the whole picture, whose pixels do not know of each other."""
        self.ok("render", "scene.pbrt", "-o", "whole.exr")
        self.ok("render", "scene.pbrt", "--crop", "0.25", "0.75", "0.5", "1", "-o", "part.exr")
        self.ok("compare", "part.exr", "whole.exr", "--max-mse", "0")
        self.ok("render", "scene.pbrt", "--crop", "0.25", "0.75", "0.5", "1", "--seed", "3", "-o", "other.exr")
        self.fails_beyond("compare", "other.exr", "whole.exr", "--max-mse", "0")
        self.fails("compare", "whole.exr", "part.exr", says="x")  # the other way round sizes differ

    def fails_beyond(self, *words):
        run = self.run_program(*words)
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertIn("beyond", run.stderr)

    def test_shrunk_pictures(self):
        def size(*words):
            self.ok("render", "scene.pbrt", "-o", "a.exr", "--stats", "s.json", *words)
            stats = json.loads((self.path / "s.json").read_text())
            return stats["width"], stats["height"]
        width, height = size()
        self.assertEqual(size("--shrink", "2"), (width // 2, height // 2))
        self.assertEqual(size("--shrink", "2", "--quick"), (max(1, width // 8), max(1, height // 8)))
        self.assertEqual(size("--shrink", "1000"), (1, 1))
        self.assertNotEqual(self.run_program("render", "scene.pbrt", "--shrink", "0").returncode, 0)

    def test_groom_writes_what_render_reads(self):
        self.ok("groom", "hair-cube", "--strands", "100", "-o", "cube.pbrt.gz")
        name = self.scene(SCENE.replace('Shape "curve" "point P" [-1 0 0 0 1 0 0 -1 0 1 0 0] "float width" .2',
                                        'Include "cube.pbrt.gz"'), "cube.pbrt")
        self.ok("render", name, "-o", "a.exr", "--stats", "s.json", "--spp", "1")
        self.assertGreater(json.loads((self.path / "s.json").read_text())["curves"], 99)

    def test_colours_of_a_file_of_strands(self):
        """The scene's Material holds, unless the file's colours are asked for; what is done with them is said."""
        strand = ('#usda 1.0\ndef BasisCurves "c" {\n uniform token type = "linear"\n int[] curveVertexCounts = [2]\n'
                  ' point3f[] points = [(0,0,0),(0,1,0)]\n float[] widths = [0.1]\n%s}\n')
        (self.path / "red.usda").write_text(strand % " color3f[] primvars:displayColor = [(0.5, 0, 0)]\n")
        (self.path / "plain.usda").write_text(strand % "")
        for words, materials, says in [(["red.usda"], 0, "the scene's Material holds"),
                                       (["red.usda", "--colors", "ignore"], 0, "are left out"),
                                       (["red.usda", "--colors", "keep"], 1, "a Material \"hair\" of its own"),
                                       (["plain.usda"], 0, "1 strands")]:
            run = self.ok("groom", "from", *words, "-o", "a.pbrt")
            self.assertIn(says, run.stdout)
            self.assertEqual((self.path / "a.pbrt").read_text().count("Material"), materials, words)
        self.ok("groom", "from", "red.usda", "-o", "red.hair")
        self.assertIn("Material holds", self.ok("groom", "from", "red.hair", "-o", "a.pbrt").stdout)
        self.ok("groom", "from", "plain.usda", "-o", "plain.hair")  # its header has a colour by default
        self.assertNotIn("olours", self.ok("groom", "from", "plain.hair", "-o", "a.pbrt").stdout)

    def test_strands_of_points(self):
        points = "".join(f"{i // 100} {i % 100} 0\n" for i in range(300))
        (self.path / "s.ply").write_text("ply\nformat ascii 1.0\nelement vertex 300\nproperty float x\nproperty float y\n"
                                         "property float z\nend_header\n" + points)
        self.assertIn("3 strands", self.ok("groom", "from", "s.ply", "-o", "a.pbrt").stdout)
        self.assertIn("6 strands", self.ok("groom", "from", "s.ply", "--points-per-strand", "50", "-o", "a.pbrt").stdout)
        self.fails("groom", "from", "s.ply", "--points-per-strand", "7", "-o", "a.pbrt", says="--points-per-strand")
        run = self.ok("render", self.scene(SCENE.replace("WorldEnd", 'Shape "plymesh" "string filename" "s.ply" WorldEnd')), "-o", "a.exr")
        self.assertIn('Shape "hairfile"', run.stderr)

    def test_denoising_is_the_scenes_wish_or_the_callers(self):
        world = "WorldBegin LightSource \"infinite\" Shape \"sphere\" WorldEnd"
        for wish in ("", "\"bool denoise\" \"true\"", "\"bool denoise\" \"false\""):
            self.scene(f"Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8 {wish} "
                       f"LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\" {world}", "wish.pbrt")
            for flags, denoised in (([], "true" in wish), (["--denoise"], True), (["--no-denoise"], False),
                                    (["--variance"], False)):
                said = self.ok("render", "wish.pbrt", "-o", "wish.exr", "--spp", "4", *flags).stdout
                self.assertEqual("denoised: " in said, denoised, (wish, flags, said))

    def test_a_small_render_has_the_shell_too(self):
        self.scene('Film "image" "integer xresolution" 4 "integer yresolution" 4 Integrator "hairlight" '
                   '"bool shellnormals" "true" "float shellcell" 0.2 LookAt 0 0 -5 0 0 0 0 1 0 Camera "perspective" '
                   'WorldBegin LightSource "distant" Material "hair" Shape "groom" "string kind" "ball" '
                   '"integer strands" 200 "float width" .05 WorldEnd', "shell.pbrt")
        self.ok("render", "shell.pbrt", "-o", "shell.exr", "--spp", "1", "--stats", "shell.json")
        self.assertIn("a shell of", json.loads((self.path / "shell.json").read_text())["learned"])

    def test_volume(self):
        self.ok("groom", "hair-cube", "--strands", "400", "-o", "cube.hair", "-q")
        told = json.loads(self.ok("volume", "cube.hair", "--resolution", "20", "--smooth", "0", "--json", "-o", "shell.ply",
                                  "-o", "slices.png").stdout)
        self.assertEqual(told["strands"], 400)
        # 400 straight fibers of the cube's height
        self.assertAlmostEqual(told["length"], 400 * 2, delta=0.01)
        self.assertAlmostEqual(told["mass"], told["fiber_volume"], delta=1e-5 * told["fiber_volume"])
        self.assertAlmostEqual(told["shell_volume"], 2 ** 3, delta=3)  # to a cell on each side
        self.assertTrue((self.path / "shell.ply").read_bytes().startswith(b"ply\n"))
        self.ok("compare", "slices.png", "slices.png")
        # Vertices, whatever their width; the text; nothing
        told = json.loads(self.ok("volume", "cube.hair", "--cell", "0.25", "--density", "vertices", "--json").stdout)
        self.assertAlmostEqual(told["mass"], told["points"], delta=1e-3 * told["points"])
        self.assertIn("triangles", self.ok("volume", "cube.hair", "--resolution", "9").stdout)
        self.assertEqual(self.ok("volume", "cube.hair", "--resolution", "9", "-q").stdout, "")

    def test_volume_answers_mistakes(self):
        self.ok("groom", "hair-cube", "--strands", "4", "-o", "cube.hair", "-q")
        self.fails("volume", "cube.hair", "-o", "x.obj", says=".vdb (density and distance)")
        self.fails("volume", "none.hair", says="none.hair")
        # An output that cannot be written is found before anything is read, and nothing is left of the others
        self.fails("volume", "none.hair", "-o", "good.ply", "-o", "missing/x.vdb", says="missing/x.vdb")
        self.assertFalse((self.path / "good.ply").exists())
        self.fails("volume", "cube.hair", "--cell", "1e-6", says="choose larger cells")
        self.fails("volume", "cube.hair", "--iso", "1e9", says=["no hair is as dense as 1000000000", "the densest place"])
        self.fails("volume", "cube.hair", "-o", "gone/x.ply", says="gone/x.ply")
        for words in [("--cell", "-1"), ("--cell", "nan"), ("--iso", "0"), ("--resolution", "0"), ("--density", "thick")]:
            self.assertEqual(self.run_program("volume", "cube.hair", *words).returncode, 1, words)
        self.assertFalse([path for path in self.path.iterdir() if "cuticle-" in path.name])

    def test_memory_is_limited_before_it_is_taken(self):
        film = SCENE.replace('xresolution" 20', 'xresolution" 16000').replace('yresolution" 10', 'yresolution" 16000')
        name = self.scene(film)
        # 256 million pixels of 56 bytes: 13.4 GB; of 136: 32.4
        self.fails("render", name, "--max-memory", "4G", "-o", "a.exr", preexec_fn=bounded_memory,
                   says=["13.4 GB", "--max-memory allows 4.0 GB", "the film of 16000 x 16000 pixels", "bad.pbrt:"])
        self.fails("render", name, "--max-memory", "13.5G", "--variance", "-o", "a.exr", preexec_fn=bounded_memory, says="32.4 GB")
        self.ok("render", "scene.pbrt", "--max-memory", "100M", "-o", "a.exr")
        groom = SCENE.replace("WorldEnd", 'Shape "groom" "string kind" "hair-cube" "integer strands" 1000000\nWorldEnd')
        self.fails("render", self.scene(groom), "--max-memory", "100M", "-o", "a.exr",
                   says=["curve segments and their tree (bad.pbrt:"])
        for wrong in ["lots", "-1", "4X", "0", "4GG"]:
            run = self.run_program("render", "scene.pbrt", f"--max-memory={wrong}", "-o", "a.exr")
            self.assertEqual(run.returncode, 1, wrong)
            self.assertIn("size of memory", run.stderr, wrong)

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
        for name, wrong, says in [('"hair"', '"hiar"', ["bad.pbrt:4:", "hair"]), ('"curve"', '"curv"', ["bad.pbrt:5:", "curve"]),
                                  ('"infinite"', '"infinte"', ["bad.pbrt:4:", "infinite"]),
                                  ('"float width" .2', '"float width" "thick"', ["bad.pbrt:5:"])]:
            text = self.scene(SCENE.replace(name, wrong))  # pbrt-v3 goes on after these
            run = self.ok("render", text, "-o", "a.exr")
            for part in says:
                self.assertIn(part, run.stderr)
            self.fails("render", text, "-o", "a.exr", "--strict", says=says)
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

    def cpu_seconds_of(self, run):
        start = os.times()
        run()
        end = os.times()
        return end.children_user + end.children_system - start.children_user - start.children_system

    def ends_soon(self, text, says, name="bad.pbrt", limit=1.0, words=()):
        """A scene that is refused within a second of CPU time and in 512 MB."""
        seconds = self.cpu_seconds_of(lambda: self.fails("render", self.scene(text, name), *words, says=says, preexec_fn=bounded_memory))
        self.assertLess(seconds, limit)

    def test_absurd_scenes_end_soon(self):
        world = SCENE[:SCENE.index("WorldBegin")] + "WorldBegin\n"
        self.ends_soon("", "WorldBegin")
        self.ends_soon(SCENE[:40], "bad.pbrt:")
        self.ends_soon(world + "AttributeBegin\n" * 1000000, "nested")
        self.ends_soon(world + "TransformBegin AttributeBegin " * 500000, "nested")
        self.ends_soon(world + 'ObjectBegin "a"\n' * 1000000, "nested")
        self.ends_soon(world + 'Shape "sphere" "float radius" ' + "[" * 1000000, "bad.pbrt:5:")
        self.ends_soon(world + 'Shape "sphere" "float radius" 1e999', "out of range")
        self.ends_soon(world + 'Shape "sphere" "float radius" ' + "9" * 100, "out of range")
        self.ends_soon(world + 'Shape "sphere" "float radius" ' + "9" * 1000000, "bad.pbrt:5:")
        self.ends_soon(world + 'Shape "sphere" ' + "".join(f'"float a{i}" 1\n' for i in range(100000)), "parameters")
        self.ends_soon(world + 'Texture "t" "float" "wrinkled" "integer octaves" ' + "1" + "0" * 30, "32 bits")
        for film in ['"integer xresolution" 1000000000', '"integer xresolution" -1', '"integer yresolution" 0']:
            self.ends_soon(SCENE.replace('Sampler', f'Film "image" {film} Sampler'), "film of")
        for samples in ["0", "-1", "1000000000000", "2147483647"]:
            self.ends_soon(SCENE.replace('"integer pixelsamples" 4', f'"integer pixelsamples" {samples}'), "samples")
        self.ends_soon(world + 'Shape "groom" "integer strands" 1000000000', "strands")
        first = world + 'Texture "t0" "float" "constant"\n'
        chain = 'Texture "t{}" "float" "scale" "texture tex1" "t{}" "{}"\n'  # deeper than the stack; 2^60 evaluations
        for levels, other in [(100000, 'float tex2" 1 "float x'), (60, 'texture tex2" "t{}" "float x')]:
            end = 'Material "matte" "texture sigma" "t{}" Shape "sphere" WorldEnd'
            flat, deep = ["".join(chain.format(i + 1, before, other.format(before))[:-1] + " 1\n" for i, before in pairs)
                          for pairs in [((i, 0) for i in range(levels)), ((i, i) for i in range(levels))]]
            # Reading so many textures takes its time; following them may take as much again, and not more.
            reading = self.cpu_seconds_of(
                lambda: self.ok("render", self.scene(first + flat + end.format(levels)), "-o", "a.exr", "--spp", "1"))
            self.ends_soon(first + deep + end.format(levels), "levels deep", limit=2 * reading + 0.5)

    def test_many_names_take_no_quadratic_time(self):
        """Each of these is right, or a warning; with 10,000 of a kind a quadratic search would show."""
        head = SCENE[:SCENE.index("WorldBegin")] + "WorldBegin\n"
        names = "".join(f'MakeNamedMaterial "material{i}" "string type" "matte"\n' for i in range(10000))
        unknown = "".join(f'NamedMaterial "matreial{i}" Shape "sphere"\n' for i in range(10000))
        blocks = "".join(f'Texture "t{i}" "float" "constant"\nAttributeBegin Texture "u" "float" "constant" AttributeEnd\n'
                         for i in range(10000))
        start = os.times()
        run = self.ok("render", self.scene(head + names + unknown + blocks + "WorldEnd\n"), "-o", "a.exr", "--spp", "1", "--threads", "1")
        self.assertIn("more of this kind", run.stderr)
        end = os.times()
        self.assertLess(end.children_user + end.children_system - start.children_user - start.children_system, 20)

    def test_includes_that_go_round_or_are_no_files(self):
        self.scene('Include "bad.pbrt"', "other.pbrt")
        self.ends_soon('Include "bad.pbrt"', "includes itself")
        self.ends_soon('Include "other.pbrt"', ["other.pbrt:1:", "includes itself"])
        os.symlink("bad.pbrt", self.path / "link.pbrt")
        self.ends_soon('Include "link.pbrt"', "includes itself")
        self.ends_soon('Include "vanished.pbrt"', ["bad.pbrt:1:9: warning:", "vanished.pbrt", "No such file", "without a WorldBegin"])
        self.ends_soon('Include "."', ["bad.pbrt:1:9: error:", "folder"])
        os.mkfifo(self.path / "pipe.pbrt")
        for suffix in [".exr", ".ply", ".hair", ".spd"]:
            os.mkfifo(self.path / f"pipe{suffix}")
        for name in ["pipe.pbrt", "/dev/zero", "/dev/full"]:
            self.ends_soon(f'Include "{name}"', ["bad.pbrt:1:9: error:", "not a scene file"])
        for line in ['Shape "plymesh" "string filename" "pipe.ply"', 'Shape "hairfile" "string filename" "pipe.hair"',
                     'LightSource "infinite" "string mapname" "pipe.exr"', 'Material "matte" "spectrum Kd" "pipe.spd"',
                     'Texture "t" "color" "imagemap" "string filename" "pipe.exr"']:
            self.scene(SCENE.replace("WorldEnd", line + "\nWorldEnd"))
            self.fails("render", "bad.pbrt", "-o", "a.exr", "--strict", says=["bad.pbrt:6:", "not a"])

    def test_nothing_reaches_the_terminal_raw(self):
        """Neither names of files nor the scene's words move a cursor or turn the direction of what is written."""
        evil = "\x1b]0;owned\x07\x9b31m\u202e\nerror: forged"
        (self.path / evil).mkdir()
        scene = f"{evil}/\u2066s.pbrt"
        (self.path / scene).write_text(SCENE.replace('"hair"', '"hair\x1b[2J\u202e"') + '\x1b[31m')
        os.mkdir(os.fsencode(self.path) + b"/\xff\xfe")
        for words in [["render", scene, "-o", f"{evil}/\u202ea.exr", "--spp", "1", "-v", "1"], ["render", scene, "--strict"], ["render", evil],
                      ["compare", evil, evil], ["convert", evil, "a.png"], ["groom", "from", evil, "-o", "a.pbrt"], [evil],
                      ["features", evil], ["features", "Material", evil], ["render", "scene.pbrt", "--integrator", evil],
                      ["render", "scene.pbrt", "--" + evil], ["render", "scene.pbrt", "--spp", evil], ["figure", evil], ["chart", evil],
                      ["render", "scene.pbrt", "-o", evil + "/no/a.exr"], ["render", b"\xff\xfe"], ["convert", b"\xff\xfe", "a.png"]]:
            run = subprocess.run([PROGRAM, *words], cwd=self.path, capture_output=True, timeout=60)
            out = run.stdout + run.stderr
            text = out.decode()  # valid UTF-8
            for bad in "\x1b\x07\x9b\u202e\u2066\x7f":
                self.assertNotIn(bad, text, words)

    def test_a_sandbox_holds_all_files(self):
        box = self.path / "box"
        box.mkdir()
        (self.path / "outside.pbrt").write_text('Shape "sphere"')
        (self.path / "outside.spd").write_text("400 1 700 1")
        self.ok("render", "scene.pbrt", "-o", "outside.exr", "--spp", "1")
        before = (self.path / "outside.exr").read_bytes()
        os.symlink("../outside.exr", box / "link.exr")
        os.symlink("..", box / "up")
        os.symlink("../new.exr", box / "dangling.exr")
        secrets = ["../outside", "up/outside", str(self.path / "outside")]
        (box / "s.pbrt").write_text(SCENE)
        self.ok("render", "--sandbox", "box", "box/s.pbrt", "-o", "box/a.exr", "--spp", "1")
        self.ok("render", "box/s.pbrt", "-o", "box/b.exr", "--spp", "1", "--sandbox", box)

        def refused(text, *words):
            (box / "s.pbrt").write_text(text)
            self.fails("render", "box/s.pbrt", "--sandbox", "box", "--spp", "1", *(words or ["-o", "box/a.exr"]), says="sandbox")

        for name in secrets + ["link"]:
            for line in ['Include "{}.pbrt"', 'Texture "t" "color" "imagemap" "string filename" "{}.exr"',
                         'LightSource "infinite" "string mapname" "{}.exr"', 'Shape "plymesh" "string filename" "{}.ply"',
                         'Shape "hairfile" "string filename" "{}.hair"', 'Material "matte" "spectrum Kd" "{}.spd"']:
                if name != "link" or ".exr" in line:
                    refused(SCENE.replace("WorldEnd", line.format(name) + "\nWorldEnd"))
            refused(SCENE.replace("Sampler", f'Film "image" "string filename" "{name if name[0] == "/" else "box/" + name}.exr" Sampler'), "-q")
        refused(SCENE, "-o", "box/dangling.exr")
        refused(SCENE, "-o", "a.exr")
        refused(SCENE, "-o", "box/a.exr", "--stats", "stats.json")
        self.fails("render", "scene.pbrt", "--sandbox", "box", "-o", "box/a.exr", says="sandbox")
        self.fails("render", "scene.pbrt", "--sandbox", "nowhere", says="is no folder")
        self.assertEqual((self.path / "outside.exr").read_bytes(), before)
        self.assertFalse((self.path / "new.exr").exists())

    def test_numbers_out_of_range(self):
        for words in [["--seed", "-1"], ["--seed", "1e30"], ["--seed", "18446744073709551616"], ["--seed", "x"], ["--spp", "0"], ["--spp", "-1"],
                      ["--spp", "1e99"], ["--spp", "99999999999"], ["--threads", "0"], ["--threads", "-1"], ["--threads", "99999999999"],
                      ["--crop", "nan", "1", "0", "1"], ["--crop", "0", "1", "0"], ["--crop", "inf", "1", "0", "1"], ["--crop", "2", "3", "0", "1"]]:
            run = self.run_program("render", "scene.pbrt", "-o", "a.exr", *words)
            self.assertEqual(run.returncode, 1, words)
            self.assertNotEqual(run.stderr, "", words)
        self.ok("render", "scene.pbrt", "-o", "a.exr", "--spp", "1", "--seed", "9007199254740992")
        self.fails("render", "/dev/zero", says="binary")
        self.fails("render", ".", says="folder")

    def test_damaged_files_name_the_directive(self):
        rubbish = {"empty": b"", "binary": bytes(range(256)) * 20, "text": b"not this\n" * 100}
        lines = {".ply": 'Shape "plymesh" "string filename" "FILE"', ".hair": 'Shape "hairfile" "string filename" "FILE"',
                 ".spd": 'Material "matte" "spectrum Kd" "FILE"'}
        for suffix in [".exr", ".png", ".pfm", ".tga", ".jpg", ".hdr"]:
            lines[suffix] = 'LightSource "infinite" "string mapname" "FILE"'
        for suffix, line in lines.items():
            for what, content in rubbish.items():
                file = what + suffix
                (self.path / file).write_bytes(content)
                self.ends_soon(SCENE.replace("WorldEnd", line.replace("FILE", file) + "\nWorldEnd"), ["bad.pbrt:6:", file], words=["--strict"])

    def test_outputs_that_cannot_be(self):
        before = (self.path / "scene.pbrt").read_text()
        self.fails("render", "scene.pbrt", "-o", "scene.pbrt", says=".exr or .png")
        (self.path / "scene.exr").write_text(SCENE)  # a scene with a picture's name
        self.fails("render", "scene.exr", "-o", "scene.exr", says="overwrite")
        self.assertEqual((self.path / "scene.exr").read_text(), SCENE)
        self.fails("render", "scene.pbrt", "-o", "a.exr", "--stats", "scene.pbrt", says="overwrite")
        self.assertEqual((self.path / "scene.pbrt").read_text(), before)
        self.fails("render", "scene.pbrt", "-o", "a.exr", "--stats", "a.exr", says="both")
        self.fails("render", "scene.pbrt", "-o", "a.exr", "--stats", "nowhere/s.json", says="nowhere")
        self.assertFalse((self.path / "a.exr").exists())
        (self.path / "folder.exr").mkdir()
        self.fails("render", "scene.pbrt", "-o", "folder.exr", says="folder")
        self.fails("render", "scene.pbrt", "-o", "/proc/a.exr", says="/proc")
        self.fails("groom", "hair-cube", "--strands", "9", "-o", "/proc/a.pbrt", says="/proc")
        os.symlink("/dev/full", self.path / "full.exr")
        os.symlink("/dev/full", self.path / "full.pbrt")
        self.fails("render", "scene.pbrt", "-o", "full.exr", says=["full.exr", "No space left"])
        self.fails("groom", "hair-cube", "--strands", "9", "-o", "full.pbrt", says=["full.pbrt", "No space left"])
        self.assertTrue(os.path.islink(self.path / "full.exr") and os.path.islink(self.path / "full.pbrt"))
        if os.getuid() != 0:  # to root nothing is read-only
            (self.path / "locked").mkdir(mode=0o500)
            self.fails("render", "scene.pbrt", "-o", "locked/a.exr", says="cannot be written")

    def test_a_full_disk_leaves_what_was_there(self):
        """RLIMIT_FSIZE stands for the full disk: a write beyond 200 bytes fails."""
        big = self.scene(SCENE.replace("20", "100").replace("10", "90"), "big.pbrt")
        commands = {"a.exr": ["render", big, "-o", "a.exr"], "a.png": ["render", big, "-o", "a.png"],
                    "a.pbrt": ["groom", "hair-cube", "--strands", "500", "-o", "a.pbrt"],
                    "a.pbrt.gz": ["groom", "hair-cube", "--strands", "5000", "-o", "a.pbrt.gz"],
                    "a.hair": ["groom", "hair-cube", "--strands", "500", "-o", "a.hair"]}
        for name, words in commands.items():
            for content in [None, b"what was there"]:
                if content:
                    (self.path / name).write_bytes(content)
                self.fails(*words, says=[name, "File too large"], preexec_fn=full_disk)
                self.assertEqual((self.path / name).read_bytes() if content else (self.path / name).exists(), content or False)
        self.assertEqual(sorted(f.name for f in self.path.iterdir()), sorted([*commands, "scene.pbrt", "big.pbrt"]))

    def test_render_all_tells_what_came_of_each_scene(self):
        (self.path / "deep").mkdir()
        self.scene(SCENE.replace('Material "hair"', 'Material "hair" "float bta_m" .3'), "deep/warned.pbrt")
        self.scene(SCENE.replace("Shape", "Shpae"), "refused.pbrt")
        self.scene('Include "nowhere.pbrt"\nWorldBegin WorldEnd', "lacking.pbrt")
        self.scene('Shape "sphere"', "part.pbrt")
        script = pathlib.Path(__file__).with_name("render_all.py")
        run = subprocess.run([sys.executable, script, self.path, PROGRAM], capture_output=True, text=True, timeout=60)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        for row in ["| scene.pbrt | whole |  |", '| deep/warned.pbrt | with warnings | Material "hair" has no use for parameter "bta_m" |',
                    "| refused.pbrt | refused | refused.pbrt:5:1: error:", "| lacking.pbrt | lacks files | cannot open \""]:
            self.assertIn(row, run.stdout)
        self.assertTrue(run.stdout.endswith("1 part of a scene\n"), run.stdout)

    def test_the_readme_holds_the_table_of_features(self):
        readme = (pathlib.Path(__file__).parent.parent / "README.md").read_text()
        table = readme.split("<!-- what `cuticle features` prints -->\n")[1].split("<!-- end -->")[0]
        self.assertEqual(table, self.ok("features").stdout, "replace the README's table by what `cuticle features` prints")

    def test_features_are_the_manual_of_every_parameter(self):
        hair = self.ok("features", "Material", "hair").stdout
        self.assertTrue(hair.startswith('## Material "hair"\n'), hair)
        self.assertIn("| parameter | type | unit | may be | default | meaning |\n", hair)
        row = next(line for line in hair.splitlines() if line.startswith("| `beta_m` |"))
        self.assertIn("| 0 to 1 | 0.3 |", row)
        self.assertRegex(hair, r"(?m)^\| `model` \|.*\| chiang, kajiya-kay, .*tabulated \|")
        self.assertEqual(self.ok("features", "material", "hair").stdout, hair)
        everything = self.ok("features", "Material").stdout
        self.assertIn(hair, everything)
        for name in ['"matte"', '"disney"', '""', '"fourier"']:
            self.assertIn(f"\n## Material {name}\n", everything)
        self.assertIn("Known and not rendered", self.ok("features", "Shape", "nurbs").stdout)
        self.assertIn('## Material ""\n', self.ok("features", "Material", "").stdout)
        self.fails("features", "Materiel", says='error: no directive "Materiel" takes the name of a plug-in. Did you mean "Material"?')
        self.fails("features", "hair", says='error: "hair" is no directive; it is the name of a Material: cuticle features Material hair')
        self.fails("features", "Shape", "spere", says='error: Shape "spere" is not known. Did you mean "sphere"?')

    def test_a_wrong_command_is_answered_with_the_nearest(self):
        self.fails("rendr", "x.pbrt", says='error: there is no command "rendr". Did you mean "render"?')

    def test_goniometer(self):
        run = self.ok("goniometer", "--samples", "20000", "--alpha", "3", "--roughness", "0.1", "--sigma-a", "0", "0.5",
                      "-o", "lobes")
        self.assertRegex(run.stdout, r"sum +(1\.000000|0\.99\d{4}) ± 0\.\d+ +0\.\d+ ± 0\.\d+")
        for ending in ["csv", "svg", "png"]:
            self.assertTrue((self.path / "lobes" / f"incidence.{ending}").stat().st_size > 1000, ending)
        table = (self.path / "lobes" / "incidence.csv").read_text().splitlines()
        self.assertTrue(table[0].startswith("# cuticle goniometer --eta 1.55 "), table[0])
        self.assertEqual(len(table), 2 + 360)
        # The first line makes the same numbers again.
        self.ok(*table[0].split()[2:], "-q", "-o", "again.csv")
        self.assertEqual((self.path / "again.csv").read_text().splitlines(), table)
        self.fails("goniometer", "--axis-ratio", "0", says="axis ratio must be in [0.05, 20]")
        self.fails("goniometer", "--samples", "10", "-o", "missing/a.csv", says="missing/a.csv")
        self.fails("goniometer", "--samples", "10", "--channel", "1", "-o", "a.csv", says="--channel must be below")

    def test_atlas(self):
        self.ok("atlas", "--quick", "--chapter", "paths", "longitudinal", "-o", "maps")
        index = (self.path / "maps" / "index.csv").read_text().splitlines()
        self.assertEqual(index[0], "fault,what,map,quantity,published,ours,double,state,tests")
        self.assertEqual({line.split(",")[0] for line in index[1:]}, set("1 2 3 4 5 7 8 9 12 13 15 16 26".split()))
        for ending in ["csv", "svg", "png"]:
            self.assertTrue((self.path / "maps" / f"edge.{ending}").stat().st_size > 1000, ending)
        page = (self.path / "maps" / "index.md").read_text()
        self.assertIn("![", page)
        for line in page.splitlines():
            if line.startswith("|"):  # a table of nine columns, whatever bars its texts hold
                self.assertEqual(len(re.findall(r"(?<!\\)\|", line)), 10, line)
        self.fails("atlas", "--quick", "--chapter", "paths", "-o", "scene.pbrt/maps", says="scene.pbrt/maps")

    def test_folders_that_have_the_name_of_a_file(self):
        self.fails("goniometer", "--samples", "10", "-o", "g.bmp", says=["g.bmp", ".csv, .svg, .png or .pdf"])
        self.fails("figure", "pharr-1.16", "-o", "f.png", says=["f.png", "NAME.csv, NAME.svg and NAME.png"])
        self.fails("chart", "bessel", "--quick", "-o", "c.svg", says=["c.svg", "NAME.csv"])
        self.fails("atlas", "--quick", "-o", "a.png", says=["a.png", "index.md"])
        self.assertEqual([f.name for f in self.path.iterdir()], ["scene.pbrt"])
        self.ok("figure", "pharr-1.16", "-o", "figures.new/")  # meant so
        self.ok("figure", "pharr-1.16", "-o", "figures.new")  # and there now

    def test_figures_that_are_rendered(self):
        scenes = pathlib.Path(__file__).resolve().parent.parent / "scenes"
        said = self.ok("figure", "pharr-1.20", "--quality", "draft", "--scenes", scenes, "-o", "drawn").stdout
        self.assertIn("pharr-1.20.csv, .svg, .png, pharr-1.20.exr", said)
        self.assertIn("CIEDE2000", said)
        self.assertEqual({f.name for f in (self.path / "drawn").iterdir()},
                         {f"pharr-1.20.{ending}" for ending in ["csv", "svg", "png", "exr"]})
        self.fails("figure", "pharr-1.20", "--scenes", "nowhere", says=["nowhere/pharr-1.20.pbrt"])
        self.fails("figure", "marschner-02", says="photograph")
        for words in [["pharr-1.20", "--quality", "best"], ["--all", "--list"], ["--all", "pharr-1.20"]]:
            run = self.run_program("figure", *words)
            self.assertEqual(run.returncode, 1, words)
            self.assertIn(words[-2] if words[-1] == "best" else "excludes", run.stderr)

    def test_what_cannot_be_printed_is_an_error(self):
        for words in [["features"], ["figure", "--list"], ["chart", "--list"], ["--help"], ["render", "--help"], ["--version"],
                      ["goniometer", "--samples", "100"], ["render", "scene.pbrt", "-o", "a.exr"]]:
            with open("/dev/full", "w") as full:
                run = subprocess.run([PROGRAM, *words], cwd=self.path, stdout=full, stderr=subprocess.PIPE, text=True, timeout=60)
            self.assertEqual(run.returncode, 1, words)
            self.assertIn("error: the standard output could not be written", run.stderr, words)

    def test_interrupt_writes_what_there_is(self):
        process = subprocess.Popen([PROGRAM, "render", "scene.pbrt", "--spp", "10000000", "-o", "a.exr"], cwd=self.path,
                                   stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        time.sleep(1.5)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertRegex(errors, r"stopped after \d+ of 10000000 samples")
        self.assertTrue((self.path / "a.exr").exists())

    RECIPE = ('Hair "groom" "integer strands" 30\nSimulation "strands" "float seconds" 0.25 "integer keys" 10\nObstacle "head"\n'
              'Motion "keys" "float time" [0 .2] "vector3 turn" [0 0 0 0 30 0]\n')

    def test_simulate_writes_frames(self):
        self.scene(self.RECIPE, "r.recipe")
        run = self.ok("simulate", "r.recipe", "-o", "frames/%03d.hair")
        self.assertRegex(run.stdout, "7 frames, 10 key hairs of 32 points, 3 steps a frame")
        self.assertEqual(sorted(f.name for f in (self.path / "frames").iterdir()), [f"{i:03}.hair" for i in range(7)])
        self.assertEqual(self.ok("simulate", "r.recipe", "-q", "-o", "a.usda").stdout, "")
        # The last frame of the one is that of the other
        self.ok("groom", "from", "frames/006.hair", "--spline", "linear", "-q", "-o", "a.pbrt")
        self.ok("groom", "from", "a.usda", "--time", "6", "-q", "-o", "b.pbrt")
        first, last = [re.search(r'"point P" \[([^\]]*)', (self.path / f).read_text())[1].split()[:3] for f in ["a.pbrt", "b.pbrt"]]
        self.assertEqual(first, last)
        self.assertIn("`bending`", self.ok("simulate", "--manual").stdout)
        self.ok("simulate", "r.recipe", "-q", "--keys", "-o", "k/%d.hair")
        self.assertLess((self.path / "k" / "6.hair").stat().st_size, (self.path / "frames" / "006.hair").stat().st_size)

    def test_mistakes_in_a_recipe(self):
        self.scene(self.RECIPE.replace("Obstacle", "Obstakle"), "bad.recipe")
        self.fails("simulate", "bad.recipe", "-o", "a.usda", says=["bad.recipe:3:1", 'Did you mean "Obstacle"'])
        self.scene(self.RECIPE, "r.recipe")
        self.fails("simulate", "r.recipe", "-o", "a.hair", says="%04d.hair")
        self.fails("simulate", "r.recipe", "-o", "a.exr", says=[".hair", ".usda"])
        self.fails("simulate", "none.recipe", "-o", "a.usda", says="none.recipe")
        self.fails("simulate", "r.recipe", "-o", "a.usda", "--vdb", "a%d.hair", says=['"a%d.hair" must end in .vdb', "frames/%04d.vdb"])
        self.fails("simulate", "r.recipe", "-o", "a.usda", "--vdb", "a.vdb", says="%04d.vdb")
        self.fails("simulate", says="-o OUTPUT")
        self.assertFalse((self.path / "a.usda").exists())

    def test_a_stopped_simulation_keeps_its_frames(self):
        self.scene(self.RECIPE.replace("0.25", "4000"), "r.recipe")
        for output in ["f/%05d.hair", "a.usda"]:
            process = subprocess.Popen([PROGRAM, "simulate", "r.recipe", "-o", output], cwd=self.path, stdout=subprocess.PIPE,
                                       stderr=subprocess.PIPE, text=True)
            time.sleep(1.5)
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 130)
            kept = int(re.search(r"stopped after (\d+) of 96001 frames, which are kept", errors)[1])
            self.assertGreater(kept, 1)
        self.assertEqual(self.ok("groom", "from", "a.usda", "--time", str(kept - 1), "-q", "-o", "b.pbrt").stdout, "")
        self.assertTrue((self.path / "f" / "00001.hair").exists())

    def test_a_stopped_simulation_goes_on_to_the_same_frames(self):
        self.scene(self.RECIPE.replace("0.25", "20"), "r.recipe")  # 481 frames
        command = ["simulate", "r.recipe", "-o", "f/%03d.hair", "--head", "f/head-%03d.pbrt"]
        process = subprocess.Popen([PROGRAM, *command], cwd=self.path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while not (self.path / "f" / "020.hair").exists():
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertIn("--resume goes on from f/simulation.part", errors)
        state = (self.path / "f" / "simulation.part").read_bytes()
        self.scene(self.RECIPE.replace("0.25", "19"), "other.recipe")
        self.fails("simulate", "other.recipe", *command[2:], "--resume", says=["simulation.part", "another recipe"])
        (self.path / "f" / "simulation.part").write_bytes(state[:-1])
        self.fails(*command, "--resume", says="simulation.part")
        (self.path / "f" / "simulation.part").write_bytes(state)
        first = (self.path / "f" / "010.hair").stat().st_mtime_ns
        self.ok(*command, "--resume")
        self.assertEqual((self.path / "f" / "010.hair").stat().st_mtime_ns, first)
        self.assertFalse((self.path / "f" / "simulation.part").exists())
        self.ok(*[word.replace("f/", "g/") for word in command])
        names = sorted(p.name for p in (self.path / "g").iterdir())
        self.assertEqual(len(names), 2 * 481)
        self.assertEqual(sorted(p.name for p in (self.path / "f").iterdir()), names)
        for name in names:
            self.assertEqual((self.path / "f" / name).read_bytes(), (self.path / "g" / name).read_bytes(), name)
        self.assertIn("ConcatTransform", (self.path / "f" / "head-004.pbrt").read_text())
        self.fails("simulate", "r.recipe", "-o", "a.usda", "--resume", says=["one file for all", "%04d.hair"])

    # A sphere whose place comes from a file of its own in each frame, and hair of both kinds of files.
    ANIMATION = ('Film "image" "integer xresolution" 8 "integer yresolution" 8\nSampler "sobol" "integer pixelsamples" 4\n'
                 'LookAt 0 0 60 0 0 0 0 1 0 Camera "perspective" "float fov" 40\nWorldBegin\nLightSource "infinite"\n')

    def test_frames_of_an_animation(self):
        self.scene(self.RECIPE, "r.recipe")
        self.ok("simulate", "r.recipe", "-o", "h/%03d.hair")
        self.ok("simulate", "r.recipe", "-o", "h.usda")
        self.scene(self.ANIMATION + 'Shape "hairfile" "string filename" "h/%03d.hair" "float width" 3\nWorldEnd\n', "many.pbrt")
        self.scene(self.ANIMATION + 'Shape "hairfile" "string filename" "h.usda" "float width" 3\nWorldEnd\n', "one.pbrt")
        run = self.ok("render", "many.pbrt", "--frames", "2:6:2", "-o", "out/%02d.exr", "--stats", "out/%d.json")
        self.assertEqual(sorted(f.name for f in (self.path / "out").iterdir()),
                         ["02.exr", "04.exr", "06.exr", "2.json", "4.json", "6.json"])
        self.assertEqual(run.stdout.count("8 x 8"), 3)
        # A frame is the picture of its own file; the time samples of the other file give the same to rounding
        self.scene((self.path / "many.pbrt").read_text().replace("%03d", "004"), "four.pbrt")
        self.ok("render", "four.pbrt", "-o", "four.exr")
        self.assertEqual(self.ok("compare", "four.exr", "out/04.exr", "--json").stdout.count('"mse": 0.0'), 1)
        # Rounding moves edges across a few samples: with 64 of them each counts little
        self.ok("render", "one.pbrt", "--frames", "6:6", "--spp", "64", "-o", "one%d.exr")
        self.ok("render", "many.pbrt", "--frames", "2:6:4", "--spp", "64", "-o", "deep%d.exr")
        mse = [json.loads(self.run_program("compare", "one6.exr", f"deep{n}.exr", "--json").stdout)["mse"] for n in [2, 6]]
        self.assertLess(mse[1], mse[0] / 100)
        # What is there stays, what is missing is made
        (self.path / "out" / "04.exr").unlink()
        before = (self.path / "out" / "02.exr").stat().st_mtime_ns
        run = self.ok("render", "many.pbrt", "--frames", "2:6:2", "-o", "out/%02d.exr", "--resume")
        self.assertIn("2 frames were there already", run.stdout)
        self.assertEqual(run.stdout.count("8 x 8"), 1)
        self.assertEqual((self.path / "out" / "02.exr").stat().st_mtime_ns, before)
        self.assertTrue((self.path / "out" / "04.exr").exists())
        # Beyond the samples hair stands still, and that is said
        self.assertIn("samples from time 0 to 6", self.ok("render", "one.pbrt", "--frames", "9:9", "-o", "b%d.exr").stderr)

    def test_mistakes_with_frames(self):
        self.scene(self.ANIMATION + 'Shape "hairfile" "string filename" "h/%03d.hair"\nWorldEnd\n', "many.pbrt")
        for frames in ["5", "5:", ":5", "a:b", "-1:3", "1:2:3:4", "1.5:2", "0:9999999", "1:2 "]:
            self.fails("render", "many.pbrt", f"--frames={frames}", "-o", "f%d.exr", says=["no range of frames", "0:95"])
        self.fails("render", "many.pbrt", "--frames", "5:4", "-o", "f%d.exr", says="ends before it begins")
        self.fails("render", "many.pbrt", "--frames", "1:4:0", "-o", "f%d.exr", says="step of 0")
        self.fails("render", "many.pbrt", "--frames", "1:4", says="needs -o")
        self.fails("render", "many.pbrt", "--frames", "1:4", "-o", "f.exr", says=["no place", "%04d.exr"])
        self.fails("render", "many.pbrt", "--frames", "1:4", "-o", "f%d%d.exr", says="two places")
        self.fails("render", "many.pbrt", "--frames", "1:4", "-o", "f%d.exr", "--stats", "s.json", says=["statistics", "no place"])
        self.fails("render", "many.pbrt", "--frames", "7:9", "-o", "f%d.exr", says=["many.pbrt:", "h/007.hair"])

    def test_a_stopped_animation_goes_on(self):
        self.scene(self.ANIMATION + 'Shape "sphere" "float radius" 9\nWorldEnd\n', "ball.pbrt")
        arguments = ["render", "ball.pbrt", "--frames", "0:3", "-o", "f/%d.exr", "--spp", "30000"]
        process = subprocess.Popen([PROGRAM, *arguments], cwd=self.path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while not (self.path / "f" / "0.exr").exists():
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        if process.returncode == 130:  # a fast machine may have ended
            self.assertRegex(errors, "stopped (in|before) frame [123]")
            self.assertFalse((self.path / "f" / "3.exr").exists())
        self.ok(*arguments, "--resume")
        self.ok("render", "ball.pbrt", "-o", "whole.exr", "--spp", "30000")
        for name in ["0.exr", "1.exr", "3.exr"]:
            self.assertEqual(self.ok("compare", "whole.exr", f"f/{name}", "--json").stdout.count('"mse": 0.0'), 1, name)
        self.assertEqual(sorted(f.name for f in (self.path / "f").iterdir()), [f"{i}.exr" for i in range(4)])

    def stand_in(self, script):
        """Puts a program called ffmpeg before all others; returns the environment in which it is found."""
        (self.path / "bin").mkdir(exist_ok=True)
        (self.path / "bin" / "ffmpeg").write_text(f"#!/bin/sh\n{script}\n")
        (self.path / "bin" / "ffmpeg").chmod(0o755)
        return {**os.environ, "PATH": f"{self.path}/bin:{os.environ['PATH']}"}

    def test_a_video_of_frames(self):
        self.scene(self.ANIMATION + 'Shape "sphere" "float radius" 9\nWorldEnd\n', "ball.pbrt")
        self.ok("render", "ball.pbrt", "--frames", "0:4:2", "-o", "f %d;.exr")
        # The program gets its words one by one, and the pixels of all frames
        env = self.stand_in('printf "%s\\n" "$@" > words; cat > pixels; printf video')
        run = self.ok("convert", "f %d;.exr", "-o", "a;b 'c.mp4", "--fps", "12.5", "--crf", "30", env=env)
        self.assertIn("8 x 8, 3 frames, 0.2 s", run.stdout)
        words = (self.path / "words").read_text().split("\n")
        for option, value in [("-s", "8x8"), ("-framerate", "12.5"), ("-crf", "30"), ("-f", "rawvideo")]:
            self.assertEqual(words[words.index(option) + 1], value)
        self.assertEqual((self.path / "a;b 'c.mp4").read_bytes(), b"video")
        self.ok("convert", "f 0;.exr", "f.png")
        pixels = (self.path / "pixels").read_bytes()
        self.assertEqual(len(pixels), 3 * 8 * 8 * 3)
        self.assertEqual(pixels[:192], pixels[192:384], "the ball stands still")
        self.assertGreater(len(set(pixels)), 4)
        self.assertIn("2 frames", self.ok("convert", "f %d;.exr", "b.mp4", "--frames", "2:4:2", env=env).stdout)
        # What goes wrong is said, and no video is left
        self.fails("convert", "g%d.exr", "c.mp4", says="no picture with a name like")
        self.fails("convert", "f %d;.exr", "c.mp4", "--frames", "0:4", says=["frame 1 is missing", "f 1;.exr"])
        self.fails("convert", "f 0;.exr", "c.mp4", says=["no place", "%04d.exr"])
        self.fails("convert", "f 0;.exr", "c.png", "--frames", "0:1", says=".mp4")
        self.fails("convert", "f %d;.exr", "c.mp4", env=self.stand_in("echo no such codec >&2; exit 1"), says="no such codec")
        self.fails("convert", "f %d;.exr", "c.mp4", env={**env, "PATH": str(self.path)}, says=["ffmpeg", "install"])
        (self.path / "f 2;.exr").unlink()
        self.fails("convert", "f %d;.exr", "c.mp4", "--frames", "0:4:2", env=env, says="frame 2 is missing")
        self.assertFalse((self.path / "c.mp4").exists())

    def test_a_stop_ends_the_maker_of_a_video(self):
        self.ok("render", "scene.pbrt", "--frames", "0:1", "-o", "f%d.exr", "--quick")
        env = self.stand_in("echo $$ > started; exec sleep 300")
        process = subprocess.Popen([PROGRAM, "convert", "f%d.exr", "a.mp4"], cwd=self.path, env=env, stdout=subprocess.DEVNULL)
        while not (self.path / "started").exists() or not (self.path / "started").read_text().strip():
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(timeout=20), 130)
        self.assertFalse((self.path / "a.mp4").exists())
        child = int((self.path / "started").read_text())
        self.assertFalse(pathlib.Path(f"/proc/{child}/cmdline").exists(), "it was ended, too")

    @unittest.skipUnless(shutil.which("ffmpeg"), "no ffmpeg here")
    def test_a_video_by_the_real_program(self):
        self.ok("render", "scene.pbrt", "--frames", "0:2", "-o", "f%d.exr", "--quick")
        self.ok("convert", "f%d.exr", "a.mp4")
        video = (self.path / "a.mp4").read_bytes()
        self.assertEqual(video[4:8], b"ftyp")
        self.assertLess(video.find(b"moov"), video.find(b"mdat"), "what a player needs stands in front")

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
