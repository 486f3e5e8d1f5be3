"""Sessions on a console: command lines with all that they write, in text files below `console/`.

    python tests/console.py [FILE...]     # runs them again and writes what is answered today; read the diff

Each section is a test of its own, which begins in a folder with links to `samples`, `eds` and `data`; what comes before
the first section of a file is done at the beginning of each:

    == title
    # What is to be seen.
    $ cat >a.log <<.
    > (1.000000) can0 705#00
    > .
    $ canalyze check a.log | head -n 2
    (standard output)
    ! (standard error)
    [1]

`canalyze` runs in English, in a fork; what else there is runs in a shell. `<FILE` is the standard input, NAME=VALUE
before the command a variable (FOLDER in it is where it runs), `| pick [KEY=VALUE...] KEY...` shows these keys of the
JSON lines that have these values, and `[1]` is the exit code of the command, where that is not 0.
"""

from __future__ import annotations

import difflib
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import forked
import pytest
from conftest import environment

FOLDER: Final = Path(__file__).with_name("console")
_ROOT: Final = FOLDER.parent.parent
_HEADING: Final = re.compile(r"^== (.+)\n", re.MULTILINE)
_CONTROL: Final = re.compile("[\0-\x08\x0b-\x1f\x7f]")
_VARIABLE: Final = re.compile(r"(\w+)=(\S*) ")


@dataclass(slots=True)
class Step:
    """A command line of a session, the comment before it, the lines that it is given, and its answer."""

    line: str
    comment: list[str]
    given: list[str] = field(default_factory=list)
    answer: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        return "".join(f"{line}\n" for line in (*self.comment, f"$ {self.line}", *self.given, *self.answer))


def steps(text: str) -> list[Step]:
    """Returns the command lines of a section."""
    found: list[Step] = []
    before: list[str] = []
    for line in text.splitlines():
        if line.startswith("$ "):
            comment: list[str] = []
            while before and before[-1].startswith("# "):
                comment.insert(0, before.pop())
            while before and not before[-1]:
                before.pop()
            found.append(Step(line[2:], comment))
            before = found[-1].answer
        elif line.startswith("> ") and found and not before:
            found[-1].given.append(line)
        else:
            before.append(line)
    while before and not before[-1]:
        before.pop()
    return found


def written(steps: list[Step]) -> str:
    """Returns the text of a section; a blank line follows each answer."""
    return "\n".join("".join(map(str, part)).rstrip("\n") + "\n" if part else "" for part in _parts(steps))


def _parts(steps: list[Step]) -> Iterator[list[Step]]:
    part: list[Step] = []
    for step in steps:
        part.append(step)
        if step.answer:
            yield part
            part = []
    if part:
        yield part


def sections(text: str) -> tuple[list[Step], list[tuple[str, list[Step]]]]:
    """Returns what each section begins with, and the sections by their titles."""
    first, *rest = _HEADING.split(text)
    return steps(first), [(title, steps(body)) for title, body in zip(rest[::2], rest[1::2], strict=True)]


def answered(beginning: list[Step], session: list[Step]) -> list[Step]:
    """Returns the session with the answers of today."""
    with tempfile.TemporaryDirectory(prefix="canalyze-") as name:
        folder = Path(name)
        for linked in ("samples", "eds", "tests/data"):
            (folder / Path(linked).name).symlink_to(_ROOT / linked)
        for step in beginning:
            assert _answer(step, folder) == [], step.line
        return [Step(step.line, step.comment, step.given, _answer(step, folder)) for step in session]


