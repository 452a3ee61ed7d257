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

    # --- blocks, numbers, appendices ---------------------------------------------------------------------------------
    def test_a_block_that_is_neither_run_nor_checked(self):
        self.assert_errors({CHAPTER: "# 1 A\n\nText.\n\n```cpp\nint a;\n```\n"},
                           f"{CHAPTER}:5: error: a block `cpp` is neither run nor checked: run, values, figure, chart, numbers or sh")
        self.assert_errors({CHAPTER: "# 1 A\n\nText:\n\n    make it\n"},
                           f"{CHAPTER}:5: error: indented code is neither run nor checked: write a block, ```sh or ```run")

    def test_the_words_of_a_command_are_looked_up(self):
        files = {"CMakeLists.txt": "add_executable(tool a.cpp)\n", "tests/fibers/a_test.cpp": "TEST(Mp, IsADensity) {}\nTEST_P(Hair, Furnace) {}\n"}
        block = "# 1 A\n\nText.\n\n```sh\n{}\n```\n"
        for good in ["build/release/tool scenes", "build/release/test_fibers --gtest_filter='Mp.*:*Furnace*'", "cmake --build --preset release --target tool"]:
            self.assert_good({**files, CHAPTER: block.format(good)})
        for bad, what in [("build/release/toll", "CMakeLists.txt makes no toll"), ("cat tests/none.cpp", "there is no file tests/none.cpp"),
                          ("build/release/test_fibers --gtest_filter='Mp.*:Np.*'", "no test is called Np.*"),
                          ("build/release/test_fibers --gtest_filter='Mp.*-*Fournace*'", "no test is called *Fournace*")]:
            self.assert_errors({**files, CHAPTER: block.format(bad)}, f"{CHAPTER}:6: error: {what}")

    def test_the_commands_of_the_manual_are_looked_up(self):
        files = {"CMakeLists.txt": "add_executable(cuticle a.cpp)\n", "src/cli/render.cpp": "app.add_subcommand(\"render\", ...)"}
        self.assert_good({**files, "README.md": "Do:\n\n```sh\nbuild/release/cuticle render a.pbrt\n```\n"})
        self.assert_errors({**files, "README.md": "Do:\n\n```sh\nbuild/release/cuticle rander a.pbrt\n```\n"}, "README.md:4: error: cuticle has no command rander")
        self.assert_errors({**files, "literate_docs/README.md": "Do:\n\n    sh tests/none.sh\n"}, "literate_docs/README.md:3: error: there is no file tests/none.sh")

    def test_a_number_is_tied(self):
        source = {"src/fibers/b.h": "constexpr int kMaxLobes = 16;\n"}
        text = "# 1 A\n\nThey merge at $46.9°$, and at most 16 lobes have five percent in $10^{-3}$ s.\n\n```numbers\n"
        good = ["merge at $46.9°$ == degrees(asin(sqrt((4 - 1.55 ** 2) / 3)))", "at most 16 == src/fibers/b.h: kMaxLobes = (\\d+)",
                "have five percent == 4.6", "$10^{-3}$ s :: the machine of an example"]
        good[1] = good[1].replace("\\\\", "\\")
        with_entries = lambda *entries: {**source, CHAPTER: text + "\n".join(entries) + "\n```\n"}
        file = lambda check: [line for line in check if not line.startswith("src/")]
        status, lines = self.check(with_entries(*good))
        self.assertEqual(file(lines), [])
        for k, number in enumerate(["46.9", "16", "five", "10^{-3}"]):
            status, lines = self.check(with_entries(*(e for i, e in enumerate(good) if i != k)))
            self.assertEqual(file(lines), [f"{CHAPTER}:3: error: the number {number} is tied to nothing: {{{{a value}}}} or a line of ```numbers"])
        for k, bad, what in [(0, "merge at $46.9° == 46.96", "says 46.9; 46.96 is 46.96"), (1, "at most 16 == src/fibers/b.h: kMinLobes = (.)", "has nothing that matches"),
                             (1, "at most 16 == src/fibers/b.h: = 1(.)", "says 16; src/fibers/b.h: = 1(.) is 6"), (2, "has five percent == 5", "no number of the prose stands in the words"),
                             (3, "$10^{-3}$ s == 0.02", "says 10^{-3}; 0.02 is 0.02"), (0, "merge at $46.9° = 4", "a number is tied as")]:
            status, lines = self.check(with_entries(*(bad if i == k else e for i, e in enumerate(good))))
            self.assertTrue(any(what in line for line in file(lines)), (bad, lines))

    def test_numbers_in_words(self):
        for words, value in [("three", 3), ("sixteen", 16), ("twenty-four", 24), ("a hundred thousand", 1e5), ("three million", 3e6), ("eight hundred", 800),
                             ("half a ten-thousandth", 5e-5), ("three millionths", 3e-6), ("1,234.5", 1234.5), ("10^{-7}", 1e-7), ("0x1p-3f", 0.125)]:
            self.assertAlmostEqual(weave.value_of(words) / value, 1, 12, words)
        for number, good, bad in [("0.30", 0.304, 0.306), ("46.9", 46.94, 46.96), ("16", 16, 17), ("five", 4.6, 5.6), ("a hundred", 95, 80), ("10^{-7}", 6e-8, 2e-8)]:
            self.assertTrue(weave.agrees(number, good) and not weave.agrees(number, bad), number)
        found = lambda text: [number for _, _, number in weave.numbers_in_prose(text)]
        self.assertEqual(found("Up to sixteen of a hundred, twenty-four percent, a tenth of two dozen, seven degrees."),
                         ["sixteen", "a hundred", "twenty-four", "a tenth", "seven"])

    def test_numbers_that_need_no_tie(self):
        self.assert_good({CHAPTER: "# 1 A of 77\n\nSee [chapter 12](12-b.md), [7](07-c.md), figure 1.20 and Veach (1997): `12` of $x^{20} / 3$ at 90° is {{a .3g}}.\n\n"
                                   "```run\necho 5\n```\n\n1. First.\n\n## Exercises\n\n1. Take 16 of 20.\n"})

    def test_symbols_and_works_stand_in_the_appendices(self):
        chapters = {f"literate_docs/0{k}-a.md": f"# {k} A\n\n$\\theta_i$ and $x$, by Veach and Guibas (1995).\n" for k in (1, 2, 3)}
        notation, works = "literate_docs/B-notation.md", "literate_docs/C-bibliography.md"
        row, entry = "# B\n\n| a | b |\n| --- | --- |\n| $\\theta_i$ | angle | [1](01-a.md) |\n", "# C\n\n- **Veach and Guibas 1995.** Eric Veach: *Optimally.*\n"
        self.assert_good({**chapters, notation: row, works: entry})
        self.assert_errors({**chapters, notation: row.replace("_i", "_o"), works: entry},
                           "literate_docs/01-a.md:1: error: $\\theta_i$ is used in 3 chapters and has no row in literate_docs/B-notation.md",
                           "literate_docs/B-notation.md:5: error: 01-a.md does not use $\\theta_o$")
        self.assert_errors({**chapters, notation: row, works: entry.replace("1995", "1996")},
                           *(f"literate_docs/0{k}-a.md:3: error: Veach and Guibas (1995 is not in literate_docs/C-bibliography.md" for k in (1, 2, 3)))

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
                          CHAPTER: GOOD_CHAPTER + "\n```run\n⟨Nothing⟩\n⟨\n```\n\nWrite `⟨Name⟩` or ``⟨`Name⟩``.\n"})

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
                       "Text.\n\n```run\ncode\n```\n\n", "Text.\n\n| a | b |\n", "Text.\n\n---\n", "# Heading\n\n$$x$$\n\n",
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
