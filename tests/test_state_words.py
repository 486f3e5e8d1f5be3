"""One word for one state: what a node is in after its boot-up message, wherever it is said.

CiA 301, 7.3.2: with the boot-up message a node has left Initialisation and is Pre-operational. What it must not do: say
when a state begins or ends.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from captures import session_output
from conftest import Runner
from mcap.reader import make_reader

from canalyze import _core
from canalyze.running.reading import SessionOptions

BOOTED = b"(1700000000.000000) can0 705#00\n"


FIXED = "Pre-operational (boot-up)"
"""What machines read, in every language."""


@pytest.mark.parametrize(("lang", "word"), [("zh", "启动(Boot-up)"), ("en", FIXED)])
def test_after_the_boot_up(lang: str, word: str, canalyze: Runner, tmp_path: Path) -> None:
    (row,) = session_output([BOOTED], output_format="jsonl", lang=lang).splitlines()
    assert json.loads(row)["heartbeat"]["name"] == FIXED
    assert word in session_output([BOOTED], output_format="summary", lang=lang).decode()

    session = _core.Session(SessionOptions(lang=lang, format="columns", tables=["lanes", "states"]))
    session.begin("boot.log", True, "candump")
    session.feed(BOOTED)
    session.end()
    session.finish()
    batches = dict(session.batches())
    assert batches["lanes"].column("state") == [word]
    assert batches["lanes"].column("class") == ["pre-operational"]
    assert batches["states"].column("name") == [word]

    (tmp_path / "boot.log").write_bytes(BOOTED)
    assert word in canalyze("--lang", lang, "summary", "boot.log").out
    assert FIXED in canalyze("--lang", lang, "decode", "--format", "jsonl", "boot.log").out
    done = canalyze("--lang", lang, "convert", "--decoded", "boot.log", "boot.mcap")
    assert done.code == 0, done.err
    with (tmp_path / "boot.mcap").open("rb") as file:
        data = [
            one.data for _, topic, one in make_reader(file).iter_messages() if topic.topic == "/can0/node5/nmt_state"
        ]
    assert len(data) == 1
    assert word.encode() in data[0]


@pytest.mark.parametrize(("lang", "word"), [("zh", "初始化 (已命令)"), ("en", "Initialisation (commanded)")])
def test_after_a_reset(lang: str, word: str) -> None:
    """Until it boots again."""
    session = _core.Session(SessionOptions(lang=lang, format="columns", tables=["lanes"]))
    session.begin("reset.log", True, "candump")
    session.feed(b"(1.000000) can0 705#7F\n(2.000000) can0 000#8105\n(3.000000) can0 705#00\n")
    session.end()
    session.finish()
    ((_, lanes),) = session.batches()
    assert lanes.column("state")[1] == word
    assert lanes.column("class") == ["pre-operational", "initialising", "pre-operational"]
