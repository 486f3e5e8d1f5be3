"""PDOs as a DBC file: cantools decodes by it what `canalyze signals` shows, and what it cannot hold is named."""

from __future__ import annotations

import random
import sys
from pathlib import Path

import bench_captures
import pytest
from captures import EDS, SAMPLES, CanFrame, log_text, run_canalyze
from conftest import Runner
from dbc_decoding import compare, read

DEVICES = ["--eds", f"5={EDS / 'drive.eds'}", "--eds", f"6={EDS / 'io.eds'}", "--eds", f"7={EDS / 'encoder.eds'}"]
MAPPED = {
    # index: name, data type, bits mapped, further keys
    0x2000: ("Speed [rpm]", 0x0003, 16, "Unit=1/min\nFactor=0.25\nLowLimit=-400\nHighLimit=400\n"),
    0x2001: ("Drehzahl für Öl", 0x0002, 5, ""),
    0x2002: ("开关", 0x0001, 1, ""),
    0x2003: ('Inch " and \\', 0x0008, 32, 'Unit="\n'),
    0x2004: ("Speed  rpm", 0x0005, 10, ""),
    0x2005: ("BO_", 0x0011, 64, "Factor=2\n"),
    0x2006: ("text", 0x0009, 32, ""),
    0x2007: ("Wide", 0x0010, 24, "Factor=1e-7\n"),
    0x2008: ("Wide", 0x001B, 64, ""),
    0x2009: ("Speed [rpm]", 0x0015, 32, ""),
}
PDOS = {
    # number of the TPDO: COB-ID, transmission type, event timer, what is mapped (an index of MAPPED or a dummy)
    1: ("$NODEID+0x180", 255, 40, [0x2000, 0x2001, 0x2002, 0x2004, 0x2003]),
    2: ("$NODEID+0x280", 2, 0, [0x2005]),
    3: ("0x2001F385", 1, 0, [0x0005, 0x2006, 0x2007]),
    4: ("$NODEID+0x180", 254, 0, [0x2008]),
    5: ("0x80000000", 254, 0, [0x2008]),
    6: ("0x1A0", 254, 0, [0x2000, 0x2000, 0x2009]),
    7: ("0x1A1", 254, 0, []),
    8: ("0x1A2", 254, 0, [0x2008, 0x2008]),
    9: ("0x1A3", 254, 0, [0x2006]),
}


def described(tmp_path: Path) -> str:
    """Write a description with everything in it that a DBC has to take."""
    sections = ["[DeviceInfo]\nProductName=x\n[DummyUsage]\nDummy0005=1\n"]
    for index, (name, kind, _, further) in MAPPED.items():
        sections.append(
            f"[{index:04X}]\nParameterName={name}\nDataType={kind:#x}\nAccessType=rw\nPDOMapping=1\n{further}"
        )
    for number, (cob, transmission, timer, mapped) in PDOS.items():
        sections.append(f"[{0x17FF + number:04X}]\nParameterName=TPDO\nObjectType=9\nSubNumber=4\n")
        for sub, value in {0: 5, 1: cob, 2: transmission, 5: timer}.items():
            sections.append(entry(0x17FF + number, sub, value))
        words = [f"{0x00050008 if one == 5 else one << 16 | MAPPED[one][2]:#x}" for one in mapped]
        sections.append(f"[{0x19FF + number:04X}]\nParameterName=Mapping\nObjectType=9\nSubNumber={len(words) + 1}\n")
        sections += [entry(0x19FF + number, sub, value) for sub, value in enumerate([len(words), *words])]
    (tmp_path / "odd.eds").write_text("".join(sections), encoding="utf-8")
    return "odd.eds"


def entry(index: int, sub: int, value: object) -> str:
    kind = 7 if sub == 1 or (index >= 0x1A00 and sub) else 5
    keys = f"ParameterName=x\nDataType={kind}\nAccessType=rw\nDefaultValue={value}\n"
    return f"[{index:04X}sub{sub:X}]\n{keys}"


