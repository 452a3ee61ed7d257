#!/usr/bin/env python3
"""Check that the book and the literate sources tell one story. Needs Python 3 and nothing else.

In a literate source, `//> Name of the step, with $math$` opens a chunk and `//<` closes the one opened last (in Python
`#>` and `#<`). Chunks nest. A name opened again in the same file continues that chunk: it then has several pieces.
Every line of a literate file lies inside a chunk.

In a chapter (literate_docs/NN-name.md, in an appendix A-name.md) a line that holds only ⟨Name⟩ shows the next piece of that name that no line
before it has shown, reading the chapters in the order of their names. Inside a sentence, ⟨Name⟩ is a link. A name may
be broken over two lines there. Where several files have a chunk of one name, the file is named too, by as much of
the end of its path as tells it from the others: ⟨path.h: Name⟩. The file may always be named. Text between ` or
``` marks is not read.

A number in prose is made when the book is built ({{name}}, see book.py) or stands in a block of its chapter that says
where it comes from. The block is not shown; each of its lines begins with words of the prose that hold the number:
  ```numbers
  merge at 46.9° == degrees(asin(sqrt((4 - 1.55 ** 2) / 3)))   computed, and compared with the digits that are printed
  At most 16 lobes == src/fibers/a.h: kMaxLobes = (\d+)         found in a file of the project by a regular expression
  index of 1.55 :: Marschner 2003, table 1                     given: by a source, by definition, as an example
  ```
Not counted are whole numbers in formulas (but for angles, percentages and those over 99), 0 and 1, right, straight and
full angles, numbers of chapters, figures and the like, years, what exercises ask, and the bibliography.

What --check finds wrong it prints as `file:line: error: ...`, and then exits with status 1:
  in a source: a chunk never closed, a close without an open, a mark without a name, a chunk inside itself, a line
      outside all chunks, a piece that no chapter shows;
  in a chapter: a name that no literate file has, or that several have, a listing with no prose before it (a displayed
      formula may stand between the two, a heading or another listing may not), a listing once too often;
      a block that is neither run nor checked (run, values, figure, chart, numbers; the commands of a `sh` block name
      files and targets that exist); a pattern of tests that matches none; a number that is tied to nothing, or wrong;
      a symbol of three chapters that the appendix of notation lacks, a cited work that the bibliography lacks.
"""

import argparse
import fnmatch
import math
import re
import sys
from pathlib import Path

# The literate sources. A file that one of these patterns names must be shown, whole, in some chapter.
LITERATE = [
    "src/fibers/**/*",
    "src/shapes/curve.*",
    "src/shapes/curve_capsule.*",
    "src/shapes/curve_list.*",
    "src/shapes/curve_set*",
    "src/shapes/curve_tree.*",
    "src/core/fit_special.py",
    "src/core/lanes.h",
    "src/core/special.h",
    "src/core/sampling.*",
    "src/core/quadrature.*",
    "src/materials/hair_material.*",
    "src/render/path.*",
    "src/render/hair_light.*",
    "src/render/direct_light.*",
    "src/render/dual_scattering.*",
    "src/render/fiber_albedo.*",
    "src/render/light_pilot.*",
    "src/render/denoise.*",
    "src/render/guides.*",
    "src/render/integrator.*",
    "src/images/compare.*",
    "src/images/flip.*",
    "src/images/planes.*",
    "src/volume/**/*",
    "src/dynamics/rod*",
    "src/dynamics/strand.*",
    "src/dynamics/obstacle.*",
    "src/dynamics/key_hairs.*",
    "src/dynamics/simulation.*",
    "src/dynamics/velocity_grid.*",
    "src/dynamics/springs.*",
    "src/dynamics/directing.*",
    "src/dynamics/crossings.*",
    "src/grooms/groom_params.*",
    "src/grooms/head_*",
    "src/grooms/lock_source.*",
    "src/grooms/procedural.*",
    "src/grooms/scalp.*",
]
CHAPTERS = "literate_docs/[0-9A-Z]*-*.md"  # numbered chapters, then appendices by letter

