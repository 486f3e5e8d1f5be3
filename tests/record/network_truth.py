"""What happened in a recording of `record_network.py`, from the senders' account and the lines of the log.

Why it exists: the truth file must come from those who sent the frames. The log only says at which line each of them
stands; states, SYNC and LSS, where one byte is the whole meaning, are read from the log by tables. What it must not
do: decode PDOs.
"""

from __future__ import annotations

import itertools
import json
import re
from collections import deque
from collections.abc import Mapping
from typing import Any, Protocol

Sent = Mapping[int, deque[tuple[bytes, dict[str, Any]]]]

COMMANDS = {0x01: "start", 0x02: "stop", 0x80: "enter pre-operational", 0x81: "reset node", 0x82: "reset communication"}
STATES = {0x00: "boot-up", 0x04: "stopped", 0x05: "operational", 0x7F: "pre-operational"}
LSS = {
    0x04: "switch state global",
    0x40: "switch selective vendor",
    0x41: "switch selective product",
    0x42: "switch selective revision",
    0x43: "switch selective serial",
    0x44: "switch selective response",
    0x11: "configure node-ID",
    0x17: "store",
    0x46: "identify vendor",
    0x47: "identify product",
    0x48: "identify revision low",
    0x49: "identify revision high",
    0x4A: "identify serial low",
    0x4B: "identify serial high",
    0x4C: "identify non-configured",
    0x4F: "identify slave",
    0x50: "identify non-configured slave",
    0x51: "fastscan",
    0x5A: "inquire vendor",
    0x5B: "inquire product",
    0x5C: "inquire revision",
    0x5D: "inquire serial",
    0x5E: "inquire node-ID",
}


class Recorded(Protocol):
    """What the truth needs of a session."""

    files: dict[int, str | None]
    overflow: int
    window_us: int | None
    period_us: int | None
    sync_producer: str
    kept: list[tuple[int, float, float, float]]


def describe(name: str, text: str, sent: Sent, session: Recorded) -> tuple[str, list[str]]:
    """The text of the truth file, and what shows that the machine stalled."""
    rows = [_row(line) for line in text.splitlines()]
    bus = rows[0][1]
    truth: dict[str, list[dict[str, Any]]] = {
        key: [] for key in ("nmt", "boot_ups", "state_changes", "sync", "pdo", "mpdo", "emcy", "lss")
    }
    missed: list[str] = []
    states: dict[int, int] = {}
    syncs: list[tuple[int, float]] = []
    counters: list[int | None] = []
    for line, (stamp, _, can_id, data) in enumerate(rows, 1):
        at: dict[str, Any] = {"line": line, "bus": bus}
        queue = sent.get(can_id)
        meaning: dict[str, Any] = {}
        if data is not None and queue and queue[0][0] == data:
            meaning = queue.popleft()[1]
        if can_id == 0x080 and data is not None:
            syncs.append((line, stamp))
            counters.append(data[0] if data else None)
        elif 0x700 < can_id < 0x780 and data:
            node, state = can_id - 0x700, data[0] & 0x7F
            if meaning:
                truth["boot_ups"].append({**at, "node": node})
            if states.get(node) != state:
                truth["state_changes"].append({**at, "node": node, "state": STATES[state]})
            states[node] = state
        elif can_id in (0x7E4, 0x7E5) and data:
            truth["lss"].append({"line": line} | _lss(data, request=can_id == 0x7E5))
        elif "nmt" in meaning:
            command = meaning["nmt"]
            row: dict[str, Any] = {"command": COMMANDS[command], "cs": f"{command:02X}", "node": meaning["node"]}
            truth["nmt"].append(at | row)
        elif "emcy" in meaning:
            assert data is not None
            code, register = f"{meaning['code']:04X}", f"{meaning['register']:02X}"
            row = {"node": can_id - 0x80, "code": code, "error_register": register, "data": data[3:].hex()}
            truth["emcy"].append(at | row)
        elif "mpdo" in meaning:
            truth["mpdo"].append(at | meaning)
        elif "signals" in meaning:
            row = {**at, **meaning}
            if (cycle := row.pop("cycle", None)) is not None:
                before, after = syncs[cycle - 1], syncs[cycle] if cycle < len(syncs) else None
                row |= {"sync_line": before[0], "cycle": cycle}
                delay = round((stamp - before[1]) * 1_000_000)
                if after is not None or not 0 <= delay <= (session.window_us or 10_000):
                    missed.append(f"line {line}: {delay} us after its SYNC")
            truth["pdo"].append(row)
    missed += [f"{can_id:03X}: {len(queue)} frames are not in the log" for can_id, queue in sent.items() if queue]
    if syncs:
        gaps = [round((b[1] - a[1]) * 1_000_000) for a, b in itertools.pairwise(syncs)]
        truth["sync"].append(
            {
                "bus": bus,
                "cob": "080",
                "producer": session.sync_producer,
                "period_us": session.period_us,
                "window_us": session.window_us,
                "counter_overflow": session.overflow,
                "first_line": syncs[0][0],
                "last_line": syncs[-1][0],
                "count": len(syncs),
                "measured_us": {"min": min(gaps), "max": max(gaps), "mean": round(sum(gaps) / len(gaps), 1)},
                "lines": [line for line, _ in syncs],
                "counters": counters,
            }
        )
    head = {
        "capture": f"{name}.log",
        "interfaces": [bus],
        "frames": len(rows),
        "seconds": round(rows[-1][0] - rows[0][0], 6),
        "stack": "python-canopen 2.4 dictionaries, SDO servers and master; nodes of tests/record/network_nodes.py",
        "nodes": [{"bus": bus, "node": node, "role": "slave", "eds": eds} for node, eds in session.files.items()],
    }
    return _written(head | truth | {"natural": []}), missed


