#!/usr/bin/env python3
"""A picture is never lost: signals, kills, outputs that cannot be, files that change: never_lost_test.py PROGRAM"""
import json
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

from program_case import ProgramCase
from same_pictures import exr_values

PROGRAM = os.path.abspath(sys.argv.pop(1))
SCENE = """LookAt 0 0 3 0 0 0 0 1 0 Camera "perspective" "float fov" 40
Film "image" "integer xresolution" 40 "integer yresolution" 30 "string filename" "named.exr"
Sampler "halton" "integer pixelsamples" 4
WorldBegin LightSource "infinite" Material "hair"
Shape "curve" "point P" [-1 0 0 0 1 0 0 -1 0 1 0 0] "float width" .2
WorldEnd
"""
FOR_EVER = ["--spp", "16000000"]


def until(condition, seconds=60):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise AssertionError("it did not come to pass")
        time.sleep(0.02)


def catches(pid, number):
    try:
        status = pathlib.Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False
    return int(status.split("SigCgt:")[1].split()[0], 16) >> (number - 1) & 1


class NeverLost(ProgramCase):
    program, scene_text = PROGRAM, SCENE
    decoding = "replace"

    def start(self, *words, under=(), **options):
        """Starts a render, and waits until its temporary file shows that it is under way."""
        options = {"cwd": self.path, "stderr": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, **options}
        process = subprocess.Popen([*under, PROGRAM, "render", *words], **options)
        until(lambda: process.poll() is not None or
              (catches(process.pid, signal.SIGTERM) and list(self.path.glob("**/*.cuticle-??????"))))
        time.sleep(0.2)
        return process

    def names(self):
        return sorted(f.name for f in self.path.iterdir())

    def test_signals_that_end_a_program_write_the_picture(self):
        for stop in [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGXCPU]:
            process = self.start("scene.pbrt", *FOR_EVER, "-o", "a.exr")
            process.send_signal(stop)
            if stop != signal.SIGINT:  # systems repeat themselves; only a second Ctrl-C is impatience
                process.send_signal(stop)
            _, errors = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 128 + stop, errors)
            self.assertRegex(errors, r"stopped after \d+ of 16000000 samples per pixel; wrote a.exr\n")
            self.assertEqual(self.names(), ["a.exr", "scene.pbrt"])
            (self.path / "a.exr").unlink()

    def test_a_limit_on_processor_time_writes_the_picture(self):
        run = self.run_program("render", "scene.pbrt", *FOR_EVER, "-o", "a.exr",
                               preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (1, 60)))
        self.assertEqual(run.returncode, 128 + signal.SIGXCPU, run.stderr)
        self.assertTrue((self.path / "a.exr").exists())

    def test_what_the_caller_ignores_stays_ignored(self):
        """A shell starts what runs in its background with SIGINT ignored, nohup with SIGHUP."""
        def ignoring():
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            signal.signal(signal.SIGHUP, signal.SIG_IGN)
        process = self.start("scene.pbrt", *FOR_EVER, "-o", "a.exr", preexec_fn=ignoring)
        for _ in range(3):
            process.send_signal(signal.SIGINT)
            process.send_signal(signal.SIGHUP)
        time.sleep(0.5)
        self.assertIsNone(process.poll())
        process.terminate()
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 128 + signal.SIGTERM)

    def test_readers_that_go_cost_nothing(self):
        warned = SCENE.replace('Material "hair"', 'Material "hair" "float bta_m" .3').replace(
            "WorldEnd", 'Shape "nurbs"\nWorldEnd')
        (self.path / "warned.pbrt").write_text(warned)
        for words in ["render warned.pbrt -o a.exr", "compare a.exr a.exr --error-image b.png",
                      "convert a.exr c.png", "groom hair-cube --strands 99 -o d.hair",
                      "goniometer --samples 1000 -o e.csv", "features"]:
            # The reader is gone before the program begins
            reader, writer = os.pipe()
            os.close(reader)
            run = subprocess.run([PROGRAM, *words.split()], cwd=self.path, stdout=writer, stderr=writer, timeout=60)
            os.close(writer)
            self.assertEqual(run.returncode, 0, words)
        self.assertEqual(self.names(), ["a.exr", "b.png", "c.png", "d.hair", "e.csv", "scene.pbrt", "warned.pbrt"])

    def test_a_kill_costs_little_and_the_rest_is_the_same(self):
        words = ["render", "scene.pbrt", "--variance", "--threads", "2", "-o", "a.exr", "--spp", "800"]
        self.ok(*words)
        (self.path / "a.exr").rename(self.path / "whole.exr")
        process = self.start(*words[1:], "--checkpoint", "0.01")
        part = self.path / "a.exr.part"
        until(lambda: part.exists() or process.poll() is not None)
        process.kill()
        process.communicate()
        self.assertTrue(part.exists() and not (self.path / "a.exr").exists())
        before = part.read_bytes()
        self.fails(*words, says=["a.exr.part", "of 800 samples per pixel", "--resume"])
        self.fails(*words[:-1], "801", "--resume", says=["number of samples per pixel is 800, not 801"])
        (self.path / "scene.pbrt").write_text(SCENE.replace(".2", ".3"))
        self.fails(*words, "--resume", says=["a.exr.part", "hash of the scene's files"])
        (self.path / "scene.pbrt").write_text(SCENE)
        for other in [["--seed", "2"], ["--compat", "pbrt-v3"], ["--hair-model", "marschner"], ["--curves", "binary"],
                      ["--integrator", "whitted"], ["--crop", "0", ".5", "0", "1"], ["--quick"], ["--hair", "scalar"]]:
            self.fails(*words, *other, "--resume", says=["a.exr.part", "is a part of another render"])
        self.fails(*words, "--resume", says="is a part of another render: the instruction set is",
                   env={**os.environ, "CUTICLE_ISA": "sse2"})
        self.assertEqual(part.read_bytes(), before)
        run = self.ok(*words, "--resume", "--stats", "s.json")
        self.assertIn("800 samples per pixel", run.stdout)
        self.assertEqual(exr_values(self.path / "whole.exr"), exr_values(self.path / "a.exr"))
        self.assertEqual(self.names(), ["a.exr", "s.json", "scene.pbrt", "whole.exr"])  # no part, nothing temporary

    def test_a_stopped_run_is_gone_on_with(self):
        words = ["scene.pbrt", *FOR_EVER, "-o", "a.exr"]
        last = 0
        for wish in [["--checkpoint", "1000"], ["--resume"], ["--resume"]]:
            process = self.start(*words, *wish)
            process.terminate()
            _, errors = process.communicate(timeout=60)
            self.assertIn("--resume goes on from a.exr.part", errors)
            done = int(errors.split("stopped after ")[1].split()[0])
            self.assertGreaterEqual(done, last)
            last = done
        self.fails("render", *words, says=f"holds {last} of 16000000")
        os.mkfifo(self.path / "pipe.png")
        reader = os.open(self.path / "pipe.png", os.O_RDONLY | os.O_NONBLOCK)
        self.fails("render", "scene.pbrt", "-o", "pipe.png", "--resume", says="no plain file")
        os.close(reader)

    def test_a_part_knows_every_file_of_its_scene(self):
        subprocess.run([PROGRAM, "groom", "hair-cube", "--strands", "9", "-o", "g.hair", "-q"], cwd=self.path, check=True)
        self.ok("render", "scene.pbrt", "-o", "t.exr", "--spp", "1", "-q")
        (self.path / "inc.pbrt").write_text("# included\n")
        (self.path / "s.spd").write_text("400 1\n700 1\n")
        (self.path / "m.ply").write_text("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                                         "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                                         "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
        shutil.copy(self.path / "t.exr", self.path / "sky.exr")
        more = """Include "inc.pbrt" Texture "t" "color" "imagemap" "string filename" "t.exr"
Material "matte" "texture Kd" "t" Shape "plymesh" "string filename" "m.ply" Material "matte" "spectrum Kd" "s.spd"
Shape "sphere" "float radius" .1 Shape "hairfile" "string filename" "g.hair"
LightSource "infinite" "string mapname" "sky.exr" WorldEnd"""
        (self.path / "scene.pbrt").write_text(SCENE.replace("WorldEnd", more))
        words = ["scene.pbrt", *FOR_EVER, "-o", "a.exr", "--checkpoint", "1000"]
        process = self.start(*words)
        process.terminate()
        process.communicate(timeout=60)
        self.assertTrue((self.path / "a.exr.part").exists())
        for name in ["scene.pbrt", "inc.pbrt", "t.exr", "m.ply", "s.spd", "g.hair", "sky.exr"]:
            file = self.path / name
            before = file.read_bytes()
            # What is read as an error does not count; these are read the same, or nearly
            file.write_bytes(before + b"\n" if name[-3:] in ["brt", "spd", "ply"] else before[:-1] + bytes([before[-1] ^ 1]))
            run = self.run_program("render", *words, "--resume")
            self.assertEqual(run.returncode, 1, name)
            self.assertRegex(run.stderr, "another render: the (hash of the scene's files|scene's text in bytes)|" + name)
            file.write_bytes(before)
            # Nor is one of them ever written over
            for out in {name, "link.exr"}:
                if pathlib.Path(out).suffix == ".exr":
                    (self.path / "link.exr").unlink(missing_ok=True)
                    os.symlink(name, self.path / "link.exr")
                    self.fails("render", "scene.pbrt", "--spp", "1", "-o", out, says="cannot overwrite what is read here")
            self.fails("render", "scene.pbrt", "--spp", "1", "-o", "b.exr", "--stats", name,
                       says="cannot overwrite what is read here")
            self.assertEqual(file.read_bytes(), before)

    def test_no_command_writes_over_what_it_reads(self):
        self.ok("groom", "hair-cube", "--strands", "9", "-o", "g.hair")
        self.ok("render", "scene.pbrt", "-o", "t.exr")
        before = {f.name: f.read_bytes() for f in self.path.iterdir()}
        for words in [["groom", "from", "g.hair", "-o", "g.hair"], ["convert", "t.exr", "t.exr"],
                      ["compare", "t.exr", "t.exr", "--error-image", "t.exr"]]:
            self.fails(*words, says="cannot overwrite what is read here")
        self.assertEqual({f.name: f.read_bytes() for f in self.path.iterdir()}, before)

    def test_outputs_that_cannot_be_are_known_before(self):
        spp = ["--spp", "100000000"[:8]]
        os.symlink("/dev/full", self.path / "full.exr")
        os.symlink("nowhere/a.exr", self.path / "lost.exr")
        os.mkfifo(self.path / "pipe.exr")
        (self.path / "kept.exr").write_text("kept")
        (self.path / "kept.exr").chmod(0o444)
        for name, says in {"a" * 300 + ".exr": "File name too long", "no/a.exr": "does not exist", "/proc/a.exr": "/proc",
                           "full.exr": "No space left", "lost.exr": "No such file", "pipe.exr": "nobody reads",
                           "kept.exr": "Permission denied"}.items():
            start = time.monotonic()
            self.fails("render", "scene.pbrt", *spp, "-o", name, says=says)
            self.fails("render", "scene.pbrt", *spp, "-o", "a.exr", "--stats", name, says=says)
            self.assertLess(time.monotonic() - start, 60)
        self.assertEqual((self.path / "kept.exr").read_text(), "kept")
        self.assertFalse((self.path / "a.exr").exists())
        os.symlink("later.exr", self.path / "dangling.exr")
        self.ok("render", "scene.pbrt", "-o", "dangling.exr")
        self.assertTrue((self.path / "dangling.exr").is_symlink() and not (self.path / "later.exr").is_symlink())
        # A pipe that is read gets the picture
        self.ok("render", "scene.pbrt", "-o", "a.png")
        got = []
        reader = threading.Thread(target=lambda: got.append((self.path / "pipe.png").read_bytes()))
        os.mkfifo(self.path / "pipe.png")
        reader.start()
        time.sleep(0.2)
        self.ok("render", "scene.pbrt", "-o", "pipe.png")
        reader.join()
        self.assertEqual(got, [(self.path / "a.png").read_bytes()])

    def test_a_full_disk_is_known_before(self):
        disk = self.path / "disk"
        disk.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", disk], capture_output=True).returncode:
            self.skipTest("only root may mount a small disk")
        try:
            self.fails("render", "scene.pbrt", *FOR_EVER, "-o", "disk/a.exr", says=["disk/a.exr", "no room"])
        finally:
            subprocess.run(["umount", disk], check=True)

    def test_a_folder_that_vanishes_does_not_take_the_picture_along(self):
        (self.path / "gone").mkdir()
        (self.path / "a.exr").write_text("something else")
        process = self.start("scene.pbrt", *FOR_EVER, "-o", "gone/a.exr")
        shutil.rmtree(self.path / "gone")
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1, errors)
        self.assertIn(f'the picture was saved as "{self.path.resolve()}/a-1.exr" instead', errors)
        self.assertEqual((self.path / "a.exr").read_text(), "something else")
        self.assertEqual(len(exr_values(self.path / "a-1.exr")["R"]), 40 * 30)

    def test_what_killed_runs_leave_is_removed(self):
        killed = self.start("scene.pbrt", *FOR_EVER, "-o", "a.exr", "--stats", "a.json")
        killed.kill()
        killed.communicate()
        self.assertEqual(len(list(self.path.glob("*.cuticle-*"))), 2)
        living = self.start("scene.pbrt", *FOR_EVER, "-o", "b.exr")
        self.ok("render", "scene.pbrt", "-o", "c.exr")
        self.assertEqual([f.name[:5] for f in self.path.glob("*.cuticle-*")], ["b.exr"])
        living.terminate()
        living.communicate(timeout=60)
        self.assertEqual(self.names(), ["b.exr", "c.exr", "scene.pbrt"])

    def test_fewer_threads_than_wished(self):
        """A small space for addresses holds few stacks: a warning or an error, never an end by abort."""
        for megabytes in [150, 200, 250, 300, 400, 600, 1000, 2000]:
            size = megabytes << 20
            run = self.run_program("render", "scene.pbrt", "-o", "a.exr", "--spp", "1", "--threads", "200",
                                   preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (size, size)))
            # 127: the libraries themselves do not fit
            self.assertIn(run.returncode, [0, 1, 127], f"{megabytes} MB: {run.stderr}")
            if run.returncode == 0 and megabytes < 1000:
                self.assertIn("threads can be started", run.stderr)

    def test_names_that_are_not_utf8(self):
        name = b"sc\xe8ne\xff.pbrt"
        (self.path / os.fsdecode(name)).write_text(SCENE)
        self.ok("render", os.fsdecode(name), "-o", os.fsdecode(b"\xfe.exr"), "--stats", "s.json")
        self.assertEqual(json.loads((self.path / "s.json").read_bytes().decode())["scene"], "sc\ufffdne\ufffd.pbrt")
        self.assertTrue((self.path / os.fsdecode(b"\xfe.exr")).exists())
        picture = os.fsdecode(b"\xfe.exr")
        json.loads(self.ok("compare", picture, picture, "--json").stdout)


unittest.main()
