"""The weaver of the book (literate_docs/book.py): what it shows, and that whatever is broken stops it and says where.

Every test writes a tiny book into a temporary folder. Those that need pandoc and KaTeX are skipped where `.ci/setup book` has not
installed them; broken chunks, names, values and commands are found without. Run: python3 -m unittest tests/book_test.py
"""

import contextlib
import io
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "literate_docs"))
import book  # noqa: E402

SOURCE = "src/fibers/a.h"
CHAPTER = "literate_docs/01-first.md"
GOOD_SOURCE = """//> Add numbers
// Exact (Nobody 1999).
int Add(int a, int b) {
    //> Return the sum of $a$ and $b$
    return a + b;
    //<
}
//<
//> Add numbers
int Zero();
//<
"""
GOOD_CHAPTER = """# 1 Sums

Numbers can be added, $a < b$, as in ⟨Return the sum of $a$ and $b$⟩.

⟨Add numbers⟩

$$
\\sum_i a_i
$$

A sum it is.

⟨Return the sum of $a$ and $b$⟩

And nothing:

⟨Add numbers⟩

```values
pi = echo about 3.14159, twice 6.28318 => about ([\\d.]+)
tau => twice ([\\d.]+)
```

The circle has {{pi .3g}}, or {{pi %}}, or {{pi}}; all around {{tau .3g}}.

```run
echo made by > made.png; echo 6*7 is $((6*7))
```

![a picture](run:made.png)
"""
WITH_TOOLS = unittest.skipUnless(
    shutil.which("pandoc") and shutil.which("node") and any(Path(p).exists() for p in book.KATEX_CSS),
    "pandoc or KaTeX is missing: .ci/setup book installs them")