def stalls(text: str, session: Recorded) -> list[str]:
    """Periods that were not kept."""
    last: dict[int, float] = {}
    found = []
    for line in text.splitlines():
        stamp, _, can_id, _ = _row(line)
        for kept, since, until, gap in session.kept:
            if kept == can_id and since <= last.get(can_id, 0) and stamp <= until and stamp - last[can_id] > gap:
                found.append(f"{can_id:03X}: {stamp - last[can_id]:.4f} s, not {gap:.4f}")
        last[can_id] = stamp
    return found


def _row(line: str) -> tuple[float, str, int, bytes | None]:
    """Stamp, bus, CAN-ID, and the data or None for a remote frame."""
    match = re.fullmatch(r"\((\d+\.\d+)\) (\S+) ([0-9A-F]{3})#(?:(R\d?)|([0-9A-F]*))", line)
    if match is None:
        raise ValueError(f"not a line of the recording: {line!r}")
    stamp, bus, can_id, remote, data = match.groups()
    return float(stamp), bus, int(can_id, 16), None if remote else bytes.fromhex(data)


def _lss(data: bytes, *, request: bool) -> dict[str, Any]:
    """One LSS frame by its command specifier."""
    cs, number = data[0], int.from_bytes(data[1:5], "little")
    row: dict[str, Any] = {"dir": "request" if request else "answer", "cs": f"{cs:02X}", "service": LSS[cs]}
    if cs == 0x51:
        return row | {"value": f"{number:08X}", "bit": data[5], "sub": data[6], "next": data[7]}
    if cs in (0x11, 0x17) and not request:
        return row | {"error": data[1], "specific": data[2]}
    if cs in (0x04, 0x11) or (cs == 0x5E and not request):
        return row | {"value": data[1]}
    if (request and 0x40 <= cs <= 0x4B) or (not request and 0x5A <= cs <= 0x5D):
        return row | {"value": f"{number:08X}"}
    return row


def _written(truth: dict[str, Any]) -> str:
    """JSON with one row a line."""
    parts = []
    for key, value in truth.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            rows = ",\n".join(" " + json.dumps(row) for row in value)
            parts.append(f"{json.dumps(key)}: [\n{rows}\n]")
        else:
            parts.append(f"{json.dumps(key)}: {json.dumps(value)}")
    return "{\n" + ",\n".join(parts) + "\n}\n"