def test_a_description_becomes_messages(canalyze: Runner, tmp_path: Path) -> None:
    done = canalyze("eds", "--lang", "en", "--node", "5", "--dbc", "odd.dbc", described(tmp_path))
    assert (done.code, done.out) == (0, "")
    assert done.complaints == [
        "canalyze: odd.dbc: 4 messages, 10 signals",
        "canalyze: odd.dbc: 185h: TPDO4 of node 5 has this COB-ID, too; only TPDO1 of node 5 is written",
        "canalyze: odd.dbc: 1A1h (TPDO7 of node 5): nothing mapped, not written",
        "canalyze: odd.dbc: 1A2h (TPDO8 of node 5): 128 bits mapped, more than 8 bytes, not written",
        "canalyze: odd.dbc: 1A3h (TPDO9 of node 5): text (32 bits) is not a number, which a DBC cannot express; its "
        "bits are left out",
        "canalyze: odd.dbc: 1A3h (TPDO9 of node 5): no signal that a DBC can express, not written",
        "canalyze: odd.dbc: 0001F385h (TPDO3 of node 5): text (32 bits) is not a number, which a DBC cannot express; "
        "its bits are left out",
        "canalyze: odd.dbc: characters that the encoding of DBC (cp1252) does not have are written as ?",
    ]
    messages = {one.name: one for one in read(tmp_path / "odd.dbc").messages}
    assert {
        name: (one.frame_id, one.is_extended_frame, one.length, one.senders, one.cycle_time)
        for name, one in messages.items()
    } == {
        "Node5_TPDO1": (0x185, False, 8, ["Node5"], 40),
        "Node5_TPDO2": (0x285, False, 8, ["Node5"], None),
        "Node5_TPDO3": (0x1F385, True, 8, ["Node5"], None),
        "Node5_TPDO6": (0x1A0, False, 8, ["Node5"], None),
    }
    signals = {
        one.name: (one.start, one.length, one.is_signed, one.is_float, one.scale, one.unit, one.minimum, one.maximum)
        for one in messages["Node5_TPDO1"].signals
    }
    assert signals == {
        "Speed_rpm": (0, 16, True, False, 0.25, "1/min", -100, 100),
        "Drehzahl_fur_Ol": (16, 5, True, False, 1, None, None, None),
        "Obj_2002h_00": (21, 1, False, False, 1, None, None, None),
        "Speed_rpm_2004h_00": (22, 10, False, False, 1, None, None, None),
        "Inch_and": (32, 32, False, True, 1, "'", None, None),
    }
    assert [(one.name, one.start, one.scale) for one in messages["Node5_TPDO3"].signals] == [("Wide", 40, 1e-7)]
    assert {one.name for one in messages["Node5_TPDO6"].signals} == {
        "Speed_rpm_2000h_00",
        "Speed_rpm_2000h_00_2",
        "Speed_rpm_2009h_00",
    }


def test_random_payloads_are_decoded_alike(tmp_path: Path) -> None:
    source = random.Random(2106)
    ids = [(0x185, False), (0x285, False), (0x1F385, True), (0x1A0, False)]
    frames = [
        CanFrame("can0", can_id, source.randbytes(8), number * 1000, extended)
        for number, (can_id, extended) in enumerate(source.choices(ids, k=2000))
    ]
    (tmp_path / "odd.log").write_bytes(log_text(frames))
    counted = compare(tmp_path / "odd.log", ["--eds", f"5={tmp_path / described(tmp_path)}"], tmp_path)
    assert counted["equal"] > 4000 and not counted["another mapping"] and not counted["only DBC"]


@pytest.mark.parametrize(
    ("capture", "options", "equal", "others"),
    [
        ("network/sync-and-pdos", DEVICES, 333, {}),
        ("network/remapping", DEVICES, 113, {"another mapping": 19}),
        ("network/remapping", [], 54, {"another mapping": 12, "only DBC": 9}),
        ("network/multiplex-and-safety", [], 20, {}),
        ("network/drive-states", DEVICES, None, {}),
        ("stacks/c3-pdo-remap-master-sync", [], 165, {"another mapping": 13}),
    ],
)
def test_captures_are_decoded_alike(
    capture: str, options: list[str], equal: int | None, others: dict[str, int], tmp_path: Path
) -> None:
    """Where a mapping has changed, frames by an earlier one are not compared, and how many these are is known."""
    counted = compare(SAMPLES / f"{capture}.log", options, tmp_path)
    assert equal is None or counted.pop("equal") == equal
    assert {key: count for key, count in counted.items() if count and key != "equal"} == others


def test_a_large_capture_is_decoded_alike(tmp_path: Path) -> None:
    """The benchmark's traffic; of a million frames `tests/dbc_decoding.py` tells the same."""
    capture = tmp_path / "capture.log"
    bench_captures.make(capture, 20_000)
    counted = compare(capture, ["--eds", f"1-8={EDS / 'drive.eds'}"], tmp_path)
    assert counted["equal"] > 20_000 and counted["equal"] == sum(counted.values())


def test_multiplexed_and_received(canalyze: Runner, tmp_path: Path) -> None:
    canalyze("od", "--dbc", "m.dbc", str(SAMPLES / "network/multiplex-and-safety.log"))
    source, received = sorted(read(tmp_path / "m.dbc").messages, key=lambda one: one.name, reverse=True)
    assert (source.senders, received.senders) == (["Node4"], [])
    assert all(one.receivers == ["Node4"] for one in received.signals)
    ids = {one.name: one.multiplexer_ids for one in source.signals}
    assert ids == {"address": None, **{f"Obj_2000h_0{sub}": [sub << 24 | 0x200004] for sub in range(1, 5)}}


