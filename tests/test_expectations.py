"""Files of expectations: every key comes through, every mistake is named with its line and with what is allowed.

`canalyze expect` and `check --expect`: a good capture meets its own expectations, every seeded fault is a finding. Must
not: test what an expectation means in each case; the core's own tests have that.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from captures import DATA, EDS, SAMPLES, SHARED, TESTS, CanFrame, Row, log_text, read_log, run_canalyze
from conftest import Runner
from network import echoed_late, jittered
from test_network_clean import MASTERS, frames_of
from test_stacks import console_form

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


CASES = tomllib.loads((DATA / "expectations.toml").read_text("utf-8"))
MEANT: list[tuple[str, str, dict[str, Any]]] = []
"""Tables and what is written in them, with what the core gets of it."""
for case in CASES["meant"]:
    first = next((wanted for table, _, wanted in MEANT if table == case["table"]), {})
    MEANT.append((case["table"], case["content"], first | json.loads(case["wanted"])))


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


MISTAKES = [(case["content"], case["said"]) for case in CASES["mistake"]]


@pytest.mark.parametrize(("content", "said"), MISTAKES, ids=[row[0] for row in MISTAKES])
def test_a_mistake_is_named_with_its_line(tmp_path: Path, content: str, said: str) -> None:
    path = tmp_path / "boot.expect.toml"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        read(path)
    assert str(caught.value) == f"{path}{said}"
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


DRIVE = ("--eds", f"5={EDS / 'drive.eds'}")
GOOD = [
    *sorted((SAMPLES / "stacks").glob("*.log")),
    *sorted((SAMPLES / "network").glob("*.log")),
    *(SAMPLES / name for name in ("zephyr-sdo.log", "services.log", "sdo-block.log", "two-nodes-interleaved.log")),
]


def described(capture: Path) -> list[str]:
    """The options that name the devices of a session of a network."""
    if capture.parent.name != "network":
        return []
    nodes = json.loads(capture.with_suffix(".json").read_text())["nodes"]
    return [part for row in nodes if row["eds"] for part in ("--eds", f"{row['node']}={EDS / row['eds']}")]


@cache
def draft(capture: Path, *options: str) -> bytes:
    return run_canalyze(["expect", "--lang", "en", *options, capture])


def expectations_of(capture: Path, scratch: Path, *options: str) -> Path:
    path = scratch / f"{capture.stem}.expect.toml"
    path.write_bytes(draft(capture, *options))
    return path


def checked(captures: Path | Sequence[Path], file: Path, *options: str) -> list[Row]:
    """What `check` says of expectations that are not met, of one capture or of several."""
    arguments: list[str | Path] = [
        "check",
        "--format",
        "jsonl",
        "--lang",
        "en",
        "--fail-on",
        "never",
        "--expect",
        file,
        *options,
        *([captures] if isinstance(captures, Path) else captures),
    ]
    rows = [json.loads(line) for line in run_canalyze(arguments).splitlines()]
    return [row for row in rows if row["kind"] == "finding" and row["code"].startswith("EXP")]


def failed(captures: Path | Sequence[Path], file: Path, *options: str) -> list[Row]:
    return [row for row in checked(captures, file, *options) if row["severity"] != "info"]


@pytest.mark.parametrize("capture", GOOD, ids=lambda path: path.stem)
def test_a_capture_meets_its_own_expectations(capture: Path, tmp_path: Path) -> None:
    options = [*described(capture), "--bitrate", "500k"]
    file = expectations_of(capture, tmp_path, *options)
    found = json.loads(read(file).normal)
    assert sum(len(found[table]) for table in found if table != "file") > 1
    assert not checked(capture, file, *options)


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_a_draft_is_the_same_each_time(lang: str) -> None:
    arguments: list[str | Path] = ["expect", "--lang", lang, *DRIVE, SAMPLES / "network" / "sync-and-pdos.log"]
    assert run_canalyze(arguments) == run_canalyze(arguments)


@pytest.mark.parametrize("name", sorted(path.stem for path in (SAMPLES / "stacks").glob("*.log")))
def test_other_recordings_of_a_session_meet_them(name: str, tmp_path: Path) -> None:
    capture = SAMPLES / "stacks" / f"{name}.log"
    file = expectations_of(capture, tmp_path)
    console = tmp_path / "console.txt"
    console.write_text(console_form(capture.read_text()))
    unstamped = tmp_path / "unstamped.txt"
    unstamped.write_text("".join(line.split("  ", 1)[1] for line in console.read_text().splitlines(keepends=True)))
    other = SHARED / "stacks" / f"{name}.log"
    recordings = [recording for recording in (console, unstamped, other) if recording.exists()]
    assert not [(row["file"], row["message"]) for row in failed(recordings, file)]


def test_the_recorded_session_meets_them_in_every_dialect(tmp_path: Path) -> None:
    recorded = SAMPLES / "recorded"
    file = expectations_of(recorded / "session.log", tmp_path)
    dialects = [path for path in sorted(recorded.glob("session.*")) if path.suffix in (".log", ".candump")]
    assert len(dialects) > 10
    assert not [(row["file"], row["message"]) for row in failed(dialects, file)]


@pytest.mark.parametrize("name", ["configuring", "remapping", "sync-and-pdos", "drive_by_sdo", "states"])
def test_a_late_echo_changes_no_verdict(name: str, tmp_path: Path) -> None:
    """What an SDO write changes holds from its pair on, also where its channel is silent after it."""
    capture = tmp_path / "base.log"
    capture.write_bytes(log_text(frames_of(name)))
    file = expectations_of(capture, tmp_path)
    for seed in range(1, 4):
        late = tmp_path / f"late{seed}.log"
        late.write_bytes(log_text(jittered(echoed_late(frames_of(name), MASTERS, seed=seed), most_us=50, seed=seed)))
        assert not failed(late, file)


def test_lines_of_what_only_the_end_proves(tmp_path: Path) -> None:
    """The value differs at the beginning; long after it, the end says so, and the lines are still there."""
    write = ["605#2B17100064000000", "585#6017100000000000"]
    poll = ["605#4000100000000000", "585#4300100091010F00"]
    capture, file = tmp_path / "long.log", tmp_path / "long.toml"
    frames = ["705#00", *write, *poll * 40]
    capture.write_text("".join(f"({1 + at / 100:.6f}) can0 {frame}\n" for at, frame in enumerate(frames)))
    file.write_text('[[sdo]]\nnode = 5\nobject = "1017:00"\nvalue = 500\n')
    (found,) = failed(capture, file)
    assert (found["code"], found["frame"]) == ("EXP003", 3)
    assert [line["frame"] for line in found["lines"]] == [2, 3]


SESSION = SAMPLES / "network" / "sync-and-pdos.log"
REMAPPED = SAMPLES / "stacks" / "c3-pdo-remap-master-sync.log"
Frames = list[CanFrame]


def without(frames: Frames, *numbers: int) -> Frames:
    return [frame for number, frame in enumerate(frames, 1) if number not in numbers]


def changed(frames: Frames, number: int, at: int, data: bytes) -> Frames:
    frame = frames[number - 1]
    new = replace(frame, data=frame.data[:at] + data + frame.data[at + len(data) :])
    return [*frames[: number - 1], new, *frames[number:]]


def later(frames: Frames, number: int, by_us: int) -> Frames:
    """Returns the frames, with one and all after it later."""
    return [replace(frame, t_us=frame.t_us + by_us * (place >= number)) for place, frame in enumerate(frames, 1)]


def slower(frames: Frames, times: int) -> Frames:
    start = frames[0].t_us
    return [replace(frame, t_us=start + (frame.t_us - start) * times) for frame in frames]


def inserted(frames: Frames, number: int, can_id: int, data: str) -> Frames:
    before = frames[number - 2]
    return [
        *frames[: number - 1],
        replace(before, can_id=can_id, data=bytes.fromhex(data), t_us=before.t_us + 1),
        *frames[number - 1 :],
    ]


def flooded(frames: Frames) -> Frames:
    first = frames[100]
    flood = [replace(first, can_id=0x7F0, data=bytes(8), t_us=first.t_us + 300 * place) for place in range(3500)]
    return sorted([*frames, *flood], key=lambda frame: frame.t_us)


def first_of(capture: Path, can_id: int, data: str = "", nth: int = 1) -> int:
    """The number of a frame in a capture."""
    numbers = [
        number
        for number, frame in enumerate(read_log(capture.read_bytes()), 1)
        if frame.can_id == can_id and frame.data.hex().startswith(data.lower())
    ]
    return numbers[nth - 1]


LAST = len(read_log(SESSION.read_bytes()))
FAULTS: dict[str, tuple[str, Callable[[Frames], Frames], int | None]] = {
    # what is seeded: the finding, the change, the number of the frame that shows it (None: any)
    "missing transfer": ("EXP001", lambda frames: without(frames, 4, 5), LAST - 2),
    "other value": ("EXP003", lambda frames: changed(frames, 4, 4, b"\xc8\x00"), 5),
    "late state": ("EXP005", lambda frames: later(frames, first_of(SESSION, 0x705, "05"), 20_000_000), None),
    "state that never comes": (
        "EXP005",
        lambda frames: [f for f in frames if f.can_id != 0x705 or f.data[0] != 5],
        None,
    ),
    "signal out of range": (
        "EXP007",
        lambda frames: changed(frames, first_of(SESSION, 0x485, nth=9), 2, b"\xff\x7f\x00\x00"),
        first_of(SESSION, 0x485, nth=9),
    ),
    "PDO too late": (
        "EXP008",
        lambda frames: without(frames, first_of(SESSION, 0x385, nth=9)),
        first_of(SESSION, 0x385, nth=10) - 1,
    ),
    "SYNC too late": (
        "EXP010",
        lambda frames: without(frames, first_of(SESSION, 0x080, nth=9)),
        first_of(SESSION, 0x080, nth=10) - 1,
    ),
    "heartbeat too late": (
        "EXP009",
        lambda frames: without(frames, first_of(SESSION, 0x707, "05", nth=2)),
        first_of(SESSION, 0x707, "05", nth=3) - 1,
    ),
    "everything too slow": ("EXP010", lambda frames: slower(frames, 2), first_of(SESSION, 0x080, nth=2)),
    "EMCY": ("EXP012", lambda frames: inserted(frames, 200, 0x085, "3081010000000000"), 200),
    "slow response": ("EXP013", lambda frames: later(frames, 19, 200_000), 19),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_seeded_fault_is_a_finding_at_its_frame(fault: str, tmp_path: Path) -> None:
    code, change, at = FAULTS[fault]
    file = expectations_of(SESSION, tmp_path, *DRIVE)
    capture = tmp_path / "fault.log"
    capture.write_bytes(log_text(change(read_log(SESSION.read_bytes()))))
    found = failed(capture, file, *DRIVE)
    assert code in {row["code"] for row in found}, [row["message"] for row in found]
    if at is not None:
        assert at in {row["frame"] for row in found if row["code"] == code}
    lines = file.read_text().splitlines()
    for row in found:
        name, _, line = row["facts"]["expectation"].rpartition(":")
        assert (name, lines[int(line) - 1][:2]) == (str(file), "[["), "the message leads to its table"
        assert f"{name}:{line}" in row["message"]


def test_too_much_load_is_a_finding(tmp_path: Path) -> None:
    options = ("--bitrate", "500k")
    file = expectations_of(REMAPPED, tmp_path, *options)
    capture = tmp_path / "fault.log"
    capture.write_bytes(log_text(flooded(read_log(REMAPPED.read_bytes()))))
    assert "EXP014" in {row["code"] for row in failed(capture, file)}, "the file tells the bit rate"
    assert not failed(REMAPPED, file)


def test_what_is_no_capture_leaves_no_file(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "empty.log").write_bytes(b"")
    done = canalyze("expect", "empty.log", "-o", "empty.expect.toml")
    assert done.code == 2 and not (tmp_path / "empty.expect.toml").exists()
