#!/usr/bin/env python3
"""Checks the house: which room may include which, and the format of every source file.

house_check.py includes   file:line: error for an #include against the direction of the design
house_check.py format     file: error for a file that clang-format would change
"""
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
# room: the rooms it may include besides itself
ROOMS = {
    "core": set(),
    "images": {"core"},
    "fibers": {"core"},
    "shapes": {"core"},
    "grooms": {"core"},
    "parser": {"core", "shapes"},
    "materials": {"core", "images", "fibers", "shapes", "parser"},
    "scene": {"core", "images", "fibers", "shapes", "grooms", "parser", "materials"},
    "render": {"core", "images", "fibers", "shapes", "grooms", "parser", "materials", "scene"},
    "figures": {"core", "images", "fibers", "shapes", "grooms", "parser", "materials", "scene", "render"},
    "cli": {"core", "images", "fibers", "shapes", "grooms", "parser", "materials", "scene", "render", "figures"},
}


def sources(*folders):
    for folder in folders:
        yield from sorted(p for p in (ROOT / folder).rglob("*") if p.suffix in {".h", ".cpp"})


def check_includes():
    errors = []
    for path in sources("src"):
        room = path.relative_to(ROOT / "src").parts[0]
        if room not in ROOMS:
            errors.append(f"{path.relative_to(ROOT)}: error: src/{room} is no room of the house")
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            match = re.match(r'\s*#\s*include\s+"([^"]+)"', line)
            if not match:
                continue
            target = match.group(1).split("/")[0]
            if "/" not in match.group(1):
                errors.append(f'{path.relative_to(ROOT)}:{number}: error: include "{match.group(1)}" by its room')
            elif target != room and target not in ROOMS[room]:
                errors.append(f"{path.relative_to(ROOT)}:{number}: error: {room} must not include {target}")
    return errors


def check_format():
    program = shutil.which("clang-format") or shutil.which("clang-format-14")
    if not program:
        return ["clang-format is not installed: error: .ci/setup installs it"]
    errors = []
    files = [str(p) for p in sources("src", "tests")]
    for start in range(0, len(files), 40):
        run = subprocess.run([program, "--dry-run", "-Werror", *files[start : start + 40]], capture_output=True, text=True)
        errors += [line for line in run.stderr.splitlines() if "error:" in line]
    return errors


def main():
    checks = {"includes": check_includes, "format": check_format}
    if len(sys.argv) != 2 or sys.argv[1] not in checks:
        sys.exit(__doc__)
    errors = checks[sys.argv[1]]()
    print("\n".join(errors[:50]))
    print(f"{sys.argv[1]}: {len(errors)} errors")
    sys.exit(1 if errors else 0)


main()
