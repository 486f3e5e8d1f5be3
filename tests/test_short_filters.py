"""The short forms of --filter: --node, --grep and --problem."""

from pathlib import Path

import click
import pytest
from conftest import Runner

from canalyze.cli import COMMANDS, build
from canalyze.commands.examples import FOLDER

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
