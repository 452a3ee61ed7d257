#!/usr/bin/env python3
"""Fuzzes the readers, the renderer and the grammar of scenes: run.py --minutes N

Builds the fuzz targets (CMake preset fuzz: clang's libFuzzer, address and undefined sanitizers, assertions of the
standard library, checks of ours; all kernels are in) and runs each of them for its share of N minutes, as many at once
as there are processors. Corpora grow in --corpora, build/fuzz/corpora where none is named; what a target dies of stays
there as NAME-crash-... (also -timeout-, -oom-, -leak-) and is run again alone by build/fuzz/fuzz_NAME FILE. Seeds are
the files of this repository and of the --seeds folders whose endings a target reads; the dictionary is every short
string in the sources of the readers. Exit status 1 when anything was found.

Target "grammar" changes scenes by statements, parameters, blocks, includes and damaged files (tests/fuzz/
scene_grammar.h), and takes half of the time; the others change bytes.

A find is mended and stays as a small named test in tests/, with its bytes in the test's text.
"""
import argparse
import concurrent.futures
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
# By target: endings of its seeds, the longest input, the folders whose strings are its dictionary, its part of the time
TARGETS = {
    "grammar": ([".pbrt"], 16384, [], 9),
    "scene": ([".pbrt"], 8192, ["src/parser", "src/materials", "src/scene"], 1),
    "render": ([".pbrt"], 4096, ["src/parser", "src/materials", "src/scene", "src/render"], 3),
    "ply": ([".ply"], 4096, ["src/shapes", "src/files"], 1),
    "ply_strands": ([".ply"], 4096, ["src/grooms", "src/files"], 1),
    "hair_file": ([".hair"], 4096, [], 1),
    "tfx_file": ([".tfx"], 4096, [], 1),
    "usd_file": ([".usda"], 4096, ["src/grooms"], 1),
    "image": ([".pfm", ".png", ".exr", ".hdr", ".tga", ".jpg"], 8192, [], 1),
    "spd": ([".spd"], 2048, [], 1),
    "recipe": ([".recipe", ".poses"], 4096, ["src/dynamics", "src/parser"], 1),
}


def dictionary(folders, at):
    words = set()
    for folder in folders:
        for source in sorted((ROOT / folder).glob("*.cpp")):
            words.update(re.findall(r'"(\w[\w ./-]{1,30})"', source.read_text()))
    at.write_text("".join(f'"{w}"\n' for w in sorted(words)))


def seed(target, folders, corpus):
    """Copies what is short enough; of longer texts and pictures their beginning, which is where a reader decides."""
    endings, longest = TARGETS[target][:2]
    files = [f for folder in folders for f in sorted(folder.rglob("*")) if f.suffix in endings and f.is_file()]
    for i, file in enumerate(files):
        with file.open("rb") as stream:
            content = stream.read(longest)
        if target == "image":  # its first byte is the format
            content = bytes([endings.index(file.suffix)]) + content
        (corpus / f"seed-{i}").write_bytes(content[:longest])


def run(target, seconds, corpora, seeds, seed_number):
    """Runs one target. Returns its line for the reader, and the log's end where something was found."""
    corpus = corpora / target
    corpus.mkdir(parents=True, exist_ok=True)
    seed(target, [ROOT / "scenes", ROOT / "tests", ROOT / "reference_images", *seeds], corpus)
    words = corpora / f"{target}.dict"
    dictionary(TARGETS[target][2], words)
    empty = corpora / "empty"  # relative names in an input are looked for where there are none
    empty.mkdir(exist_ok=True)
    scratch = corpora / f"{target}-scratch"
    scratch.mkdir(exist_ok=True)
    done = subprocess.run(
        [ROOT / f"build/fuzz/fuzz_{target}", corpus, *([f"-dict={words}"] if words.stat().st_size else []),
         f"-max_len={TARGETS[target][1]}", f"-max_total_time={seconds}", f"-seed={seed_number}", "-timeout=25", "-rss_limit_mb=2048",
         f"-artifact_prefix={corpora}/{target}-", "-print_final_stats=1", "-verbosity=0"],
        cwd=empty, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace",
        env={**os.environ, "ASAN_OPTIONS": "allocator_may_return_null=0:detect_leaks=1", "TMPDIR": str(scratch)})
    shutil.rmtree(scratch, ignore_errors=True)  # a target that died left its folder
    (corpora / f"{target}.log").write_text(done.stderr)
    count = re.search(r"number_of_executed_units: (\d+)", done.stderr)
    found = done.returncode != 0
    line = f"{target}: {count.group(1) if count else '?'} inputs in {seconds} s, {'FOUND SOMETHING' if found else 'clean'}"
    return line, "\n".join(done.stderr.splitlines()[-60:]) if found else ""


def build(minutes):
    """Builds all targets. False where that takes longer than so many minutes (None: as long as it takes)."""
    words = ["cmake", "--build", "--preset", "fuzz"]
    with subprocess.Popen(words, cwd=ROOT, stdout=subprocess.DEVNULL, start_new_session=True) as process:
        try:
            if process.wait(minutes and 60 * minutes) != 0:
                raise subprocess.CalledProcessError(process.returncode, words)
        except BaseException as error:
            if process.returncode is None:
                os.killpg(process.pid, signal.SIGTERM)  # the builder's children as well
            if isinstance(error, subprocess.TimeoutExpired):
                return False
            raise
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, required=True, help="on the wall, all targets together")
    parser.add_argument("--corpora", type=pathlib.Path, default=ROOT / "build/fuzz/corpora")
    parser.add_argument("--seeds", type=pathlib.Path, nargs="*", default=[])
    parser.add_argument("--targets", nargs="*", choices=list(TARGETS), default=list(TARGETS))
    parser.add_argument("--seed", type=int, default=0, help="of the random changes; 0: another one each time")
    parser.add_argument("--build-minutes", type=float, help="end, with status 0, where building takes longer")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="targets at once")
    arguments = parser.parse_args()
    subprocess.run(["cmake", "--preset", "fuzz"], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    if not build(arguments.build_minutes):
        print(f"not fuzzed: the targets are not built after {arguments.build_minutes:g} minutes")
        return 0
    corpora = arguments.corpora.resolve()
    # Who has the most time begins, so that all end at about the same moment
    targets = sorted(arguments.targets, key=lambda t: -TARGETS[t][3])
    total = sum(TARGETS[t][3] for t in targets)
    jobs = max(1, min(arguments.jobs, len(targets)))
    share = {t: max(1, round(60 * arguments.minutes * jobs * TARGETS[t][3] / total)) for t in targets}
    found = False
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for line, log in pool.map(lambda t: run(t, share[t], corpora, arguments.seeds, arguments.seed), targets):
            print(line, flush=True)
            if log:
                found = True
                print(log, flush=True)
    return 1 if found else 0


sys.exit(main())
