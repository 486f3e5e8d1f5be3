"""What all listings have in common: colours, numbers of frames, filters, one zero of time, one language of names."""

from __future__ import annotations

import csv
import io
import itertools
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import pytest
from captures import SAMPLES
from conftest import Runner
from test_cli_terminal import on_terminal

from canalyze import _core
from canalyze.records import SEVERITIES, Severity

PROBLEMS = str(SAMPLES / "problems.log")
ESCAPES = re.compile(r"\x1b\[[0-9;]*m")
NUMBER = re.compile(r" *([0-9]+):  ")
SHOWING = (["decode"], ["check"], ["summary"], ["sdo"], ["diagnose"])


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


@pytest.mark.parametrize(
    ("env", "coloured"),
    [({}, False), ({"FORCE_COLOR": "1"}, True), ({"CLICOLOR_FORCE": "1"}, True), ({"FORCE_COLOR": "0"}, False)],
)
def test_colours_in_a_pipe_are_forced(canalyze: Runner, env: dict[str, str], coloured: bool) -> None:
    assert ("\x1b" in canalyze("decode", PROBLEMS, env=env).out) == coloured


def test_the_option_goes_before_the_environment(canalyze: Runner, tmp_path: Path) -> None:
    assert "\x1b" in canalyze("decode", "--color", "always", PROBLEMS, env={"NO_COLOR": "1"}).out
    assert "\x1b" not in canalyze("decode", "--color", "never", PROBLEMS, env={"FORCE_COLOR": "1"}).out
    files = [tmp_path / name for name in ("forced.txt", "always.txt")]
    canalyze("decode", "-o", str(files[0]), PROBLEMS, env={"FORCE_COLOR": "1"})
    canalyze("decode", "-o", str(files[1]), "--color", "always", PROBLEMS)
    assert ["\x1b" in file.read_text() for file in files] == [False, True]


@pytest.mark.parametrize(("command", "form"), [("decode", "jsonl"), ("sdo", "csv"), ("check", "jsonl")])
def test_machine_output_has_no_colours(canalyze: Runner, command: str, form: str) -> None:
    assert "\x1b" not in canalyze(command, "--format", form, "--color", "always", PROBLEMS).out


def test_findings_have_the_colour_of_their_severity(canalyze: Runner) -> None:
    lines = canalyze("decode", "--lang", "en", "--color", "always", PROBLEMS).lines
    for severity in SEVERITIES:
        found = [line for line in lines if re.search(rf"[A-Z]{{3}}[0-9]{{3}} {severity}:", line)]
        assert found and all(line.startswith(_core.COLOURS[severity]) for line in found), severity


def test_coloured_lines_are_read_again(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "coloured.txt").write_text(canalyze("decode", "-n", "--color", "always", PROBLEMS).out)
    assert canalyze("decode", "coloured.txt").out == canalyze("decode", PROBLEMS).out


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


def test_frames_beyond_the_end(canalyze: Runner) -> None:
    for option, value, span in (("--around", "99999:1", "99998-100000"), ("--frame", "5000-5001", "5000-5001")):
        done = canalyze("decode", "--lang", "en", option, value, "--frame", "3", PROBLEMS)
        assert (done.code, len(done.lines)) == (0, 1)
        assert done.err == f"canalyze: no frame {span}: the capture has frames 1-175\n"


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["--frame", "5000"], "no frame 5000: the capture has frames 1-175"),
        (["--around", "99999:1", "--filter", "node=9"], "no frame 99998-100000: the capture has frames 1-175"),
        (["--frame", "5000", "--frame", "6000-6001"], "no frame 5000, 6000-6001: the capture has frames 1-175"),
        (["--filter", "frame=5000"], "no frame 5000: the capture has frames 1-175"),
        (["--frame", "3-4", "--filter", "node=99"], "no frame matches the filter (175 frames)"),
        (["--frame", "3-4", "--frame", "5000", "--filter", "node=99"], "no frame matches the filter (175 frames)"),
    ],
)
def test_one_line_says_why_nothing_is_shown(canalyze: Runner, args: list[str], said: str) -> None:
    done = canalyze("decode", "--lang", "en", *args, PROBLEMS)
    assert (done.code, done.out, done.err) == (0, "", f"canalyze: {said}\n")


@pytest.mark.parametrize(
    ("args", "wanted"),
    [
        (["--around", "100"], [*range(90, 111)]),
        (["--around", "2:4"], [*range(1, 7)]),
        (["--around", "100:0", "--around", "5:1"], [4, 5, 6, 100]),
        (["--frame", "7"], [7]),
        (["--frame", "7-9", "--frame", "20-21"], [7, 8, 9, 20, 21]),
        (["--frame", "170-900"], [*range(170, 176)]),
        (["--frame", "1-20", "--filter", "node=3"], [1, 5, 6]),
    ],
)
def test_parts_of_a_capture(canalyze: Runner, args: list[str], wanted: list[int]) -> None:
    done = canalyze("decode", *args, PROBLEMS)
    shown = numbers(done.lines)
    assert (done.code, shown[: len(wanted)]) == (0, wanted)
    lines = [json.loads(line) for line in canalyze("decode", *args, "--format", "jsonl", PROBLEMS).lines]
    assert [line["frame"] for line in lines if line["kind"] == "frame"] == shown


