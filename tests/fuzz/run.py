#!/usr/bin/env python3
"""Fuzzes the readers: run.py CORPORA SECONDS [--seeds FOLDER ...] [--targets NAME ...]

Builds the fuzz targets (CMake preset fuzz: clang's libFuzzer, address and undefined sanitizers) and runs each of them
for its share of SECONDS, one process at a time. CORPORA is a folder of your own outside the repository: corpora grow
there, and what a target dies of stays there as CORPORA/NAME-crash-... (also -timeout-, -oom-, -leak-). Seeds are the
files of this repository and of the --seeds folders whose endings a target reads; the dictionary is every short string
in the sources of the readers. Exit status 1 when anything was found.

A find is mended and stays as a small named test in tests/, with its bytes in the test's text.
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
# By target: endings of its seeds, the longest input, the folders whose strings are its dictionary
TARGETS = {
    "scene": ([".pbrt"], 8192, ["src/parser", "src/materials", "src/scene"]),
    "render": ([".pbrt"], 4096, ["src/parser", "src/materials", "src/scene", "src/render"]),
    "ply": ([".ply"], 4096, ["src/shapes"]),
    "hair_file": ([".hair"], 4096, []),
    "tfx_file": ([".tfx"], 4096, []),
    "usd_file": ([".usda"], 4096, ["src/grooms"]),
    "image": ([".pfm", ".png", ".exr", ".hdr", ".tga", ".jpg"], 8192, []),
    "spd": ([".spd"], 2048, []),
}


def dictionary(folders, at):
    words = set()
    for folder in folders:
        for source in sorted((ROOT / folder).glob("*.cpp")):
            words.update(re.findall(r'"(\w[\w ./-]{1,30})"', source.read_text()))
    at.write_text("".join(f'"{w}"\n' for w in sorted(words)))


def seed(target, folders, corpus):
    """Copies what is short enough; of longer texts and pictures their beginning, which is where a reader decides."""
    endings, longest, _ = TARGETS[target]
    files = [f for folder in folders for f in sorted(folder.rglob("*")) if f.suffix in endings and f.is_file()]
    for i, file in enumerate(files):
        with file.open("rb") as stream:
            content = stream.read(longest)
        if target == "image":  # its first byte is the format
            content = bytes([endings.index(file.suffix)]) + content
        (corpus / f"seed-{i}").write_bytes(content[:longest])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("corpora", type=pathlib.Path)
    parser.add_argument("seconds", type=int)
    parser.add_argument("--seeds", type=pathlib.Path, nargs="*", default=[])
    parser.add_argument("--targets", nargs="*", choices=list(TARGETS), default=list(TARGETS))
    arguments = parser.parse_args()
    for words in [["cmake", "--preset", "fuzz"], ["cmake", "--build", "--preset", "fuzz"]]:
        subprocess.run(words, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    corpora = arguments.corpora.resolve()
    found = 0
    for target in arguments.targets:
        corpus = corpora / target
        corpus.mkdir(parents=True, exist_ok=True)
        seed(target, [ROOT / "scenes", ROOT / "tests", ROOT / "reference_images", *arguments.seeds], corpus)
        words = corpora / f"{target}.dict"
        dictionary(TARGETS[target][2], words)
        empty = corpora / "empty"  # relative names in an input are looked for where there are none
        empty.mkdir(exist_ok=True)
        run = subprocess.run(
            [ROOT / f"build/fuzz/fuzz_{target}", corpus, *([f"-dict={words}"] if words.stat().st_size else []), f"-max_len={TARGETS[target][1]}",
             f"-max_total_time={arguments.seconds // len(arguments.targets)}", "-timeout=10", "-rss_limit_mb=2048",
             f"-artifact_prefix={corpora}/{target}-", "-print_final_stats=1", "-verbosity=0"],
            cwd=empty, stderr=subprocess.PIPE, text=True, errors="replace",
            env={**os.environ, "ASAN_OPTIONS": "allocator_may_return_null=0:detect_leaks=1"})
        (corpora / f"{target}.log").write_text(run.stderr)
        runs = re.search(r"number_of_executed_units: (\d+)", run.stderr)
        print(f"{target}: {runs.group(1) if runs else '?'} inputs, {'clean' if run.returncode == 0 else 'FOUND SOMETHING'}",
              flush=True)
        if run.returncode != 0:
            found += 1
            print("\n".join(run.stderr.splitlines()[-60:]), flush=True)
    return 1 if found else 0


sys.exit(main())