OPEN = re.compile(r"\s*(?://|#)>(.*)")
CLOSE = re.compile(r"\s*(?://|#)<(.*)")
REFERENCE = re.compile(r"⟨([^⟨⟩]*)⟩")
WITH_FILE = re.compile(r"([\w./-]+\.\w+):\s+(.*)")


class Piece:
    """One stretch of a source between //> and //<."""

    def __init__(self, file, line, name, parent=None):
        self.file, self.line, self.name, self.parent = file, line, name, parent
        self.shown = None  # (chapter, line) of its listing
        self.body = []  # of what is shown: (line number, text), and the pieces inside


class Check:
    def __init__(self, root):
        self.root = root
        self.errors = []  # (file, line, message)
        self.chunks = {}  # name -> {file: [Piece, in the order of the source]}
        self.listings = {}  # (chapter, line) -> the Piece shown there

    def error(self, file, line, message):
        self.errors.append((file, line, message))

    # --- sources ---------------------------------------------------------------------------------------------------
    def read_source(self, file):
        open_pieces = []
        was_outside = False  # so that a run of lines outside is reported once
        for number, line in enumerate((self.root / file).read_text(encoding="utf-8").splitlines(), 1):
            opens, closes = OPEN.fullmatch(line), CLOSE.fullmatch(line)
            outside = False
            if opens:
                name = " ".join(opens[1].split())
                if not name or not opens[1].startswith(" "):
                    self.error(file, number, "a chunk opens with '//> Name of the step': a space and a name")
                if any(piece.name == name for piece in open_pieces):
                    self.error(file, number, f"chunk ⟨{name}⟩ is opened inside itself")
                piece = Piece(file, number, name, open_pieces[-1] if open_pieces else None)
                if open_pieces:
                    open_pieces[-1].body.append(piece)
                open_pieces.append(piece)
                self.chunks.setdefault(name, {}).setdefault(file, []).append(piece)
            elif closes:
                if closes[1].strip():
                    self.error(file, number, "'//<' stands alone on its line")
                if open_pieces:
                    open_pieces.pop()
                else:
                    self.error(file, number, "'//<' closes a chunk, but none is open")
            elif open_pieces:
                open_pieces[-1].body.append((number, line))
            else:
                outside = True
                if not was_outside:
                    self.error(file, number, "this line lies outside all chunks")
            was_outside = outside
        for piece in open_pieces:
            self.error(file, piece.line, f"chunk ⟨{piece.name}⟩ is never closed")

    # --- chapters --------------------------------------------------------------------------------------------------
    def find(self, chapter, line, reference):
        """The pieces that ⟨reference⟩ means, or None after an error."""
        name = " ".join(reference.split())
        files = self.chunks.get(name)
        if files is None and (match := WITH_FILE.fullmatch(name)):
            ending, name = match[1], match[2]
            files = {file: pieces for file, pieces in self.chunks.get(name, {}).items()
                     if file == ending or file.endswith("/" + ending)}
        if not files:
            self.error(chapter, line, f"unknown chunk ⟨{' '.join(reference.split())}⟩")
            return None
        if len(files) > 1:
            self.error(chapter, line, f"chunk ⟨{name}⟩ is in several files: say which, as in "
                       + " or ".join(f"⟨{Path(file).name}: {name}⟩" for file in sorted(files)))
            return None
        return next(iter(files.values()))

    def read_chapter(self, chapter):
        lines = mask_code((self.root / chapter).read_text(encoding="utf-8")).split("\n")
        kinds = [kind_of(line) for line in lines]
        mark_formulas(lines, kinds)
        text = "\n".join(lines)
        for match in REFERENCE.finditer(text):
            number = text.count("\n", 0, match.start()) + 1
            pieces = self.find(chapter, number, match[1])
            if kinds[number - 1] == "listing":
                if not has_prose_before(kinds, number - 1):
                    self.error(chapter, number, f"unexplained chunk {match[0]}: no prose stands before it")
                if pieces:
                    self.show(chapter, number, pieces)
        for match in re.finditer("[⟨⟩]", REFERENCE.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), text)):
            self.error(chapter, text.count("\n", 0, match.start()) + 1, f"'{match[0]}' has no partner")

    def show(self, chapter, line, pieces):
        for piece in pieces:
            if piece.shown is None:
                piece.shown = (chapter, line)
                self.listings[piece.shown] = piece
                return
        where = "{}:{}".format(*pieces[-1].shown)
        self.error(chapter, line, f"chunk ⟨{pieces[0].name}⟩ is shown twice; the last of it was shown at {where}")

    # --- blocks ----------------------------------------------------------------------------------------------------
    def read_blocks(self, chapter):
        """Every block of code is one that book.py runs, or `sh`, whose words are looked up here."""
        kind = None
        for number, line in enumerate((self.root / chapter).read_text(encoding="utf-8").split("\n"), 1):
            if mark := re.match(r"\s*(?:```|~~~)\s*(\S*)", line):
                kind = None if kind is not None else mark[1]
                if kind is not None and kind not in ("run", "values", "figure", "chart", "numbers", "sh"):
                    self.error(chapter, number, f"a block `{kind}` is neither run nor checked: run, values, figure, chart, numbers or sh")
            elif kind is None and re.match(r"    +[\w./$]", line) and re.search(r"\n\n$", self.before(chapter, number)):
                self.error(chapter, number, "indented code is neither run nor checked: write a block, ```sh or ```run")
            elif kind in ("run", "values", "sh"):
                self.read_command(chapter, number, line)

    def read_manual(self, file):
        """Of a file that is not woven, the words of the commands in its blocks are looked up."""
        inside = False
        for number, line in enumerate((self.root / file).read_text(encoding="utf-8").split("\n"), 1):
            if line.lstrip().startswith("```"):
                inside = not inside
            elif inside or line.startswith("    "):
                self.read_command(file, number, line)

    def before(self, chapter, number):
        return "\n".join((self.root / chapter).read_text(encoding="utf-8").split("\n")[:number - 1]) + "\n"

    def read_command(self, chapter, number, line):
        for path in re.findall(r"(?<![\w/.-])(?:src|tests|scenes|literate_docs|reference_images|\.ci)/[\w./-]*\w", line):
            if not (self.root / path).exists():
                self.error(chapter, number, f"there is no file {path}")
        for target in re.findall(r"--target (\w+)|build/release/(\w+)", line):
            target = target[0] or target[1]
            if target not in self.targets():
                self.error(chapter, number, f"CMakeLists.txt makes no {target}")
        for command in re.findall(r"build/release/cuticle ([a-z]\w+)", line):
            if not any(f'"{command}"' in path.read_text(encoding="utf-8") for path in self.root.glob("src/cli/*.cpp")):
                self.error(chapter, number, f"cuticle has no command {command}")
        for patterns in re.findall(r"--gtest_filter='?([^'\s]+)", line):
            for pattern in filter(None, re.split("[:-]", patterns)):
                if not any(fnmatch.fnmatchcase(name, pattern) for name in self.tests()):
                    self.error(chapter, number, f"no test is called {pattern}")

    def targets(self):
        """Programs and targets of CMakeLists.txt; tests and benchmarks have the names of their folder and file."""
        if not hasattr(self, "targets_"):
            file = self.root / "CMakeLists.txt"
            text = file.read_text(encoding="utf-8") if file.exists() else ""
            self.targets_ = {"bash", *re.findall(r"add_(?:executable|custom_target|library)\((\w+)", text)}
            self.targets_ |= {f"test_{path.name}" for path in self.root.glob("tests/*") if path.is_dir()}
            self.targets_ |= {f"bench_{path.name[:-10]}" for path in self.root.glob("tests/bench/*_bench.cpp")}
        return self.targets_

    def tests(self):
        """Names of all tests as --gtest_filter sees them; a parameter or a type is written 0."""
        if not hasattr(self, "tests_"):
            self.tests_, suites, prefixes = set(), [], {}
            for path in [*self.root.glob("tests/**/*_test.cpp"), *self.root.glob("tests/**/*.h")]:
                text = path.read_text(encoding="utf-8")
                suites += re.findall(r"\b(TEST|TEST_F|TEST_P|TYPED_TEST)\(\s*(\w+),\s*(\w+)\s*\)", text)
                for prefix, suite in re.findall(r"INSTANTIATE_TEST_SUITE_P\(\s*(\w+),\s*(\w+)", text):
                    prefixes.setdefault(suite, []).append(prefix)
            for kind, suite, name in suites:
                if kind == "TEST_P":
                    self.tests_ |= {f"{prefix}/{suite}.{name}/0" for prefix in prefixes.get(suite, ["Some"])}
                else:
                    self.tests_.add(f"{suite}/0.{name}" if kind == "TYPED_TEST" else f"{suite}.{name}")
        return self.tests_

    # --- numbers ---------------------------------------------------------------------------------------------------
    def read_numbers(self, chapter):
        text = (self.root / chapter).read_text(encoding="utf-8")
        found = numbers_in_prose(text)  # (offset, end, number)
        tied = set()
        for block in re.finditer(r"^```numbers\n(.*?)^```", text, re.M | re.S):
            line = text.count("\n", 0, block.start()) + 1
            for i, entry in enumerate(block[1].splitlines(), 1):
                if entry.strip():
                    tied |= self.tie(chapter, line + i, entry, text, found)
        for offset, end, number in found:
            if (offset, end) not in tied:
                self.error(chapter, text.count("\n", 0, offset) + 1, f"the number {' '.join(number.split())} is tied to nothing: {{{{a value}}}} or a line of ```numbers")

    def tie(self, chapter, line, entry, text, found):
        """Reads one line of a block `numbers`; returns the places of the numbers that it covers."""
        match = re.fullmatch(r"\s*(.+?)\s+(==|::)\s+(.+?)\s*", entry)
        if not match:
            self.error(chapter, line, "a number is tied as: words with the number == expression or file: pattern, or :: where it is from")
            return set()
        words, sign, origin = match.groups()
        pattern = re.compile(r"\s+".join(map(re.escape, words.split())))
        prose = blank_blocks(text)
        places = {(offset, end): number for m in pattern.finditer(prose) for offset, end, number in found if m.start() <= offset and end <= m.end()}
        if not places:
            self.error(chapter, line, f"no number of the prose stands in the words \"{words}\"")
        elif sign == "==":
            value = self.origin(chapter, line, origin)
            for number in sorted(set(places.values())) if value is not None else []:
                if not agrees(number, value):
                    self.error(chapter, line, f"\"{words}\" says {number}; {origin} is {value:.6g}")
        return set(places)

    def origin(self, chapter, line, origin):
        """The number that an expression has, or that a pattern finds in a file; None after an error."""
        file = re.match(r"([\w./-]+\.\w+):\s+(.+)", origin)
        try:
            if not file:
                return float(eval(origin, {"__builtins__": {}}, NAMES))  # the author's own arithmetic
            match = re.search(file[2], (self.root / file[1]).read_text(encoding="utf-8"))
            return value_of(match[1])
        except TypeError:
            self.error(chapter, line, f"{file[1] if file else origin} has nothing that matches {file[2] if file else ''}")
        except Exception as error:  # whatever the author's expression can raise
            self.error(chapter, line, f"{origin}: {error}")
        return None

    # --- appendices ------------------------------------------------------------------------------------------------
    def read_appendices(self):
        """Symbols of the chapters stand in the appendix "notation", works that are cited in the "bibliography"."""
        chapters = {path.relative_to(self.root).as_posix(): path.read_text(encoding="utf-8") for path in sorted(self.root.glob(CHAPTERS))}
        notation = next((name for name in chapters if "notation" in name), None)
        if notation:
            self.read_symbols(notation, {name: text for name, text in chapters.items() if not re.search("notation|bibliography", name)}, chapters[notation])
        bibliography = next((name for name in chapters if "bibliography" in name), None)
        if bibliography:
            works = [(set(re.findall(r"[\w'’]+", m[1] + " " + m[3])), m[2])
                     for m in re.finditer(r"\*\*([^*]*?) (\d{4})\.\*\*([^*]*)", chapters[bibliography])]
            texts = {name: blank_blocks(text) for name, text in chapters.items() if name != bibliography}
            for files in self.chunks.values():
                for file, pieces in files.items():
                    texts.setdefault(file, "\n".join(re.sub(r"^(?!\s*(?://|#)).*|^\s*(?://|#)", "", line)
                                                     for line in (self.root / file).read_text(encoding="utf-8").split("\n")))
            for name, text in sorted(texts.items()):
                for match in CITATION.finditer(text):
                    names = set(re.findall(r"(?:d')?[A-Z][\w'’]+", match[1])) - {"In", "Since", "From", "Until", "Appendix", "SIGGRAPH"}
                    if names and not any(year == match[2] and names & of for of, year in works):
                        self.error(name, text.count("\n", 0, match.start()) + 1, f"{' '.join(match[0].split())} is not in {bibliography}")

    def read_symbols(self, notation, chapters, table):
        """Greek letters and capitals that three chapters use have a row; a row's chapters use its symbol."""
        used = {name: symbols_of(text) for name, text in chapters.items()}
        rows = [(symbols_of(row.split("|")[1]), row) for row in table.split("\n") if row.startswith("| $")]
        known = set().union(*(symbols for symbols, _ in rows))
        for symbol in sorted(set().union(*used.values())):
            where = [name for name in used if symbol in used[name]]
            if len(where) >= 3 and symbol not in known and not re.match("[a-z]", symbol):
                self.error(where[0], 1, f"${symbol}$ is used in {len(where)} chapters and has no row in {notation}")
        for symbols, row in rows:
            for chapter in re.findall(r"\]\(((?:\d\d|[A-Z])-[\w-]+\.md)\)", row):
                name = next((n for n in used if n.endswith("/" + chapter)), None)
                if name and not symbols & used[name]:
                    self.error(notation, table[:table.index(row)].count("\n") + 1, f"{chapter} does not use {row.split('|')[1].strip()}")

    # --- all -------------------------------------------------------------------------------------------------------
    def run(self):
        sources = {path for pattern in LITERATE for path in self.root.glob(pattern) if path.is_file()}
        for path in sorted(sources):
            self.read_source(path.relative_to(self.root).as_posix())
        for path in sorted(self.root.glob(CHAPTERS)):
            self.read_chapter(path.relative_to(self.root).as_posix())
            self.read_blocks(path.relative_to(self.root).as_posix())
            if "bibliography" not in path.name:
                self.read_numbers(path.relative_to(self.root).as_posix())
        for manual in ("README.md", "literate_docs/README.md"):
            if (self.root / manual).exists():
                self.read_manual(manual)
        self.read_appendices()
        for files in self.chunks.values():
            for file, pieces in files.items():
                for i, piece in enumerate(pieces, 1):
                    if piece.shown is None:
                        which = f"piece {i} of {len(pieces)} of " if len(pieces) > 1 else ""
                        self.error(file, piece.line, f"unused chunk: {which}⟨{piece.name}⟩ is shown in no chapter")
        return sorted(self.errors)


