"""What all listings have in common: colours, numbers of frames, filters, one zero of time, one language of names."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import pytest
from captures import SAMPLES
from conftest import Runner, runner
from test_cli_terminal import on_terminal

from canalyze import _core
from canalyze.records import SEVERITIES, Severity

PROBLEMS = str(SAMPLES / "problems.log")
ESCAPES = re.compile(r"\x1b\[[0-9;]*m")
NUMBER = re.compile(r" *([0-9]+):  ")
SHOWING = (["decode"], ["check"], ["summary"], ["sdo"], ["diagnose"])


@pytest.fixture
def canalyze(tmp_path: Path) -> Runner:
    """One process runs all of them: there are many, and they only read and write."""
    return runner(tmp_path, kept=True)


def numbers(lines: list[str]) -> list[int]:
    return [int(found[1]) for line in lines if (found := NUMBER.match(line))]


# Colours.


@pytest.mark.parametrize("args", SHOWING, ids=lambda args: args[0])
@pytest.mark.parametrize("lang", ["zh", "en"])
def test_colours_change_no_character(canalyze: Runner, args: list[str], lang: str) -> None:
    plain = canalyze(*args, "--lang", lang, PROBLEMS)
    coloured = canalyze(*args, "--lang", lang, "--color", "always", PROBLEMS)
    assert "\x1b" not in plain.out
    assert "\x1b[" in coloured.out
    assert ESCAPES.sub("", coloured.out) == plain.out
    assert coloured.code == plain.code


@pytest.mark.parametrize(
    ("env", "coloured"),
    [
        ({}, True),
        ({"NO_COLOR": "1"}, False),
        ({"NO_COLOR": ""}, True),
        ({"TERM": "dumb"}, False),
        ({"CLICOLOR": "0"}, False),
        ({"NO_COLOR": "1", "FORCE_COLOR": "1"}, False),
        ({"TERM": "dumb", "FORCE_COLOR": "1"}, True),
    ],
)
def test_colours_on_a_terminal(tmp_path: Path, env: dict[str, str], coloured: bool) -> None:
    given = {"TERM": "xterm-256color"} | env
    code, shown = on_terminal(tmp_path, "decode", "--frame", "77", PROBLEMS, only_err=False, **given)
    assert (code, b"\x1b[" in shown) == (0, coloured)


def test_findings_have_the_colour_of_their_severity(canalyze: Runner) -> None:
    lines = canalyze("decode", "--lang", "en", "--color", "always", PROBLEMS).lines
    for severity in SEVERITIES:
        found = [line for line in lines if re.search(rf"[A-Z]{{3}}[0-9]{{3}} {severity}:", line)]
        assert found and all(line.startswith(_core.COLOURS[severity]) for line in found), severity


# Numbers, and what is around them.


def test_each_frame_has_its_number(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    done = canalyze("decode", "-n", notes)
    assert numbers(done.lines) == list(range(1, 11))
    assert [NUMBER.sub("", line) for line in done.lines] == canalyze("decode", notes).lines
    bare = tmp_path / "bare.txt"  # no stamps and no buses: nothing but the colon tells that the number is none
    bare.write_text("60A#4008100000000000\n58A#4108100017000000\n")
    (tmp_path / "numbered.txt").write_text(canalyze("decode", "-n", "bare.txt").out)
    assert canalyze("decode", "numbered.txt").out == canalyze("decode", "bare.txt").out


def test_frames_that_findings_cite_are_found(canalyze: Runner) -> None:
    whole = canalyze("decode", "-n", "--lang", "en", PROBLEMS).lines
    cited = {int(found[1]) for line in whole if (found := re.match(r"#   [A-Z]{3}\d{3} .*: frame (\d+) ", line))}
    assert cited
    for frame in cited:
        done = canalyze("decode", "--lang", "en", "--around", f"{frame}:3", PROBLEMS)
        assert numbers(done.lines) == list(range(frame - 3, frame + 4))
        assert set(done.lines) <= set(whole)


# Filters.


def frames(canalyze: Runner, expression: str, *more: str) -> list[dict[str, Any]]:
    done = canalyze("decode", "--lang", "en", "--format", "jsonl", "--filter", expression, *more, PROBLEMS)
    assert done.code == 0, done.err
    return [line for line in map(json.loads, done.lines) if line["kind"] == "frame"]


EVERY = "frame=1-4294967295"


@pytest.mark.parametrize(
    ("expression", "fits"),
    [
        ("object=1017", lambda one: one["service"] == "sdo" and one["sdo"]["index"] == "1017"),
        ("object=1016h:01,0x1017", lambda one: one["service"] == "sdo" and one["sdo"]["index"] in ("1016", "1017")),
        ("object=1000-1016", lambda one: one["service"] == "sdo" and one["sdo"]["index"] == "1016"),
        ("code=HBT001", lambda one: "HBT001" in one["findings"]),
        ("code=emc,NMT", lambda one: any(code[:3] in ("EMC", "NMT") for code in one["findings"])),
        ("code=EMC node=0x4", lambda one: one["node"] == 4 and any(code[:3] == "EMC" for code in one["findings"])),
        ("node=0x3-0x04", lambda one: one["node"] in (3, 4)),
        ("text=BOOT-UP", lambda one: "boot-up" in one["text"].lower()),
        ('text="boot-up of node 4","of node 9"', lambda one: re.search("boot-up of node 4|of node 9", one["text"])),
    ],
)
def test_filters(canalyze: Runner, expression: str, fits: Any) -> None:
    wanted = [one["frame"] for one in frames(canalyze, EVERY) if fits(one)]
    shown = [one["frame"] for one in frames(canalyze, expression)]
    if expression.startswith("text="):  # also what is found at a frame is said of it
        assert set(wanted) <= set(shown) and len(shown) < 175
    else:
        assert shown == wanted
    assert wanted


def test_filter_by_severity(canalyze: Runner) -> None:
    found = [json.loads(line) for line in canalyze("check", "--format", "jsonl", "--fail-on", "info", PROBLEMS).lines]
    of = {rule.code: rule.severity for rule in _core.rules("en")}
    for severity in SEVERITIES:
        shown = {code for one in frames(canalyze, f"severity={severity}") for code in one["findings"]}
        assert any(of[code] == severity for code in shown)
        done = canalyze("check", "--format", "jsonl", "--fail-on", "info", "--filter", f"severity={severity}", PROBLEMS)
        lines = [json.loads(line) for line in done.lines]
        kept = [line["code"] for line in lines if line["kind"] == "finding"]
        assert kept == [one["code"] for one in found if one["kind"] == "finding" and one["severity"] == severity]


# One language of names.

TEXTS = {"text", "message", "state_text", "meaning", "cause", "title", "reason", "reasons", "error"}
"""Keys whose values are for people, in the language that is asked for."""
NETWORKS = sorted((SAMPLES / "network").glob("*.log"))
CAPTURES = [*sorted(SAMPLES.glob("*.log")), *NETWORKS, *sorted((SAMPLES / "stories").glob("*.log"))[:4]]
MACHINE = (
    ["decode", "--format", "jsonl", "--problems"],
    ["sdo", "--format", "jsonl"],
    ["sdo", "--format", "csv"],
    ["signals", "--format", "jsonl"],
    ["signals", "--format", "csv"],
    ["summary", "--format", "jsonl", "--bitrate", "500k"],
    ["check", "--format", "jsonl", "--problems", "open"],
    ["diagnose", "--format", "jsonl"],
    ["info", "--format", "jsonl"],
)


def leaves(value: object, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], object]]:
    """Give every value with the keys that lead to it."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(inner, (*path, key))
    elif isinstance(value, list):
        for inner in value:
            yield from leaves(inner, (*path, "[]"))
    else:
        yield path, value


