#!/usr/bin/env python3
"""Check that the book and the literate sources tell one story. Needs Python 3 and nothing else.

In a literate source, `//> Name of the step, with $math$` opens a chunk and `//<` closes the one opened last (in Python
`#>` and `#<`). Chunks nest. A name opened again in the same file continues that chunk: it then has several pieces. Every line of a literate
file lies inside a chunk.

In a chapter (literate_docs/NN-name.md) a line that holds only ⟨Name⟩ shows the next piece of that name that no line
before it has shown, reading the chapters in the order of their names. Inside a sentence, ⟨Name⟩ is a link. A name may
be broken over two lines there. Where several files have a chunk of one name, the file is named too, by as much of
the end of its path as tells it from the others: ⟨path.h: Name⟩. The file may always be named. Text between ` or
``` marks is not read.

What --check finds wrong it prints as `file:line: error: ...`, and then exits with status 1:
  in a source: a chunk never closed, a close without an open, a mark without a name, a chunk inside itself, a line
      outside all chunks, a piece that no chapter shows;
  in a chapter: a name that no literate file has, or that several have, a listing with no prose before it (a displayed
      formula may stand between the two, a heading or another listing may not), a listing once too often.
"""

import argparse
import re
import sys
from pathlib import Path

# The literate sources. A file that one of these patterns names must be shown, whole, in some chapter.
LITERATE = [
    "src/fibers/**/*",
    "src/shapes/curve.*",
    "src/shapes/curve_capsule.*",
    "src/shapes/curve_set*",
    "src/shapes/curve_tree.*",
    "src/core/fit_special.py",
    "src/core/lanes.h",
    "src/core/special.h",
    "src/core/sampling.*",
    "src/core/quadrature.*",
    "src/materials/hair_material.*",
    "src/render/path.*",
    "src/render/integrator.*",
    "src/images/compare.*",
    "src/images/flip.*",
    "src/images/planes.*",
]
CHAPTERS = "literate_docs/[0-9][0-9]-*.md"

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

    # --- all -------------------------------------------------------------------------------------------------------
    def run(self):
        sources = {path for pattern in LITERATE for path in self.root.glob(pattern) if path.is_file()}
        for path in sorted(sources):
            self.read_source(path.relative_to(self.root).as_posix())
        for path in sorted(self.root.glob(CHAPTERS)):
            self.read_chapter(path.relative_to(self.root).as_posix())
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