def mask_code(text):
    """The text without code: words between ` become x, lines between ``` become ```."""
    lines, fence = [], None
    for line in text.split("\n"):
        mark = re.match(r"\s*(```+|~~~+)", line)
        if fence is None and mark:
            fence = mark[1]
            lines.append("```")
        elif fence is not None:
            lines.append("```")
            if mark and mark[1].startswith(fence):
                fence = None
        else:
            lines.append(re.sub(r"(`+)(?!`).*?(?<!`)\1(?!`)", lambda m: "x" * len(m[0]), line))
    return "\n".join(lines)


CITATION = re.compile(r"((?:d')?\b[A-Z][\w'’]+(?:(?:,\s|\sand\s)(?:d')?(?:[A-Z][\w’']+|others|colleagues)|\set\sal\.)*),?\s\(?((?:19|20)\d\d)\b")
GREEK = "alpha|beta|gamma|delta|epsilon|eta|theta|phi|psi|sigma|tau|omega|mu|kappa|lambda|Lambda|Phi|Delta|chi|rho"


def symbols_of(text):
    """The letters of all formulas, with their indices: \\theta_i, \\eta', A_p (also for A_0), h."""
    found = set()
    for formula in re.finditer(r"\$\$(.+?)\$\$|\$([^$]+?)\$", blank_blocks(text), re.S):
        plain = re.sub(r"\\(?:text|operatorname|mathrm|mathbf|mathbb|begin|end)\s*\{[^}]*\}", " ", formula[1] or formula[2])
        for m in re.finditer(rf"(\\(?:{GREEK})(?![a-zA-Z])|(?<![a-zA-Z\\])[A-Za-z](?![a-zA-Z]))('*)(\^\*)?(_(?:\{{[^}}]*\}}|\\?\w+))?", plain):
            index = re.sub(r"[{}]", "", m[4] or "")
            found.add(m[1] + m[2] + (m[3] or "") + ("_p" if re.fullmatch(r"_\d|_k", index) and m[1] in "AMN" else "" if re.fullmatch(r"_\d", index) and m[1] != "I" else index))
    return found


