"""What of the findings counts: prefixes, thresholds, overrides, and the baseline with its file."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from captures import DATA
from msgspec.structs import replace
from report_verdicts import FINDING

from canalyze import _core
from canalyze.check import baseline, policy
from canalyze.check.baseline import Kind
from canalyze.check.policy import Override, Policy, judge, named
from canalyze.check.verdict import Counted, Examined
from canalyze.configuration.config import read
from canalyze.errors import ConfigError
from canalyze.records import Severity


def counted(
    code: str = "SDO001",
    severity: Severity = "error",
    *,
    count: int = 1,
    node: int | None = 5,
    bus: str | None = "can0",
    index: str | None = "1017",
) -> Counted:
    """Give findings of one kind."""
    about = {"bus": bus, "node": node, "index": index, "sub": None if index is None else 0}
    finding = replace(FINDING, code=code, severity=severity, file="a.log", frame=3, cause_frame=None, **about)
    return Counted(finding, (finding,), count)


def kinds(found: tuple[Counted, ...]) -> list[tuple[str, str]]:
    return [(one.finding.code, one.finding.severity) for one in found]


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("SDO001", ("SDO001",)),
        (" sdo , hbt0 ", ("SDO", "HBT0")),
        ("S", ("S",)),
        ("SDO,SDO", ("SDO",)),
        ("", None),
        ("SDO,", None),
        ("SDO0011", None),
        ("S1", None),
        ("SDO 001", None),
        ("*", None),
    ],
)
def test_codes(text: str, read: tuple[str, ...] | None) -> None:
    assert _core.codes(text) == read


@pytest.mark.parametrize(
    ("select", "ignore", "taken", "left"),
    [
        ((), (), "SDO001 HBT001", ""),
        (("SDO",), (), "SDO001", "HBT001"),
        ((), ("SDO",), "HBT001", "SDO001 SDO002"),
        (("SDO001",), ("SDO",), "SDO001", "SDO002 HBT001"),
        (("SDO",), ("SDO002", "HBT"), "SDO001", "SDO002 HBT001"),
        (("SDO",), ("SDO",), "", "SDO001"),
    ],
)
def test_the_longest_prefix_counts(select: tuple[str, ...], ignore: tuple[str, ...], taken: str, left: str) -> None:
    held = Policy(select=select, ignore=ignore)
    assert all(held.takes(code) for code in taken.split())
    assert not any(held.takes(code) for code in left.split())


@pytest.mark.parametrize(
    ("threshold", "fails"),
    [(None, ["warning", "error"]), ("error", ["error"]), ("info", ["info", "warning", "error"]), ("never", [])],
)
def test_threshold(threshold: policy.Threshold | None, fails: list[str]) -> None:
    severities: tuple[Severity, ...] = ("info", "warning", "error")
    assert [one for one in severities if Policy(threshold).fails(one)] == fails


def test_options_overrule_the_file() -> None:
    filed = Policy("error", ("SDO",), ("SDO005",), "a.json", directory="d")
    assert filed.overruled(Policy()) == filed
    held = filed.overruled(Policy("info", ("HBT",), ("HBT002",), "b.json"))
    assert held == Policy("info", ("HBT",), ("SDO005", "HBT002"), "b.json", directory="d")


@pytest.mark.parametrize(
    ("file", "glob", "fits"),
    [
        ("captures/boot.log", "captures/*.log", True),
        ("captures/boot.log", "captures/**/*.log", True),
        ("captures/a/b/boot.log", "captures/**/*.log", True),
        ("captures/a/boot.log", "captures/*.log", False),
        ("captures/boot.log", "boot.log", True),
        ("captures/boot.log", "*.asc", False),
        ("./boot.log", "boot.log", True),
        ("boot.log", "./boot.log", True),
        ("captures/boot[1].log", "captures/boot[[]1].log", True),
        ("captures/boot2.log", "captures/boot[!1].log", True),
        ("captures/boot1.log", "captures/boot[!1].log", False),
        ("captures/boot.log", "captures/b??t.log", True),
        ("captures/x.log", "captures", False),
        ("-", "*.log", False),
    ],
)
def test_globs_of_overrides(file: str, glob: str, fits: bool) -> None:
    assert named(file, glob, ".") == fits


def test_a_glob_is_relative_to_the_configuration(tmp_path: Path) -> None:
    assert named(str(tmp_path / "captures/boot.log"), "captures/*.log", str(tmp_path))
    assert not named(str(tmp_path / "other/boot.log"), "captures/*.log", str(tmp_path))


def test_an_override_needs_all_that_it_says() -> None:
    override = Override(("SDO",), "ignore", "known", ("a.log",), (5,), "can0")
    assert override.covers(counted(), "a.log", ".")
    assert not override.covers(counted("HBT001"), "a.log", ".")
    assert not override.covers(counted(), "b.log", ".")
    assert not override.covers(counted(node=6), "a.log", ".")
    assert not override.covers(counted(node=None), "a.log", ".")
    assert not override.covers(counted(bus="can1"), "a.log", ".")
    assert Override(("SDO",), "ignore", "known").covers(counted(node=None, bus=None), "b.log", ".")


def test_an_override_leaves_a_consequence_out_or_as_it_is() -> None:
    finding = replace(counted(severity="info").finding, because_of=2)
    consequence = Counted(finding, (finding,), 1)
    examined = Examined("a.log", (counted(), consequence))
    raised = policy.judge(examined, Policy(overrides=(Override(("SDO",), "error", "strict"),)), {})
    assert (kinds(raised.failures), kinds(raised.consequences)) == ([("SDO001", "error")], [("SDO001", "info")])
    assert raised.reasons == (("strict", 1),)
    assert policy.judge(examined, Policy(overrides=(Override(("SDO",), "ignore", "known"),)), {}).overruled == 2


def test_overrides_are_counted_by_their_reason() -> None:
    overrides = (
        Override(("SDO",), "ignore", "old server"),
        Override(("SDO001",), "info", "harmless"),
        Override(("PDO006",), "error", "must not be"),
    )
    found = (counted(count=3), counted("SDO002", "warning"), counted("PDO006", "warning"), counted("SYN003", "warning"))
    verdict = judge(Examined("a.log", found, frames=9), Policy("error", ignore=("SYN",), overrides=overrides), {})
    assert kinds(verdict.failures) == [("PDO006", "error")]
    assert kinds(verdict.others) == [("SDO001", "info")]
    assert verdict.overruled == 2
    assert verdict.reasons == (("harmless", 3), ("must not be", 1), ("old server", 1))


def test_only_more_than_the_baseline_fails() -> None:
    known: baseline.Baseline = {Kind("SDO001", "can0", 5, "1017:00"): 2}
    for count, failed in ((1, False), (2, False), (3, True)):
        verdict = judge(Examined("a.log", (counted(count=count),)), Policy(), known)
        (one,) = verdict.failures or verdict.others
        assert (verdict.failed, one.known, one.count) == (failed, 2, count)
    for other in (counted("SDO002"), counted(node=6), counted(bus=None), counted(index="1018")):
        assert judge(Examined("a.log", (other,)), Policy(), known).failed


def test_baseline_comes_back_as_it_was(tmp_path: Path) -> None:
    known: baseline.Baseline = {
        Kind("SYN003", None, None, None): 1,
        Kind("SDO001", "can1", 5, "1017:00"): 2,
        Kind("SDO001", "can0", 127, None): 12,
        Kind("SDO001", "\u603b\u7ebf", 1, "6041:FF"): 7,
    }
    file = tmp_path / "known.json"
    file.write_text(baseline.text(known), encoding="utf-8")
    assert baseline.read(str(file)) == known
    assert baseline.text(baseline.read(str(file))) == file.read_text(encoding="utf-8")
    assert [line[2:20] for line in file.read_text(encoding="utf-8").splitlines()[1:-1]] == [
        '{"code": "SDO001",',
        '{"code": "SDO001",',
        '{"code": "SDO001",',
        '{"code": "SYN003",',
    ]
    file.write_text(baseline.text({}))
    assert baseline.read(str(file)) == {}
    file.write_text(json.dumps(json.loads(baseline.text(known)), indent=4))  # by another program
    assert baseline.read(str(file)) == known


def test_a_new_entry_is_one_more_line() -> None:
    before: dict[Kind | baseline.ProblemKind, int] = {
        Kind("SDO001", "can0", 5, None): 1,
        Kind("SYN003", "can0", None, None): 1,
    }
    after = before | {Kind("SDO002", "can0", 5, None): 1}
    lines = baseline.text(before).splitlines()
    assert [line for line in baseline.text(after).splitlines() if line not in lines] == [
        '  {"code": "SDO002", "bus": "can0", "node": 5, "object": null, "count": 1},'
    ]


def test_the_most_in_any_one_capture() -> None:
    one, other = Kind("SDO001", None, 5, None), Kind("SDO002", None, 5, None)
    assert baseline.most([{one: 3}, {one: 1, other: 2}, {}]) == {one: 3, other: 2}


def test_baseline_that_is_no_text(tmp_path: Path) -> None:
    file = tmp_path / "known.json"
    file.write_bytes(b'{\n"canalyze_baseline": "\xff"}')
    with pytest.raises(ConfigError, match=r"known\.json:2"):
        baseline.read(str(file))
    file.write_text("[" * 100_000)
    with pytest.raises(ConfigError):
        baseline.read(str(file))


def test_check_of_canalyze_toml(tmp_path: Path) -> None:
    file = tmp_path / "canalyze.toml"
    file.write_bytes((DATA / "check.toml").read_bytes())
    held = read(str(file)).check
    assert held == Policy(
        "error",
        ("SDO", "HBT"),
        ("SDO005",),
        str(tmp_path / "known.json"),
        (
            Override(
                ("HBT001", "SDO"),
                "ignore",
                "the old master",
                ("captures/**/*.log",),
                (5, 7, 8, 9),
                "can1",
                f"{file}:11",
            ),
            Override(("SYN003",), "info", "jitter of the adapter", at=f"{file}:16"),
        ),
        str(tmp_path),
        (("select", f"{file}:3"), ("ignore", f"{file}:4")),
    )
