"""The pages for users as what can be run: their fenced blocks, executed in a folder with the files that they name.

What a block is, the words behind its fence tell:

    console           `$ COMMAND` lines and what each prints; `rewritten` puts there what it prints now
    sh                commands; each must succeed (or end with 1, as a check that found something)
    sh live           commands that need a bus, a window or another program: only their options are looked at
    python            a program that must run
    KIND FILE         the content of a file that later blocks use; where FILE is in samples/, it is that of the sample
    text, yaml, ...   anything else: not run

    text samples/F:A-B  lines of a sample

`test_pages.py` keeps the blocks of both languages alike, so what shows nothing runs for the English page alone; for the
Chinese one only where a listing follows, which may need it.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import forked
from captures import SAMPLES

from canalyze import html
from canalyze.commands import examples
from canalyze.commands.examples import EXAMPLES, of_pages
from canalyze.pages import FOLDER
from canalyze.words import LANGUAGES

ROOT = SAMPLES.parent
README = ROOT / "README.md"
PAGES = [README, *sorted(path for lang in LANGUAGES for path in (FOLDER / lang).glob("*.md"))]
"""Every page for users."""

BUILT = html.WASM.exists() and os.environ.get("CANALYZE_WEB") != "later"
"""The core for the page is there, and is not being built at this moment."""
_FENCE = re.compile(r"^```(\w+)?((?: [^\n]+)?)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_SHELL = frozenset("|&;<>*?$`~{}()\\\n")
"""Characters that a shell has to look at."""
_DUCKDB = "import sys, duckdb; print(str(duckdb.sql(sys.stdin.read())).strip())"


@dataclass(frozen=True)
class Block:
    """A fenced block."""

    kind: str
    words: str
    """What stands behind the kind."""
    text: str
    start: int
    end: int
    """Where its text is in the page."""

    @property
    def live(self) -> bool:
        return self.words == "live"

    @property
    def writes_page(self) -> bool:
        """Returns true if it needs the core for the page."""
        return re.search(r"--html\b|\.html\(|\bcanalyze page\b", self.text) is not None

    @property
    def file(self) -> str | None:
        """The file whose content it is."""
        return self.words if "." in self.words else None

    def commands(self) -> list[str]:
        """The command lines, a continued one joined."""
        joined = self.text.replace("\\\n", " ")
        if self.kind == "console":
            return [line[2:] for line in joined.splitlines() if line.startswith("$ ")]
        if self.kind == "sh":
            return [line for line in joined.splitlines() if line.strip() and not line.startswith("#")]
        if self.kind == "yaml":
            return re.findall(r"(?:run: |- )(canalyze .+)", joined)
        return []


def language(page: Path) -> str:
    """The language of a page."""
    return "zh" if page.parent.name == "zh" else "en"


def blocks(text: str) -> list[Block]:
    """The fenced blocks of a page."""
    return [
        Block(match[1] or "", match[2].strip(), match[3], match.start(3), match.end(3))
        for match in _FENCE.finditer(text)
    ]


def invocations(line: str) -> Iterator[list[str]]:
    """The arguments of every `canalyze` in a command line: pipes and lists of commands are taken apart."""
    lexer = shlex.shlex(line, posix=True, punctuation_chars="|&;<>")
    lexer.whitespace_split = True
    lexer.commenters = "#" if " #" in line else ""
    found: list[str] | None = None
    for token in lexer:
        if token == "canalyze" and found is None:
            found = []
        elif set(token) <= set("|&;<>"):
            if found is not None:
                yield found
            found = None
        elif found is not None:
            found.append(token)
    if found is not None:
        yield found


def workspace(folder: Path) -> None:
    """Put the files that `canalyze examples --pages` writes into a folder, and the commands into its bin/."""
    for name, data in ({name: (examples.FOLDER / name).read_bytes() for name in EXAMPLES} | of_pages()).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    (folder / "bin").mkdir()
    for name, module in (("canalyze", "canalyze"), ("pytest", "pytest -p no:cacheprovider")):
        script = folder / "bin" / name
        script.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m {module} "$@"\n')
        script.chmod(0o755)
    # As its command line, of which the package for Python has none.
    script = folder / "bin" / "duckdb"
    script.write_text(f'#!/bin/sh\nexec "{sys.executable}" -c "{_DUCKDB}"\n')
    script.chmod(0o755)


def environment(folder: Path, lang: str) -> dict[str, str]:
    """The environment in which examples run: a user of this language, no colours, a terminal of 100 columns."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("CANALYZE", "PYTEST", "COV"))}
    path = f"{folder / 'bin'}{os.pathsep}{os.environ.get('PATH', '')}"
    ours = {
        "PATH": path,
        "PYTHONPATH": str(ROOT),
        "CANALYZE_LANG": lang,
        "NO_COLOR": "1",
        "COLUMNS": "100",
        "TZ": "UTC",
    }
    return kept | ours | {"PYTHONIOENCODING": "utf-8"}