NAMES = {name: getattr(math, name) for name in dir(math) if not name.startswith("_")} | {"abs": abs, "max": max, "min": min, "sum": sum, "range": range}
UNITS = {word: value for value, word in enumerate("zero one two three four five six seven eight nine ten eleven twelve".split())} | {
    "a": 1, "half a": 0.5}
TEENS = {word: value for value, word in enumerate("thirteen fourteen fifteen sixteen seventeen eighteen nineteen".split(), 13)}
TENS = {word: 10 * value for value, word in enumerate("twenty thirty forty fifty sixty seventy eighty ninety".split(), 2)}
GREAT = {"hundred": 100, "thousand": 1000, "million": 1e6}
PARTS = {"tenth": 0.1, "twentieth": 0.05, "hundredth": 0.01, "thousandth": 1e-3, "ten-thousandth": 1e-4, "millionth": 1e-6}
ANY = {**UNITS, **TEENS, **TENS}


def one_of(words):
    return "(?:" + "|".join(sorted(map(re.escape, words), key=len, reverse=True)).replace("\\ ", r"\s+") + ")"


# In figures; powers of ten; and words: a count from thirteen on, hundreds, fractions from a tenth on, and percent or degrees
NUMBER = re.compile(
    r"\b10\^\{?-?\d+\}?|(?<![\w.^{-])\d+(?:,\d{3})*(?:\.\d+)?(?![\w]*\.?\w*[`_])|(?i:\b(?:"
    + rf"{one_of(ANY)}(?:\s+{one_of(GREAT)})+|{one_of(UNITS)}\s+{one_of(PARTS)}s?|{one_of(TEENS)}|{one_of(TENS)}(?:-{one_of(UNITS)})?"
    + rf"|{one_of(set(ANY) - {'a', 'half a'})}(?=\s+(?:percent|degrees?)\b))\b)")


