"""The base of tests that use the program as its users do: each in a folder of its own that holds scene.pbrt."""
import pathlib
import subprocess
import tempfile
import unittest


class ProgramCase(unittest.TestCase):
    program = scene_text = None  # set by the test's file
    decoding = "strict"  # of what the program prints: bytes that are no UTF-8 fail

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self.folder.name)
        (self.path / "scene.pbrt").write_text(self.scene_text)

    def tearDown(self):
        self.folder.cleanup()

    def run_program(self, *words, **options):
        return subprocess.run([self.program, *words], cwd=self.path, capture_output=True, text=True, timeout=120,
                              **{"errors": self.decoding, **options})

    def ok(self, *words, **options):
        run = self.run_program(*words, **options)
        self.assertEqual(run.returncode, 0, run.stderr)
        return run

    def fails(self, *words, says, **options):
        """Runs what must end with exit status 1 and one error."""
        run = self.run_program(*words, **options)
        self.assertEqual(run.returncode, 1, f"{words}: {run.stdout} {run.stderr}")
        for text in [says] if isinstance(says, str) else says:
            self.assertIn(text, run.stderr)
        self.assertEqual(run.stderr.count("error:"), 1, run.stderr)
        return run
