"""What comes out of a capture that somebody made to hurt: nothing drives a terminal, hides text or is a command."""

import json
import os
import subprocess
from pathlib import Path

import pytest
from conftest import NOTES, Runner, command, environment
from test_hostile_files import XDD

from canalyze._core import Session
from canalyze.output import commandless, json_line, json_text, printable
from canalyze.running.reading import SessionOptions
from canalyze.sources import bridge

EVIL = "\x7f\x85\x9b\u200b\u202e\u2028\u2066\ufeff"
NAME = f"evil{EVIL}##[error]x.pcapng"
INTERFACE = "\n::error file=x::pwn"


def unsafe(text: str) -> list[str]:
    """The lines that are commands of GitHub, and what is not seen as it is."""
    commands = [line for line in text.splitlines() if line.lstrip().startswith("::") or "##[" in line]
    return commands + [char for char in text if char in EVIL]


def on_evil_bus(canalyze: Runner, directory: Path, name: str) -> None:
    """Writes a capture whose bus has a name that no listing could hold: pcapng can."""
    plain = "i" * len(INTERFACE)
    rows = (line.split() for line in NOTES.splitlines())
    lines = [f"({number}.5) {plain} {row[1]}#{''.join(row[3:])}\n" for number, row in enumerate(rows)]
    (directory / "plain.log").write_text("".join([*lines, f"(11.0) {plain} 08A#3081110102030405\n"]))
    assert canalyze("convert", "plain.log", "plain.pcapng").code == 0
    content = (directory / "plain.pcapng").read_bytes()
    assert plain.encode() in content
    (directory / name).write_bytes(content.replace(plain.encode(), INTERFACE.encode()))


@pytest.fixture
def evil(canalyze: Runner, tmp_path: Path) -> str:
    """Give the name of a capture whose name, bus and device description are evil."""
    on_evil_bus(canalyze, tmp_path, NAME)
    (tmp_path / "evil.xdd").write_text(XDD.format(name=f"a{EVIL}##[error]b", value=f"::error::{EVIL}"))
    return NAME


@pytest.mark.parametrize(
    "line",
    [
        ["info"],
        ["info", "--format", "jsonl"],
        ["check"],
        ["check", "--format", "jsonl"],
        ["check", "--format", "github", "--fail-on", "never"],
        ["check", "--fail-on", "info", "--eds", "10=evil.xdd"],
        ["decode", "--eds", "10=evil.xdd"],
        ["decode", "--eds", "10=evil.xdd", "--format", "jsonl"],
        ["decode", "--eds", "10=evil.xdd", "--explain"],
        ["sdo", "--eds", "10=evil.xdd"],
        ["sdo", "--eds", "10=evil.xdd", "--format", "jsonl"],
        ["od", "--eds", "10=evil.xdd"],
        ["od", "--eds", "10=evil.xdd", "--format", "jsonl"],
        ["od", "--eds", "10=evil.xdd", "--format", "csv"],
        ["od", "--eds", "10=evil.xdd", "--history"],
        ["od", "--eds", "10=evil.xdd", "--history", "--format", "csv"],
        ["summary"],
        ["summary", "--format", "jsonl"],
        ["signals"],
        ["expect"],
    ],
    ids=" ".join,
)
def test_no_form_lets_it_through(canalyze: Runner, evil: str, line: list[str]) -> None:
    done = canalyze("--lang", "en", *line, evil)
    assert done.code in (0, 1) and done.out
    own = ("::error file=", "::warning file=", "::notice file=")
    expected = [one for one in done.lines if one.startswith(own)] if "github" in line else []
    assert [one for one in unsafe(done.out + done.err) if one not in expected] == []
    if "jsonl" in line:
        rows = [json.loads(one) for one in done.lines]
        assert all(row.get("file", NAME) == NAME for row in rows)


@pytest.mark.parametrize("form", ["text", "jsonl"])
def test_no_form_of_a_description_lets_it_through(canalyze: Runner, evil: str, form: str) -> None:
    done = canalyze("eds", "--format", form, "evil.xdd")
    assert done.code == 0 and unsafe(done.out + done.err) == []
    if form == "jsonl":
        (row,) = [row for row in map(json.loads, done.lines) if row["kind"] == "object"]
        assert (row["name"], row["value"]) == (f"a{EVIL}##[error]b", f"::error::{EVIL}")


def test_a_report_and_a_baseline_hold_it_escaped(canalyze: Runner, evil: str, tmp_path: Path) -> None:
    assert canalyze("check", "--sarif", "a.sarif", "--fail-on", "info", evil).code in (0, 1)
    content = (tmp_path / "a.sarif").read_text()
    assert json.loads(content) and not [char for char in content if char in EVIL] and "##[" not in content


