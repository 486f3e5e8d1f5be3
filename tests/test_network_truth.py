"""What the program reads from the recorded networks is what their senders meant: `samples/network/NAME.json`.

Signals of every PDO, NMT commands, boot-ups, states, SYNC cycles, EMCY, LSS. What it must not do: take a value from
the program where the truth has none.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from captures import SAMPLES, Row, analyze, decoded, log_text, read_log
from network_sessions import BITS, event_driven

CAPTURES = sorted((SAMPLES / "network").glob("*.log"))
STATES = {"00": "boot-up", "04": "stopped", "05": "operational", "7F": "pre-operational"}

every_capture = pytest.mark.parametrize("log", CAPTURES, ids=lambda path: path.stem)


@cache
def truth_of(log: Path) -> dict[str, Any]:
    truth: dict[str, Any] = json.loads(log.with_suffix(".json").read_text())
    return truth


@cache
def rows_of(log: Path, described: bool = False) -> dict[int, Row]:
    """The program's frames by line, with or without the descriptions of the nodes."""
    if not described:
        return {row["line"]: row for row in decoded(log).frames}
    eds = {row["node"]: row["eds"] for row in truth_of(log)["nodes"] if row["eds"]}
    return {row["line"]: row for row in analyze(log.read_bytes(), name=log.name, eds=eds).frames}


def of_service(log: Path, service: str) -> list[Row]:
    return [row for row in rows_of(log).values() if row["service"] == service]


def test_the_truth_is_large_enough() -> None:
    """Something of every kind is compared."""
    for key in ("nmt", "boot_ups", "state_changes", "sync", "pdo", "mpdo", "emcy", "lss"):
        assert sum(len(truth_of(log)[key]) for log in CAPTURES) > 0, key
    assert sum(len(row["signals"]) for log in CAPTURES for row in truth_of(log)["pdo"]) > 500


@every_capture
def test_every_frame_is_there(log: Path) -> None:
    assert sorted(rows_of(log)) == list(range(1, truth_of(log)["frames"] + 1))


@every_capture
def test_nmt(log: Path) -> None:
    given = [(row["line"], row["nmt"]["command"], row["nmt"]["target"]) for row in of_service(log, "nmt")]
    assert given == [(row["line"], row["cs"], row["node"]) for row in truth_of(log)["nmt"]]


@every_capture
def test_boot_ups_and_states(log: Path) -> None:
    boot_ups, changes = [], []
    known: dict[int, str] = {}
    for line, row in rows_of(log).items():
        said = row.get("heartbeat") or row.get("guarding")
        if not said or "state" not in said:
            continue
        if said.get("boot_up"):
            boot_ups.append((line, row["node"]))
        state = STATES[f"{int(said['state'], 16) & 0x7F:02X}"]
        if known.get(row["node"]) != state:
            changes.append((line, row["node"], state))
        known[row["node"]] = state
    assert boot_ups == [(row["line"], row["node"]) for row in truth_of(log)["boot_ups"]]
    assert changes == [(row["line"], row["node"], row["state"]) for row in truth_of(log)["state_changes"]]


@every_capture
def test_emcy(log: Path) -> None:
    given = [
        (row["line"], row["node"], row["emcy"]["code"], row["emcy"]["register"], row["emcy"]["manufacturer"].lower())
        for row in of_service(log, "emcy")
    ]
    wanted = [(r["line"], r["node"], r["code"], r["error_register"], r["data"]) for r in truth_of(log)["emcy"]]
    assert given == wanted


@every_capture
def test_lss(log: Path) -> None:
    given, wanted = [], []
    for row in of_service(log, "lss"):
        said = row["lss"]
        part = {key: said[key] for key in ("error", "specific") if key in said}
        for key in ("value", "new_node", "node", "mode", "id_number"):
            if key in said:
                part["value"] = said[key]
        part |= {ours: said[key] for ours, key in (("sub", "lss_sub"), ("next", "lss_next")) if key in said}
        if "bit_check" in said:
            part["bit"] = int(said["bit_check"], 16)
        given.append((row["line"], said["from"], said["command"], part))
    for row in truth_of(log)["lss"]:
        part = {key: row[key] for key in ("error", "specific", "value", "bit", "sub", "next") if key in row}
        wanted.append((row["line"], "master" if row["dir"] == "request" else "slave", row["cs"], part))
    assert given == wanted


@every_capture
def test_mpdo(log: Path) -> None:
    given = []
    for row in of_service(log, "pdo"):
        if said := row["pdo"].get("mpdo"):
            value = int.from_bytes(bytes.fromhex(said["data"]), "little")
            given.append((row["line"], said["mode"], said["node"], said["index"], said["sub"], value))
    wanted = [(r["line"], r["mpdo"], r["node"], r["index"], r["sub"], r["value"]) for r in truth_of(log)["mpdo"]]
    assert given == wanted