def value_of(number):
    """3, 3.5, 10^{-7}, 50,000, "five", "twenty-four", "a hundred thousand", "three millionths", 1e-6f, 0x1p-20."""
    number = " ".join(number.strip().lower().split())
    if power := re.fullmatch(r"10\^\{?(-?\d+)\}?", number):
        return 10.0 ** int(power[1])
    if re.match("[a-z]", number):
        value = 0.5 if number.startswith("half a ") else 1.0
        for word in number.removeprefix("half a ").split():
            tens, _, units = word.partition("-")
            value *= PARTS.get(word.rstrip("s"), 0) or GREAT.get(word, 0) or ANY.get(word, 0) or TENS[tens] + UNITS[units]
        return value
    number = number.replace(",", "").replace("'", "")
    return float.fromhex(number.rstrip("fl")) if number.startswith("0x") else float(number.rstrip("flu"))


def agrees(number, value):
    """Whether a printed number is the value to its last digit; a power of ten, to the nearest; in words, to a tenth."""
    if number.startswith("10^"):
        return value > 0 and round(math.log10(value)) == round(math.log10(value_of(number)))
    if number[0].isalpha():
        return abs(value_of(number) - value) <= max(0.1 * value_of(number), 1e-12) or round(value) == value_of(number)
    digits = len(number.partition(".")[2])
    return abs(value_of(number) - value) <= 0.5001 * 10.0 ** -digits