class Failed(AssertionError):
    """An example does not run."""


def rewritten(page: Path) -> str:
    """The page as it should be: with what its commands print now. Failed where an example does not run.

    What writes the page for browsers stays as it is while there is no core for it.
    """
    text = page.read_text(encoding="utf-8")
    lang = language(page)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        workspace(folder)
        done, at = "", 0
        found = blocks(text)
        listings = sum(block.kind == "console" for block in found)
        for block in found:
            listings -= block.kind == "console"
            done, at = done + text[at : block.start] + _run(block, folder, lang, needed=listings > 0), block.end
        return done + text[at:]


def _run(block: Block, folder: Path, lang: str, *, needed: bool) -> str:
    """Runs a block and returns the text that belongs there. `needed`: a listing follows."""
    if block.live or (block.writes_page and not BUILT):
        return block.text
    skipped = lang == "zh" and (block.kind == "python" or not needed)
    if block.file is not None:
        if block.file.startswith("samples/"):
            name, first, last = re.split("[:-](?=[0-9]+(?:-|$))", block.file)
            lines = (ROOT / name).read_text(encoding="utf-8").splitlines(keepends=True)
            return "".join(lines[int(first) - 1 : int(last)])
        (folder / block.file).write_text(block.text, encoding="utf-8")
    elif block.kind == "python" and not skipped:
        _said([sys.executable, "-c", block.text], folder, lang)
    elif block.kind == "sh" and not skipped:
        for line in block.commands():
            _said(_command(line, "-o", "pipefail"), folder, lang)
    elif block.kind == "console":
        return "".join(f"$ {line}\n{_said(_command(line), folder, lang)}" for line in _console(block))
    return block.text


def _console(block: Block) -> list[str]:
    """Its commands as they are written, with their continued lines."""
    return re.findall(r"^\$ ((?:.*\\\n)*.*)$", block.text, re.MULTILINE)


def _command(line: str, *options: str) -> list[str]:
    """The program that runs a command line: canalyze itself, or a shell with these options where the line needs one."""
    if line.startswith("canalyze ") and not _SHELL & set(line):
        return shlex.split(line, comments=True)
    return ["bash", *options, "-c", line]


def _said(command: list[str], folder: Path, lang: str) -> str:
    env = environment(folder, lang)
    if command[0] == "canalyze":
        others = {name: value for name, value in env.items() if not name.startswith(forked.OF_PYTHON)}
        ours = others | forked.of_python(os.environ)
        done = forked.run(command[1:], cwd=folder, env=ours, timeout_s=120, kept=True)
    else:
        done = subprocess.run(command, cwd=folder, env=env, stdin=subprocess.DEVNULL, capture_output=True, check=False)
    if done.returncode not in ((0,) if command[-1].startswith("pytest") else (0, 1)):
        raise Failed(f"{command[-1]}\nends with {done.returncode}: {done.stderr.decode()}")
    if done.returncode == 1 and b"Traceback" in done.stderr:
        raise Failed(f"{command[-1]}\n{done.stderr.decode()}")
    said = (done.stdout + done.stderr).decode()
    return "\n".join(line.rstrip() for line in said.splitlines()) + "\n" if said else ""
