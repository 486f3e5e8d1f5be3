"""The keys of the machine output, kept in `json_keys.txt`: keys may be added there, none may be renamed or go.

    python tests/test_json_keys.py     # writes those of today; read the diff

A key that not every object of a kind has ends in `?`.
"""

from __future__ import annotations

import gzip
import json
import re
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from captures import EDS, SAMPLES, Row, described_beside, run_canalyze, session_output

from canalyze import _core

FILE: Final = Path(__file__).with_name("json_keys.txt")
SOURCE: Final = Path(__file__).parent.parent / "canalyze/core/src/tables/jsonl"
OPEN: Final = {"facts", "dialect", "value"}
"""Objects with other keys for each rule, format or kind of difference."""
NETWORK: Final = SAMPLES / "network/sync-and-pdos.log"
RESET: Final = b"""\
(1.0) can0 60A#4002200000000000
(1.1) can0 58A#4F0220005A000000
(1.2) can0 60A#4008100000000000
(1.3) can0 58A#4108100017000000
(1.4) can0 70A#00
"""
"""A transfer that a reset ends: a note."""
ODD: Final = "[MandatoryObjects]\nSupportedObjects=1\n1=0x1000\n[1000]\nParameterName=x\nDataType=7\nDefaultValue=No\n"


def outputs(folder: Path) -> Iterator[bytes]:
    """Yields JSON lines of every command, which have all kinds of records."""
    yield from (path.read_bytes() for path in sorted(SAMPLES.rglob("*.jsonl")))
    (folder / "cut.gz").write_bytes(gzip.compress(b"(1.0) can0 701#05\n(1.0) can0 701#0\n" * 1000)[:-10])
    frames = (SAMPLES / "network/boot-and-states.log").read_bytes().splitlines(keepends=True)
    (folder / "other.log").write_bytes(b"".join(frames[:40] + frames[60:]))
    (folder / "odd.eds").write_text(ODD)
    rules = SAMPLES / "rules"
    summarized = [*sorted((SAMPLES / "stacks").glob("*.log")), SAMPLES / "services.log", rules / "BUS009.log"]
    lines: list[tuple[int, str, Sequence[str | Path]]] = [
        (0, "info", ["cut.gz"]),
        (1, "check", [rules / f"{code}.log" for code in ("SDO001", "SYN003", "CAP001")]),
        (1, "diff", [SAMPLES / "network/boot-and-states.log", "other.log"]),
        (1, "diff", [rules / "HBT002.log", rules / "HBT002.clean.log"]),
        *((0, "summary", ["--bitrate", "500k", str(path)]) for path in summarized),
        (0, "eds", ["--node", "5", EDS / "drive.eds", "odd.eds"]),
        (1, "od", [SAMPLES / "od/other-firmware.log", "--against", EDS / "drive.eds"]),
        (0, "diagnose", [SAMPLES / "problems.log"]),
        (0, "signals", ["--eds", f"5={EDS / 'drive.eds'}", NETWORK]),
    ]
    for code, command, rest in lines:
        yield run_canalyze([command, "--format", "jsonl", *rest], expected_exit=code, folder=folder)
    yield session_output([RESET], output_format="jsonl")
    text = NETWORK.read_bytes() + b"(1700009999.000000) vcan0 085#3081110000000000\n"
    yield session_output([text], name=NETWORK.name, output_format="observed", network=described_beside(NETWORK))


def objects(value: Any, place: str) -> Iterator[tuple[str, Row]]:
    """Yields an object of a record and those in it, with where they are."""
    if isinstance(value, list):
        for one in value:
            yield from objects(one, place)
    elif isinstance(value, dict):
        yield place, value
        for key, inner in value.items():
            if key not in OPEN:
                yield from objects(inner, f"{place}.{key}")


def keys() -> str:
    """Returns the keys of today, a line for each kind of object."""
    seen: dict[str, Counter[str]] = defaultdict(Counter)
    count = Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        for output in outputs(Path(folder)):
            for row in map(json.loads, output.splitlines()):
                for place, found in objects(row, row.get("kind", "signal")):
                    seen[place].update(found.keys())
                    count[place] += 1
    lines = []
    for place in sorted(seen):
        named = [f"{key}?" if seen[place][key] < count[place] else key for key in sorted(seen[place])]
        lines.append(f"{place}: {' '.join(named)}\n")
    return "".join(lines)


def test_keys_are_those_that_are_kept() -> None:
    assert keys() == FILE.read_text()


def test_the_schema_has_every_key() -> None:
    schema = {record["kind"]: record["columns"] for record in json.loads(_core.schema())}
    kept = dict(line.split(": ") for line in FILE.read_text().splitlines())
    for kind in ("frame", "finding", "note", "transfer", "od_node", "od_pdo", "od_object"):
        always = {key for key in kept[kind].split() if not key.endswith("?")}
        assert {"kind"} | {one["key"] for one in schema[kind] if one["key"] and not one["optional"]} == always


def test_keys_are_declared_where_they_are_documented() -> None:
    declared = _core.schema().decode() + "".join(path.read_text() for path in SOURCE.glob("*.rs"))
    declared += (SOURCE.parents[3] / "reports/check.py").read_text()
    for line in FILE.read_text().splitlines():
        place, _, named = line.partition(": ")
        if place in ("info", "check", "diff") or place.startswith(("observed_", "summary_")):
            assert not [key for key in re.findall(r"\w+", named) if key not in declared], place


if __name__ == "__main__":
    FILE.write_text(keys())