def blank(match):
    return re.sub(r"[^\n]", " ", match[0])


def blank_blocks(text):
    return re.sub(r"^```.*?^```", blank, text, flags=re.M | re.S)


def numbers_in_prose(text):
    """(start, end, number) of all numbers that must come from somewhere."""
    prose = blank_blocks(text)
    prose = re.sub(r"^## Exercises\n(?:.*\n?)*?(?=^## |\Z)", blank, prose, flags=re.M) if "**1.1" not in prose else prose
    prose = re.sub(r"^#.*|<!--.*?-->", blank, prose, flags=re.M)
    prose = re.sub(r"`[^`\n]*`|\{\{[^{}]*\}\}|⟨[^⟨⟩]*⟩|\[\d+\]\([^)]*\)|\]\([^)]*\)|\\tag\{[^}]*\}", blank, prose)
    prose = re.sub(r"\$\$(.+?)\$\$|\$([^$]+?)\$", whole_numbers_of_formula, prose, flags=re.S)
    prose = re.sub(r"^(?:\*\*[\d.]+\*\*|\d+\.) |^\| \d+ \|", blank, prose, flags=re.M)
    named = r"chapters?|figures?|tables?|equations?|sections?|exercises?|appendix|algorithm|Pharr|Debian|Ubuntu|C\+\+|Rec\.|CIE"
    prose = re.sub(rf"(?i:\b(?:{named}))\s+\[?\(?\d+(?:[.-]\d+)*\w?\b(?:(?:,| and| to)\s+\d+(?:\.\d+)*\b)*|\((?:\d+\.\d)\)", blank, prose)
    prose = re.sub(r"\b(?:19|20)\d\d\b", blank, prose)
    plain = lambda m: m[0] in ("0", "1") or m[0] in ("90", "180", "360") and text[m.end()] == "°"
    return [(m.start(), m.end(), m[0]) for m in NUMBER.finditer(prose) if not plain(m)]