def test_a_part_says_what_the_whole_says(canalyze: Runner) -> None:
    """State is tracked over all frames, also those that are not shown."""
    whole = canalyze("decode", "-n", PROBLEMS).lines
    part = canalyze("decode", "--frame", "130-140", PROBLEMS).lines
    start = next(place for place, line in enumerate(whole) if NUMBER.match(line) and numbers([line]) == [130])
    assert part[-1].startswith("#   第134帧: 1条后果")  # what is known at the end
    assert part[:-1] == whole[start : start + len(part) - 1] and len(part) > 11


@pytest.mark.parametrize(
    "args",
    [
        ["--around", "0"],
        ["--around", "x"],
        ["--around", "5:"],
        ["--around", "5:-1"],
        ["--frame", "9-7"],
        ["--frame", "0-7"],
        ["--frame", "7-"],
        ["--frame", ""],
        ["-n", "--format", "jsonl"],
    ],
)
def test_parts_that_cannot_be(canalyze: Runner, args: list[str]) -> None:
    done = canalyze("decode", *args, PROBLEMS)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert args[0] in done.err or "--number" in done.err


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


def test_filters_of_transfers(canalyze: Runner) -> None:
    def shown(expression: str) -> list[tuple[int, str]]:
        done = canalyze("sdo", "--format", "jsonl", "--filter", expression, PROBLEMS)
        return [(line["node"], line["index"]) for line in map(json.loads, done.lines)]

    assert shown("object=1016") == [(4, "1016")]
    assert shown("object=1017 node=0x5") == [(5, "1017")]
    assert shown("code=SDO") == []
    assert shown('text="1016h:01"') == [(4, "1016")]


@pytest.mark.parametrize("command", ["decode", "sdo", "check", "summary", "signals"])
@pytest.mark.parametrize(
    ("expression", "said"),
    [
        ("node=200", "node-ID is 1 to 127"),
        ("node=0", "node-ID is 1 to 127"),
        ("node=0xFF", "node-ID is 1 to 127"),
        ("object=10000", "object="),
        ("code=QQQ", "canalyze rules"),
        ("severity=fatal", "error warning info"),
        ("colour=red", "severity="),
    ],
)
def test_filters_that_cannot_be(canalyze: Runner, command: str, expression: str, said: str) -> None:
    done = canalyze(command, "--lang", "en", "--filter", expression, PROBLEMS)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert said in done.err and expression.partition("=")[0] in done.err


@pytest.mark.parametrize(
    ("args", "number"),
    [
        (["diagnose", "--node", "200", PROBLEMS], "200"),
        (["eds", "--node", "0", "drive.eds"], "0"),
        (["decode", "--eds", "200=drive.eds", PROBLEMS], "200"),
        (["decode", "--eds", "can1:1-3,128=drive.eds", PROBLEMS], "128"),
        (["decode", "--cob", "185=200.TPDO1", PROBLEMS], "200"),
        (["decode", "--sdo", "640,5C0=0xFF", PROBLEMS], "0xFF"),
        (["explain", "--eds", "0=drive.eds", "185#00"], "0"),
    ],
)
def test_nodes_that_cannot_be(canalyze: Runner, args: list[str], number: str) -> None:
    for lang, said in (("en", "1 to 127"), ("zh", "1到127")):
        done = canalyze(*args, "--lang", lang)
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
        assert said in done.err and number in done.err.replace("127", "")


# Time.


@pytest.mark.parametrize("start", [0, 12, 1_700_000_000])
def test_one_zero(canalyze: Runner, tmp_path: Path, start: int) -> None:
    lines = [f"({start + at / 10:.6f}) can0 70{node}#05\n" for at, node in ((0, 3), (5, 4), (10, 5), (15, 4))]
    (tmp_path / "a.log").write_text("".join(lines))
    shown = canalyze("decode", "-t", "z", "--filter", "t=0.4..1.1", "a.log").lines
    assert [line.split(")")[0] for line in shown] == ["(000.500000", "(001.000000"]
    # also where the first frame is not shown
    assert canalyze("decode", "-t", "z", "--filter", "node=4", "a.log").lines[0].startswith("(000.500000)")


def test_forms_of_time(canalyze: Runner) -> None:
    for form, first in (("a", "1700000000.100000"), ("z", "0.100000"), ("A", "2023-11-14 22:13:20.100000"), ("n", "")):
        rows = list(csv.DictReader(io.StringIO(canalyze("sdo", "--format", "csv", "-t", form, PROBLEMS).out)))
        assert rows[0]["t"] == first
        lines = canalyze("sdo", "--format", "jsonl", "-t", form, PROBLEMS).lines
        assert json.loads(lines[0])["t"] == (first or None)
        table = canalyze("sdo", "-t", form, PROBLEMS).lines
        assert (first or " -  ") in table[1]
    for command in ("sdo", "summary", "check", "signals"):
        done = canalyze(command, "-t", "d", PROBLEMS)
        assert (done.code, len(done.complaints)) == (2, 1)


