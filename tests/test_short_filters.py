"""The short forms of --filter: --node, --grep and --problem."""

import json
from pathlib import Path

import click
import pytest
from captures import SAMPLES
from conftest import Runner
from test_listings import numbers

from canalyze.cli import COMMANDS, build
from canalyze.examples import FOLDER

LOST = "node-lost.log"


@pytest.fixture(autouse=True)
def lost(tmp_path: Path) -> None:
    """A capture with two problems, the second one caused by the first."""
    (tmp_path / LOST).write_bytes((FOLDER / LOST).read_bytes())


READERS = ("decode", "sdo", "signals", "summary", "view", "convert", "export")
"""Commands that read one capture and have --filter."""
SEVERAL = ("check", "expect", "diff", "fleet", "monitor", "sniff", "od")
"""Other commands that have --filter."""


def test_short_forms_are_where_a_filter_is() -> None:
    for name in COMMANDS:
        command = build("en").get_command(click.Context(click.Command("canalyze")), name)
        assert command is not None
        shown = {name for one in command.params if not getattr(one, "hidden", False) for name in one.opts}
        assert ("--filter" in shown) == (name in READERS + SEVERAL), name
        assert ("--grep" in shown) == ("--filter" in shown), name
        assert ("--problem" in shown) == (name in READERS), name
        assert "--node" in shown or "--filter" not in shown, name


@pytest.mark.parametrize(
    ("short", "expression"),
    [
        (["--node", "4"], "node=4"),
        (["--node", "0x03-4,9"], "node=3,4,9"),
        (["--grep", "Heartbeat error"], 'text="heartbeat error"'),
        (["--grep", "a,b = c"], 'text="a,b = c"'),
        (["--node", "4", "--grep", "emcy"], "node=4 text=emcy"),
        (["--node", "3", "--filter", "service=heartbeat"], "node=3 service=heartbeat"),
        (["--node", "3", "--filter", 'text="operational'], 'node=3 text="operational'),
    ],
)
@pytest.mark.parametrize("command", ["decode", "sdo", "summary", "check"])
def test_a_short_form_is_a_filter(canalyze: Runner, command: str, short: list[str], expression: str) -> None:
    form = ["--format", "jsonl", "--lang", "en"]
    done = canalyze(command, *form, *short, LOST)
    same = canalyze(command, *form, "--filter", expression, LOST)
    assert (done.code, done.out, done.err) == (same.code, same.out, same.err)
    if command == "decode" and "a,b = c" not in short:
        assert 0 < len(done.lines) < len(canalyze(command, *form, LOST).lines)


def test_short_forms_where_something_is_written(canalyze: Runner, tmp_path: Path) -> None:
    assert canalyze("convert", "--lang", "en", "--node", "3", "--grep", "boot-up", LOST, "a.log").code == 0
    assert canalyze("convert", "--lang", "en", "--filter", "node=3 text=boot-up", LOST, "b.log").code == 0
    assert (tmp_path / "a.log").read_bytes() == (tmp_path / "b.log").read_bytes() != b""


def test_a_node_of_an_inventory(canalyze: Runner) -> None:
    done = canalyze("od", "--node", "4", "--filter", "service=sdo", "--format", "jsonl", LOST)
    same = canalyze("od", "--filter", "node=4 service=sdo", "--format", "jsonl", LOST)
    assert {json.loads(line)["node"] for line in done.lines} == {4} and done.out == same.out


def test_frames_of_a_problem(canalyze: Runner) -> None:
    assert numbers(canalyze("decode", "--problem", "1", LOST).lines) == list(range(79, 89))
    assert numbers(canalyze("decode", "--problem", "2", LOST).lines) == list(range(84, 89))
    assert numbers(canalyze("decode", "--problem", "1", "--node", "3", LOST).lines) == [79, 82, 84, 87]
    done = canalyze("decode", "--problem", "1", "--format", "jsonl", "--filter", "service=emcy", LOST)
    assert {one["frame"] for one in map(json.loads, done.lines) if one["kind"] == "frame"} == {86}
    assert canalyze("decode", "--problem", "1", "--stamps", "zero", "missing.log").code == 2


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["--problem", "7", LOST], "no problem 7; problems: 1-2"),
        (["--problem", "1", str(SAMPLES / "sdo-expedited.log")], "no problem 1: no problems found"),
        (["--problem", "0", LOST], "--problem 0: expected a whole number above 0"),
        (["--problem", "1", "-"], "--problem reads files twice"),
        (["--grep", 'a "b"', LOST], '--grep a "b": expected a text without "'),
        (["--grep", "", LOST], "--grep"),
        (["--node", "5-3", LOST], "node-IDs are 1 to 127"),
        (["--node", "x", LOST], "node-IDs are 1 to 127"),
    ],
)
def test_short_forms_that_cannot_be(canalyze: Runner, args: list[str], said: str) -> None:
    done = canalyze("decode", "--lang", "en", *args)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert said in done.err


def test_signals_name_the_option_that_left_none(canalyze: Runner) -> None:
    assert "matches --node in" in canalyze("signals", "--lang", "en", "--node", "9", LOST).err
    assert (
        "matches --filter --grep in"
        in canalyze("signals", "--lang", "en", "--grep", "x", "--filter", "node=9", LOST).err
    )
