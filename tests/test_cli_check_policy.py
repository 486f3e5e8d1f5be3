"""`canalyze check`: thresholds, selections, overrides, baselines and expectations, and what fails by them."""

from __future__ import annotations

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from captures import SAMPLES
from conftest import Runner
from test_cli_check import RULES, codes, ends, jsonl

from canalyze.words import LANGUAGES, Words


@pytest.mark.parametrize(
    ("threshold", "name", "code"),
    [
        ("error", "toggle", 1),
        ("error", "sync", 0),
        ("warning", "sync", 1),
        ("info", "clean", 0),
        ("never", "toggle", 0),
    ],
)
def test_threshold(canalyze: Runner, set_of_captures: Path, threshold: str, name: str, code: int) -> None:
    assert canalyze("check", "--fail-on", threshold, f"captures/{name}.log").code == code


def test_select_and_ignore(canalyze: Runner, set_of_captures: Path) -> None:
    both = ("captures/toggle.log", "captures/sync.log")
    assert codes(jsonl(canalyze, *both)) == ["SDO001", "SYN003"]
    assert codes(jsonl(canalyze, "--select", "sdo", *both)) == ["SDO001"]
    assert codes(jsonl(canalyze, "--ignore", "SDO,PDO", "--ignore=NMT", *both)) == ["SYN003"]
    found = jsonl(canalyze, "--select", "SDO", "--ignore", "SDO001", *both, code=0)
    assert [row["overruled"] for row in ends(found)] == [1, 1]


@pytest.mark.parametrize(
    ("option", "value", "said"),
    [
        ("--select", "SD0", "SDO"),
        ("--ignore", "HBT,SYC", "SYN"),
        ("--select", "SDO999", "SDO0"),
        ("--select", "SDO 1", "SDO,HBT001"),
        ("--select", "", "SDO,HBT001"),
        ("--fail-on", "warn", "error, warning, info, never"),
    ],
)
@pytest.mark.parametrize("lang", ["zh", "en"])
def test_codes_that_cannot_be(canalyze: Runner, option: str, value: str, said: str, lang: str) -> None:
    done = canalyze("--lang", lang, "check", f"{option}={value}", "x.log")
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert said in done.err and option in done.err


def test_overrides_of_the_configuration(canalyze: Runner, set_of_captures: Path, tmp_path: Path) -> None:
    (tmp_path / "canalyze.toml").write_text(
        "[check]\nfail_on = 'error'\n"
        "[[check.override]]\nfiles = ['captures/t*.log']\nnodes = [10]\ncodes = ['SDO']\n"
        "severity = 'ignore'\nreason = 'old server'\n"
        "[[check.override]]\ncodes = ['SYN003']\nseverity = 'error'\nreason = 'drives depend on it'\n"
    )
    both = ("captures/toggle.log", "captures/sync.log")
    found = jsonl(canalyze, *both)
    assert [(row["code"], row["severity"]) for row in found if row["kind"] == "finding"] == [("SYN003", "error")]
    assert [row["reasons"] for row in ends(found)] == [
        [{"reason": "old server", "count": 1}],
        [{"reason": "drives depend on it", "count": 1}],
    ]
    done = canalyze("check", "--lang", "en", *both)
    assert "1 finding overridden: old server" in done.lines
    assert "captures/toggle.log, 8 frames: clean, 1 ignored" in done.lines
    absolute = [str(set_of_captures / "toggle.log")]
    assert jsonl(canalyze, *absolute, code=0)


def test_codes_of_the_configuration_are_held_against_the_rules(canalyze: Runner, tmp_path: Path) -> None:
    for text, line in (
        ("[check]\n\nselect = ['SDX']\n", 3),
        ("[check]\nignore = 'ABC'\n", 2),
        ("[[check.override]]\nreason = 'x'\nseverity = 'info'\ncodes = ['HBX']\n", 4),
    ):
        (tmp_path / "canalyze.toml").write_text(text)
        done = canalyze("check", "--lang", "en", "x.log")
        assert (done.code, len(done.complaints)) == (2, 1)
        assert done.err.startswith(f"canalyze: canalyze.toml:{line}: ")
        assert canalyze("decode", str(SAMPLES / "sdo-abort.log")).code == 0


def examples_of_the_configuration() -> list[str]:
    """What help and README show of canalyze.toml about `check`."""
    readme = (SAMPLES.parent / "README.md").read_text(encoding="utf-8")
    fenced = re.findall(r"^```toml\n(.*?)^```$", readme, flags=re.DOTALL | re.MULTILINE)
    shown = [Words(lang)("check.examples").partition("# canalyze.toml\n")[2] for lang in LANGUAGES]
    return [*shown, *(part for part in fenced if "[[check.override]]" in part)]


