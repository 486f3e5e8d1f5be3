"""Files of expectations: every key comes through, every mistake is named with its line and with what is allowed."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from captures import TESTS

from canalyze import _core
from canalyze.errors import ConfigError
from canalyze.expectations import beside, read
from canalyze.sinks import suffixes
from canalyze.words import LANGUAGES, Words

SCHEMA = _core.SETTINGS["expect"]
"""Of every table each key: the sentence about it, and what it allows."""


def normal(tmp_path: Path, content: str) -> dict[str, Any]:
    path = tmp_path / "boot.expect.toml"
    path.write_text(content, encoding="utf-8")
    found = json.loads(read(path).normal)
    assert isinstance(found, dict)
    return found


def only(tmp_path: Path, table: str, content: str) -> dict[str, Any]:
    """The one entry of this table."""
    (entry,) = normal(tmp_path, f"[[{table}]]\n{content}\n")[table]
    assert entry.pop("line") == 1
    assert isinstance(entry, dict)
    return entry


SDO: dict[str, Any] = {
    "bus": None,
    "node": 5,
    "index": 0x1017,
    "sub": 0,
    "direction": None,
    "value": None,
    "outcome": "ok",
    "abort": None,
    "sequence": None,
    "count": 1,
    "within_ns": None,
}
STATE: dict[str, Any] = {
    "bus": None,
    "node": 5,
    "state": None,
    "drive": None,
    "axis": None,
    "by_ns": None,
    "since": "start",
    "stays": False,
}
SIGNAL: dict[str, Any] = {
    "bus": None,
    "select": "5.*",
    "min": None,
    "max": None,
    "period_ns": None,
    "tolerance_ns": None,
}
LATENCY: dict[str, Any] = {
    "bus": None,
    "node": None,
    "of": "sdo",
    "index": None,
    "sub": None,
    "pdo": None,
    "max_ns": 20_000_000,
}
INCIDENT: dict[str, Any] = {
    "bus": None,
    "node": None,
    "kind": None,
    "occurs": None,
    "ends_within_ns": None,
    "cause": None,
}
SILENT = {"kind": "node-silent"}
A_WRITE = 'node = 5\nobject = "1017:00"\n'
MEANT: list[tuple[str, str, dict[str, Any]]] = [
    ("sdo", A_WRITE, SDO),
    ("sdo", 'node = 5\nobject = "0x1017:00"', SDO),
    ("sdo", 'node = 5\nobject = "1017h:0"', SDO),
    ("sdo", 'node = 5\nobject = "607a:1F"', SDO | {"index": 0x607A, "sub": 0x1F}),
    ("sdo", A_WRITE + 'bus = "can1"', SDO | {"bus": "can1"}),
    ("sdo", A_WRITE + 'direction = "upload"', SDO | {"direction": "upload"}),
    ("sdo", A_WRITE + "value = 1000", SDO | {"value": {"number": 1000}}),
    ("sdo", A_WRITE + "value = -1", SDO | {"value": {"number": -1}}),
    ("sdo", A_WRITE + "value = 0x40000185", SDO | {"value": {"number": 0x40000185}}),
    ("sdo", A_WRITE + "value = 18446744073709551615", SDO | {"value": {"number": 2**64 - 1}}),
    ("sdo", A_WRITE + "value = 1.5", SDO | {"value": {"number": 1.5}}),
    ("sdo", A_WRITE + "value = true", SDO | {"value": {"bool": True}}),
    ("sdo", A_WRITE + 'value = "save"', SDO | {"value": {"text": "save"}}),
    ("sdo", A_WRITE + 'data = "e8 03"', SDO | {"value": {"data": "E803"}}),
    ("sdo", A_WRITE + 'outcome = "any"', SDO | {"outcome": "any"}),
    ("sdo", A_WRITE + 'outcome = "aborted"', SDO | {"outcome": "aborted"}),
    ("sdo", A_WRITE + 'abort = "0x06010002"', SDO | {"outcome": "aborted", "abort": 0x06010002}),
    ("sdo", A_WRITE + 'sequence = "boot"', SDO | {"sequence": "boot"}),
    ("sdo", A_WRITE + "count = 3", SDO | {"count": 3}),
    ("sdo", A_WRITE + "never = true", SDO | {"count": 0, "outcome": "any"}),
    ("sdo", A_WRITE + 'never = true\noutcome = "ok"', SDO | {"count": 0}),
    ("sdo", A_WRITE + "within_s = 2.5", SDO | {"within_ns": 2_500_000_000}),
    ("state", 'node = 5\nstate = "operational"', STATE | {"state": "operational"}),
    ("state", 'node = 5\nstate = "boot-up"\nby_s = 1', STATE | {"state": "boot-up", "by_ns": 1_000_000_000}),
    ("state", 'node = 5\nstate = "stopped"\nsince = "boot-up"', STATE | {"state": "stopped", "since": "boot-up"}),
    ("state", 'node = 5\nstate = "operational"\nstays = true', STATE | {"state": "operational", "stays": True}),
    ("state", 'node = 5\ndrive = "fault"\naxis = 2', STATE | {"drive": "fault", "axis": 2}),
    ("signal", 'select = "5.*"', SIGNAL),
    (
        "signal",
        'select = "5.*"\nmin = -10\nmax = 10.5\nbus = "can1"',
        SIGNAL | {"min": -10, "max": 10.5, "bus": "can1"},
    ),
    ("signal", 'select = "5.*"\nperiod_ms = 10', SIGNAL | {"period_ns": 10_000_000, "tolerance_ns": 1_000_000}),
    (
        "signal",
        'select = "5.*"\nperiod_us = 500\ntolerance_percent = 20',
        SIGNAL | {"period_ns": 500_000, "tolerance_ns": 100_000},
    ),
    (
        "heartbeat",
        "node = 5\nperiod_ms = 1000\ntolerance_ms = 0.5",
        {"bus": None, "node": 5, "period_ns": 1_000_000_000, "tolerance_ns": 500_000},
    ),
    ("sync", "period_us = 10000\ntolerance_us = 0", {"bus": None, "period_ns": 10_000_000, "tolerance_ns": 0}),
    ("emcy", 'occurs = "never"', {"bus": None, "node": None, "code": None, "occurs": "never"}),
    (
        "emcy",
        'occurs = "may"\nnode = 5\ncode = "81xx"',
        {"bus": None, "node": 5, "code": [0x8100, 0xFF00], "occurs": "may"},
    ),
    ("emcy", 'occurs = "must"\ncode = "8130"', {"bus": None, "node": None, "code": [0x8130, 0xFFFF], "occurs": "must"}),
    ("problem", "occurs = 0", INCIDENT | {"occurs": [0, 0]}),
    ("problem", 'kind = "node-silent"\nnode = 5\noccurs = 2', INCIDENT | SILENT | {"node": 5, "occurs": [2, 2]}),
    ("problem", 'kind = "node-*"\noccurs = "1-3"', INCIDENT | {"kind": "node-*", "occurs": [1, 3]}),
    ("problem", 'kind = "node-silent"\noccurs = "1 - "', INCIDENT | SILENT | {"occurs": [1, None]}),
    ("problem", "ends_within_s = 0.5", INCIDENT | {"ends_within_ns": 500_000_000}),
    ("problem", 'kind = "node-silent"\ncause = "bus-???"', INCIDENT | SILENT | {"cause": "bus-???"}),
    ("latency", 'of = "sdo"\nmax_ms = 20', LATENCY),
    (
        "latency",
        'of = "sdo"\nnode = 5\nobject = "1018:01"\nmax_us = 500',
        LATENCY | {"node": 5, "index": 0x1018, "sub": 1, "max_ns": 500_000},
    ),
    ("latency", 'of = "sync"\npdo = "tpdo3"\nmax_ms = 2', LATENCY | {"of": "sync", "pdo": 3, "max_ns": 2_000_000}),
    ("latency", 'of = "nmt"\nmax_ms = 20', LATENCY | {"of": "nmt"}),
    ("load", "max_percent = 60", {"bus": None, "max_percent": 60, "bit_rate": None, "window_ns": 100_000_000}),
    (
        "load",
        'max_percent = 0.5\nbitrate = "500k"\nwindow_ms = 100',
        {"bus": None, "max_percent": 0.5, "bit_rate": 500_000, "window_ns": 100_000_000},
    ),
]


@pytest.mark.parametrize(("table", "content", "wanted"), MEANT, ids=[f"{row[0]}-{row[1]}" for row in MEANT])
def test_what_is_written_is_what_the_core_gets(
    tmp_path: Path, table: str, content: str, wanted: dict[str, Any]
) -> None:
    given = only(tmp_path, table, content)
    assert given == wanted
    assert [type(value) for value in given.values()] == [type(wanted[key]) for key in given]


def test_every_key_is_tried() -> None:
    tried = {(table, line.split(" = ")[0]) for table, content, _ in MEANT for line in content.splitlines()}
    allowed = {(name, key) for name, keys in SCHEMA.items() for key in keys if key != "bus"}
    untried = {("sync", "period_ms"), ("sync", "tolerance_ms"), ("sync", "tolerance_percent")}
    untried |= {("heartbeat", key) for key in ("period_us", "tolerance_us", "tolerance_percent")}
    untried |= {("signal", key) for key in ("tolerance_ms", "tolerance_us")}
    assert allowed - tried == untried, "the same readers, tried in other tables"


def test_every_state_has_its_name(tmp_path: Path) -> None:
    for key, count in (("state", 4), ("drive", 8)):
        states = re.findall('"(.*?)"', SCHEMA["state"][key][1])
        assert len(states) == count
        for state in states:
            assert only(tmp_path, "state", f'node = 5\n{key} = "{state}"')[key] == state


def test_entries_know_their_lines(tmp_path: Path) -> None:
    content = (
        '# of a drive\n\n[[load]]\nmax_percent = 50\n[[emcy]]  # none\noccurs = "never"\n[[load]]\nmax_percent = 1\n'
    )
    found = normal(tmp_path, content)
    assert [entry["line"] for entry in found["load"]] == [3, 7]
    assert [entry["line"] for entry in found["emcy"]] == [5]
    assert found["file"] == str(tmp_path / "boot.expect.toml")
    assert set(found) == {"file", *SCHEMA}


MISTAKES: list[tuple[str, int | None, str]] = [
    # text, line, what is said in English
    (
        "[[sdos]]\n",
        1,
        "unknown key sdos (did you mean [[sdo]]?); allowed: [[sdo]], [[state]], [[signal]], [[heartbeat]]",
    ),
    ("node = 5\n", 1, "unknown key node; allowed: [[sdo]]"),
    ("[sdo]\nnode = 5\n", 1, "key sdo must be a table, [[sdo]]"),
    ("[[sdo]]\nnode = 5\n", 1, "missing key sdo.object"),
    ('[[sdo]]\nobject = "1017:00"\n', 1, "missing key sdo.node"),
    (
        f"[[sdo]]\n{A_WRITE}vlaue = 1\n",
        4,
        "unknown key sdo.vlaue (did you mean value?); allowed: node, object, direction",
    ),
    (f"[[sdo]]\n{A_WRITE}colour = 1\n", 4, "unknown key sdo.colour; allowed: node, object, direction, value, data"),
    ('[[signal]]\nselect = " , "\n', 2, '" , " is not a non-empty text in quotes'),
    ('[[sdo]]\nnode = 128\nobject = "1017:00"\n', 2, "128 is not a node-ID, 1 to 127"),
    ('[[sdo]]\nnode = "5"\nobject = "1017:00"\n', 2, '"5" is not a node-ID, 1 to 127'),
    ('[[sdo]]\nnode = true\nobject = "1017:00"\n', 2, "true is not a node-ID, 1 to 127"),
    ("[[sdo]]\nnode = 5\nobject = 1017\n", 3, 'such as "1017:00" or "0x1018:04"'),
    ('[[sdo]]\nnode = 5\nobject = "1017"\n', 3, 'such as "1017:00" or "0x1018:04"'),
    ('[[sdo]]\nnode = 5\nobject = "11017:00"\n', 3, 'such as "1017:00" or "0x1018:04"'),
    (f'[[sdo]]\n{A_WRITE}direction = "read"\n', 4, '"read" is not one of "upload", "download"'),
    (f"[[sdo]]\n{A_WRITE}value = 1979-05-27\n", 4, "is not a number of up to 64 bits, true, false or a text in quotes"),
    (f"[[sdo]]\n{A_WRITE}value = 36893488147419103232\n", 4, "is not a number of up to 64 bits"),
    (f"[[sdo]]\n{A_WRITE}value = nan\n", 4, "is not a number of up to 64 bits"),
    (f"[[sdo]]\n{A_WRITE}value = [1]\n", 4, "is not a number of up to 64 bits"),
    (f'[[sdo]]\n{A_WRITE}data = "E8 0"\n', 4, 'is not hexadecimal bytes in quotes, such as "E8 03"'),
    (f'[[sdo]]\n{A_WRITE}value = 1\ndata = "E8"\n', 5, "keys sdo.data and value cannot be used together"),
    (f'[[sdo]]\n{A_WRITE}outcome = "fine"\n', 4, '"fine" is not one of "ok", "aborted", "any"'),
    (f"[[sdo]]\n{A_WRITE}abort = 0x06010002\n", 4, 'eight hexadecimal digits in quotes, such as "06010002"'),
    (f'[[sdo]]\n{A_WRITE}abort = "0601"\n', 4, 'eight hexadecimal digits in quotes, such as "06010002"'),
    (f'[[sdo]]\n{A_WRITE}outcome = "ok"\nabort = "06010002"\n', 5, 'sdo.abort needs outcome = "aborted"'),
    (f'[[sdo]]\n{A_WRITE}value = 1\noutcome = "aborted"\n', 4, 'sdo.value needs outcome = "ok"'),
    (f"[[sdo]]\n{A_WRITE}sequence = 1\n", 4, "1 is not a non-empty text in quotes"),
    (f"[[sdo]]\n{A_WRITE}count = 0\n", 4, "0 is not a whole number, 1-1000000"),
    (f"[[sdo]]\n{A_WRITE}count = 1.5\n", 4, "1.5 is not a whole number, 1-1000000"),
    (f"[[sdo]]\n{A_WRITE}count = true\n", 4, "true is not a whole number, 1-1000000"),
    (f"[[sdo]]\n{A_WRITE}never = false\n", 4, "key sdo.never: false is not true; otherwise leave it out"),
    (f'[[sdo]]\n{A_WRITE}never = "yes"\n', 4, '"yes" is neither true nor false'),
    (f"[[sdo]]\n{A_WRITE}count = 1\nnever = true\n", 5, "keys sdo.never and count cannot be used together"),
    (f'[[sdo]]\n{A_WRITE}never = true\nsequence = "a"\n', 5, "keys sdo.sequence and never cannot be used together"),
    (f"[[sdo]]\n{A_WRITE}never = true\nwithin_s = 1\n", 5, "keys sdo.within_s and never cannot be used together"),
    (f'[[sdo]]\n{A_WRITE}sequence = "a"\ncount = 2\n', 5, "keys sdo.count and sequence cannot be used together"),
    (f"[[sdo]]\n{A_WRITE}within_s = 0\n", 4, "0 is not a number above 0 and up to 1000000000"),
    (f"[[sdo]]\n{A_WRITE}within_s = -1\n", 4, "-1 is not a number above 0"),
    (f"[[sdo]]\n{A_WRITE}within_s = inf\n", 4, "inf is not a number above 0"),
    (f'[[sdo]]\n{A_WRITE}within_s = "1 s"\n', 4, '"1 s" is not a number above 0'),
    (f"[[sdo]]\n{A_WRITE}within_ms = 1\n", 4, "unknown key sdo.within_ms (did you mean within_s?)"),
    (f'[[sdo]]\n{A_WRITE}bus = ""\n', 4, "is not a non-empty text in quotes"),
    ("[[state]]\nnode = 5\n", 1, "[[state]] needs one of these keys: state, drive"),
    (
        '[[state]]\nnode = 5\nstate = "operational"\ndrive = "fault"\n',
        4,
        "keys state.drive and state cannot be used together",
    ),
    (
        '[[state]]\nnode = 5\nstate = "Operational"\n',
        3,
        'one of "boot-up", "stopped", "operational", "pre-operational"',
    ),
    ('[[state]]\nnode = 5\ndrive = "enabled"\n', 3, '"enabled" is not one of "not-ready-to-switch-on"'),
    ('[[state]]\nnode = 5\nstate = "operational"\naxis = 1\n', 4, "key state.axis needs drive"),
    ('[[state]]\nnode = 5\ndrive = "fault"\naxis = 9\n', 4, "9 is not a whole number, 1-8"),
    ('[[state]]\nnode = 5\nstate = "boot-up"\nstays = true\n', 4, "in which no node stays"),
    ('[[state]]\nnode = 5\nstate = "stopped"\nsince = "boot"\n', 4, '"boot" is not one of "start", "boot-up"'),
    (
        '[[state]]\nnode = 5\nstate = "stopped"\nby = 1\n',
        4,
        "unknown key state.by; allowed: node, state, drive, axis, by_s",
    ),
    ("[[signal]]\nmin = 1\n", 1, "missing key signal.select"),
    ('[[signal]]\nselect = "a"\nmin = "1"\n', 3, '"1" is not a number'),
    ('[[signal]]\nselect = "a"\nmin = 2\nmax = 1\n', 4, "key signal.max: 1 is below min 2"),
    ('[[signal]]\nselect = "a"\ntolerance_ms = 1\n', 3, "signal.tolerance_ms needs period_ms, period_us"),
    (
        '[[signal]]\nselect = "a"\nperiod_ms = 1\nperiod_us = 1\n',
        4,
        "keys signal.period_us and period_ms cannot be used together",
    ),
    ('[[signal]]\nselect = "a"\nperiod_s = 1\n', 3, "unknown key signal.period_s (did you mean period_"),
    ("[[heartbeat]]\nnode = 5\n", 1, "[[heartbeat]] needs one of these keys: period_ms, period_us"),
    ("[[heartbeat]]\nnode = 5\nperiod_ms = 0\n", 3, "0 is not a number above 0 and up to 4000000"),
    ("[[heartbeat]]\nnode = 5\nperiod_ms = 1e-9\n", 3, "1e-09 is not a number above 0 and up to 4000000"),
    ("[[heartbeat]]\nnode = 5\nperiod_ms = 5\ntolerance_ms = -1\n", 4, "-1 is not a number, 0 to 4000000"),
    ("[[heartbeat]]\nnode = 5\nperiod_ms = 5\ntolerance_percent = 2000\n", 4, "2000 is not a number, 0 to 1000"),
    (
        "[[heartbeat]]\nnode = 5\nperiod_ms = 5\ntolerance_us = 1\ntolerance_percent = 1\n",
        5,
        "keys heartbeat.tolerance_percent and tolerance_us cannot be used together",
    ),
    ("[[sync]]\nnode = 1\nperiod_us = 1\n", 2, "unknown key sync.node; allowed: period_ms, period_us"),
    ("[[sync]]\nperiod_us = 5000000000\n", 2, "5000000000 is not a number above 0 and up to 4000000000"),
    ("[[emcy]]\nnode = 5\n", 1, "missing key emcy.occurs"),
    ('[[emcy]]\noccurs = "sometimes"\n', 2, '"sometimes" is not one of "must", "may", "never"'),
    ('[[emcy]]\noccurs = "may"\ncode = "8x30"\n', 3, "the last ones may be x"),
    ('[[emcy]]\noccurs = "may"\ncode = 0x8130\n', 3, 'such as "8130" or "81xx"'),
    ("[[problem]]\nnode = 5\n", 1, "[[problem]] needs one of these keys: occurs, ends_within_s, cause"),
    ("[[problem]]\noccurs = -1\n", 2, "-1 is neither a count, 0 to 1000000, nor a range in quotes"),
    ("[[problem]]\noccurs = true\n", 2, "true is neither a count"),
    ("[[problem]]\noccurs = 1.5\n", 2, "1.5 is neither a count"),
    ('[[problem]]\noccurs = "3-1"\n', 2, '"3-1" is neither a count'),
    ('[[problem]]\noccurs = "never"\n', 2, '"never" is neither a count'),
    ('[[problem]]\noccurs = "1-9999999"\n', 2, '"1-9999999" is neither a count'),
    ('[[problem]]\nkind = "Node"\noccurs = 1\n', 2, '"Node" is not a kind of problem in quotes'),
    ("[[problem]]\nkind = 5\noccurs = 1\n", 2, "5 is not a kind of problem in quotes"),
    (
        '[[problem]]\noccurs = 1\nkind = "node-silence"\n',
        3,
        'no kind of problem "node-silence"; closest: node-silent',
    ),
    ('[[problem]]\nkind = "q*"\noccurs = 1\ncause = "zzz*"\n', 4, 'no kind of problem "zzz*"'),
    ("[[problem]]\nends_within_s = 0\n", 2, "0 is not a number above 0 and up to 1000000000"),
    (
        "[[problem]]\noccurs = 0\nends_within_s = 1\n",
        3,
        "keys problem.ends_within_s and occurs = 0 cannot be used together",
    ),
    ("[[problem]]\nkinds = 1\noccurs = 0\n", 2, "unknown key problem.kinds (did you mean kind?)"),
    ("[[latency]]\nmax_ms = 1\n", 1, "missing key latency.of"),
    ('[[latency]]\nof = "sdo"\n', 1, "[[latency]] needs one of these keys: max_ms, max_us"),
    ('[[latency]]\nof = "pdo"\nmax_ms = 1\n', 2, '"pdo" is not one of "sdo", "sync", "nmt"'),
    ('[[latency]]\nof = "nmt"\nobject = "1017:00"\nmax_ms = 1\n', 3, 'latency.object needs of = "sdo"'),
    ('[[latency]]\nof = "sdo"\npdo = "TPDO1"\nmax_ms = 1\n', 3, 'latency.pdo needs of = "sync"'),
    ('[[latency]]\nof = "sync"\npdo = "RPDO1"\nmax_ms = 1\n', 3, 'is not a TPDO, "TPDO1" to "TPDO512"'),
    ("[[load]]\nbitrate = 500000\n", 1, "missing key load.max_percent"),
    ("[[load]]\nmax_percent = 101\n", 2, "101 is not a number above 0 and up to 100"),
    ("[[load]]\nmax_percent = 0\n", 2, "0 is not a number above 0 and up to 100"),
    ('[[load]]\nmax_percent = 1\nbitrate = "5"\n', 3, '"5" is not a bit rate, 1000 to 1000000'),
    ("[[load]]\nmax_percent = 1\nwindow_s = 1\n", 3, "unknown key load.window_s (did you mean window_ms?)"),
    (
        "# first\n[[load]]\nmax_percent = 1\n\n[[load]]\nmax_percent = 2\nbus = 1\n",
        7,
        "1 is not a non-empty text in quotes",
    ),
    ("[[load]]\nmax_percent = \n", 2, "not valid TOML"),
    ("sdo = 5\n", 1, "key sdo must be a table, [[sdo]]"),
]


@pytest.mark.parametrize(("content", "line", "said"), MISTAKES, ids=[row[0] for row in MISTAKES])
def test_a_mistake_is_named_with_its_line(tmp_path: Path, content: str, line: int | None, said: str) -> None:
    path = tmp_path / "boot.expect.toml"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        read(path)
    assert str(caught.value).startswith(f"{path}:{line}:")
    assert said in str(caught.value)
    for lang in LANGUAGES:
        sentence = caught.value.in_words(Words(lang))
        assert "\n" not in sentence and "{" not in sentence


def test_every_kind_of_mistake_is_tried(tmp_path: Path) -> None:
    said = set()
    for content, *_ in MISTAKES:
        (tmp_path / "boot.expect.toml").write_text(content, encoding="utf-8")
        with pytest.raises(ConfigError) as caught:
            read(tmp_path / "boot.expect.toml")
        said.add(caught.value.key)
    assert said >= {f"config.{sentence}" for keys in SCHEMA.values() for sentence, _ in keys.values()}
    assert said >= {
        f"expect.{name}"
        for name in ("exclusive", "lacks_one", "goes_with", "only_true", "below_min", "no_problem", "no_problem_near")
    }


def test_a_file_that_cannot_be_read_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot read the expectations: no such file"):
        read(tmp_path / "none.expect.toml")
    (tmp_path / "latin.expect.toml").write_bytes(b"# ok\n# \xe9\n")
    with pytest.raises(ConfigError, match=r"latin.expect.toml:2: not UTF-8 text"):
        read(tmp_path / "latin.expect.toml")


@pytest.mark.parametrize(
    ("capture", "found"),
    [
        ("boot.log", True),
        ("boot.log.gz", True),
        ("boot.LOG.ZST", True),
        ("boot.asc", True),
        ("boot.mcap", True),
        ("boot", True),
        ("boot.v2.log", False),
        ("boot.v2", False),
        ("other.log", False),
        (".log", False),
        ("-", False),
    ],
)
def test_the_file_beside_a_capture(tmp_path: Path, capture: str, found: bool) -> None:
    (tmp_path / "boot.expect.toml").write_text("")
    name = capture if capture == "-" else str(tmp_path / capture)
    assert beside(name) == (tmp_path / "boot.expect.toml" if found else None)


def test_every_format_has_its_file_beside(tmp_path: Path) -> None:
    (tmp_path / "boot.expect.toml").write_text("")
    for suffix in suffixes():
        assert beside(str(tmp_path / f"boot{suffix}"))


def test_the_name_of_a_capture_may_have_dots(tmp_path: Path) -> None:
    (tmp_path / "boot.v2.expect.toml").write_text("")
    assert beside(str(tmp_path / "boot.v2.log.xz")) == tmp_path / "boot.v2.expect.toml"
    assert beside(str(tmp_path / "boot.v2")) == tmp_path / "boot.v2.expect.toml"


def written_examples() -> list[Any]:
    """The files of expectations that help and README show."""
    shown = [pytest.param(Words(lang)("expect.examples").partition("\n\n")[2], id=f"help-{lang}") for lang in LANGUAGES]
    readme = (TESTS.parent / "README.md").read_text(encoding="utf-8")
    fenced = re.findall(r"^```toml\n(.*?)^```$", readme, flags=re.DOTALL | re.MULTILINE)
    return shown + [pytest.param(part, id=f"readme-{place}") for place, part in enumerate(fenced) if "[[emcy]]" in part]


@pytest.mark.parametrize("content", written_examples())
def test_what_is_shown_is_valid(tmp_path: Path, content: str) -> None:
    assert all(normal(tmp_path, content)[table] for table in ("sdo", "state", "emcy"))


@pytest.mark.parametrize("lang", LANGUAGES)
def test_help_shows_every_key(lang: str) -> None:
    shown = Words(lang)("expect.examples")
    assert not {key for keys in SCHEMA.values() for key in keys if not re.search(rf"\b{key}\b", shown)}
