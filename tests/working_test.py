#!/usr/bin/env python3
"""The appendix "Working on Cuticle" names places that exist, and what it says of them stands there.

In its tables the first cell of a row is a room or a file, as `path`; where the second cell begins with words between
backticks and a colon, they must occur in that file. Paths of its commands must exist as well.
"""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
APPENDIX = ROOT / "literate_docs" / "D-working-on-cuticle.md"


def wrong(text, root):
    """What does not hold, as a list of messages."""
    messages, rows = [], 0
    rooms = {p.name for p in (root / "src").iterdir() if p.is_dir()}
    told = set()
    for number, line in enumerate(text.splitlines(), 1):
        cells = [cell.strip() for cell in line.split("|")[1:-1]]
        if len(cells) == 2 and (place := re.fullmatch("`([^`]+)`", cells[0])):
            rows += 1
            if "/" not in place[1]:
                told.add(place[1])
                continue
            path = root / place[1]
            if not path.is_file():
                messages.append(f"{number}: there is no file {place[1]}")
            elif (words := re.match("`([^`]+)`:", cells[1])) and words[1] not in path.read_text():
                messages.append(f"{number}: {place[1]} does not say \"{words[1]}\"")
        for path in re.findall(r"`?\b((?:src|tests|literate_docs)/[\w./-]+\.\w+)", line):
            if not (root / path).exists():
                messages.append(f"{number}: there is no file {path}")
    messages += [f"the room {room} is not told of" for room in sorted(rooms - told)]
    messages += [f"there is no room {room}" for room in sorted(told - rooms)]
    if rows < 20:
        messages.append(f"only {rows} rows of tables were read")
    return messages


class Appendix(unittest.TestCase):
    def test_every_place_is_there(self):
        self.assertEqual(wrong(APPENDIX.read_text(), ROOT), [])

    def test_a_wrong_place_is_found(self):
        text = APPENDIX.read_text()
        for old, new in [("src/fibers/models.cpp", "src/fibers/modells.cpp"), ("`To add a light`", "`To add a lamp`"),
                         ("| `shapes` |", "| `forms` |")]:
            self.assertIn(old, text)
            self.assertNotEqual(wrong(text.replace(old, new), ROOT), [], old)


if __name__ == "__main__":
    unittest.main()
