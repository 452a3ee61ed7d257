"""The check of the book (literate_docs/weave.py --check) finds each kind of error, names its place, and fails.

Every test writes a tiny book into a temporary folder. Run: python3 -m unittest tests/literate_check_test.py
"""

import contextlib
import io
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

WEAVE = Path(__file__).resolve().parent.parent / "literate_docs" / "weave.py"
sys.dont_write_bytecode = True  # leave no cache beside the book
sys.path.insert(0, str(WEAVE.parent))
import weave  # noqa: E402
SOURCE = "src/fibers/a.h"
CHAPTER = "literate_docs/01-first.md"
GOOD_SOURCE = "//> Add two numbers\nint Add(int a, int b);\n//<\n"
GOOD_CHAPTER = "# 1 Sums\n\nNumbers can be added.\n\n⟨Add two numbers⟩\n"


class LiterateCheck(unittest.TestCase):
    @contextlib.contextmanager
    def book(self, files):
        """A folder that holds files, {path: text}."""
        with tempfile.TemporaryDirectory() as folder:
            for path, text in files.items():
                file = Path(folder) / path
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text, encoding="utf-8")
            yield folder

    def check(self, files):
        """Runs the check over files; returns (exit status, lines printed)."""
        with self.book(files) as folder, contextlib.redirect_stdout(io.StringIO()) as output:
            status = weave.main(["--check", "--root", folder])
        return status, output.getvalue().splitlines()

    def assert_good(self, files):
        self.assertEqual(self.check(files), (0, []))

    def assert_errors(self, files, *expected):
        self.assertEqual(self.check(files), (1, list(expected)))

    # --- the command -----------------------------------------------------------------------------------------------
    def run_command(self, files, *options):
        with self.book(files) as folder:
            result = subprocess.run([sys.executable, str(WEAVE), *options, "--root", folder],
                                    capture_output=True, text=True, encoding="utf-8")
        return result.returncode, result.stdout, result.stderr

    def test_the_command_ends_with_the_status_and_prints_the_errors(self):
        self.assertEqual(self.run_command({SOURCE: GOOD_SOURCE, CHAPTER: GOOD_CHAPTER}, "--check"), (0, "", ""))
        self.assertEqual(self.run_command({SOURCE: "int outside;\n"}, "--check"),
                         (1, f"{SOURCE}:1: error: this line lies outside all chunks\n", ""))

    def test_the_command_wants_to_be_told_to_check(self):
        status, output, errors = self.run_command({})
        self.assertEqual((status, output), (2, ""))
        self.assertIn("--check", errors)

    # --- what is right -----------------------------------------------------------------------------------------------
    def test_a_book_that_shows_everything_is_right(self):
        self.assert_good({SOURCE: GOOD_SOURCE, CHAPTER: GOOD_CHAPTER})

    def test_an_empty_project_is_right(self):
        self.assert_good({})

    def test_other_files_need_no_chunks(self):
        self.assert_good({"src/scene/parser.cpp": "int x;\n", "src/shapes/ply.h": "int y;\n"})

    def test_nested_and_continued_chunks(self):
        source = ("//> Outer\nint a;\n    //> Inner\n    int b;\n    //<\n//<\n"
                  "//> Outer\nint c;\n//<\n")
        chapter = "First, as ⟨Inner⟩ will say.\n\n⟨Outer⟩\n\nThen.\n⟨Inner⟩\n\nLast.\n\n⟨Outer⟩\n"
        self.assert_good({SOURCE: source, CHAPTER: chapter})

    def test_pieces_may_be_shown_in_several_chapters(self):
        source = "//> Outer\nint a;\n//<\n//> Outer\nint b;\n//<\n"
        self.assert_good({SOURCE: source, CHAPTER: "One.\n\n⟨Outer⟩\n", "literate_docs/02-second.md": "Two.\n\n⟨Outer⟩\n"})

    def test_one_name_in_two_files_is_told_apart_by_file(self):
        self.assert_good({"src/fibers/a.h": GOOD_SOURCE, "src/fibers/b.h": GOOD_SOURCE,
                          CHAPTER: "One ⟨b.h: Add two numbers⟩.\n\n⟨a.h: Add two numbers⟩\n\nTwo.\n\n"
                                   "⟨fibers/b.h: Add two numbers⟩\n"})

    def test_a_formula_may_stand_between_prose_and_listing(self):
        self.assert_good({SOURCE: GOOD_SOURCE, CHAPTER: "Numbers add:\n\n$$\na + b\n$$\n\n$$c$$\n\n⟨Add two numbers⟩\n"})

    def test_a_link_may_run_over_two_lines(self):
        self.assert_good({SOURCE: GOOD_SOURCE, CHAPTER: GOOD_CHAPTER + "\nSee ⟨Add two\nnumbers⟩ again.\n"})

    def test_code_in_a_chapter_is_not_read(self):
        self.assert_good({SOURCE: GOOD_SOURCE,
                          CHAPTER: GOOD_CHAPTER + "\n```\n⟨Nothing⟩\n⟨\n```\n\nWrite `⟨Name⟩` or ``⟨`Name⟩``.\n"})

    def test_prose_may_begin_with_code(self):
        self.assert_good({SOURCE: GOOD_SOURCE, CHAPTER: "Numbers can be added by\n`Add`.\n\n⟨Add two numbers⟩\n"})

    # --- sources -----------------------------------------------------------------------------------------------------
    def test_unclosed(self):
        self.assert_errors({SOURCE: "\n".join(["//> Outer", "int a;", "//> Add two numbers", "int b;", "//<", ""]),
                            CHAPTER: "Text.\n\n⟨Outer⟩\n\nText.\n\n⟨Add two numbers⟩\n"},
                           f"{SOURCE}:1: error: chunk ⟨Outer⟩ is never closed")

    def test_over_closed(self):
        self.assert_errors({SOURCE: GOOD_SOURCE + "//<\n", CHAPTER: GOOD_CHAPTER},
                           f"{SOURCE}:4: error: '//<' closes a chunk, but none is open")

    def test_line_outside_all_chunks(self):
        self.assert_errors({SOURCE: "#pragma once\n\n" + GOOD_SOURCE + "int outside;\n", CHAPTER: GOOD_CHAPTER},
                           f"{SOURCE}:1: error: this line lies outside all chunks",
                           f"{SOURCE}:6: error: this line lies outside all chunks")

    def test_every_literate_place_is_looked_at(self):
        for path in ("src/fibers/lanes/b.cpp", "src/shapes/curve.h", "src/shapes/curve_set_build.cpp",
                     "src/core/sampling.cpp", "src/materials/hair_material.h", "src/render/path.cpp",
                     "src/render/integrator.h", "src/images/compare.cpp"):
            with self.subTest(path):
                self.assert_errors({path: "int outside;\n"}, f"{path}:1: error: this line lies outside all chunks")

    def test_mark_without_a_name(self):
        self.assert_errors({SOURCE: GOOD_SOURCE + "//>Name\n//<\n", CHAPTER: GOOD_CHAPTER + "\nText.\n\n⟨Name⟩\n"},
                           f"{SOURCE}:4: error: a chunk opens with '//> Name of the step': a space and a name")

    def test_close_with_words_after_it(self):
        self.assert_errors({SOURCE: GOOD_SOURCE[:-1] + " end\n", CHAPTER: GOOD_CHAPTER},
                           f"{SOURCE}:3: error: '//<' stands alone on its line")

    def test_chunk_inside_itself(self):
        self.assert_errors({SOURCE: "//> A\n//> A\nint a;\n//<\n//<\n", CHAPTER: "Text.\n\n⟨A⟩\n\nText.\n\n⟨A⟩\n"},
                           f"{SOURCE}:2: error: chunk ⟨A⟩ is opened inside itself")

    # --- chapters ----------------------------------------------------------------------------------------------------
    def test_unknown_listing(self):
        self.assert_errors({SOURCE: GOOD_SOURCE, CHAPTER: GOOD_CHAPTER + "\nText.\n\n⟨Add three numbers⟩\n"},
                           f"{CHAPTER}:9: error: unknown chunk ⟨Add three numbers⟩")

    def test_unknown_link(self):
        self.assert_errors({SOURCE: GOOD_SOURCE, CHAPTER: GOOD_CHAPTER + "\nSee ⟨Add three\nnumbers⟩ there.\n"},
                           f"{CHAPTER}:7: error: unknown chunk ⟨Add three numbers⟩")

    def test_unknown_in_the_file_that_is_named(self):
        self.assert_errors({SOURCE: GOOD_SOURCE, CHAPTER: GOOD_CHAPTER + "\nSee ⟨z.h: Add two numbers⟩.\n"},
                           f"{CHAPTER}:7: error: unknown chunk ⟨z.h: Add two numbers⟩")

    def test_name_in_several_files(self):
        self.assert_errors({"src/fibers/a.h": GOOD_SOURCE, "src/fibers/b.h": GOOD_SOURCE,
                            CHAPTER: "One.\n\n⟨a.h: Add two numbers⟩\n\nTwo.\n\n⟨b.h: Add two numbers⟩\n\n"
                                     "And ⟨Add two numbers⟩.\n"},
                           f"{CHAPTER}:9: error: chunk ⟨Add two numbers⟩ is in several files: say which, as in "
                           "⟨a.h: Add two numbers⟩ or ⟨b.h: Add two numbers⟩")

    def test_unused(self):
        self.assert_errors({SOURCE: GOOD_SOURCE, CHAPTER: "Text with a link to ⟨Add two numbers⟩.\n"},
                           f"{SOURCE}:1: error: unused chunk: ⟨Add two numbers⟩ is shown in no chapter")

    def test_unused_without_any_chapter(self):
        self.assert_errors({SOURCE: GOOD_SOURCE},
                           f"{SOURCE}:1: error: unused chunk: ⟨Add two numbers⟩ is shown in no chapter")

    def test_unused_nested_chunk(self):
        self.assert_errors({SOURCE: "//> Outer\nint a;\n//> Inner\nint b;\n//<\n//<\n", CHAPTER: "Text.\n\n⟨Outer⟩\n"},
                           f"{SOURCE}:3: error: unused chunk: ⟨Inner⟩ is shown in no chapter")

    def test_unused_second_piece(self):
        self.assert_errors({SOURCE: "//> A\nint a;\n//<\n//> A\nint b;\n//<\n", CHAPTER: "Text.\n\n⟨A⟩\n"},
                           f"{SOURCE}:4: error: unused chunk: piece 2 of 2 of ⟨A⟩ is shown in no chapter")

    def test_shown_twice(self):
        self.assert_errors({SOURCE: GOOD_SOURCE, CHAPTER: GOOD_CHAPTER,
                            "literate_docs/02-second.md": "Again.\n\n⟨Add two numbers⟩\n"},
                           "literate_docs/02-second.md:3: error: chunk ⟨Add two numbers⟩ is shown twice; "
                           f"the last of it was shown at {CHAPTER}:5")

    def test_unexplained(self):
        listing = "⟨Add two numbers⟩\n"
        for before in ("", "# Heading\n\n", "Text.\n\n## Heading\n\n", "Text.\n\n![figure](a.png)\n\n",
                       "Text.\n\n```\ncode\n```\n\n", "Text.\n\n| a | b |\n", "Text.\n\n---\n", "# Heading\n\n$$x$$\n\n",
                       "Text.\n\n## Heading\n\n$$\nx\n$$\n", "Text.\n\n<!-- note -->\n"):
            with self.subTest(before):
                self.assert_errors({SOURCE: GOOD_SOURCE, CHAPTER: before + listing},
                                   f"{CHAPTER}:{before.count(chr(10)) + 1}: error: unexplained chunk "
                                   "⟨Add two numbers⟩: no prose stands before it")

    def test_unexplained_after_another_listing(self):
        self.assert_errors({SOURCE: "//> A\nint a;\n//<\n//> B\nint b;\n//<\n", CHAPTER: "Text.\n\n⟨A⟩\n\n⟨B⟩\n"},
                           f"{CHAPTER}:5: error: unexplained chunk ⟨B⟩: no prose stands before it")

    def test_bracket_without_partner(self):
        self.assert_errors({SOURCE: GOOD_SOURCE, CHAPTER: GOOD_CHAPTER + "\nSee ⟨ there.\n"},
                           f"{CHAPTER}:7: error: '⟨' has no partner")

    def test_errors_are_reported_together_in_order(self):
        self.assert_errors({SOURCE: "int x;\n//> A\nint a;\n", CHAPTER: "⟨A⟩\n\nSee ⟨B⟩.\n"},
                           f"{CHAPTER}:1: error: unexplained chunk ⟨A⟩: no prose stands before it",
                           f"{CHAPTER}:3: error: unknown chunk ⟨B⟩",
                           f"{SOURCE}:1: error: this line lies outside all chunks",
                           f"{SOURCE}:2: error: chunk ⟨A⟩ is never closed")


if __name__ == "__main__":
    unittest.main()
