#!/usr/bin/env python3
"""Make a page of every figure that can be made: gallery.py PROGRAM --out DIR [--quality draft|paper] [--pictures DIR] [ID ...]

Each figure stands beside its caption, its claims with tick or cross and the numbers that they were measured by, its table,
and what it took; the pictures and the scenes of a rendered figure are linked. A figure that is in DIR already is not made
again: the page can be interrupted and goes on.
"""
import argparse
import html
import pathlib
import re
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
STYLE = """body { font: 16px/1.5 sans-serif; max-width: 80rem; margin: 2rem auto; padding: 0 1rem; }
section { display: grid; grid-template-columns: minmax(20rem, 3fr) 2fr; gap: 2rem; border-top: 1px solid #ccc; padding: 1.5rem 0; }
h2, header, details { grid-column: 1 / -1; margin: 0; } img { max-width: 100%; } .videos { grid-column: 1 / -1; } .videos figure { display: inline-block; width: 15rem; margin: .5rem; vertical-align: top; } li { list-style: none; } ul { padding: 0; }
.broken { color: #b00; } table { font-size: 13px; border-collapse: collapse; } td, th { padding: 0 .6em; text-align: right; }
@media (max-width: 50rem) { section { grid-template-columns: 1fr; } }"""


def figures(program):
    """id, kind, caption, names of scenes of each figure that is made."""
    rows = []
    for line in subprocess.run([program, "figure", "--list"], capture_output=True, text=True, check=True).stdout.splitlines():
        m = re.match(r"(\S+) +(\S+) +made +(.*)", line)
        if m:
            rows.append([m[1], m[2], m[3], []])
        elif "scenes: " in line and rows:
            rows[-1][3] = line.split("scenes: ")[1].split()
    return rows


def plain(caption):
    """A caption in gnuplot's notation, for HTML."""
    text = html.escape(caption)
    text = re.sub(r"_\{([^{}]*)\}|_(\w)", lambda m: f"<sub>{m[1] or m[2]}</sub>", text)
    return re.sub(r"\^\{([^{}]*)\}|\^(\w)", lambda m: f"<sup>{m[1] or m[2]}</sup>", text)


def claims(said):
    """The laws that the program printed, as list items."""
    items = []
    for state, law in re.findall(r"^  (holds: |BROKEN:) (.*)$", said, re.M):
        good = state.startswith("holds")
        items.append(f'<li class="{"holds" if good else "broken"}">{"✓" if good else "✗"} {html.escape(law)}</li>')
    return "<ul>" + "".join(items) + "</ul>"


def table(file):
    lines = file.read_text().splitlines()[:60]
    rows = ["<tr>" + "".join(f"<td>{html.escape(cell.strip(chr(34)))}</td>" for cell in line.split(",")) + "</tr>" for line in lines]
    return "<table>" + "".join(rows) + "</table>"


def section(out, row, said):
    name, kind, caption, scenes = row
    text = "".join(f'<p><a href="{s}.exr">{s}.exr</a>, <a href="{ROOT.as_uri()}/scenes/{s}.pbrt">its scene</a></p>' for s in scenes)
    seconds = re.search(r"^seconds (.*)$", said, re.M)
    return (f'<section id="{name}"><h2>{name}</h2><div><a href="{name}.png"><img src="{name}.png" alt="{name}"></a></div>'
            f"<div><p>{plain(caption)}</p>{claims(said)}<p>{kind}, {seconds[1]} s on the wall</p>{text}</div>"
            f'<details><summary>Numbers (<a href="{name}.csv">CSV</a>)</summary>{table(out / f"{name}.csv")}</details></section>')


def videos(out):
    """The videos that the target of that name made and that were looked at."""
    shown = ""
    for file in sorted((ROOT / "reference_images/videos").glob("*.mp4")):
        for name in (file, file.with_suffix(".jpg")):
            shutil.copy(name, out / name.name)
        scene = ROOT / f"scenes/videos/{file.stem}.pbrt"
        words = scene.read_text().split("\n")[0].strip("# ")
        shown += (f'<figure><video src="{file.name}" poster="{file.stem}.jpg" controls loop muted playsinline preload="none"></video>'
                  f'<figcaption><a href="{scene.as_uri()}">{file.stem}</a>: {html.escape(words)}</figcaption></figure>')
    return f'<section id="videos"><h2>Videos of Petrovic and others</h2><div class="videos">{shown}</div></section>'


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--quality", choices=["draft", "paper"], default="paper")
    parser.add_argument("--pictures", type=pathlib.Path, help="rendered before: nothing is rendered")
    parser.add_argument("ids", nargs="*", help="default: all that can be made")
    arguments = parser.parse_intermixed_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    sections, broken = [], 0
    for row in figures(arguments.program):
        if arguments.ids and row[0] not in arguments.ids:
            continue
        done = arguments.out / f"{row[0]}.txt"
        if not done.exists():
            print(row[0], flush=True)
            start = time.monotonic()
            words = [arguments.program, "figure", row[0], "-o", arguments.out, "--quality", arguments.quality, "--scenes", ROOT / "scenes"]
            words += ["--pictures", arguments.pictures] if arguments.pictures else []
            run = subprocess.run([str(w) for w in words], capture_output=True, text=True)
            if "BROKEN" not in run.stdout and run.returncode != 0:
                print(run.stderr, file=sys.stderr)
                continue
            done.write_text(f"{run.stdout}seconds {time.monotonic() - start:.1f}\n")
        said = done.read_text()
        broken += said.count("BROKEN")
        sections.append(section(arguments.out, row, said))
    if not arguments.ids:
        sections.append(videos(arguments.out))
    made = len(sections) - (not arguments.ids)
    page = (f'<!doctype html><html lang="en"><meta charset="utf-8"><title>Figures</title><style>{STYLE}</style><header><h1>Figures</h1>'
            f"<p>{made} figures, {broken} claims that do not hold.</p></header>{''.join(sections)}</html>")
    (arguments.out / "index.html").write_text(page)
    print(f"wrote {arguments.out / 'index.html'}: {made} figures, {broken} claims that do not hold")
    return 1 if broken else 0


sys.exit(main())
