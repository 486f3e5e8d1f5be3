"""`check --format github`: workflow commands, read as GitHub's runner does, and nothing else to be read.

The reader below follows the runner's documentation of commands: `::name key=value,key=value::data` at the begin of a
line, after blanks; the older `##[name key=value]data` anywhere in a line; four or six characters escaped.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import pytest
from msgspec.structs import replace
from report_verdicts import BLOCKS, FINDING, hostile, many, one

from canalyze.check.verdict import Verdict
from canalyze.reports import hosts
from canalyze.words import LANGUAGES, Words

EN = Words("en")


@dataclass
class Command:
    """A command, its escapes undone."""

    name: str
    properties: dict[str, str]
    data: str


def unescaped(text: str, *tokens: str) -> str:
    for token in (*tokens, "\r", "\n", "%"):
        text = text.replace(f"%{ord(token):02X}", token)
    return text


def parsed(line: str) -> Command | None:
    assert line == line.strip("\r\n") and len(line.splitlines()) == 1
    text = line.lstrip()
    if text.startswith("::") and "::" in text[2:]:
        head, data = text[2:].split("::", 1)
        name, _, listed = head.partition(" ")
        pairs = [pair.split("=", 1) for pair in listed.split(",") if pair]
        assert all(len(pair) == 2 for pair in pairs)
        return Command(name, {key: unescaped(value, ":", ",") for key, value in pairs}, unescaped(data))
    assert "##[" not in line, "an older command"
    return None


def commands(*verdicts: Verdict, lang: str = "en") -> list[Command]:
    return [found for line in hosts.github(verdicts, Words(lang)) if (found := parsed(line))]


@pytest.mark.parametrize("lang", LANGUAGES)
@pytest.mark.parametrize("seeds", BLOCKS)
def test_any_line_is_what_it_is_meant_to_be(seeds: range, lang: str) -> None:
    for seed in seeds:
        as_meant(hostile(seed), lang)


def as_meant(verdicts: list[Verdict], lang: str) -> None:
    lines = list(hosts.github(verdicts, Words(lang)))
    found = [parsed(line) for line in lines]
    counts = Counter(command.name for command in found if command)
    assert set(counts) <= {"error", "warning", "notice"} and all(count <= 10 for count in counts.values())
    told = sum(verdict.error is not None for verdict in verdicts)
    told += sum(len(verdict.failures) + sum(not other.known for other in verdict.others) for verdict in verdicts)
    assert len(lines) == told + (None in found)
    for command in found:
        if command:
            assert set(command.properties) <= {"file", "line", "title"}
            assert command.data.isprintable(), "one line"


def test_the_line_as_it_is_written() -> None:
    bare = replace(FINDING, lines=(), cause_frame=None, message="100% late, a::b", t=None)
    (line,) = hosts.github([Verdict("a,b: 5%.log", (one(bare),))], EN)
    assert line == ("::error file=a%2Cb%3A 5%25.log,line=9,title=SDO001 toggle-bit::100%25 late, a::b (frame 8)")


def test_a_capture_of_which_nothing_was_judged_is_a_notice() -> None:
    alien = Verdict("a.log", frames=9, nature="silent")
    assert commands(alien) == [Command("notice", {"file": "a.log"}, "no data frames, not judged")]
    assert [found.name for found in commands(replace(alien, failures=(one(),)))] == ["error"]
    assert not commands(replace(alien, expectations="a.expect.toml")) and not commands(Verdict("a.log", frames=9))
    found = commands(*[replace(alien, file=f"{number}.log") for number in range(20)])
    assert len(found) == 10 and "11" in found[-1].data


def test_standard_input_is_no_file() -> None:
    found, broken = commands(Verdict("-", (one(),))), commands(Verdict("-", error="stdin: nothing in it"))
    assert found[0].properties == {"title": "SDO001 toggle-bit"}
    assert broken == [Command("error", {}, "stdin: nothing in it")]


@pytest.mark.parametrize("severity", ["error", "warning", "info"])
def test_what_github_would_drop_is_in_the_log(severity: Any) -> None:
    lines = list(hosts.github([many(25, severity)], EN))
    shown = [command for line in lines if (command := parsed(line))]
    plain = [line for line in lines if not parsed(line)]
    name = {"info": "notice"}.get(severity, severity)
    most = 9 if severity == "info" else 10
    assert [command.name for command in shown] == [name] * most + ["notice"]
    assert len(plain) == 25 - most and plain[0].startswith(f"{severity} SDO001 toggle-bit a.log:8: node 10")
    assert shown[-1].data.endswith(f"in the log: {severity} {25 - most}")


def test_ten_of_a_kind_need_no_closing_line() -> None:
    assert len(list(hosts.github([many(10), many(10, "warning"), many(9, "info")], EN))) == 29


def test_a_name_cannot_become_a_command() -> None:
    evil = "\n::stop-commands::x ##[add-mask]y"
    verdicts = [replace(many(12, file=evil), error=evil), *(Verdict(evil, error=evil) for _ in range(12))]
    lines = list(hosts.github(verdicts, EN))
    assert {command.name for line in lines if (command := parsed(line))} == {"error", "notice"}


def test_nothing_found_is_nothing_said() -> None:
    assert list(hosts.github([], EN)) == list(hosts.github([Verdict("a.log")], EN)) == []
