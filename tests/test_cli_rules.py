"""`canalyze explain` and `canalyze rules`."""

import json
import re

import pytest
from conftest import NOTES, Runner

from canalyze import _core


@pytest.mark.parametrize(
    "args",
    [
        ["60A#4008100000000000"],
        ["can1", "60A", "[8]", "40", "08", "10", "00", "00", "00", "00", "00"],
        ["can1  60A   [8]  40 08 10 00 00 00 00 00"],
        ["(1612345678.123456)", "can1", "60A#4008100000000000"],
    ],
)
def test_explain_takes_what_is_pasted(canalyze: Runner, args: list[str]) -> None:
    zh, en = canalyze("explain", *args), canalyze("explain", "--lang", "en", *args)
    assert (zh.code, zh.err, en.code, en.err) == (0, "", 0, "")
    assert zh.out.endswith("\n") and not zh.out.endswith("\n\n")
    assert zh.out != en.out


@pytest.mark.parametrize("text", ["hello", "60A#4", "", "\x1b]0;x\x07hello"])
def test_explain_says_what_a_frame_looks_like(canalyze: Runner, text: str) -> None:
    done = canalyze("explain", text)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert ("60A#4: " if text == "60A#4" else "60A#4008100000000000") in done.err
    assert "\x1b" not in done.err


def test_explain_reads_lines(canalyze: Runner) -> None:
    done = canalyze("explain", "-", stdin=NOTES.splitlines(keepends=True)[0].encode() + b"\nhello\n")
    assert (done.code, len(done.complaints)) == (2, 1)
    assert "stdin:3" in done.err
    assert done.out == canalyze("explain", NOTES.splitlines()[0]).out


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize(
    "frames",
    [
        ["60A#4008100000000000", "58A#4108100017000000"],
        ["60A#4008100000000000", "70A#", "58A#4108100017000000"],
        ["can1  60A   [8]  40 08 10 00 00 00 00 00", "(1.5) can1 58A#4108100017000000"],
    ],
)
def test_explain_takes_several_frames(canalyze: Runner, frames: list[str], lang: str) -> None:
    done = canalyze("explain", "--lang", lang, *frames)
    assert (done.code, done.err) == (0, "")
    assert done.out == "\n".join(canalyze("explain", "--lang", lang, frame).out for frame in frames)


def test_explain_names_the_one_of_several_that_is_none(canalyze: Runner) -> None:
    done = canalyze("explain", "60A#4008100000000000", "60A#4")
    assert (done.code, len(done.complaints)) == (2, 1)
    assert "60A#4" in done.err
    assert done.out == canalyze("explain", "60A#4008100000000000").out


def test_explain_reads_what_explain_and_decode_write(canalyze: Runner, notes: str) -> None:
    text = canalyze("decode", "--explain", notes).out
    assert any(line.startswith("#") for line in text.splitlines())
    done = canalyze("explain", "-", stdin=text.encode())
    assert (done.code, done.err) == (0, "")
    assert done.out == canalyze("explain", "-", stdin=NOTES.encode()).out


def test_explain_without_a_frame_says_what_to_give(canalyze: Runner) -> None:
    for lang in ("zh", "en"):
        done = canalyze("explain", "--lang", lang)
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
        assert "canalyze explain '60A#4008100000000000'" in done.err
        done = canalyze("explain", "-", "--lang", lang, stdin=b"# only a comment\n\n")
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
        assert "stdin" in done.err


def test_rules_lists_the_catalogue(canalyze: Runner) -> None:
    done = canalyze("--lang", "en", "rules")
    assert (done.code, done.err) == (0, "")
    heading, *rows = done.lines
    assert heading.split() == ["code", "severity", "name", "message"]
    assert any(row.startswith("SDO001 ") for row in rows)
    objects = [json.loads(line) for line in canalyze("--lang", "en", "rules", "--format", "jsonl").lines]
    assert [row.split()[0] for row in rows] == [rule["code"] for rule in objects]
    assert all(rule["severity"] in {"error", "warning", "info"} for rule in objects)


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_rules_are_told_apart_by_their_titles(lang: str) -> None:
    titles = [rule.message for rule in _core.rules(lang)]
    assert len(titles) > 100 and len(set(titles)) == len(titles)


def test_rules_explains_one(canalyze: Runner) -> None:
    done = canalyze("rules", "sdo001")
    assert (done.code, done.err) == (0, "")
    assert done.out.startswith("SDO001 ")
    assert "常见原因" in done.out


def test_clause_is_in_no_language(canalyze: Runner) -> None:
    for lang, none in (("zh", "无"), ("en", "none")):
        page = canalyze("rules", "SDO012", "--lang", lang).out
        assert "7.2.4.3.9 ~ 7.2.4.3.15" in page
        *_, clause = canalyze("rules", "CAP001", "--lang", lang).lines
        assert clause.split()[-1] == none


def test_unknown_rule_names_the_nearest(canalyze: Runner) -> None:
    done = canalyze("rules", "SDO0O1")
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert re.findall(r"[A-Z]{3}\d{3}", done.err)[0] == "SDO001"
    assert canalyze("rules", "QQQQ").code == 2


def test_the_beginning_of_codes_lists_their_rules(canalyze: Runner) -> None:
    done = canalyze("rules", "exp")
    assert (done.code, done.err) == (0, "")
    listed = [line.split()[0] for line in canalyze("rules").lines if line.startswith("EXP")]
    assert [line.split()[0] for line in done.lines if line.startswith("EXP")] == listed
    assert canalyze("rules", "EX9").code == 2
