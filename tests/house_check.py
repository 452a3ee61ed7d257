#!/usr/bin/env python3
"""Checks the house: its rooms, its format and its rules. house_check.py CHECK ..., or `all`; prints file:line: error: ...

  includes   a room includes only the rooms that it may; oneTBB, glog and zlib stand each behind files of ours
  format     clang-format 14 would change nothing; with another version exit status 77, not judged
  size       no file is longer than 700 lines, no function than 80 (but "// Long because: ..." stands above it), no
             line than 110 columns
  types      a type at namespace scope has its name alone, in the whole house
  words      comments begin with a subject and a verb; the field's words: Min, Max
  messages   errors and warnings are built from format strings
  tables     above every table of rows stands how to add one

The checks read text, not C++: good enough for what clang-format has laid out. tests/house_check_test.py shows each of
them an example that it must find.
"""
import collections
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

# --- rooms -----------------------------------------------------------------------------------------------------------
# room: the rooms that it may include besides itself. To add one: name it here and in CMakeLists.txt (cuticle_room),
# and give it a line in README.md.
ROOMS = {
    "core": set(),
    "files": {"core"},
    "images": {"core", "files"},
    "fibers": {"core"},
    "shapes": {"core", "files"},
    "grooms": {"core", "files"},
    "volume": {"core", "files", "grooms"},
    "parser": {"core", "files", "shapes"},
    "dynamics": {"core", "files", "grooms", "volume", "parser"},  # parser: recipes are in the scenes' language
    "materials": {"core", "files", "images", "fibers", "shapes", "parser"},
}
for room in ["scene", "render", "figures", "cli"]:  # each may include all that stand above it
    ROOMS[room] = set(ROOMS)
# Rooms within a room include what lies in its root, and not each other.
SUBROOMS = {"figures": {"papers", "charts", "atlas"}}

# Headers of a library, and the only files that may include them
BEHIND = [
    (r"tbb/|oneapi/", r"src/core/parallel\.cpp"),
    (r"glog/", r"src/core/check\.(h|cpp)"),
    (r"zlib\.h", r"src/files/.*"),
    (r"OpenEXR/|Imath|png\.h|jpeglib\.h|stb/", r"src/images/.*"),
    (r"embree[34]/", r"src/shapes/.*"),
]

MAX_FILE = 700
MAX_FUNCTION = 80
MAX_LINE = 110
REASON = "// Long because: "


def sources(*folders):
    for folder in folders:
        yield from sorted(p for p in (ROOT / folder).rglob("*") if p.suffix in {".h", ".cpp"})


def house():
    """Every source file: its name within the house, its text."""
    for path in sources("src", "tests"):
        yield str(path.relative_to(ROOT)), path.read_text(encoding="utf-8")


# --- reading C++ just well enough -----------------------------------------------------------------------------------
TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.S)


def mask(text, keep_comments=False, keep_strings=False):
    """The text with comments and the insides of strings blanked out, character for character."""

    def blank(match):
        token = match[0]
        is_comment = token.startswith(("//", "/*"))
        # 1'000'000 is a number: what looks like a character after a digit is none
        if token[0] == "'" and match.start() > 0 and text[match.start() - 1].isalnum():
            return token
        if keep_comments if is_comment else keep_strings:
            return token
        blanked = re.sub(r"[^\n]", " ", token)
        return blanked if is_comment else token[0] + blanked[1:-1] + token[-1]

    return TOKEN.sub(blank, text)


def line_of(text, at):
    return text.count("\n", 0, at) + 1


def drop_directives(code):
    """The masked code without preprocessor lines and their continuations."""
    return re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", lambda m: re.sub(r"[^\n]", " ", m[0]), code, flags=re.M)


def blocks(code):
    """(kind, head, begin of the head, end) of every { } of masked code; kind: namespace, type, function or other."""
    code = drop_directives(code)
    stack = []
    start = 0  # of the head of the next block
    for match in re.finditer(r"[{};]|^[ \t]*(?:public|private|protected):", code, flags=re.M):
        if match[0] == "{":
            head = code[start : match.start()]
            begin = start + len(head) - len(head.lstrip())
            tight = match.start() > 0 and not code[match.start() - 1].isspace()
            if tight or head.count("(") > head.count(")"):
                stack.append(("value", head, start))  # as in b_{a}: what follows still belongs to the head
                continue
            stack.append((kind_of(head.strip(), [s[0] for s in stack]), " ".join(head.split()), begin))
            start = match.end()
        elif match[0] == "}":
            start = match.end()
            if stack:
                kind, head, begin = stack.pop()
                if kind == "value":
                    start = begin
                else:
                    yield kind, head, begin, match.end()
        elif code.count("(", start, match.start()) <= code.count(")", start, match.start()):  # no ; of a for (;;)
            start = match.end()