@pytest.mark.parametrize("text", examples_of_the_configuration())
def test_what_is_shown_of_the_configuration_is_valid(
    canalyze: Runner, set_of_captures: Path, tmp_path: Path, text: str
) -> None:
    (tmp_path / "canalyze.toml").write_text(text)
    (tmp_path / "known.json").write_text('{"canalyze_baseline": 1, "findings": []}\n')
    assert canalyze("check", "captures/clean.log").code == 0


# The baseline.


def test_baseline_round_trip(canalyze: Runner, set_of_captures: Path, tmp_path: Path) -> None:
    every = ("captures/toggle.log", "captures/sync.log", "captures/clean.log")
    missing = canalyze("check", "--lang", "en", "--baseline", "known.json", *every)
    assert (missing.code, len(missing.complaints)) == (2, 1) and "--update-baseline" in missing.err
    done = canalyze("check", "--lang", "en", "--baseline", "known.json", "--update-baseline", *every)
    assert done.code == 0
    assert done.complaints == ["canalyze: known.json: baseline written, 2 entries"]
    written = (tmp_path / "known.json").read_text()
    assert [json.loads(line.rstrip(","))["code"] for line in written.splitlines()[1:-1]] == ["SDO001", "SYN003"]
    again = canalyze("check", "--lang", "en", "--baseline", "known.json", *every)
    assert (again.code, again.err) == (0, "")
    assert "captures/toggle.log, 8 frames: clean, 1 in baseline" in again.lines
    canalyze("check", "--baseline", "known.json", "--update-baseline", *every)
    assert (tmp_path / "known.json").read_text() == written
    less = canalyze("check", "--lang", "en", "--baseline", "known.json", "captures/clean.log", "captures/sync.log")
    assert less.code == 0
    assert less.complaints == [
        "canalyze: known.json: no longer occurs: SDO001 can0, node 10, 1008:00; --update-baseline removes it"
    ]
    canalyze("check", "--baseline", "known.json", "--update-baseline", "captures/clean.log")
    assert json.loads((tmp_path / "known.json").read_text()) == {"canalyze_baseline": 1, "findings": []}


def test_more_than_the_baseline_fails(canalyze: Runner, set_of_captures: Path, tmp_path: Path) -> None:
    args = ("check", "--lang", "en", "--baseline", "known.json")
    two, three = ("".join(f"({2 + at}.000000) can0 085#1081000000000000\n" for at in range(count)) for count in (2, 3))
    (tmp_path / "two.log").write_text(f"(1.000000) can0 705#00\n{two}")
    (tmp_path / "three.log").write_text(f"(1.000000) can0 705#00\n{three}")
    assert canalyze(*args, "--update-baseline", "two.log").code == 0
    assert canalyze(*args, "two.log").code == 0
    done = canalyze(*args, "two.log", "three.log")
    assert done.code == 1
    assert any(line.startswith("two.log, ") and ": clean, " in line for line in done.lines)
    assert "    3 times, 2 in baseline; also at frames 3, 4" in done.lines


def test_fewer_than_the_baseline_is_said(canalyze: Runner, set_of_captures: Path, tmp_path: Path) -> None:
    args = ("check", "--lang", "en", "--baseline", "known.json")
    emcy = "(2.000000) can0 085#1081000000000000\n"
    for name, count in (("two", 2), ("three", 3)):
        (tmp_path / f"{name}.log").write_text("(1.000000) can0 705#00\n" + emcy * count)
    assert canalyze(*args, "--update-baseline", "three.log").code == 0
    done = canalyze(*args, "two.log")
    assert done.code == 0
    (said,) = done.complaints
    assert "per capture, baseline 3:" in said
    assert not canalyze(*args, "two.log", "three.log").complaints
    assert canalyze(*args, "--update-baseline", "two.log").code == 0
    assert not canalyze(*args, "two.log").complaints
    assert canalyze(*args, "three.log").code == 1


EXPECTED = """
[[sdo]]
node = 5
object = "1017:00"
value = {first}
[[sdo]]
node = 5
object = "1017:00"
value = {second}
"""


