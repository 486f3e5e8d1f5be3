"""Text lines: annotated frames, findings and emergencies.

Must not: make a text; the lines are the core's.
"""

from typing import Final

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from canalyze.timeline.clock import places
from canalyze.timeline.contents import Contents
from canalyze.timeline.stream import LEVEL, TEXT, Stream, mapped, path, plain, words
from canalyze.timeline.stream import part as part_of

_LEVELS: Final[dict[str | None, str]] = {"error": "ERROR", "warning": "WARN", "info": "INFO", None: "TRACE"}
_SOURCES: Final = {"finding": "findings", "emcy": "emcy"}
"""The second part of their paths, by the core's names; the third is the bus, then comes the node."""


class LogWriter:
    """Writes lines to a recording."""

    def __init__(self, stream: Stream, contents: Contents) -> None:
        """Writes rows to `stream` and updates `contents`."""
        self._stream = stream
        self._contents = contents
        self._buses: set[str] = set()

    def frames(self, batch: pa.RecordBatch) -> None:
        """Appends annotated frames, prefixed with the bus if there are several."""
        if not len(batch):
            return
        lines, buses = batch.column("line"), batch.column("bus")
        self._buses |= words(buses)
        if len(self._buses) > 1:
            lines = pc.binary_join_element_wise(plain(buses).fill_null("-"), lines, "  ")
        self._contents.frames += len(batch)
        levels = mapped(batch.column("severity"), _LEVELS)
        self._stream.texts("/frames", places(batch), [(TEXT, lines), (LEVEL, levels)])

    def log(self, batch: pa.RecordBatch) -> None:
        """Appends findings and emergencies."""
        rows, sources = places(batch), np.asarray(plain(batch.column("source")), object)
        coded = pc.binary_join_element_wise(plain(batch.column("code")), batch.column("text"), "  ")
        levels = mapped(batch.column("level"), _LEVELS)
        buses = np.asarray(plain(batch.column("bus")).fill_null(""), object)
        nodes = np.asarray(batch.column("node").fill_null(0))
        for source, kind in _SOURCES.items():
            (every,) = np.nonzero(sources == source)
            for bus, node in dict.fromkeys(zip(buses[every].tolist(), nodes[every].tolist(), strict=True)):
                some = every[(buses[every] == bus) & (nodes[every] == node)]
                entity = path("log", kind, bus, *([f"node{node}"] if node else []))
                if node:
                    self._contents.told.setdefault((part_of(bus), node), {})[entity] = None
                taken = pa.array(some)
                told = levels.take(taken)
                for one in told.value_counts().to_pylist():
                    self._contents.logged[one["values"]] = self._contents.logged.get(one["values"], 0) + one["counts"]
                self._contents.findings += len(some) if source == "finding" else 0
                # The text of an emergency has its code.
                texts = batch.column("text") if source == "emcy" else coded
                self._stream.texts(entity, rows[some], [(TEXT, texts.take(taken)), (LEVEL, told)])
