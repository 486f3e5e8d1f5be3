"""`canalyze info`: what a file is, of every kind of input, in both languages."""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import Any

import pytest
from captures import SAMPLES
from conftest import NOTES, Done, Runner

LOG = """\
(1700000000.000000) can0 701#05
(1700000000.500000) can1 00000705#R
(1700000000.250000) can0 185##1AABB
# a comment
(1700000001.000000) can0 20000004#0000000000000000
(1700000001.000000) can0 701#0
(1700000002.000000) can0 701#05 T
"""


def records(done: Done) -> list[dict[str, Any]]:
    return [json.loads(line) for line in done.lines]


def test_figures_of_a_log(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.log").write_text(LOG)
    done = canalyze("info", "--format", "jsonl", "a.log")
    (record,) = records(done)
    assert (done.code, done.err) == (0, "")
    assert (record["format"], record["compression"], record["size"]) == ("candump", None, len(LOG))
    assert record["buses"] == [{"bus": "can0", "frames": 4}, {"bus": "can1", "frames": 1}]
    assert record["kinds"] == {"data": 2, "remote": 1, "fd": 1, "error": 1, "standard": 3, "extended": 1}
    assert record["directions"] == {"rx": 0, "tx": 1}
    assert (record["frames"], record["unstamped"]) == (5, 0)
    assert (record["first_t"], record["last_t"]) == ("1700000000.000000", "1700000002.000000")
    assert (record["seconds"], record["decimals"]) == ("2.000000", [6, 6])
    assert (record["first_date"], record["zone"]) == ("2023-11-14 22:13:20.000000", "utc")
    assert (record["backward"], record["backward_most_us"]) == (1, 250_000)
    assert record["unreadable"] == {"count": 1, "first_line": 6, "first_offset": None, "further_buses": 0}
    assert (record["damage"], record["damages"]) == ([], 0)


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_the_report_says_the_same(canalyze: Runner, tmp_path: Path, lang: str) -> None:
    (tmp_path / "a.log").write_text(LOG)
    done = canalyze("--lang", lang, "info", "a.log")
    assert (done.code, done.err, done.lines[0]) == (0, "", "a.log")
    for fact in ("2023-11-14 22:13:20.000000", "UTC", "2.000000 s", "can0", "can1", "250 ms", "CAN FD"):
        assert fact in done.out, fact


def test_stamps_that_tell_no_date(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "zero").write_text("(0.000000) can0 701#05\n(1.500000) can0 701#05\n")
    (tmp_path / "local").write_text(" (2026-09-15 18:44:56.479963)  can0  701   [1]  05\n")
    (tmp_path / "bare").write_text(NOTES)
    zero, local, bare = records(canalyze("info", "--format", "jsonl", "zero", "local", "bare"))
    assert (zero["first_date"], zero["zone"], zero["seconds"]) == (None, None, "1.500000")
    assert (local["first_date"], local["zone"]) == ("2026-09-15 18:44:56.479963", "local")
    assert (bare["first_t"], bare["seconds"], bare["decimals"], bare["unstamped"]) == (None, None, None, 10)
    said = canalyze("--lang", "en", "info", "zero", "local", "bare").out
    assert "unknown origin" in said and "time zone unknown" in said and "no timestamps" in said


def test_each_file_is_by_itself(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a").write_text("(1.0) can7 701#05\n")
    (tmp_path / "b").write_text("(1.0) can3 701#05\n(2.0) can7 701#05\n")
    found = records(canalyze("info", "--format", "jsonl", "a", "b", "a"))
    assert [[bus["bus"] for bus in one["buses"]] for one in found] == [["can7"], ["can3", "can7"], ["can7"]]
    assert [one["file"] for one in found] == ["a", "b", "a"]
    assert canalyze("info", "a", "b").out.count("\n\n") == 1


def test_what_cannot_be_read_does_not_stop_the_others(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    (tmp_path / "prose").write_text("nothing of it is a frame\n" * 20)
    (tmp_path / "empty").write_text("")
    done = canalyze("--lang", "en", "info", "missing", "prose", notes, "empty", ".")
    assert done.code == 2
    assert [line.split(": ")[1] for line in done.complaints] == ["missing", "prose", "empty", "."]
    assert done.out.startswith(notes)


def test_compression_and_damage(canalyze: Runner, tmp_path: Path) -> None:
    text = (SAMPLES / "network" / "sync-and-pdos.log").read_bytes()
    packed = gzip.compress(text)
    (tmp_path / "a.gz").write_bytes(packed)
    (tmp_path / "cut.gz").write_bytes(packed[:-100])
    whole, cut = records(canalyze("info", "--format", "jsonl", "a.gz", "cut.gz"))
    assert (whole["compression"], whole["size"], whole["damages"]) == ("gzip", len(packed), 0)
    assert cut["damage"] == [
        {"kind": "cut", "line": None, "offset": len(packed) - 100, "bytes": None, "frames": None},
    ]
    assert 0 < cut["frames"] < whole["frames"]
    done = canalyze("--lang", "en", "info", "cut.gz")
    assert (done.code, done.err) == (0, "")
    assert f"damage at byte {len(packed) - 100}: the file ends in the middle of a record" in done.out


def test_standard_input(canalyze: Runner) -> None:
    (record,) = records(canalyze("info", "--format", "jsonl", "-", stdin=NOTES.encode()))
    assert (record["file"], record["frames"], record["size"]) == ("stdin", 10, len(NOTES))
    assert canalyze("info", stdin=NOTES.encode()).code == 0


def test_output_goes_to_a_file(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    assert canalyze("info", notes, "-o", "out.txt").out == ""
    assert (tmp_path / "out.txt").read_text().startswith(notes)
    assert canalyze("info", "missing", "-o", "none.txt").code == 2
    assert not (tmp_path / "none.txt").exists()


@pytest.mark.parametrize("form", ["asc", "blf", "trc"])
def test_channels_are_told_with_their_buses(canalyze: Runner, tmp_path: Path, form: str) -> None:
    (tmp_path / "a.log").write_text("(1700000000.5) can1 701#05\n(1700000000.6) can0 701#05\n")
    assert canalyze("convert", "a.log", f"a.{form}").code == 0
    (record,) = records(canalyze("info", "--format", "jsonl", f"a.{form}"))
    told = record["contents"]["dialect"]["channels"]
    assert sorted(told.split(", ")) == ["1 = can0", "2 = can1"]
    assert f"channels: {told}" in canalyze("--lang", "en", "info", f"a.{form}").out


def test_a_file_that_cannot_be_read_is_not_called_whole(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.db").write_bytes(b"SQLite format 3\0" + bytes(4080))
    done = canalyze("info", "a.db")
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize("content", [b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n", b"PK\x03\x04\x14\0\0\0", b"\x7fELF\2\1\1"])
def test_what_is_no_capture_hears_of_every_format(canalyze: Runner, tmp_path: Path, content: bytes, lang: str) -> None:
    (tmp_path / "a.bin").write_bytes(content)
    done = canalyze("--lang", lang, "decode", "a.bin")
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert "canalyze decode --help" in done.err
    told = canalyze("--lang", lang, "decode", "--help").out
    for name in ("candump", "ASC", "BLF", "MCAP", "pcap", "TRC", "MF4", "CSV", "SQLite"):
        assert name in told


def test_a_format_that_was_asked_for_is_named(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.log").write_text(LOG)
    for form, title in (("asc", "Vector ASC"), ("blf", "Vector BLF"), ("mcap", "MCAP"), ("pcap", "pcap")):
        done = canalyze("--lang", "en", "decode", "--input-format", form, "a.log")
        assert (done.code, done.out) == (2, "")
        assert f"read as {title}, no CAN frames" in done.complaints[-1]
        assert "candump, asc, blf, mcap, pcap, pcapng, rows, trc, mf4, csv, db" in done.complaints[-1]


def test_a_format_that_does_not_fit_names_those_that_there_are(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.log").write_text(LOG)
    for lang in ("en", "zh"):
        for form in ("asc", "trc", "csv", "db", "pcapng", "nothing"):
            done = canalyze("--lang", lang, "decode", "--input-format", form, "a.log")
            assert (done.code, done.out) == (2, ""), form
            assert "candump, asc, blf, mcap, pcap, pcapng, rows, trc, mf4, csv, db" in done.complaints[-1], form
    # Where nobody has said what it is there is nothing to choose.
    (tmp_path / "a.asc").write_text("date Sam Sep 30 15:06:13.191 2017\nbase hex  timestamps absolute\n")
    assert "--input-format" not in canalyze("--lang", "en", "decode", "a.asc").err


@pytest.mark.parametrize(
    "stamps",
    [(1, 3, 9), (1, 5, 3, 9), (100, 5, 7, 9), (10, 2, 12, 1), (5, 4.9995, 5.2), (7,), (9, 1, 1, 1)],
)
def test_a_time_span_is_the_same_in_every_report(canalyze: Runner, tmp_path: Path, stamps: tuple[float, ...]) -> None:
    (tmp_path / "a.log").write_text("".join(f"({1_700_000_000 + at:.6f}) can0 701#05\n" for at in stamps))
    keys = ("first_t", "last_t", "seconds", "backward", "backward_most_us")
    (whole,) = records(canalyze("info", "--format", "jsonl", "a.log"))
    capture = records(canalyze("summary", "--format", "jsonl", "a.log"))[0]
    assert [whole[key] for key in keys] == [capture[key] for key in keys]
    assert float(whole["seconds"]) >= 0


def test_info_takes_what_says_how_topics_are_read(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.log").write_text(LOG)
    assert canalyze("convert", "a.log", "a.mcap").code == 0
    (record,) = records(canalyze("info", "--format", "jsonl", "--topic", "/can1/*", "a.mcap"))
    assert [bus["bus"] for bus in record["buses"] if bus["frames"]] == ["can1"]