class Weaver(unittest.TestCase):
    def weave(self, files):
        """Weaves files, {path: text}; returns (status, what is printed, {page: text})."""
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()) as output:
            for path, text in files.items():
                file = Path(folder) / path
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text, encoding="utf-8")
            out = Path(folder) / "out"
            status = book.main(["--root", folder, "--out", str(out), "--no-pdf"])
            pages = {p.name: p.read_text(encoding="utf-8") for p in out.glob("*.html")} if out.exists() else {}
        return status, output.getvalue(), pages

    def assert_stops(self, chapter, *says, source=GOOD_SOURCE, **others):
        status, output, pages = self.weave({SOURCE: source, CHAPTER: chapter, **others})
        self.assertEqual(status, 1, output)
        self.assertEqual(pages, {})
        for text in says:
            self.assertIn(text, output)

    # --- what is broken stops the build ------------------------------------------------------------------------------
    def test_a_broken_chunk(self):
        self.assert_stops(GOOD_CHAPTER, f"{SOURCE}:9: error: chunk ⟨Add numbers⟩ is never closed", source=GOOD_SOURCE[:-5] + "\n")

    def test_a_broken_name(self):
        self.assert_stops(GOOD_CHAPTER.replace("⟨Add numbers⟩", "⟨Add number⟩", 1), f"{CHAPTER}:5: error: unknown chunk ⟨Add number⟩")

    def test_a_value_that_is_not_printed(self):
        self.assert_stops(GOOD_CHAPTER.replace("echo about", "echo exactly"),
                          f"{CHAPTER}:20: error: `echo exactly 3.14159, twice 6.28318` prints nothing that matches about")

    def test_a_value_that_nobody_defines(self):
        self.assert_stops(GOOD_CHAPTER.replace("{{pi %}}", "{{rho %}}"), f"{CHAPTER}:24: error: unknown value {{{{rho}}}}; this chapter has: pi, tau")

    def test_a_value_that_is_no_number(self):
        self.assert_stops(GOOD_CHAPTER.replace("([\\d.]+)", "(\\d)").replace("{{pi .3g}}", "{{pi .3q}}"),
                          f"{CHAPTER}:24: error: value pi is 3, which '.3q' does not format")

    def test_a_value_written_wrongly(self):
        self.assert_stops(GOOD_CHAPTER.replace("=>", "->"), f"{CHAPTER}:20: error: a value is written as: name = command")

    def test_a_value_without_a_command_before_it(self):
        self.assert_stops(GOOD_CHAPTER.replace("pi = echo about 3.14159, twice 6.28318 => about ([\\d.]+)\n", ""),
                          f"{CHAPTER}:20: error: a value is written as: name = command")

    def test_a_command_that_fails(self):
        self.assert_stops(GOOD_CHAPTER.replace("echo 6*7", "false && echo 6*7"), f"{CHAPTER}:27: error: `", "ends with status 1")

    def test_a_pattern_of_tests_that_matches_none(self):
        with tempfile.TemporaryDirectory() as folder:
            program = Path(folder) / "tests.sh"  # lists one test for the pattern A*, none for others
            program.write_text("#!/bin/sh\ncase \"$*\" in *list_tests*=A\\*) printf 'A.\\n  One\\n';; esac\n")
            program.chmod(0o755)
            check = book.Book.require_tests
            check(f"{program} --gtest_brief=1 --gtest_filter='A*'", folder, CHAPTER, 1)
            check(f"CUTICLE_ISA=sse2 X= {program} --gtest_filter='A*'", folder, CHAPTER, 1)
            with self.assertRaisesRegex(book.BookError, r"no test of .*tests.sh is called B\*"):
                check(f"CUTICLE_ISA=sse2 {program} --gtest_filter='A*:B*'", folder, CHAPTER, 1)

    def test_a_command_runs_again_when_a_program_that_it_names_has_changed(self):
        with tempfile.TemporaryDirectory() as folder:
            program = Path(folder) / "build/release/tool"
            program.parent.mkdir(parents=True)

            def output(says):
                if says:
                    program.write_text(f"echo {says}; echo ran >> {folder}/log\n")
                a_book = book.Book(Path(folder), Path(folder) / "out")
                return a_book.run("bash build/release/tool", CHAPTER, 1)

            self.assertEqual([output("one"), output(None), output("two")], ["one\n", "one\n", "two\n"])
            self.assertEqual((Path(folder) / "log").read_text(), "ran\nran\n")

    @contextlib.contextmanager
    def a_book(self):
        """Runs commands of a book that begins anew, but in the folder of the one before: run(command, ...)."""
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)

            def run(*commands):
                self.book = book.Book(root, root / "out")
                return [self.book.run(command, CHAPTER, 1) for command in commands]

            yield root, run

    def test_a_command_runs_again_when_what_it_reads_has_changed(self):
        with self.a_book() as (root, run):
            for name in ("scenes/a.pbrt", "scenes/textures/b.png", "reference_images/c.exr", "src/core/d.py"):
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text("old")
                command = f"echo {name.split('/')[0]}/a.pbrt; date +%N" if "scenes" in name else f"echo {name}; date +%N"
                first = run(command)
                self.assertEqual(run(command), first)
                (root / name).write_text("new")
                self.assertNotEqual(run(command), first, name)

    def test_a_command_runs_again_when_one_that_it_builds_on_has(self):
        with self.a_book() as (root, run):
            both = ["date +%N > time.txt", "cat time.txt; date +%N"]
            first = run(*both)
            self.assertEqual(run(*both), first)
            self.assertNotEqual(run("date +%N > time.txt; echo", both[1])[1], first[1])
            (root / "out/run/01-first/time.txt").unlink()  # what is not there any more is made again
            run(both[0])
            self.assertTrue((root / "out/run/01-first/time.txt").exists())

    def test_what_no_command_makes_disappears(self):
        with self.a_book() as (root, run):
            run("echo > old.png", "echo > kept.png")
            run("echo > kept.png")
            with self.assertRaisesRegex(book.BookError, "no command of this chapter wrote the picture old.png"):
                (root / "literate_docs").mkdir()
                (root / CHAPTER).write_text("")
                self.book.picture("old.png", CHAPTER)
            (root / "out/figures").mkdir()
            (root / "out/figures/01-first-old.png").write_text("")
            self.book.copied = [(CHAPTER, "kept.png")]
            self.book.sweep()
            self.assertEqual(sorted(p.name for p in (root / "out/run/01-first").glob("*.png")), ["kept.png"])
            self.assertEqual(list((root / "out/figures").glob("*")), [])

    def test_a_filter_that_lets_nothing_through(self):
        with self.a_book() as (root, run):
            for command in ["echo a | sed -n '/b/p'", "echo a | cut -c5-"]:
                with self.assertRaisesRegex(book.BookError, "prints nothing: its pattern matches nothing"):
                    run(command)
            with self.assertRaisesRegex(book.BookError, "ends with status 1"):
                run("echo a | grep b | cat")
            self.assertEqual(run("true > head.png"), [""])

    @unittest.skipUnless(shutil.which("ninja"), "needs ninja")
    def test_a_program_older_than_its_sources(self):
        with self.a_book() as (root, run):
            build = root / "build/release"
            build.mkdir(parents=True)
            (root / "a.cpp").write_text("echo one")
            (build / "build.ninja").write_text(f"rule copy\n  command = cp $in $out; chmod +x $out\nbuild tool: copy {root}/a.cpp\n")
            self.assertEqual(run("bash build/release/tool"), ["one\n"])
            (root / "a.cpp").write_text("echo two")
            self.assertEqual(run("bash build/release/tool; true"), ["two\n"])  # built again first
            with self.assertRaisesRegex(book.BookError, "the target book of CMakeLists.txt does not name it"):
                book.Book(root, root / "out", ["other"]).run("bash build/release/tool; echo", CHAPTER, 1)
            (root / "a.cpp").unlink()
            with self.assertRaisesRegex(book.BookError, "build/release/tool cannot be built"):
                run("bash build/release/tool; date")

    @WITH_TOOLS
    def test_a_build_that_fails_leaves_no_page_of_before(self):
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
            root = Path(folder)
            for path, text in {SOURCE: GOOD_SOURCE, CHAPTER: GOOD_CHAPTER}.items():
                (root / path).parent.mkdir(parents=True, exist_ok=True)
                (root / path).write_text(text, encoding="utf-8")
            self.assertEqual(book.main(["--root", folder, "--out", f"{folder}/out", "--no-pdf"]), 0)
            (root / CHAPTER).write_text(GOOD_CHAPTER.replace("echo 6*7", "false && echo 6*7"), encoding="utf-8")
            self.assertEqual(book.main(["--root", folder, "--out", f"{folder}/out", "--no-pdf"]), 1)
            self.assertEqual(list((root / "out").glob("*.html")), [])

    @WITH_TOOLS
    def test_a_broken_formula(self):
        self.assert_stops(GOOD_CHAPTER.replace("\\sum_i", "\\summe_i"), f"{CHAPTER}:7: error: KaTeX does not know $\\summe_i a_i$")
        self.assert_stops(GOOD_CHAPTER, f"{SOURCE}:1: error: KaTeX does not know $\\nix$",
                          source=GOOD_SOURCE.replace("Add numbers", "Add $\\nix$"),
                          **{"literate_docs/01-first.md": GOOD_CHAPTER.replace("Add numbers", "Add $\\nix$")})

    @WITH_TOOLS
    def test_a_dead_link(self):
        self.assert_stops(GOOD_CHAPTER + "\nSee [there](02-second.md).\n", f"{CHAPTER}:32: error: dead link: 02-second.md")
        self.assert_stops(GOOD_CHAPTER + "\nSee [there](#nowhere).\n", f"{CHAPTER}:32: error: dead link: nothing is called #nowhere")

    @WITH_TOOLS
    def test_a_missing_picture(self):
        self.assert_stops(GOOD_CHAPTER.replace("run:made.png", "run:other.png"), f"{CHAPTER}:30: error: no command of this chapter wrote the picture other.png")
        self.assert_stops(GOOD_CHAPTER.replace("run:made.png", "other.png"), f"{CHAPTER}:", "dead link: other.png")

    # --- what is woven -----------------------------------------------------------------------------------------------
    @WITH_TOOLS
    def test_a_book(self):
        status, output, pages = self.weave({SOURCE: GOOD_SOURCE, CHAPTER: GOOD_CHAPTER + "\nIt has 16 parts.\n\n```numbers\n16 parts == 4 ** 2\n```\n", "literate_docs/02-second.md": "# 2 More\n\nSee [chapter 1](01-first.md).\n"})
        self.assertEqual(status, 0, output)
        page = pages["01-first.html"]
        text = re.sub(r"<[^>]+>", "", page)
        self.assertNotIn("4 ** 2", text)
        for words in ["⟨Add numbers⟩ ≡", "It has 16 parts.", "⟨Add numbers⟩ +≡", "The circle has 3.14, or 314%, or 3.14159; all around 6.28.", "6*7 is 42", "used in", "continued in"]:
            self.assertIn(words, text)
        self.assertIn('class="katex"', page)
        self.assertIn("<figcaption>a picture</figcaption>", page)
        self.assertNotIn("$a", text.replace("application/x-tex", ""))
        self.assertIn('<a rel="next" href="02-second.html">', page)
        # From the listing to its line and back
        self.assertIn(f'href="source-src-fibers-a.h.html#L4">{SOURCE}:4</a>', page)
        source = pages["source-src-fibers-a.h.html"]
        target = re.search(r'id="L4".*?href="(01-first.html#[^"]+)"', source)[1]
        self.assertIn(f'id="{target.split("#")[1]}"', page)
        self.assertIn("Add", re.sub(r"<[^>]+>", "", pages["index-names.html"]))
        self.assertNotIn("\x02", "".join(pages.values()))

    @WITH_TOOLS
    def test_a_video_has_a_still_for_paper(self):
        films = GOOD_CHAPTER.replace("> made.png;", "> made.png; touch a.mp4 a.jpg b.mp4;") + "\n![it moves](run:a.mp4)\n![a picture](run:made.png)\n"
        status, output, pages = self.weave({SOURCE: GOOD_SOURCE, CHAPTER: films})
        self.assertEqual(status, 0, output)
        figures = re.findall(r"<figure>.*?</figure>", pages["01-first.html"])
        self.assertEqual(len(figures), 3)
        for words in ('<video src="figures/01-first-a.mp4" poster="figures/01-first-a.jpg" controls', '<img class="still" src="figures/01-first-a.jpg"', "<figcaption>it moves</figcaption>"):
            self.assertIn(words, figures[1])
        self.assertNotIn("video", figures[2])
        self.assert_stops(films.replace("run:a.mp4", "run:b.mp4"), "no command of this chapter wrote the picture b.jpg")

    def test_captions_lose_gnuplots_marks(self):
        self.assertEqual(book.plain_caption("{/:Italic N}_{TT} from 10^{-8}; v = 1"), "N_TT from 10^-8; v = 1")

    def test_highlighting_keeps_the_text(self):
        for line in ['int a = 1.5e-3f; // "no string"', 'const char *s = "a // b"; char c = \'"\';', "#include <array>", "if (a < b && c > d) return Foo<Bar>(0x1p-24f);"]:
            plain = re.sub(r"<[^>]+>", "", book.highlight(line))
            self.assertEqual(book.html.unescape(plain), line)


if __name__ == "__main__":
    unittest.main()