@pytest.mark.parametrize(
    "name", ["::error file=x::y.log", "  ::error::y.log", "\u3000::error::y.log", "##[error]y.log"]
)
def test_the_name_of_a_capture_is_no_command(canalyze: Runner, tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(NOTES + "broken line\n")
    (tmp_path / f"{name}.none").write_text("no frame\n" * 5)
    for line in (["check"], ["info"], ["decode"], ["check", "-o", "out.txt", "--force"]):
        done = canalyze("--lang", "en", *line, f"./{name}" if name.startswith("-") else name, f"{name}.none")
        assert unsafe(done.out + done.err) == []
        assert name.strip("\u3000: #[]").split("]")[-1].split(":")[-1] in done.out + done.err


def test_an_interface_of_pcapng_is_no_command(canalyze: Runner, tmp_path: Path) -> None:
    on_evil_bus(canalyze, tmp_path, "in.pcapng")
    for line in (["summary"], ["check"], ["info"], ["sdo"], ["decode"]):
        done = canalyze("--lang", "en", *line, "in.pcapng")
        assert done.code in (0, 1) and unsafe(done.out + done.err) == []
        assert "error_file=x::pwn" in done.out


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("::error::x\n", "\\x3a:error::x\n"),
        ("a\n  ::error::x\nb\n", "a\n  \\x3a:error::x\nb\n"),
        ("a::b\n", "a::b\n"),
        (":x\n", ":x\n"),
        (":::\n", "\\x3a::\n"),
        ("\t\u00a0\u3000::x\n", "\t\u00a0\u3000\\x3a:x\n"),
        ("中文::x\n", "中文::x\n"),
        ("a ##[error]\n", "a ##\\x5berror]\n"),
        ("## [x]\n", "## [x]\n"),
    ],
)
def test_what_a_runner_takes_for_a_command(text: str, shown: str) -> None:
    assert commandless(text.encode()).decode() == shown


def test_json_is_the_same_for_every_reader() -> None:
    value = {"a": f"{EVIL}##[x 中文 \udcff \U000e0001", "b": [1, 2.5, None, True], "c": "plain 中文"}
    for compact in (False, True):
        written = json_text(value, compact=compact)
        assert json.loads(written) == value
        assert written.isprintable() and "##[" not in written and "中文" in written
    assert json_text({"a": 1, "b": "é"}) == '{"a": 1, "b": "é"}'
    assert json_text({"a": [1, {}]}, compact=True) == '{"a":[1,{}]}'
    assert json_line("x") == b'"x"\n'


def test_plain_text_is_left_alone() -> None:
    assert printable("can0 中文 é #") == "can0 中文 é #"
    assert commandless(b"can0  123   [1]  11\n") == b"can0  123   [1]  11\n"


# Exit codes.


@pytest.mark.parametrize(("alike", "code"), [(True, 0), (False, 1)])
@pytest.mark.parametrize("form", ["text", "jsonl"])
def test_a_reader_that_leaves_is_not_told_that_captures_are_alike(
    tmp_path: Path, alike: bool, code: int, form: str
) -> None:
    (tmp_path / "a.log").write_text(NOTES)
    (tmp_path / "b.log").write_text(NOTES if alike else NOTES.replace("5A 65 70", "5B 65 70"))
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "wb") as gone:
        line = command("diff", "--format", form, "a.log", "b.log")
        done = subprocess.run(line, cwd=tmp_path, env=environment(), stdout=gone, stderr=subprocess.PIPE, check=False)
    assert (done.returncode, done.stderr) == (code, b"")


# What is said of a capture.


@pytest.mark.parametrize(
    ("lang", "known", "unknown"), [("en", "; 7 bytes", "unknown number of bytes"), ("zh", "跳过7字节", "字节数未知")]
)
@pytest.mark.parametrize("kind", [bridge.CHECKSUM, bridge.STRUCTURE, bridge.COMPRESSION])
def test_damage_of_unknown_size_is_said_so(kind: int, lang: str, known: str, unknown: str) -> None:
    for size, said in ((7, known), (None, unknown)):
        session = Session(SessionOptions(lang=lang, format="check"))
        session.begin("a.blf", True, "packed")
        out = session.feed(bridge.damage(kind, 144, size)) + session.end() + session.finish()
        (finding,) = map(json.loads, out.splitlines())
        assert said in finding["message"] and ";  bytes" not in finding["message"]
        assert finding["facts"].get("bytes") == size