def whole_numbers_of_formula(match):
    """A formula of which only decimals, angles, percentages, powers of ten and numbers over 99 are left."""
    text = match[0]
    kept = {i for m in re.finditer(r"\d+\.\d+|10\^\{?-?\d+\}?|\d+(?=°|\\%|\^\\circ)|\d{3,}", text) for i in range(*m.span())}
    return "".join(c if i in kept or c == "\n" else " " for i, c in enumerate(text))


def kind_of(line):
    line = line.strip()
    if not line:
        return "blank"
    if REFERENCE.fullmatch(line):
        return "listing"
    if line.startswith(("#", "```", "|", "![", "<!--", "---")) or not re.search(r"[^\W\d_]", line):
        return "other"
    return "prose"


def mark_formulas(lines, kinds):
    """Lines of a displayed formula, $$ ... $$, become of the kind "formula"."""
    inside = False
    for i, line in enumerate(lines):
        if inside or line.strip().startswith("$$"):
            kinds[i] = "formula"
        if line.count("$$") % 2 == 1:
            inside = not inside


def has_prose_before(kinds, i):
    i -= 1
    while i >= 0 and kinds[i] in ("blank", "formula"):
        i -= 1
    return i >= 0 and kinds[i] == "prose"


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Check that the book shows and explains every literate line.")
    parser.add_argument("--check", action="store_true", required=True, help="print every error; status 1 if there is one")
    parser.add_argument("--root", type=Path, default=Path(__file__).resolve().parent.parent,
                        help="folder that holds src/ and literate_docs/ (default: of this repository)")
    options = parser.parse_args(arguments)
    errors = Check(options.root).run()
    for file, line, message in errors:
        print(f"{file}:{line}: error: {message}")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