def raw_of(signal: Row) -> int:
    """A raw value as a number, whatever its JSON type."""
    return int(signal["raw"])


def known_without_description(log: Path) -> set[tuple[int, str]]:
    """The PDOs (node and name) whose mapping the capture itself shows, by reads or writes of 16xx or 1Axx sub 0."""
    shown = set()
    for frame in read_log(log.read_bytes()):
        if 0x581 <= frame.can_id <= 0x5FF and len(frame.data) == 8:
            index = int.from_bytes(frame.data[1:3], "little")
            for base, name in ((0x1600, "RPDO"), (0x1A00, "TPDO")):
                if base <= index < base + 0x200 and frame.data[3] == 0:
                    shown.add((frame.can_id - 0x580, f"{name}{index - base + 1}"))
    return shown


def compare_signals(log: Path, described: bool, only: set[tuple[int, str]] | None) -> int:
    """Compares the signals of each line; returns how many."""
    compared = 0
    first_known: dict[tuple[int, str], int] = {}
    for wanted in truth_of(log)["pdo"]:
        key = (wanted["node"], wanted["pdo"])
        row = rows_of(log, described)[wanted["line"]]
        assert row["service"] == "pdo", wanted
        signals = row["pdo"].get("signals")
        if only is not None and (key not in only or (not signals and key not in first_known)):
            continue
        first_known.setdefault(key, wanted["line"])
        assert (row["node"], row["pdo"]["pdo"]) == key, wanted
        assert signals, f"line {wanted['line']}: nothing decoded of {key}"
        given = {f"{signal['index']}:{signal['sub']:02X}": raw_of(signal) for signal in signals}
        assert list(given) == list(wanted["signals"]), wanted
        for name, value in wanted["signals"].items():
            assert given[name] in (value, value % (1 << 16), value % (1 << 32)), (wanted["line"], name, given, value)
            compared += 1
        assert all(signal["provenance"] for signal in signals)
    return compared


@every_capture
def test_signals_with_descriptions(log: Path) -> None:
    """Every PDO of a node with an EDS, and of the others from where the capture shows the mapping."""
    described = {row["node"] for row in truth_of(log)["nodes"] if row["eds"]}
    pdos = {(row["node"], row["pdo"]) for row in truth_of(log)["pdo"]}
    shown = known_without_description(log)
    count = compare_signals(log, True, {key for key in pdos if key[0] in described or key in shown})
    wanted = sum(len(row["signals"]) for row in truth_of(log)["pdo"] if row["node"] in described)
    assert count >= wanted


@every_capture
def test_signals_without_descriptions(log: Path) -> None:
    """What the capture itself shows is enough for the PDOs whose mapping it shows."""
    compare_signals(log, False, known_without_description(log))


def test_bit_fields() -> None:
    """Fields of 32, 16, 3 and 13 bits in one PDO, by the mapping that the capture shows."""
    frames = event_driven().frames()
    said = {row["line"]: row for row in analyze(log_text(frames)).frames}
    compared = 0
    for line, frame in enumerate(frames, 1):
        if frame.can_id == 0x285:
            whole, offset = int.from_bytes(frame.data, "little"), 0
            signals = said[line]["pdo"]["signals"]
            assert len(signals) == len(BITS)
            for signal, (index, sub, bits) in zip(signals, BITS, strict=True):
                assert (signal["index"], signal["sub"]) == (f"{index:04X}", sub)
                assert raw_of(signal) % (1 << bits) == whole >> offset & ((1 << bits) - 1), (line, signal)
                offset += bits
                compared += 1
    assert compared == 80


@every_capture
def test_sync_cycles(log: Path) -> None:
    """A synchronous PDO is told in which cycle it came, and how long after its SYNC."""
    truth = truth_of(log)
    for sync in truth["sync"]:
        for line, counter in zip(sync["lines"], sync["counters"], strict=True):
            row = rows_of(log)[line]
            assert (row["service"], row["sync"]["counter"]) == ("sync", counter)
    stamps = {number: frame.t_us for number, frame in enumerate(read_log(log.read_bytes()), 1)}
    lines_of_cycle: dict[int, set[int]] = {}
    for wanted in truth["pdo"]:
        if "sync_line" not in wanted:
            continue
        said = rows_of(log, True)[wanted["line"]]["pdo"]["sync"]
        assert round(said["delay_us"]) == stamps[wanted["line"]] - stamps[wanted["sync_line"]], wanted
        lines_of_cycle.setdefault(said["cycle"], set()).add(wanted["sync_line"])
    assert all(len(lines) == 1 for lines in lines_of_cycle.values()), "one cycle, one SYNC"
    order = [lines.pop() for _, lines in sorted(lines_of_cycle.items())]
    assert order == sorted(set(order)), "cycles count upward"