TYPE = re.compile(r"(?:template <.*>\s*)?(?:typedef\s+)?(?:struct|class|union|enum(?: class| struct)?)\b(?!.*\)\s*$)"
                  r"(?:\s*\[\[[^\]]*\]\])?(?:\s+(?:alignas\([^)]*\)\s*)?([\w:]+)(?:<.*>)?)?", re.S)


def kind_of(head, outer):
    if head.startswith(("namespace", 'extern "')) or re.match(r"inline\s+namespace", head):
        return "namespace"
    if "function" in outer:
        return "inner"
    if TYPE.match(head) and not head.endswith("="):
        return "type"
    # A function has its parameters and no assignment outside of them
    if "(" in head and not re.search(r"(?<![=!<>])=(?!=)", re.sub(r"\(.*\)|operator\s*\S+", "", head, flags=re.S)):
        return "function"
    return "other"


def functions(text):
    """(name, line, lines) of every function, with its closing brace. What stands inside a function is part of it."""
    code = mask(text)
    for kind, head, begin, end in blocks(code):
        if kind == "function":
            name = re.search(r"((?:[\w~]+(?:<[^<>]*>)?::)*(?:operator\s*[^\s(]+|[\w~]+))\s*\(", head)
            first = line_of(code, begin)
            yield (name[1] if name else head[:40]), first, line_of(code, end - 1) - first + 1


def types(text):
    """(name, line) of every type that is defined at namespace scope; the name with its namespaces below cuticle."""
    code = mask(text)
    found = list(blocks(code))
    spans = [(begin, end) for kind, _, begin, end in found if kind in {"type", "function", "other"}]
    spaces = [(head, begin, end) for kind, head, begin, end in found if kind == "namespace"]
    for kind, head, begin, end in found:
        if kind != "type" or any(b < begin and end < e for b, e in spans):
            continue
        name = TYPE.match(head)[1]
        if not name or "::" in name or re.match(r"template <>", head) or re.search(rf"\b{name}<", head):
            continue  # without a name, or the definition of one declared elsewhere
        inside = sorted((b, re.sub(r"(?:inline )?namespace\s*", "", h)) for h, b, e in spaces if b < begin and end < e)
        yield "::".join([n for _, n in inside if n not in {"", "cuticle"}] + [name]), line_of(code, begin)


# --- checks -----------------------------------------------------------------------------------------------------------
def check_includes(files):
    errors = []
    for file, text in files:
        parts = file.split("/")
        room = parts[1] if parts[0] == "src" else None
        if room is not None and room not in ROOMS:
            errors.append(f"{file}:1: error: src/{room} is no room of the house")
            continue
        for number, line in enumerate(text.splitlines(), 1):
            match = re.match(r'\s*#\s*include\s+["<]([^">]+)[">]', line)
            if not match or room is None:
                continue
            where, target = f"{file}:{number}: error:", match[1].split("/")
            for library, allowed in BEHIND:
                if re.match(library, match[1]) and not re.fullmatch(allowed, file):
                    errors.append(f"{where} <{match[1]}> stands behind {allowed.replace(chr(92), '')}")
            if '"' not in line:
                continue
            if len(target) == 1:
                errors.append(f'{where} include "{match[1]}" by its room')
            elif target[0] != room and target[0] not in ROOMS[room]:
                errors.append(f"{where} {room} must not include {target[0]}")
            elif target[0] in SUBROOMS and target[1] in SUBROOMS[target[0]] and room == target[0]:
                own = parts[2] if len(parts) > 3 else None
                if own != target[1] and own is not None:
                    errors.append(f"{where} {room}/{own} must not include {room}/{target[1]}")
    return errors


def check_format(_):
    program = shutil.which("clang-format-14") or shutil.which("clang-format")
    if not program:
        return ["clang-format is not installed: error: .ci/setup installs it"]
    version = subprocess.run([program, "--version"], capture_output=True, text=True).stdout
    if "version 14." not in version:
        print(f"format: not judged: versions differ in details, and ours is 14; this is {version.strip()}")
        sys.exit(77)
    errors = []
    names = [str(p) for p in sources("src", "tests")]
    for start in range(0, len(names), 40):
        run = subprocess.run([program, "--dry-run", "-Werror", *names[start : start + 40]], capture_output=True,
                             text=True)
        errors += [line for line in run.stderr.splitlines() if "error:" in line]
    return errors


