"""More buses than are kept apart: what is on further ones is passed over and counted, and never named otherwise."""

import json
from collections.abc import Callable, Iterable
from itertools import chain
from pathlib import Path
from typing import Any

import can
import mcap_files
import pytest
from capture_frames import Recorded
from captures import CanFrame
from conftest import Runner
from other_writers import pcapng_named

from canalyze._core import Session
from canalyze.running.reading import SessionOptions

MOST = 64
START_US = 1_700_000_000_000_000


def frames(done: Any) -> list[dict[str, Any]]:
    return [row for row in map(json.loads, done.out.splitlines()) if row["kind"] == "frame"]


def test_sessions_of_further_buses_do_not_mix(canalyze: Runner, tmp_path: Path) -> None:
    """Every bus has a whole transfer, all at once; those that are not kept apart are in no finding."""
    sides = ((0x605, "4008100000000000"), (0x585, "4308100041424344"))
    lines = [(can_id, data, bus) for can_id, data in sides for bus in range(80)]
    text = "".join(
        f"(1700000000.{no:06}) can{bus} {can_id:03X}#{data}\n" for no, (can_id, data, bus) in enumerate(lines)
    )
    (tmp_path / "many.log").write_text(text)
    rows = [
        json.loads(row)
        for row in canalyze("check", "--format", "jsonl", "--fail-on", "info", "many.log").out.splitlines()
    ]
    assert {row["code"] for row in rows if row["kind"] == "finding"} == {"CAP001"}
    transfers = [json.loads(row) for row in canalyze("sdo", "--format", "jsonl", "many.log").out.splitlines()]
    assert [row["status"] for row in transfers if row["kind"] == "transfer"] == ["ok"] * MOST


Writer = Callable[[Path, Iterable[int]], None]


def blf(path: Path, buses: Iterable[int]) -> None:
    with can.BLFWriter(str(path)) as writer:
        for no, bus in enumerate(buses):
            identifier = 0x700 + bus % 100
            writer.on_message_received(
                can.Message(timestamp=1.7e9 + no, channel=bus, arbitration_id=identifier, is_extended_id=False)
            )


def asc(path: Path, buses: Iterable[int]) -> None:
    lines = ["date Tue Nov 14 10:00:00 pm 2023", "base hex  timestamps absolute"]
    lines += [f"{no}.000000 {bus + 1}  {0x700 + bus % 100:X} Rx d 0" for no, bus in enumerate(buses)]
    path.write_text("\n".join(lines) + "\n")


def trc(path: Path, buses: Iterable[int]) -> None:
    lines = [";$FILEVERSION=2.1", ";$STARTTIME=45000.0", ";$COLUMNS=N,O,T,B,I,d,R,L,D"]
    lines += [f"{no + 1} {no}.000 DT {bus + 1} {0x700 + bus % 100:04X} Rx - 0" for no, bus in enumerate(buses)]
    path.write_text("\n".join(lines) + "\n")


def pcapng(path: Path, buses: Iterable[int]) -> None:
    pcapng_named()(
        (
            Recorded(t_ns=START_US * 1000 + no, bus=f"can{bus}", can_id=0x700 + bus % 100, data=b"")
            for no, bus in enumerate(buses)
        ),
        path,
    )


def mcap(path: Path, buses: Iterable[int]) -> None:
    messages = (
        mcap_files.classic(CanFrame(f"can{bus}", 0x700 + bus % 100, b"", START_US + no)) for no, bus in enumerate(buses)
    )
    path.write_bytes(mcap_files.ros2(messages))


@pytest.mark.parametrize("count", [MOST, MOST + 1, 255, 256, 300])
@pytest.mark.parametrize("write", [blf, asc, trc, pcapng, mcap], ids=lambda write: str(write.__name__))
def test_every_format(canalyze: Runner, tmp_path: Path, write: Writer, count: int) -> None:
    """A bus that is met again behind further ones is still itself."""
    if write is trc and count > 255:
        pytest.skip("the format has no more")
    name = f"many.{write.__name__}"
    write(tmp_path / name, chain(range(count), range(count)))
    done = canalyze("decode", "--lang", "en", "--format", "jsonl", name)
    rows = frames(done)
    assert [row["bus"] for row in rows] == [f"can{n}" for n in range(MOST)] * 2
    assert all(row["id"] == f"{0x700 + int(row['bus'][3:]) % 100:03X}" for row in rows)
    passed = 2 * (count - MOST)
    info = json.loads(canalyze("info", "--format", "jsonl", name).out.splitlines()[0])
    unreadable = info["unreadable"] or {"count": 0, "further_buses": 0}
    assert (info["frames"], unreadable["count"], unreadable["further_buses"]) == (2 * MOST, passed, passed)
    if passed:
        assert f"; {passed} frames on the others skipped\n" in done.err
        assert "None" not in canalyze("info", "--lang", "en", name).out
    else:
        assert done.err == ""


def test_live_buses() -> None:
    def block(kind: int, bus: int, body: bytes = b"") -> bytes:
        return bytes((kind, bus, 0, 0)) + len(body).to_bytes(4, "little") + bytes(8) + body

    record = bytes((1, 1 | 16, 0, 0, 0, 6, 0, 0)) + (0x705).to_bytes(4, "little") + bytes(12)
    session = Session(SessionOptions(lang="en", format="jsonl"))
    session.begin("live", False, "live")
    out = session.feed(b"".join(block(1, n, b"can%d" % n) for n in range(70)))
    out += session.feed(b"".join(block(3, n, record) for n in range(70)))
    out += session.end()
    session.finish()
    rows = [json.loads(row) for row in out.splitlines()]
    assert [row["bus"] for row in rows if row["kind"] == "frame"] == [f"can{n}" for n in range(MOST)]
    assert [row["facts"] for row in rows if row.get("code") == "CAP001"] == [{"lines": 6, "further_buses": 6}]