def differing(zh: str, en: str) -> set[str]:
    """Give the keys whose values differ between two outputs of JSON lines; their shape must not."""
    found = set()
    for line, other in itertools.zip_longest(zh.splitlines(), en.splitlines()):
        pairs = itertools.zip_longest(leaves(json.loads(line)), leaves(json.loads(other)))
        for one, two in pairs:
            assert one and two and one[0] == two[0], (line, other)
            if one[1] != two[1]:
                found.add(next(key for key in reversed(one[0]) if key != "[]"))
    return found


@pytest.mark.parametrize("args", MACHINE, ids=" ".join)
def test_machine_output_is_the_same_in_every_language(canalyze: Runner, args: list[str]) -> None:
    found = set[str]()
    for capture in CAPTURES:
        zh, en = (canalyze(*args, "--lang", lang, str(capture)) for lang in ("zh", "en"))
        assert zh.code == en.code
        if "csv" in args:
            assert zh.out == en.out
        else:
            found |= differing(zh.out, en.out)
    assert found <= TEXTS, found - TEXTS
    assert "csv" in args or args[0] in ("info", "signals") or found, "a test that cannot fail"


def test_other_machine_output_is_the_same_in_every_language(canalyze: Runner) -> None:
    two = [str(SAMPLES / name) for name in ("problems.log", "services.log")]
    eds = str(next(iter(sorted(Path(__file__).parent.parent.glob("eds/*.eds")))))
    for args in (["rules"], ["diff", *two], ["eds", eds]):
        zh, en = (canalyze(*args, "--format", "jsonl", "--lang", lang).out for lang in ("zh", "en"))
        assert zh and differing(zh, en) <= TEXTS


def test_lists_are_those_of_the_core() -> None:
    assert list(get_args(Severity)) == list(SEVERITIES) == _core.SEVERITIES
    assert set(_core.SEVERITIES) <= set(_core.COLOURS)
    assert len(_core.SERVICES) == len(set(_core.SERVICES)) and {"sdo", "heartbeat"} <= set(_core.SERVICES)
