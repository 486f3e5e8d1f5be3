"""A capture as text that two recordings of the same session share, to be kept beside a test and compared.

By node: NMT states, SDO transfers, EMCYs; then findings from warning on. No times, no frame numbers, no words of a
language, no transfers that an end of the capture cuts, and no bus names where there is one bus. Its form stays, since
files in other people's repositories have it.
"""

import zlib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from canalyze.output import hexadecimal, jsonl
from canalyze.records import Transfer

if TYPE_CHECKING:
    from canalyze.library.capture import Capture
    from canalyze.records import Node

_BYTES: Final = 32
"""Bytes that are shown as they are; of more, the check sum."""


def snapshot(capture: "Capture") -> str:
    """Give the text, with a line end behind every line."""
    nodes = list(capture.nodes)
    buses = {node.bus for node in nodes}
    lines: list[str] = []
    for node in nodes:
        lines.append(f"node {_on(node.bus, buses)}{node.node}")
        lines += _states(node)
        mine = (one for one in capture.transfers.of(node=node.node) if one.bus == node.bus)
        lines += (f"  sdo {_transfer(one)}" for one in mine if one.status != "incomplete")
        lines += (f"  emcy {emcy.code:04X}h x{emcy.count}" for emcy in sorted(node.emcys, key=lambda one: one.code))
    counts: dict[str, int] = {}
    for finding in capture.findings.at_least("warning"):
        where = "" if finding.node is None else f" node {_on(finding.bus, buses)}{finding.node}"
        line = f"{finding.severity} {finding.code} {finding.name}{where} {finding.object or ''}".rstrip()
        repeated = finding.facts.get("repeated", 1)
        counts[line] = counts.get(line, 0) + int(repeated)
    lines += (f"{line} x{counts[line]}" for line in sorted(counts))
    return "".join(f"{line}\n" for line in lines) or "nothing\n"


def _on(bus: str | None, buses: set[str | None]) -> str:
    return f"{bus}:" if len(buses) > 1 and bus is not None else ""


def _states(node: "Node") -> Iterator[str]:
    for change in node.states:
        yield f"  state {change.state or '?'}{' (commanded)' if change.commanded else ''}"
    if node.changes > len(node.states):
        yield f"  state ... {node.changes - len(node.states)} more"


def _transfer(transfer: Transfer) -> str:
    shown = f"{transfer.direction} {transfer.object or '?'} {transfer.mode}"
    if transfer.status == "ok":
        return f"{shown} = {_value(transfer)}"
    if transfer.abort is not None:
        return f"{shown} {transfer.status} {transfer.abort.code:08X}h by {transfer.abort.by}"
    return f"{shown} {transfer.status}"


def _value(transfer: Transfer) -> str:
    if transfer.value is not None and transfer.size <= _BYTES:
        if written := hexadecimal(transfer.value, transfer.text):  # COB-IDs, mappings, words of bits
            return written
        return jsonl.text(transfer.value)
    if transfer.size <= _BYTES:
        return transfer.data.hex(" ").upper() or "nothing"
    return f"{transfer.size} bytes, CRC-32 {zlib.crc32(transfer.data):08X}"
