#!/usr/bin/env python3
"""Weave the book: HTML pages that need no script and no network, and a PDF of them all.

book.py --out FOLDER [--no-pdf] [--chapter NN]

Needs, beside Python 3, pandoc (Markdown), node with KaTeX (formulas) and, for the PDF, chromium: `.ci/setup book`
installs them. The book is checked first (weave.py). What is wrong stops the build with `file:line: error: ...`: a formula
that KaTeX does not know, a link or picture that leads nowhere, a command that fails, a value that it does not print.

In a chapter, beyond Markdown, $formulas$ and ⟨chunks⟩:

  ```run                the commands are run, in a folder of the chapter's own in which build/, scenes/ and
  command               reference_images/ are those of the project; the listing shows them and what they print
  ```
  ```values             the command is run and not shown; its output gives `name` the value that the regular expression's
  name = command => regular expression     group finds; a line without `= command` looks in what the one before it printed
  name => regular expression
  ```
  ```figure ID          the picture that `cuticle figure ID` makes, its caption in it
  ```
  ```chart NAME         the same of `cuticle chart NAME --quick`
  ```
  ```numbers            where numbers of the prose come from that no command makes: weave.py says how; not shown
  ```

A command is run again when a program that it names, or anything that it reads, has changed: scenes, data, what earlier
commands of its chapter wrote. {{name}} in the text is such a value, {{name .3g}} the number as Python formats it, {{name %}} as a percentage. An image
`![text](run:file.png)` is a file that a command of this chapter wrote; of `![text](run:file.mp4)` it wrote file.jpg too, a still, which
stands for the video on paper and until it plays.
"""

import argparse
import hashlib
import html
import itertools
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))
import weave  # noqa: E402

HERE = Path(__file__).resolve().parent
KATEX_CSS = ("/usr/share/javascript/katex/katex.min.css", "/usr/share/nodejs/katex/dist/katex.min.css")
KATEX_FONTS = ("/usr/share/fonts/truetype/katex", "/usr/share/javascript/katex/fonts", "/usr/share/nodejs/katex/dist/fonts")
VIDEO = r'<img src="([^"]*)" alt="([^"]*)" video="([^"]*)" />'
FENCE = re.compile(r"^```(run|values|figure|chart|numbers)\b[ ]*(.*?)\n(.*?)^```[ ]*$", re.M | re.S)
MARK = re.compile(r"\x02(\d+)\x03")  # stands for HTML that pandoc must not touch
CPP = re.compile(r"""(?P<com>//.*|/\*.*?\*/)|(?P<str>R?"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])+')|(?P<pre>^\s*\#.*)|"""
                 r"""(?P<num>\b0[xX][\da-fA-F.'p+-]+\w*|\b\d[\d.']*(?:[eE][+-]?\d+)?\w*)|(?P<word>[A-Za-z_]\w*)""")
KEYWORDS = set("""alignas auto bool break case catch char class const constexpr const_cast continue default delete do double
else enum explicit extern false final float for friend if inline int int32_t int64_t long mutable namespace new noexcept
nullptr operator override private protected public return short signed sizeof size_t static static_assert static_cast
reinterpret_cast dynamic_cast struct switch template this throw true try typedef typename uint8_t uint16_t uint32_t uint64_t
union unsigned using virtual void volatile while""".split())


class BookError(Exception):
    def __init__(self, file, line, message):
        super().__init__(f"{file}:{line}: error: {message}" if line else f"{file}: error: {message}")


def slug(text):
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-") or "x"


def plain_caption(text):
    """A caption without gnuplot's marks: {/:Italic S}, x_{min} and 10^{-3} become S, x_min and 10^-3."""
    return re.sub(r"\{(?:/\S+ )?([^{}]*)\}", r"\1", text)


def html_caption(text):
    """The same marks as HTML."""
    text = html.escape(re.sub(r"\{/\S+ ([^{}]*)\}", r"\1", text))
    text = re.sub(r"_(?:\{([^{}]*)\}|(\w))", lambda m: f"<sub>{m[1] or m[2]}</sub>", text)
    return re.sub(r"\^(?:\{([^{}]*)\}|(\w))", lambda m: f"<sup>{m[1] or m[2]}</sup>", text)


def highlight(text):
    """A line of C++ as HTML."""
    out, at = [], 0
    for m in CPP.finditer(text):
        out.append(html.escape(text[at:m.start()], quote=False))
        kind, word = m.lastgroup, html.escape(m[0], quote=False)
        if kind == "word":
            kind = "key" if m[0] in KEYWORDS else "type" if re.match(r"[A-Z]\w*[a-z]", m[0]) and text[m.end():m.end() + 1] != "(" else None
        out.append(f'<span class="{kind}">{word}</span>' if kind else word)
        at = m.end()
    out.append(html.escape(text[at:], quote=False))
    return "".join(out)