def _answer(step: Step, folder: Path) -> list[str]:
    line, *filters = step.line.split(" | ")
    env = {"CANALYZE_LANG": "en", "XDG_CONFIG_HOME": os.devnull}
    while match := _VARIABLE.match(line):
        env[match[1]] = match[2].replace("FOLDER", str(folder))
        line = line[match.end() :]
    if line.startswith("canalyze"):
        line, _, name = line.partition(" <")
        stdin = (folder / name).read_bytes() if name else b""
        words, env = shlex.split(line)[1:], environment(**env)
        done = forked.run(words, stdin=stdin, cwd=folder, env=env, timeout_s=120, kept=True)
    else:
        line = line.replace("<<.", "<<'.'")
        given = "".join(f"\n{text[2:]}" for text in step.given)
        done = _shell(" | ".join([line, *filters]) + given, b"", folder)
        filters = []
    out = done.stdout
    for one in filters:
        out = _picked(out, shlex.split(one)[1:]) if one.startswith("pick ") else _shell(one, out, folder).stdout
    said = [_shown(out, folder), *(f"! {text}" for text in _shown(done.stderr, folder).splitlines())]
    lines = [text for part in said for text in part.splitlines()]
    assert not [text for text in lines if text.startswith(("$ ", "== "))] and lines[:1] != [""], (
        "this cannot be read again"
    )
    return [*lines, f"[{done.returncode}]"] if done.returncode else lines


def _shell(line: str, stdin: bytes, folder: Path) -> subprocess.CompletedProcess[bytes]:
    env = os.environ | {"LC_ALL": "C"}
    return subprocess.run(["sh", "-c", line], input=stdin, capture_output=True, cwd=folder, env=env, timeout=120)


def _shown(text: bytes, folder: Path) -> str:
    shown = text.decode("utf-8", "backslashreplace").replace(str(folder), "FOLDER").replace(f"{_ROOT}/", "")
    return _CONTROL.sub(lambda match: f"\\x{ord(match[0]):02x}", shown)


def _picked(text: bytes, words: list[str]) -> bytes:
    wanted = [word.partition("=")[::2] for word in words if "=" in word]
    keys = [word for word in words if "=" not in word]
    shown = []
    for line in text.splitlines():
        row = json.loads(line)
        if all(str(row.get(key)) in value.split(",") for key, value in wanted):
            shown.append(" ".join(json.dumps(_at(row, key.split(".")), ensure_ascii=False) for key in keys) + "\n")
    return "".join(shown).encode()


def _at(value: Any, path: list[str]) -> Any:
    if not path:
        return value
    if isinstance(value, list):
        return [_at(one, path) for one in value]
    return _at(value[path[0]], path[1:])


class Section(pytest.Item):
    """A section of a file of sessions, as a test."""

    beginning: list[Step]
    body: list[Step]

    def runtest(self) -> None:
        """Fails with the difference where the answers are others than those that are written."""
        now = written(answered(self.beginning, self.body))
        before = written(self.body)
        if now != before:
            diff = difflib.unified_diff(before.splitlines(), now.splitlines(), "written", "now", lineterm="")
            pytest.fail("\n".join(diff), pytrace=False)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Returns the file and the title."""
        return self.path, None, self.name


class File(pytest.File):
    """A file of sessions."""

    def collect(self) -> Iterator[Section]:
        """Yields its sections."""
        beginning, found = sections(self.path.read_text("utf-8"))
        for title, session in found:
            section = Section.from_parent(self, name=title)
            section.beginning, section.body = beginning, session
            yield section


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> File | None:
    """Takes files of sessions as tests."""
    return File.from_parent(parent, path=file_path) if file_path.parent == FOLDER else None


def rerun(path: Path) -> str:
    """Returns a file with the answers of today."""
    text = path.read_text("utf-8")
    beginning, found = sections(text)
    first = text.partition("== ")[0]
    parts = [f"== {title}\n{written(answered(beginning, session))}" for title, session in found]
    return (first.rstrip("\n") + "\n\n" if first else "") + "\n".join(parts)


if __name__ == "__main__":
    for path in [Path(name) for name in sys.argv[1:]] or sorted(FOLDER.iterdir()):
        path.write_text(rerun(path), "utf-8")