def test_forms_of_time_in_a_summary(canalyze: Runner) -> None:
    shown = {form: canalyze("summary", "--lang", "en", "-t", form, PROBLEMS).out for form in "azAn"}
    assert "2023-11-14 22:13:20.000000 to 2023-11-14" in shown["A"] and "2023-11-14 22:13:20.550000 Oper" in shown["A"]
    assert " 0.000000 to " in shown["z"] and "1700000000.000000 to" in shown["a"]
    assert "1700000000" not in shown["n"] and "None" not in shown["n"]


def test_forms_of_time_in_a_check(canalyze: Runner) -> None:
    done = canalyze("check", "-t", "z", PROBLEMS)
    marked = [line for line in done.lines if line.startswith("    >")]
    assert marked and all(re.match(r"    > *\(00[0-9]\.[0-9]{6}\)", line) for line in marked), marked
    assert canalyze("check", PROBLEMS).out.count("(1700000") == done.out.count("(00")


def test_forms_of_time_of_signals(canalyze: Runner) -> None:
    capture = str(SAMPLES / "network" / "sync-and-pdos.log")
    for form, begins in (("z", "0."), ("A", "20"), ("n", "")):
        rows = list(csv.DictReader(io.StringIO(canalyze("signals", "-t", form, capture).out)))
        assert rows and all(row["t"].startswith(begins) for row in rows)
    assert all(row["t"] == "" for row in rows)


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


def test_names_are_those_of_the_standard(canalyze: Runner) -> None:
    rows = list(csv.DictReader(io.StringIO(canalyze("sdo", "--format", "csv", PROBLEMS).out)))
    assert {row["name"] for row in rows if row["object"] == "1017:00"} == {"producer heartbeat time"}
    lines = [json.loads(line) for line in canalyze("decode", "--format", "jsonl", PROBLEMS).lines]
    assert {line["nmt"]["name"] for line in lines if line.get("service") == "nmt"} >= {"start remote node"}
    assert "生产者心跳时间" in canalyze("sdo", PROBLEMS).out


def test_lists_are_those_of_the_core() -> None:
    assert list(get_args(Severity)) == list(SEVERITIES) == _core.SEVERITIES
    assert set(_core.SEVERITIES) <= set(_core.COLOURS)
    assert len(_core.SERVICES) == len(set(_core.SERVICES)) and {"sdo", "heartbeat"} <= set(_core.SERVICES)


# Frames by themselves.


@pytest.mark.parametrize(
    ("frame", "said"),
    [
        ("60A#40081", "odd number"),
        ("60A#400810000000000000", "more than 8 bytes"),
        ("60A##0" + "00" * 65, "more than 64 bytes"),
        ("can1 60A [4] 40 08 10 00 00 00 00 00", "do not match the length"),
        ("can1 60A [9] 40 08 10 00 00 00 00 00 00", "invalid length"),
        ("can1 60A [8] 40 08 10", "do not match the length"),
        ("60A#40081000000000 00", "do not match the length"),
        ("60A#40:1710", "do not match the length"),
        ("60A#81:00:12345678#1122", "CAN XL"),
        ("7FFFFFFFF#00", ""),
    ],
)
@pytest.mark.parametrize("eds", [[], ["--eds", "5=drive.eds"]], ids=["alone", "described"])
def test_explain_cuts_nothing(canalyze: Runner, tmp_path: Path, frame: str, said: str, eds: list[str]) -> None:
    (tmp_path / "drive.eds").write_bytes((Path(__file__).parent.parent / "eds/drive.eds").read_bytes())
    for args, stdin in (([frame], b""), (["-"], frame.encode())):
        done = canalyze("explain", "--lang", "en", *eds, *args, stdin=stdin)
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
        assert said in done.err and frame in done.err


@pytest.mark.parametrize("frame", ["60A#40:08:10:00:00:00:00:00", "60A#40 08 10 00 00 00 00 00"])
def test_explain_reads_bytes_with_marks_between_them(canalyze: Runner, frame: str) -> None:
    assert canalyze("explain", frame).out == canalyze("explain", "60A#4008100000000000").out


@pytest.mark.parametrize(
    "frame",
    [
        "000#0105FF",
        "080#0102",
        "705#0501",
        "7E5#04",
        "605#2F17100001",
        "185##01112131415161718192021222324",
        "123#010203",
    ],
)
def test_explain_shows_every_byte(canalyze: Runner, frame: str) -> None:
    data = re.sub(r"^[0-9A-F]+#(#.)?", "", frame)
    spaced = " ".join(data[place : place + 2] for place in range(0, len(data), 2))
    own, *rest = canalyze("explain", frame).lines
    assert f"  {spaced} " in own
    shown = " ".join(byte for line in rest for byte in re.findall(r"(?<![0-9A-F])[0-9A-F]{2}(?![0-9A-F])", line))
    missing = [byte for byte in spaced.split() if byte not in shown.split()]
    assert not missing, (missing, rest)
