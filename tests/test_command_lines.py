"""Command lines as transcripts, a file for each command in `command_lines/`: output, standard error and exit code.

    python tests/test_command_lines.py --update            # runs the command lines of the transcripts again
    python tests/test_command_lines.py --write FOLDER      # writes longer ones elsewhere, to compare two builds

A transcript has the outline of a command's help page in both languages, its usage errors, and runs over small
captures, whose first lines count. Those elsewhere have all lines, the bytes of written files, and a wrong value for
every option. A command line is added by its line in a transcript and `--update`; the diff is to be read.
"""

from __future__ import annotations

import argparse
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final
from zlib import crc32

import click
import forked
import pytest
from conftest import environment
from page_examples import BUILT

from canalyze import cli
from canalyze.commands import examples

FOLDER: Final = Path(__file__).with_name("command_lines")
SHOWN: Final = 4
"""Lines of an output that count."""
_PAGE: Final = re.compile(r"\$ \w+: canalyze (?!.*--help)(?:page |.*--html)")
"""A command line that writes a page."""

COMMANDS: Final = (*cli.COMMANDS, *(f"{first} {part}" for first, parts in cli.PARTS.items() for part in parts))


def prepare(folder: Path) -> None:
    """Writes the captures and descriptions that the command lines name."""
    for name in examples.EXAMPLES:
        shutil.copy(examples.FOLDER / name, folder / name)
    for name, data in examples.of_pages().items():
        if "/" not in name or name.startswith("captures/"):
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_bytes(data)
    shutil.copy(folder / "mapping-refused.log", folder / "c.log")
    shutil.copy(folder / "part1.log", folder / "d.log")
    (folder / "there.log").write_text("no capture\n")
    (folder / "frames.txt").write_text("# a comment\n705#7F\n\nxyz\n")
    (folder / "good.toml").write_text("[[heartbeat]]\nnode = 5\nperiod = 1000\n")


def cases(text: str) -> list[tuple[str, str]]:
    """Returns language and arguments of each command line of a transcript."""
    return [(lang, args) for lang, args in re.findall(r"^\$ (\w+): canalyze ?(.*)$", text, re.M)]


def answerable(text: str) -> str:
    """Returns a transcript without the command lines that need the core for the page, where that is not built."""
    blocks = re.split(r"\n(?=\$ )", text)
    return "\n".join(block for block in blocks if BUILT or not _PAGE.match(block))


def wrong_values(command: str) -> Iterator[tuple[str, str]]:
    """Yields a command line with a wrong value for each option, and one without a value."""
    group = cli.build("en")
    context = click.Context(group)
    found = group.get_command(context, command)
    for option in found.params if found else ():
        if isinstance(option, click.Option):
            for name in option.opts:
                yield "zh", f"{command} {name}=1" if option.is_flag else f"{command} {name} ! c.log"
                if not option.is_flag:
                    yield "zh", f"{command} c.log {name}"


def first(lines: list[str]) -> list[str]:
    """Returns the lines of an output that count."""
    return [*lines[:SHOWN], "..."] if len(lines) > SHOWN else lines


def outline(lines: list[str]) -> list[str]:
    """Returns the headings of a help page and the names of its options; their words are in `canalyze/words`."""
    first = next(number for number, line in enumerate(lines) if number and line[:1].strip())
    kept = [lines[0]]
    for line in lines[first:]:
        named = re.match(r"  (?:-\S.*?|[a-z]+(?=  ))(?=  |$)", line)
        kept += [named[0] if named else line] if named or line[:1].strip() else []
    return kept


def transcript(command_lines: Sequence[tuple[str, str]], folder: Path, *, whole: bool = False) -> str:
    """Returns what each command line writes. whole: all of it, files too."""
    blocks = []
    for lang, line in command_lines:
        (folder / "out").mkdir(exist_ok=True)
        args, _, name = line.partition("< ")
        stdin = (folder / name).read_bytes() if name else b""
        env = environment(CANALYZE_LANG=lang, XDG_CONFIG_HOME="/dev/null")
        done = forked.run(args.split(), stdin=stdin, cwd=folder, env=env, timeout_s=120, kept=True)
        lines = done.stdout.decode("utf-8", "replace").splitlines()
        if not whole:
            lines = outline(lines) if line.endswith("--help") else first(lines)
        lines += [f"! {one}" for one in done.stderr.decode("utf-8", "replace").splitlines()]
        for path in sorted(path for path in (folder / "out").rglob("*") if path.is_file()):
            opaque = not whole or path.suffix in (".rrd", ".html", ".gz", ".xml")
            shown = path.relative_to(folder)
            if "_manifest" in shown.parts or (opaque and "fleet" in line):
                continue
            lines.append(f"> {shown}" if opaque else f"> {shown} {crc32(path.read_bytes()):08x}")
        shutil.rmtree(folder / "out")
        text = "".join(f"{one}\n" for one in lines).replace(str(folder), "FOLDER")
        text = re.sub(r"0x[0-9a-f]{8,}|\d+\.\d MB|tmp\w{6,}", "...", text)
        blocks.append(f"$ {lang}: canalyze {line}\n{text}[{done.returncode}]\n")
    return "\n".join(blocks)


def rerun(path: Path, *, whole: bool = False) -> str:
    """Returns a transcript with the answers of today; whole: with all that these are, and with wrong values."""
    with tempfile.TemporaryDirectory(prefix="canalyze-") as name:
        prepare(Path(name))
        lines = cases(answerable(path.read_text("utf-8")))
        if whole and path.stem != "canalyze":
            lines += wrong_values(path.stem.replace("-", " "))
        return transcript(lines, Path(name), whole=whole)


@pytest.mark.parametrize("path", sorted(FOLDER.iterdir()), ids=lambda path: path.stem)
def test_command_lines_answer_as_before(path: Path) -> None:
    assert rerun(path) == answerable(path.read_text("utf-8"))


def test_every_command_has_a_transcript_with_its_help() -> None:
    """In both languages; and one is of the program without a command."""
    assert {path.stem.replace("-", " ") for path in FOLDER.iterdir()} == {*COMMANDS, "canalyze"}
    for command in COMMANDS:
        lines = cases((FOLDER / f"{command.replace(' ', '-')}.txt").read_text("utf-8"))
        assert {("en", f"{command} --help"), ("zh", f"{command} --help")} <= set(lines)


def main() -> int:
    """Writes transcripts; returns the exit code."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--update", action="store_true")
    parser.add_argument("--write", type=Path)
    parser.add_argument("commands", nargs="*")
    asked = parser.parse_args()
    if not asked.update and asked.write is None:
        parser.error("--update or --write FOLDER")
    if not BUILT:
        parser.error("some command lines need the core for the page, which .ci/web builds")
    target = asked.write or FOLDER
    target.mkdir(exist_ok=True, parents=True)
    for path in sorted(FOLDER.iterdir()):
        if path.stem in (asked.commands or path.stem):
            (target / path.name).write_text(rerun(path, whole=asked.write is not None), "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