def check_size(files):
    errors = []
    for file, text in files:
        lines = text.splitlines()
        if len(lines) > MAX_FILE:
            errors.append(f"{file}:1: error: {len(lines)} lines, more than {MAX_FILE}: split it by subject")
        for number, line in enumerate(lines, 1):
            if len(line) > MAX_LINE:
                errors.append(f"{file}:{number}: error: {len(line)} columns, more than {MAX_LINE}")
        for name, first, length in functions(text):
            above = first - 2
            while above >= 0 and lines[above].lstrip().startswith("//") and REASON not in lines[above]:
                above -= 1
            if length > MAX_FUNCTION and not (above >= 0 and REASON in lines[above]):
                errors.append(f"{file}:{first}: error: {name}() has {length} lines, more than {MAX_FUNCTION}: divide"
                              f' it, or say "{REASON}..." above it')
    return errors


def check_types(files):
    """Tests have programs of their own, so only src counts; a type that a header declares and a source defines is one."""
    places = collections.defaultdict(list)
    for file, text in files:
        if file.startswith("src/"):
            for name, line in types(text):
                places[name].append((file, line))
    errors = []
    for name, found in places.items():
        if len({file for file, _ in found}) > 1:
            others = ", ".join(f"{file}:{line}" for file, line in found[1:])
            errors.append(f"{found[0][0]}:{found[0][1]}: error: {name} is also at {others}: one meaning a name")
    return errors


# First words of a comment that leave it without a subject or a verb
VERBLESS = r"(?:Of|What|Where|Without|By|From)\b"
# Names of the past; "atLeast" may stay
FORBIDDEN = re.compile(r"\b(?:k(?:Most|Fewest|Smallest|Largest|Deepest|Longest|Least|Greatest)[A-Z]\w*|"
                       r"\w*(?<!at)(?:Least|Greatest)(?![a-z])\w*|(?:least|greatest)[A-Z]\w*|[Oo]pponents?Scene)\b")


def check_words(files):
    errors = []
    for file, text in files:
        previous = ""
        for number, line in enumerate(text.splitlines(), 1):
            comment = re.match(r"\s*// (.*)", line)
            begins = comment and not re.match(r"\s*//", previous)
            opened = comment and re.match(r"\s*//>", previous)  # a chunk's first line
            indent = len(line) - len(line.lstrip())
            if (begins or opened) and re.match(VERBLESS, comment[1]) and (file.endswith(".h") or indent == 0):
                if not comment[1].split("//")[0].rstrip().endswith("?"):
                    errors.append(f'{file}:{number}: error: a comment that begins with "{comment[1].split()[0]}" has '
                                  "no verb to hold on to")
            previous = line
        for match in FORBIDDEN.finditer(mask(text)):
            errors.append(f"{file}:{line_of(text, match.start())}: error: {match[0]}: say Min or Max")
    return errors


def check_messages(files):
    errors = []
    for file, text in files:
        if not file.startswith("src/"):
            continue
        code = mask(text)
        for match in re.finditer(r"\b(?:Error|Fail|fail|Warning|WithRemedy)\(", code):
            depth, at = 1, match.end()
            while depth and at < len(code):
                depth += {"(": 1, ")": -1}.get(code[at], 0)
                at += 1
            glue = code.find("std::to_string(", match.end(), at)
            if glue >= 0:
                errors.append(f"{file}:{line_of(code, glue)}: error: std::to_string in a message: use a format string")
    return errors


# Tables are arrays of rows, by the names of their types
TABLE = re.compile(r"^(?:inline |static |extern )*const(?:expr)? (?:\w+Row(?:<\w+>)?|ImageFormat|StrandFormat) (k\w+)\[\w*\]")
HOW_TO_ADD = re.compile(r"To add (?:one|an? [\w ]+):")


def check_tables(files):
    errors = []
    for file, text in files:
        lines = text.splitlines()
        for number, line in enumerate(lines, 1):
            match = TABLE.match(line) if file.startswith("src/") else None
            if match and not any(HOW_TO_ADD.search(above) for above in lines[max(0, number - 13) : number - 1]):
                errors.append(f'{file}:{number}: error: say above {match[1]} how to add a row: "To add one: ..."')
    return errors


CHECKS = {
    "includes": check_includes,
    "format": check_format,
    "size": check_size,
    "types": check_types,
    "words": check_words,
    "messages": check_messages,
    "tables": check_tables,
}


def main(names):
    names = list(CHECKS) if names == ["all"] else names
    if not names or any(name not in CHECKS for name in names):
        sys.exit(__doc__)
    files = list(house())
    count = 0
    for name in names:
        errors = CHECKS[name](files)
        print("\n".join(errors))
        print(f"{name}: {len(errors)} errors")
        count += len(errors)
    sys.exit(1 if count else 0)


if __name__ == "__main__":
    main(sys.argv[1:])