class Book:
    def __init__(self, root, out, built=None):
        self.root, self.out, self.built = root, out, built
        self.check = weave.Check(root)
        self.hashes = {}  # of what commands read
        self.written = {}  # chapter -> (key of a command, files that it wrote, command), in order
        self.current = set(built or [])  # programs that are known to be up to date
        self.held = []  # HTML behind marks
        self.formulas = {}  # (tex, display) -> [file, line, html]
        self.pages = {}  # file name -> (title, html)
        self.sections = []  # of the search: page, id, title, text
        self.chapters = []

    # --- formulas -------------------------------------------------------------------------------------------------
    def formula(self, tex, display, file, line):
        key = (tex, display)
        self.formulas.setdefault(key, [file, line, None])
        return self.hold(key)

    def hold(self, content):
        self.held.append(content)
        return f"\x02{len(self.held) - 1}\x03"

    def render_formulas(self):
        keys = list(self.formulas)
        script = """const katex = require('katex');
const all = JSON.parse(require('fs').readFileSync(0, 'utf8'));
process.stdout.write(JSON.stringify(all.map(([tex, display]) => {
  try { return [katex.renderToString(tex, {displayMode: display, throwOnError: true, strict: 'error', trust: false}), null]; }
  catch (e) { return [null, String(e.message)]; } })));"""
        run = subprocess.run(["node", "-e", script], input=json.dumps(keys), capture_output=True, text=True,
                             env={**os.environ, "NODE_PATH": "/usr/share/nodejs"})
        if run.returncode != 0:
            raise BookError("literate_docs/book.py", 0, "node with KaTeX is needed (.ci/setup book): " + run.stderr.strip()[-300:])
        for key, (rendered, message) in zip(keys, json.loads(run.stdout)):
            if message:
                file, line, _ = self.formulas[key]
                raise BookError(file, line, f"KaTeX does not know ${key[0]}$: {message}")
            self.formulas[key][2] = rendered

    def unmark(self, text):
        """Puts back what is behind the marks, formulas last."""
        def one(m):
            content = self.held[int(m[1])]
            return self.formulas[content][2] if isinstance(content, tuple) else self.unmark(content)
        return MARK.sub(one, text)

    def inline(self, text, file, line):
        """A chunk's name: text with $formulas$ and `code`."""
        parts = re.split(r"(\$[^$]+\$|`[^`]+`)", text)
        return "".join(self.formula(p[1:-1], False, file, line) if p.startswith("$") and len(p) > 2
                       else f"<code>{html.escape(p[1:-1])}</code>" if p.startswith("`") and len(p) > 2
                       else html.escape(p, quote=False) for p in parts)

    # --- chunks ---------------------------------------------------------------------------------------------------
    def page_of(self, chapter):
        return Path(chapter).stem + ".html"

    def anchor(self, piece):
        return self.anchors[id(piece)]

    def link_to(self, piece, text=None):
        text = text or "⟨" + self.inline(piece.name, piece.file, piece.line) + "⟩"
        return f'<a class="chunk" href="{self.page_of(piece.shown[0])}#{self.anchor(piece)}">{text}</a>'

    def source_page(self, file):
        return "source-" + file.replace("/", "-") + ".html"

    def name_anchors(self):
        self.anchors, used = {}, set()
        for files in self.check.chunks.values():
            for pieces in files.values():
                for piece in pieces:
                    base = "c-" + slug(piece.name)
                    name, n = base, 1
                    while name in used:
                        n += 1
                        name = f"{base}-{n}"
                    used.add(name)
                    self.anchors[id(piece)] = name

    def listing(self, piece):
        pieces = self.check.chunks[piece.name][piece.file]
        k = pieces.index(piece)
        lines = [text for item in piece.body if not isinstance(item, weave.Piece) for text in [item[1]] if text.strip()]
        lines += [" " * self.indent_of(item) for item in piece.body if isinstance(item, weave.Piece)]
        margin = min((len(t) - len(t.lstrip()) for t in lines if t.strip()), default=0)
        if any(isinstance(i, weave.Piece) for i in piece.body):
            margin = min([margin] + [self.indent_of(i) for i in piece.body if isinstance(i, weave.Piece)])
        rows = []
        for item in piece.body:
            if isinstance(item, weave.Piece):
                rows.append(" " * (self.indent_of(item) - margin) + self.link_to(item))
            else:
                rows.append(highlight(item[1][margin:]))
        # Blank lines between two names only stretch the list
        rows = [r for i, r in enumerate(rows) if r.strip() or not (0 < i < len(rows) - 1 and "class=\"chunk\"" in rows[i - 1] and "class=\"chunk\"" in rows[i + 1])]
        while rows and not rows[0].strip():
            rows.pop(0)
        while rows and not rows[-1].strip():
            rows.pop()
        notes = []
        if piece.parent:
            notes.append("used in " + self.link_to(piece.parent))
        if k > 0:
            notes.append("begun in " + self.link_to(pieces[0], "the first piece"))
        if k + 1 < len(pieces):
            notes.append("continued in " + self.link_to(pieces[k + 1], f"piece {k + 2}"))
        place = f'<a class="place" href="{self.source_page(piece.file)}#L{piece.line}">{piece.file}:{piece.line}</a>'
        return (f'<figure class="chunk" id="{self.anchor(piece)}"><figcaption><span>⟨{self.inline(piece.name, piece.file, piece.line)}⟩ '
                f'{"+≡" if k else "≡"}</span> {place}</figcaption><pre tabindex="0"><code>' + "\n".join(rows)
                + "</code></pre>" + (f'<p class="notes">{"; ".join(notes)}</p>' if notes else "") + "</figure>")

    def indent_of(self, piece):
        text = self.lines[piece.file][piece.line - 1]
        return len(text) - len(text.lstrip())

    def source(self, file):
        """A page of a literate source, each chunk's opening a link to its paragraph."""
        opened = {p.line: p for files in self.check.chunks.values() for p in files.get(file, [])}
        rows = []
        for number, text in enumerate(self.lines[file], 1):
            piece = opened.get(number)
            content = highlight(text)
            if piece:
                margin = text[:len(text) - len(text.lstrip())]
                content = f'{margin}<a class="chunk" href="{self.page_of(piece.shown[0])}#{self.anchor(piece)}">{html.escape(text.strip())}</a>'
            rows.append(f'<a class="n" id="L{number}" href="#L{number}">{number:4}</a> {content}')
        self.pages[self.source_page(file)] = (file, f'<h1><code>{file}</code></h1><p>Every name that a line opens with leads to the paragraph that explains it.</p>'
                                              '<pre class="source"><code>' + "\n".join(rows) + "</code></pre>")

    # --- commands -------------------------------------------------------------------------------------------------
    LINKED = ("build", "scenes", "reference_images", "src", "tests")  # folders of the project that commands see

    def folder_of(self, chapter):
        folder = self.out / "run" / Path(chapter).stem
        folder.mkdir(parents=True, exist_ok=True)
        for name in self.LINKED:
            if (self.root / name).exists() and not (folder / name).is_symlink():
                (folder / name).symlink_to(self.root / name)
        return folder

    def hash_of(self, path):
        """Of a file, or of all files of a folder but sources, whose programs are hashed themselves."""
        if path not in self.hashes:
            digest = hashlib.sha256()
            for file in [path] if path.is_file() else sorted(path.rglob("*")):
                if file.is_file() and (path.is_file() or file.suffix not in (".cpp", ".h", ".pyc")):
                    digest.update(f"{file.relative_to(path)} ".encode() + file.read_bytes())
            self.hashes[path] = digest.hexdigest()
        return self.hashes[path]

    def inputs_of(self, command, chapter):
        """Hashes of what a command reads: programs, scenes with all that they include, data, and what earlier commands wrote."""
        inputs = [self.hash_of(self.root / name) for name in sorted(set(re.findall(r"build/release/[\w-]+", command)))]
        for folder in ("scenes", "tests"):  # a scene includes others, a test program reads its data
            if f"{folder}/" in command or re.search(r"build/release/(test|bench)_", command):
                inputs.append(self.hash_of(self.root / folder))
        for name in sorted(set(re.findall(r"\b(?:reference_images|src|literate_docs)/[\w./-]+", command))):
            inputs.append(self.hash_of(self.root / name))
        named = lambda file: "$" in command or "*" in command or Path(file).name in command or file.split("/")[0] in command
        inputs += [key for key, files, other in self.written.get(chapter, []) if other != command and any(map(named, files))]
        return inputs

    @staticmethod
    def files_in(folder):
        """Of a run's folder, but the links to the project and what is remembered of commands: name -> (time, size)."""
        return {file.relative_to(folder).as_posix(): (file.stat().st_mtime_ns, file.stat().st_size) for file in folder.rglob("*")
                if file.is_file() and not file.name.startswith(".") and not (folder / file.relative_to(folder).parts[0]).is_symlink()}

    def run(self, command, chapter, line):
        """What a command prints. It is not run again while neither it nor anything that it reads has changed."""
        folder = self.folder_of(chapter)
        key = hashlib.sha256("\n".join([command, *self.inputs_of(command, chapter)]).encode()).hexdigest()[:24]
        kept = folder / f".{key}"
        if kept.exists():
            output, files = json.loads(kept.read_text(encoding="utf-8"))
            if all((folder / file).exists() for file in files):
                return self.remember(chapter, key, files, command, output)
        self.require_current(command, chapter, line)
        before = self.files_in(folder)
        run = subprocess.run(["bash", "-o", "pipefail", "-c", command], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                             text=True, encoding="utf-8", errors="replace")
        if run.returncode != 0:
            raise BookError(chapter, line, f"`{command}` ends with status {run.returncode}: {run.stdout.strip()[-300:]}")
        self.require_tests(command, folder, chapter, line)
        if not run.stdout.strip() and re.search(r"(?:^|[|;&]\s*)(?:grep|sed|awk|head|tail|cut|tr)\s|--benchmark_filter", command):
            raise BookError(chapter, line, f"`{command}` prints nothing: its pattern matches nothing")
        files = sorted(file for file, state in self.files_in(folder).items() if before.get(file) != state)
        kept.write_text(json.dumps([run.stdout, files]), encoding="utf-8")
        return self.remember(chapter, key, files, command, run.stdout)

    def remember(self, chapter, key, files, command, output):
        self.written.setdefault(chapter, []).append((key, files, command))
        return output

    def require_current(self, command, chapter, line):
        """The programs that a command runs are those that the sources make now: a page of old ones cannot be built."""
        ninja = self.root / "build/release/build.ninja"
        for name in sorted(set(re.findall(r"build/release/([\w-]+)", command))):
            if not ninja.exists() or name in self.current:
                continue
            if self.built is not None:  # within a build: what it has not made first may be old
                raise BookError(chapter, line, f"build/release/{name} may be older than its sources: the target book of CMakeLists.txt does not name it")
            build = subprocess.run(["ninja", "-C", str(ninja.parent), name], capture_output=True, text=True)
            if build.returncode != 0:
                raise BookError(chapter, line, f"build/release/{name} cannot be built: {build.stdout.strip()[-500:]}")
            self.current.add(name)

    def sweep(self):
        """What no command makes any more disappears from the folders of the runs; pages and pictures of before, from the book."""
        for folder in sorted((self.out / "run").glob("*")):
            chapter = f"literate_docs/{folder.name}.md"
            keep = {name for _, files, _ in self.written.get(chapter, []) for name in files}
            keys = {f".{key}" for key, _, _ in self.written.get(chapter, [])}
            for file in self.files_in(folder):
                if file not in keep:
                    (folder / file).unlink()
            for file in folder.glob(".*"):
                if file.is_file() and file.name not in keys:
                    file.unlink()
        shown = {self.figure_name(chapter, name) for chapter, name in self.copied}
        for file in (self.out / "figures").glob("*"):
            if file.name not in shown:
                file.unlink()

    @staticmethod
    def require_tests(command, folder, chapter, line):
        """Every pattern of a --gtest_filter chooses a test: one that matches none would be printed as passed."""
        # words like CUTICLE_ISA=sse2 before the program are its environment
        for program, patterns in re.findall(r"(?:\w+=\S*\s+)*([^\s=]+)[^;|&]*--gtest_filter='?([^'\s]+)", command):
            for pattern in filter(None, re.split("[:-]", patterns)):
                tests = subprocess.run([program, "--gtest_list_tests", f"--gtest_filter={pattern}"], cwd=folder, capture_output=True,
                                       text=True).stdout
                if not re.search(r"^  \S", tests, re.M):
                    raise BookError(chapter, line, f"no test of {program} is called {pattern}")

    def fenced(self, match, chapter):
        kind, argument, body = match[1], match[2].strip(), match[3]
        line = self.line_of(chapter, match[0])
        if kind == "numbers":  # weave.py has checked them
            return "\n" * match[0].count("\n")
        if kind == "values":
            command = None
            for i, definition in enumerate(filter(str.strip, body.splitlines()), 1):
                m = re.fullmatch(r"\s*(\w+)\s*(?:=(?!>)\s*(.+?)\s*)?=>\s*(.+?)\s*", definition)
                command = m[2] or command if m else None
                if not command:
                    raise BookError(chapter, line + i, "a value is written as: name = command => regular expression")
                output = self.run(command, chapter, line + i)
                found = re.search(m[3], output)
                if not found:
                    raise BookError(chapter, line + i, f"`{command}` prints nothing that matches {m[3]}")
                self.values[m[1]] = found[1]
            return "\n" * match[0].count("\n")
        if kind == "run":
            rows = []
            for i, command in enumerate(self.commands(body), 1):
                rows.append(f'<span class="prompt">{html.escape(command)}</span>')
                output = self.run(command, chapter, line + i).strip("\n")
                if output:
                    rows.append(html.escape(output))
            block = '<pre class="run" tabindex="0"><code>' + "\n".join(rows) + "</code></pre>"
        else:
            quick = " --quick" if kind == "chart" else ""
            output = self.run(f"build/release/cuticle {kind} {argument}{quick} -o .", chapter, line)
            caption = self.run(f"build/release/cuticle {kind} --list", chapter, line)
            row = next((r for r in caption.splitlines() if r.split() and r.split()[0] == argument), "")
            words = re.split(r"  +| made ", row.strip())
            stem = argument
            if not any(f"{stem}.svg" in files for _, files, _ in self.written[chapter]):
                raise BookError(chapter, line, f"`cuticle {kind} {argument}` made no {stem}.svg: {output[-200:]}")
            self.copied.append((chapter, f"{stem}.svg"))
            # The picture carries its caption, with what this run found. On a narrow window, where that is too small to read,
            # the caption stands below, and the picture opens alone, to be enlarged.
            file = "figures/" + self.figure_name(chapter, f"{stem}.svg")
            block = (f'<figure class="plot"><a href="{file}"><img src="{file}" alt="{html.escape(plain_caption(words[-1]))}"></a>'
                     f'<figcaption><span class="words">{html_caption(words[-1])}</span><code>cuticle {kind} {argument}</code></figcaption></figure>')
        return "\n```{=html}\n" + self.hold(block) + "\n```\n" + "\n" * max(0, match[0].count("\n") - 4)

    @staticmethod
    def commands(body):
        """The commands of a block, one a line; a line that leaves a quotation open goes on in the next."""
        commands, begun = [], ""
        for line in re.sub(r"\\\n\s*", "", body).splitlines():
            begun += ("\n" if begun else "") + line
            if begun.strip() and "unexpected EOF" in subprocess.run(["bash", "-n", "-c", begun], capture_output=True, text=True).stderr:
                continue
            if begun.strip():
                commands.append(begun)
            begun = ""
        return commands + ([begun] if begun else [])

    def value(self, match, chapter):
        name, style = match[1], (match[2] or "").strip()
        line = self.line_of(chapter, match[0])
        if name not in self.values:
            known = ", ".join(sorted(self.values)) or "none"
            raise BookError(chapter, line, f"unknown value {{{{{name}}}}}; this chapter has: {known}")
        value = self.values[name]
        try:
            return format(100 * float(value), ".3g") + "%" if style == "%" else format(float(value), style) if style else value
        except ValueError:
            raise BookError(chapter, line, f"value {name} is {value}, which '{style}' does not format") from None

    # --- chapters -------------------------------------------------------------------------------------------------
    def chapter(self, chapter):
        text = (self.root / chapter).read_text(encoding="utf-8")
        self.values, page = {}, self.page_of(chapter)
        # Formulas first: pandoc's own reading of $ differs, and marks survive it.
        code = "\n".join(masked if len(masked) == len(line) else "x" * len(line)
                         for masked, line in zip(weave.mask_code(text).split("\n"), text.split("\n")))
        prepared, at = [], 0
        pattern = re.compile(r"^(?P<list>[ \t]*⟨[^⟨⟩]*⟩[ \t]*)$|⟨(?P<ref>[^⟨⟩]*)⟩|\$\$(?P<display>.+?)\$\$|\$(?P<math>[^$]+?)\$", re.M | re.S)
        for m in pattern.finditer(code):
            line = code.count("\n", 0, m.start()) + 1
            original = text[m.start():m.end()]
            prepared.append(text[at:m.start()])
            newlines = "\n" * original.count("\n")
            if m["list"] is not None:
                piece = self.check.listings[(chapter, line)]
                prepared.append("\n```{=html}\n" + self.hold(("listing", piece)) + "\n```\n")
            elif m["ref"] is not None:
                pieces = self.check.find(chapter, line, m["ref"])
                prepared.append("`" + self.hold(self.link_to(pieces[0])) + "`{=html}" + newlines.replace("\n", " "))
            elif m["display"] is not None:
                prepared.append("`" + self.formula(original[2:-2].strip(), True, chapter, line) + "`{=html}")
            else:
                prepared.append("`" + self.formula(original[1:-1].replace("\n", " "), False, chapter, line) + "`{=html}")
            at = m.end()
        prepared.append(text[at:])
        body = "".join(prepared)
        body = FENCE.sub(lambda m: self.fenced(m, chapter), body)
        body = re.sub(r"\{\{(\w+)([^{}]*)\}\}", lambda m: self.value(m, chapter), body)
        woven = subprocess.run(["pandoc", "-f", "markdown-smart-tex_math_dollars-implicit_figures-citations", "-t", "html5", "--wrap=none"],
                               input=body, capture_output=True, text=True, encoding="utf-8")
        if woven.returncode != 0:
            raise BookError(chapter, 0, woven.stderr.strip())
        result = MARK.sub(lambda m: self.listing(self.held[int(m[1])][1]) if isinstance(self.held[int(m[1])], tuple)
                          and self.held[int(m[1])][0] == "listing" else m[0], woven.stdout)
        result = re.sub(r'href="((?:\d\d|[A-Z])-[\w-]+)\.md', r'href="\1.html', result)
        result = re.sub(r'<video src="run:([^"]+)\.mp4"[^>]*><a [^>]*>(.*?)</a></video>', r'<img src="run:\1.jpg" alt="\2" video="run:\1.mp4" />', result)
        result = re.sub(r'(src|video)="run:([^"]+)"', lambda m: f'{m[1]}="{self.picture(m[2], chapter)}"', result)
        result = re.sub(r"<p>((?:<img [^>]*/>\s*)+)</p>", self.with_captions, result)
        result = re.sub(r'<table style="[^"]*">\s*<colgroup>[\s\S]*?</colgroup>', "<table>", result)  # columns as wide as what is in them
        result = re.sub(r"<table[\s\S]*?</table>", self.table, result)
        title = re.search(r"<h1[^>]*>(.*?)</h1>", result, re.S)
        if not title:
            raise BookError(chapter, 1, "a chapter begins with its title: # N Title")
        self.pages[page] = (re.sub(r"<[^>]+>", "", title[1]), result)
        self.chapters.append(page)

    def picture(self, name, chapter):
        if not any(name in files for _, files, _ in self.written.get(chapter, [])):
            raise BookError(chapter, self.line_of(chapter, "run:" + name), f"no command of this chapter wrote the picture {name}")
        self.copied.append((chapter, name))
        return f"figures/{self.figure_name(chapter, name)}"

    @staticmethod
    def table(match):
        """A wide one scrolls; one of long sentences is shown row by row on a narrow window, each cell after its column's name."""
        text, heads = match[0], re.findall(r"<th[^>]*>([\s\S]*?)</th>", match[0])
        plain = [re.sub(r"<[^>]+>", "", cell) for cell in re.findall(r"<td[^>]*>([\s\S]*?)</td>", text)]
        if len(heads) > 3 and max(map(len, plain), default=0) > 80:
            columns = itertools.cycle(heads)
            text = re.sub(r"<td", lambda m: f'<td data-column="{html.escape(re.sub("<[^>]+>", "", next(columns)))}"', text.replace("<table", '<table class="long"', 1))
        return f'<div class="wide">{text}</div>'

    @staticmethod
    def with_captions(match):
        """Pictures and videos that stand alone, side by side; the words in the brackets are the captions."""
        play = lambda m: f'<video src="{m[3]}" poster="{m[1]}" controls loop muted playsinline preload="none"></video><img class="still" src="{m[1]}" alt="{m[2]}" />'
        pictures = [(img, re.search(r'alt="([^"]*)"', img)[1]) for img in re.findall(r"<img [^>]*/>", match[1])]
        shown = [f"<figure>{re.sub(VIDEO, play, img)}<figcaption>{words}</figcaption></figure>" for img, words in pictures]
        return '<div class="pictures">' + "".join(shown) + "</div>"

    @staticmethod
    def figure_name(chapter, name):
        return f"{Path(chapter).stem}-{name.replace('/', '-')}"

    def line_of(self, chapter, words):
        text = (self.root / chapter).read_text(encoding="utf-8")
        return text.count("\n", 0, text.find(words)) + 1 if words in text else 1

    # --- indices --------------------------------------------------------------------------------------------------
    def where(self, piece):
        return f"{self.link_to(piece)} <small>{piece.file}</small>"

    def indices(self):
        chunks = sorted((files[f] for files in self.check.chunks.values() for f in files), key=lambda p: p[0].name.lower())
        self.pages["index-chunks.html"] = ("Index of chunks", "<h1>Index of chunks</h1><ul>" + "".join(
            "<li>" + self.where(pieces[0]) + "".join(" " + self.link_to(p, f"+{i}") for i, p in enumerate(pieces[1:], 2)) + "</li>"
            for pieces in chunks) + "</ul>")
        names = {}
        for files in self.check.chunks.values():
            for pieces in files.values():
                for piece in pieces:
                    for item in piece.body:
                        if isinstance(item, weave.Piece):
                            continue
                        m = re.match(r"\s*(?:def|class)\s+(\w+)", item[1]) if piece.file.endswith(".py") else re.match(r"\s*(?:template\s*<[^>]*>\s*)?(?:class|struct|enum class|enum)\s+(\w+)\s*(?:final\s*)?[:{]", item[1]) \
                            or re.match(r"(?!return|else|using|typedef|#)[A-Za-z_][\w:<>,&*\s]*?[\s&*](?:\w+(?:<\w+>)?::)*(~?\w+)\((?!.*;\s*$)", item[1])
                        if m and m[1] not in KEYWORDS and len(m[1]) > 1 and not m[1].isupper():
                            names.setdefault(m[1], []).append(piece)
        rows = []
        for name in sorted(names, key=str.lower):
            seen = {id(p): p for p in names[name]}.values()
            rows.append(f"<li><code>{name}</code> " + ", ".join(self.link_to(p, f"{Path(p.file).name}:{p.line}") for p in seen) + "</li>")
        self.pages["index-names.html"] = ("Index of types and functions", '<h1>Index of types and functions</h1><ul class="columns">' + "".join(rows) + "</ul>")
        self.papers()

    def papers(self):
        """Who is cited where: the entries of the bibliography, `- **Surname and others YEAR.** ...`, in sources and chapters."""
        bibliography = next((c for c in sorted(self.root.glob(weave.CHAPTERS)) if "bibliography" in c.name), None)
        if not bibliography:
            return
        rows = []
        for m in re.finditer(r"^- \*\*([\w'’ .-]+?)(?:,? (?:and|et al)[^*]*?)? (\d{4})\w?\.\*\*", bibliography.read_text(encoding="utf-8"), re.M):
            surname, year = m[1].split(",")[0].split()[-1], m[2]
            pattern = re.compile(re.escape(surname) + r"\b[^.\n]{0,60}?" + year, re.S)
            places = []
            for chapter in sorted(self.root.glob(weave.CHAPTERS)):
                if chapter != bibliography and pattern.search(chapter.read_text(encoding="utf-8")):
                    page = self.page_of(chapter.name)
                    places.append(f'<a href="{page}">{self.pages[page][0]}</a>')
            for files in self.check.chunks.values():
                for pieces in files.values():
                    for piece in pieces:
                        own = " ".join(re.sub(r"^\s*//", "", i[1]) for i in piece.body if not isinstance(i, weave.Piece) and i[1].lstrip().startswith("//"))
                        if pattern.search(own):
                            places.append(self.link_to(piece))
            if places:
                rows.append(f"<dt>{html.escape(m[0][4:-3])}</dt><dd>" + "; ".join(places) + "</dd>")
        self.pages["index-papers.html"] = ("Index of sources", "<h1>Index of sources</h1><p>Where each paper's formulas and ideas are used.</p><dl>" + "".join(rows) + "</dl>")

    # --- pages ----------------------------------------------------------------------------------------------------
    def contents(self, current):
        items = []
        for page in self.chapters:
            title, body = self.pages[page]
            inner = ""
            if page == current:
                heads = re.findall(r'<h2[^>]*id="([^"]+)"[^>]*>(.*?)</h2>', body, re.S)
                inner = "<ul>" + "".join(f'<li><a href="#{i}">{t}</a></li>' for i, t in heads) + "</ul>" if heads else ""
            items.append(f'<li><a href="{page}"{" aria-current=page" if page == current else ""}>{title}</a>{inner}</li>')
        for page in ("index-chunks.html", "index-names.html", "index-papers.html"):
            if page in self.pages:
                items.append(f'<li><a href="{page}"{" aria-current=page" if page == current else ""}>{self.pages[page][0]}</a></li>')
        return "<ul>" + "".join(items) + "</ul>"

    def page(self, name):
        title, body = self.pages[name]
        turn = ""
        if name in self.chapters:
            k = self.chapters.index(name)
            before = f'<a rel="prev" href="{self.chapters[k - 1]}">← {self.pages[self.chapters[k - 1]][0]}</a>' if k else "<span></span>"
            after = f'<a rel="next" href="{self.chapters[k + 1]}">{self.pages[self.chapters[k + 1]][0]} →</a>' if k + 1 < len(self.chapters) else "<span></span>"
            turn = f'<nav class="turn">{before}{after}</nav>'
        plain = re.sub(r"<[^>]+>", "", self.unmark(title))
        return self.unmark(f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{plain} · Cuticle</title><link rel="stylesheet" href="katex/katex.min.css"><link rel="stylesheet" href="book.css">
<script src="search-index.js" defer></script><script src="search.js" defer></script></head><body>
<header><a href="index.html">Cuticle, the book</a><div id="search" hidden><input type="search" placeholder="Search" aria-label="Search the book"><ol></ol></div></header>
<details class="contents"><summary>Contents</summary>{self.contents(name)}</details>
<div class="both"><nav class="side">{self.contents(name)}</nav><main>{turn}{body}{turn}</main></div></body></html>
""")

    def index(self):
        body = ("<h1>Cuticle</h1><p>A book about light in hair, and about finding the hair that a ray of light meets. Every listing in it is a "
                "piece of the program that renders. Every table of results and every plot was made by that program when the book was built, and so were "
                "the measured numbers; where a number in the prose is not made but given, the source of the page says what it is checked against or "
                "whence it is taken.</p>"
                f"{self.contents('')}<p><a href=\"cuticle.pdf\">The whole book as PDF</a></p><h2 id=\"sources\">The literate sources</h2><ul class=\"columns\">"
                + "".join(f'<li><a href="{self.source_page(f)}">{f}</a></li>' for f in sorted(self.lines)) + "</ul>")
        self.pages["index.html"] = ("Contents", body)

    def search_index(self):
        entries = []
        for page in self.chapters:
            title, body = self.pages[page]
            body = re.sub(r'<figure class="chunk"[\s\S]*?</figure>', " ", body)
            for part in re.split(r"(?=<h[12][ >])", body):
                head = re.match(r'<h[12][^>]*?(?:id="([^"]+)")?[^>]*>([\s\S]*?)</h[12]>', part)
                plain = re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]+>", " ", MARK.sub(self.tex_of, part)))).strip()
                if head and plain:
                    heading = html.unescape(re.sub(r"<[^>]+>", "", MARK.sub(self.tex_of, head[2])))
                    entries.append([page + (f"#{head[1]}" if head[1] else ""), re.sub(r"<[^>]+>", "", MARK.sub(self.tex_of, title)), heading, plain])
        return "const BOOK = " + json.dumps(entries, ensure_ascii=False) + ";\n"

    def tex_of(self, m):
        content = self.held[int(m[1])]
        return html.escape(content[0]) if isinstance(content, tuple) and isinstance(content[0], str) and len(content) == 2 and isinstance(content[1], bool) else " "

    def check_links(self, written):
        ids = {name: set(re.findall(r'\sid="([^"]+)"', text)) for name, text in written.items()}
        for name, text in written.items():
            source = f"literate_docs/{Path(name).stem}.md" if name in self.chapters else name
            for link in re.findall(r'(?:href|src)="([^"]+)"', text):
                if re.match(r"[a-z]+:", link):
                    continue
                target, _, fragment = html.unescape(link).partition("#")
                known = ids.get(target or name)
                if known is None and not (self.out / target).exists():
                    shown = link.replace(".html", ".md")
                    raise BookError(source, self.line_of(source, shown) if name in self.chapters else 0, f"dead link: {shown}")
                if fragment and known is not None and fragment not in known:
                    raise BookError(source, self.line_of(source, "#" + fragment) if name in self.chapters else 0, f"dead link: nothing is called {link}")

    # --- all ------------------------------------------------------------------------------------------------------
    def weave(self, pdf, only=None):
        errors = self.check.run()
        if errors:
            for file, line, message in errors:
                print(f"{file}:{line}: error: {message}")
            return 1
        self.out.mkdir(parents=True, exist_ok=True)
        for page in self.out.glob("*.html"):  # a build that fails leaves no page of an earlier one
            page.unlink()
        sources = sorted({f for files in self.check.chunks.values() for f in files})
        self.lines = {f: (self.root / f).read_text(encoding="utf-8").splitlines() for f in sources}
        self.copied = []
        self.name_anchors()
        for path in sorted(self.root.glob(weave.CHAPTERS)):
            if not only or path.name.startswith(f"{only}-"):
                self.chapter(path.relative_to(self.root).as_posix())
        if only:
            return self.weave_one()
        for file in sources:
            self.source(file)
        self.indices()
        self.index()
        self.render_formulas()
        self.write_files()
        written = {name: self.page(name) for name in self.pages}
        if not pdf:
            written["index.html"] = written["index.html"].replace('<p><a href="cuticle.pdf">The whole book as PDF</a></p>', "")
        else:
            (self.out / "cuticle.pdf").touch()
        self.check_links(written)
        for name, text in written.items():
            (self.out / name).write_text(text, encoding="utf-8")
        if pdf:
            self.write_pdf()
        print(f"{self.out}/index.html: {len(self.chapters)} chapters, {len(self.anchors)} chunks, {len(self.formulas)} formulas")
        return 0

    def weave_one(self):
        """The page of a single chapter, its links not checked, for they lead to pages that are not woven."""
        self.render_formulas()
        self.write_files(sweep=False)
        for name in self.chapters:
            (self.out / name).write_text(self.page(name), encoding="utf-8")
            print(f"{self.out}/{name}")
        return 0 if self.chapters else 1

    def write_files(self, sweep=True):
        for name in ("book.css", "search.js"):
            shutil.copy(HERE / name, self.out / name)
        (self.out / "search-index.js").write_text(self.search_index(), encoding="utf-8")
        (self.out / "figures").mkdir(exist_ok=True)
        for chapter, name in self.copied:
            shutil.copy(self.folder_of(chapter) / name, self.out / "figures" / self.figure_name(chapter, name))
        if sweep:
            self.sweep()
        css = next((Path(p) for p in KATEX_CSS if Path(p).exists()), None)
        fonts = next((Path(p) for p in KATEX_FONTS if Path(p).exists()), None)
        if not css or not fonts:
            raise BookError("literate_docs/book.py", 0, "KaTeX's style and letters are not installed (.ci/setup book)")
        (self.out / "katex").mkdir(exist_ok=True)
        text = css.read_text(encoding="utf-8")
        for font in sorted(set(re.findall(r"KaTeX_[\w-]+\.woff2", text))):
            (self.out / "katex" / "fonts").mkdir(exist_ok=True)
            shutil.copy(fonts / font, self.out / "katex" / "fonts" / font)
        text = re.sub(r"url\([^()]*?(KaTeX_[\w-]+\.woff2)\)", r"url(fonts/\1)", text)
        text = re.sub(r',url\([^()]*?\.(?:woff|ttf)\) format\("[a-z]+"\)', "", text)
        (self.out / "katex" / "katex.min.css").write_text(text, encoding="utf-8")

    def write_pdf(self):
        """All chapters on one page, printed by chromium without a window."""
        bodies = []
        for page in self.chapters:
            prefix = Path(page).stem
            body = re.sub(r'\sid="([^"]+)"', rf' id="{prefix}--\1"', self.pages[page][1])
            body = re.sub(r'href="#([^"]+)"', rf'href="#{prefix}--\1"', body)
            body = MARK.sub(lambda m: self.held[int(m[1])] if isinstance(self.held[int(m[1])], str) else m[0], body)
            body = re.sub(r'href="((?:\d\d|[A-Z])-[\w-]+)\.html(?:#([^"]+))?"', lambda m: f'href="#{m[1]}--{m[2]}"' if m[2] else f'href="#{m[1]}"', body)
            bodies.append(f'<section id="{prefix}">{body}</section>')
        text = self.unmark('<!doctype html><html lang="en"><head><meta charset="utf-8"><title>Cuticle</title><link rel="stylesheet" href="katex/katex.min.css">'
                           '<link rel="stylesheet" href="book.css"></head><body class="print"><h1 class="title">Cuticle</h1><p>The book of the program.</p>'
                           "<ul>" + "".join(f'<li><a href="#{Path(p).stem}">{self.pages[p][0]}</a></li>' for p in self.chapters) + "</ul>" + "".join(bodies) + "</body></html>")
        page = self.out / "print.html"
        page.write_text(text, encoding="utf-8")
        chromium = shutil.which("chromium") or shutil.which("chromium-browser")
        if not chromium:
            raise BookError("literate_docs/book.py", 0, "chromium is needed for the PDF (.ci/setup book), or --no-pdf")
        pdf = self.out / "cuticle.pdf"
        pdf.unlink(missing_ok=True)
        run = subprocess.run([chromium, "--headless", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer",
                              f"--print-to-pdf={pdf}", page.as_uri()], capture_output=True, text=True, timeout=600)
        if run.returncode != 0 or not pdf.exists() or pdf.stat().st_size < 1000:
            raise BookError("literate_docs/book.py", 0, "chromium made no PDF: " + run.stderr.strip()[-300:])


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Weave the book into HTML pages and a PDF.")
    parser.add_argument("--out", type=Path, required=True, help="folder for the pages")
    parser.add_argument("--no-pdf", action="store_true", help="HTML only: needs no chromium")
    parser.add_argument("--built", nargs="+", metavar="PROGRAM", help="programs that are up to date; without it, they are built as they are needed")
    parser.add_argument("--chapter", metavar="NN", help="weave this chapter alone, to look at while writing; others' pages are left out")
    parser.add_argument("--root", type=Path, default=HERE.parent, help="folder that holds src/ and literate_docs/")
    options = parser.parse_args(arguments)
    root = options.root.resolve()
    try:
        return Book(root, options.out.resolve(), options.built).weave(not options.no_pdf, options.chapter)
    except BookError as error:
        print(error)
        return 1


if __name__ == "__main__":
    sys.exit(main())
