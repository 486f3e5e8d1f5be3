"""A Rerun recording as tests read it: rows of an entity's component with their places on the timelines.

What it must not do: know what is in a recording of canalyze.
"""

from __future__ import annotations

import subprocess
import sysconfig
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rerun.chunk import Chunk, RrdReader

TIMELINES = ("capture_time", "time_since_start", "frame", "sync_cycle")


@dataclass(slots=True)
class Recording:
    """What is in a file."""

    application: str
    chunks: dict[str, list[Chunk]] = field(default_factory=dict)

    def entities(self) -> set[str]:
        return set(self.chunks)

    def rows(self, entity: str, component: str) -> list[dict[str, Any]]:
        """Its rows in the order of their frames: `value`, and the timelines on which it stands, in ns and numbers."""
        rows: list[dict[str, Any]] = []
        for chunk in self.chunks.get(entity, []):
            batch = chunk.to_record_batch()
            if chunk.is_static or component not in batch.schema.names:
                continue
            columns = {
                name: batch.column(name).cast("int64").to_pylist() for name in TIMELINES if name in batch.schema.names
            }
            columns["value"] = batch.column(component).to_pylist()
            rows += [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
        return sorted(rows, key=lambda row: row["frame"])

    def static(self, entity: str, component: str) -> list[Any]:
        """What holds at any time: the last one."""
        found: list[Any] = []
        for chunk in self.chunks.get(entity, []):
            batch = chunk.to_record_batch()
            if chunk.is_static and component in batch.schema.names:
                found = batch.column(component).to_pylist()[-1]
        return found


def recording(path: Path) -> Recording:
    """Read a file."""
    reader = RrdReader(str(path))
    (store,) = reader.recordings()
    found = Recording(store.application_id)
    for chunk in reader.stream(store=store):
        found.chunks.setdefault(chunk.entity_path, []).append(chunk)
    return found


def verified(path: Path) -> bool:
    """Whether Rerun itself finds no fault with a file."""
    rerun = Path(sysconfig.get_path("scripts")) / "rerun"
    return subprocess.run([rerun, "rrd", "verify", path], capture_output=True, check=False).returncode == 0