def test_each_expectation_is_a_finding_of_its_own(canalyze: Runner, tmp_path: Path) -> None:
    capture, file = tmp_path / "write.log", tmp_path / "write.expect.toml"
    capture.write_text("(1.0) can0 605#2B171000E8030000\n(1.001) can0 585#6017100000000000\n")
    file.write_text(EXPECTED.format(first=500, second=600))
    junit, sarif = tmp_path / "report.xml", tmp_path / "report.sarif"
    found = jsonl(canalyze, "--junit", str(junit), "--sarif", str(sarif), str(capture))
    labels = [f"{file}:{line}" for line in (2, 6)]
    assert [row["facts"]["expectation"] for row in found[:-1]] == labels
    assert {(row["code"], row["node"], row["index"], row["count"]) for row in found[:-1]} == {("EXP003", 5, "1017", 1)}
    assert (found[-1]["failures"], found[-1]["expectations"]) == (2, str(file))
    cases = ElementTree.parse(junit).getroot().findall(".//testcase")
    assert [case.get("name", "").split()[-1] for case in cases] == ["write.expect.toml:2", "write.expect.toml:6"]
    properties = {one.get("name"): one.get("value") for one in ElementTree.parse(junit).getroot().iter("property")}
    assert properties["expectations"] == str(file)
    results = json.loads(sarif.read_text())["runs"][0]["results"]
    assert len({row["partialFingerprints"]["findingKind/v1"] for row in results}) == len(results) == 2
    text = canalyze("check", "--lang", "en", str(capture))
    assert all(text.out.count(f"(expected by {label})") == 1 for label in labels)
    assert f"\nexpectations: {file} (for 1 capture)\n1 file, " in text.out
    commands = canalyze("check", "--format", "github", str(capture), env={"GITHUB_ACTIONS": "true"})
    assert sum(line.startswith("::error") for line in commands.lines) == 2


def test_a_baseline_does_not_tell_expectations_apart(canalyze: Runner, tmp_path: Path) -> None:
    capture, file, baseline = (tmp_path / name for name in ("write.log", "write.expect.toml", "known.json"))
    capture.write_text("(1.0) can0 605#2B171000E8030000\n(1.001) can0 585#6017100000000000\n")
    known = ["check", "--lang", "en", "--baseline", str(baseline), str(capture)]
    file.write_text(EXPECTED.format(first=500, second=600).rpartition("[[sdo]]")[0])
    assert canalyze(*known[:-1], "--update-baseline", str(capture)).code == 0
    assert [row["count"] for row in json.loads(baseline.read_text())["findings"]] == [1]
    file.write_text("# Lines move.\n" + file.read_text())
    done = canalyze(*known)
    assert (done.code, done.err) == (0, "")
    file.write_text(EXPECTED.format(first=500, second=600))
    done = canalyze(*known)
    assert done.code == 1
    assert done.out.count("2 times, 1 in baseline") == 2
    assert canalyze(*known[:-1], "--update-baseline", str(capture)).code == 0
    assert [row["count"] for row in json.loads(baseline.read_text())["findings"]] == [2]
    assert canalyze(*known).code == 0


def test_many_failing_captures_are_summed_up(canalyze: Runner, tmp_path: Path) -> None:
    for number in range(12):
        source = "SYN003" if number % 3 else "SDO001"
        (tmp_path / f"{number:02}.log").write_bytes((RULES / f"{source}.log").read_bytes())
    done = canalyze("check", "--lang", "en", *(str(tmp_path / f"{number:02}.log") for number in range(12)))
    heads = ["SYN003 sync-period", "SDO001 toggle-bit", "12 files, 112 frames"]
    assert [line.partition(":")[0] for line in done.lines[-3:]] == heads
    assert [line.rpartition("(in ")[2] for line in done.lines[-3:]] == ["8 files)", "4 files)", "12 files)"]


def test_the_baseline_of_the_configuration(canalyze: Runner, set_of_captures: Path, tmp_path: Path) -> None:
    (set_of_captures / "canalyze.toml").write_text("[check]\nbaseline = 'known.json'\n")
    args = ("check", "--config", "captures/canalyze.toml")
    assert canalyze(*args, "--update-baseline", "captures/toggle.log").code == 0
    assert (set_of_captures / "known.json").exists()
    assert canalyze(*args, "captures/toggle.log").code == 0
    assert canalyze("check", "--update-baseline", "captures/toggle.log").code == 2


def test_a_baseline_is_not_made_of_half_a_set(canalyze: Runner, set_of_captures: Path, tmp_path: Path) -> None:
    done = canalyze("check", "--baseline", "b.json", "--update-baseline", "captures/toggle.log", "nothing.log")
    assert done.code == 2
    assert not (tmp_path / "b.json").exists()


def test_a_broken_baseline(canalyze: Runner, set_of_captures: Path, tmp_path: Path) -> None:
    (tmp_path / "b.json").write_text('{"canalyze_baseline": 1, "findings": [\n{"code": 5}]}')
    done = canalyze("check", "--lang", "en", "--baseline", "b.json", "captures/toggle.log")
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert done.err.startswith("canalyze: b.json:2: ")