def test_the_scanner_list_of_a_description(canalyze: Runner, tmp_path: Path) -> None:
    """What a source of multiplex PDOs sends: blocks of sub-indices; of which objects, nobody has seen yet."""
    objects = [
        "[1800]\nParameterName=TPDO\nObjectType=9\nSubNumber=3\n",
        *(entry(0x1800, 0, 2) + entry(0x1800, 1, "$NODEID+0x180") + entry(0x1800, 2, 254)),
        f"[1A00]\nParameterName=Mapping\nObjectType=9\nSubNumber=1\n{entry(0x1A00, 0, 254)}",
        f"[1FA0]\nParameterName=List\nObjectType=8\nSubNumber=2\n{entry(0x1FA0, 0, 1)}",
        entry(0x1FA0, 1, "0x02200001"),
        "[2000]\nParameterName=Value\nObjectType=8\nSubNumber=3\n",
        *(entry(0x2000, sub, 0).replace("DataType=7", "DataType=3") for sub in (1, 2)),
    ]
    (tmp_path / "source.eds").write_text("".join(objects))
    assert canalyze("eds", "--node", "9", "--dbc", "source.dbc", "source.eds").code == 0
    (message,) = read(tmp_path / "source.dbc").messages
    signals = {one.name: (one.multiplexer_ids, one.start, one.length, one.is_signed) for one in message.signals}
    assert signals == {
        "address": (None, 0, 32, False),
        "x": ([0x01200009], 32, 16, True),
        "x_2000h_02": ([0x02200009], 32, 16, True),
    }


def test_words_of_values_and_sync_as_cycle(canalyze: Runner, tmp_path: Path) -> None:
    canalyze("od", "--dbc", "s.dbc", *DEVICES, str(SAMPLES / "network/sync-and-pdos.log"))
    messages = {one.name: one for one in read(tmp_path / "s.dbc").messages}
    assert {name: one.cycle_time for name, one in messages.items() if one.cycle_time} == {
        "Node5_TPDO2": 500,
        "Node5_TPDO3": 10,
        "Node5_TPDO4": 10,
        "Node6_TPDO2": 40,
        "Node7_TPDO1": 50,
        "Node7_TPDO2": 40,
    }
    choices = messages["Node5_TPDO2"].get_signal_by_name("modes_of_operation_display").choices
    assert choices and str(choices[8]) == "cyclic synchronous position (CSP)"


def test_at_a_time(canalyze: Runner, tmp_path: Path) -> None:
    """The mapping of a time, and not that of later on."""
    capture = str(SAMPLES / "network/remapping.log")
    lengths = []
    for moment in ("0.25", "100"):
        assert canalyze("od", "--dbc", "a.dbc", "--force", "--at", moment, *DEVICES, capture).code == 0
        lengths.append({one.name: one.length for one in read(tmp_path / "a.dbc").messages})
    assert lengths[0] != lengths[1]


def test_what_cannot_be_written(canalyze: Runner, tmp_path: Path) -> None:
    drive = str(EDS / "drive.eds")
    for wrong in (
        ["eds", "--dbc", "x.dbc", drive],
        ["eds", "--node", "5", "--dbc", "x.dbc", drive, drive],
        ["eds", "--node", "5", "--dbc", "x.dbc", "-o", "y", drive],
        ["od", "--dbc", "x.dbc", "--history", "x.log"],
    ):
        assert canalyze(*wrong).code == 2
    frames = [CanFrame(bus, 0x185, b"\0\0") for bus in ("can0", "can1")]
    (tmp_path / "two.log").write_bytes(log_text(frames))
    several = "canalyze: a DBC file describes one bus, and there are several: can0, can1; choose one with "
    done = canalyze("od", "--lang", "en", "--dbc", "x.dbc", "--eds", f"5={drive}", "two.log")
    assert (done.code, done.complaints) == (2, [several + "--filter bus=NAME"])
    assert canalyze("od", "--dbc", "x.dbc", "--eds", f"5={drive}", "--filter", "bus=can1", "two.log").code == 0
    done = canalyze("od", "--lang", "en", "--dbc", "none.dbc", "--filter", "bus=can1", "two.log")
    assert (done.code, done.complaints) == (
        2,
        ["canalyze: no PDO to write to a DBC: the mapping of every PDO is unknown"],
    )
    assert not (tmp_path / "none.dbc").exists()


def test_without_cantools(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from canalyze.dictionary.dbc import made
    from canalyze.errors import CanalyzeError

    monkeypatch.setitem(sys.modules, "cantools", None)
    monkeypatch.setitem(sys.modules, "cantools.database.can", None)
    with pytest.raises(CanalyzeError, match=r"pip install 'canalyze\[dbc\]'"):
        made(b"", lambda *_: None)


def test_the_listing_alone_does_not_need_cantools() -> None:
    """It is imported where a file is made."""
    code = "import sys, canalyze.commands.od, canalyze.commands.eds; print('cantools' in sys.modules)"
    import subprocess

    assert subprocess.check_output([sys.executable, "-c", code], text=True).strip() == "False"
    assert run_canalyze(["eds", EDS / "drive.eds"])
