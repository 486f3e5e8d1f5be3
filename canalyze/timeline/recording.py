"""A recording for Rerun out of the core's tables: what is in which entity, from the first batch to the last.

`timeline/__init__` lists the tables; each has a writer in this folder. A recording begins with the first rows: until a
frame is listed, rows wait, because their application id and the beginning of time come from them. Must not: start a
viewer, or know what a frame means.
"""

import hashlib
import json
import re
import time
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import pyarrow as pa
import rerun as rr

from canalyze.timeline.clock import Clock, Places, places
from canalyze.timeline.contents import Contents
from canalyze.timeline.lanes import LaneWriter
from canalyze.timeline.layout import layout
from canalyze.timeline.logs import LogWriter
from canalyze.timeline.series import SeriesWriter
from canalyze.timeline.stream import Stream
from canalyze.timeline.summary import facts, markdown
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Batch

_WAITING: Final = 64
"""Batches that wait at most for the first annotated frame."""
_REFRESH_S: Final = 2.0
"""Between two layouts of a recording that somebody looks at while it grows."""
_SAFE: Final = re.compile("[^A-Za-z0-9]+")
_LONGEST: Final = 24
"""Characters of the readable part of an application id."""


class Timeline:
    """One capture as a recording, in a file, in a viewer, or both."""

    def __init__(
        self,
        words: Words,
        *,
        name: str,
        save: str | None = None,
        connect: str | None = None,
        configuration: Iterable[str] = (),
        live: bool = False,
    ) -> None:
        """Nothing in it yet, and nothing written.

        name: of the recording, for people. save: the file. connect: the viewer, as rerun+http://127.0.0.1:9876/proxy.
        configuration: what tells this network from another, as the descriptions of its nodes; a layout is kept for
        each network by itself. live: rows come as they happen, and without end.
        """
        self.contents = Contents()
        self._words = words
        self._name = name
        self._save = save
        self._connect = connect
        self._configuration = sorted(configuration)
        self._live = live
        self._waiting: list[tuple[str, pa.RecordBatch]] | None = []
        self._recording: rr.RecordingStream | None = None
        self._shown: tuple[object, ...] = ()
        """What the layout that was sent last was made of."""
        self._refreshed = 0.0

    def take(self, batches: "Iterable[tuple[str, Batch]]") -> None:
        """Take batches as they come from a session."""
        taken = [(name, pa.record_batch(batch)) for name, batch in batches]
        if self._waiting is not None:
            self._waiting += [one for one in taken if len(one[1])]
            listed = any(name == "listing" for name, _ in self._waiting)
            if not listed and len(self._waiting) < _WAITING:
                return
            taken = self._begin()
        for name, batch in taken:
            self._write(name, batch)
        if taken and (self._live or self._connect) and time.monotonic() - self._refreshed >= _REFRESH_S:
            self._refresh()

    def finish(self, summary: bytes = b"") -> None:
        """End the recording with a summary, given as JSON lines."""
        for name, batch in self._begin():
            self._write(name, batch)
        records = [json.loads(line) for line in summary.splitlines()]
        if records:
            self.contents.summary = True
            self._stream.always("/summary", rr.TextDocument(markdown(records, self._words), media_type="text/markdown"))
            assert self._recording is not None
            self._recording.send_property("capture", rr.AnyValues(**facts(records)))
        self.close()

    def close(self) -> None:
        """End the recording as it is; whatever was taken is in it."""
        for name, batch in self._begin():
            self._write(name, batch)
        if self._recording is not None:
            self._refresh()
            self._recording.flush()
            self._recording.disconnect()
            self._recording = None

    def _begin(self) -> list[tuple[str, pa.RecordBatch]]:
        """Create the recording, unless there is one; give the rows that have waited for it."""
        if self._waiting is None:
            return []
        waited, self._waiting = self._waiting, None
        recording = rr.RecordingStream(self._application(waited))
        sinks: list[Any] = []
        if self._connect:
            sinks.append(rr.GrpcSink(self._connect))
        if self._save:
            # The index at the end of a file takes memory for every piece of it: not without end.
            sinks.append(rr.FileSink(self._save, write_footer=not self._live))
        recording.set_sinks(*sinks)
        recording.send_recording_name(self._name)
        clock = Clock(self.contents)
        clock.start(_framed(waited))
        self._recording, self._clock = recording, clock
        stream = self._stream = Stream(recording, clock)
        series = SeriesWriter(stream, self.contents, self._words)
        self._lanes = LaneWriter(stream, self.contents)
        logs = LogWriter(stream, self.contents)
        self._writers: dict[str, Callable[[pa.RecordBatch], None]] = {
            "pdo": series.pdo,
            "sync_cycles": series.sync,
            "load": series.load,
            "lanes": self._lanes.take,
            "log": logs.log,
            "listing": logs.frames,
        }
        return waited

    def _write(self, name: str, batch: pa.RecordBatch) -> None:
        writer = self._writers.get(name.partition("/")[0])
        if writer and len(batch):
            writer(batch)

    def _refresh(self) -> None:
        """Bring everything up to date that the recording has only once: colours, extent, layout."""
        assert self._recording is not None
        self._refreshed = time.monotonic()
        self._lanes.colour()
        contents = self.contents
        if contents.last_frame:
            if not self._shown:
                self._stream.always("/span", rr.SeriesLines(visible_series=[False]))
            rr.send_columns(
                "/span", self._clock.span(), rr.Scalars.columns(scalars=np.full(2, np.nan)), recording=self._recording
            )
        shown = _outline(contents)
        if shown != self._shown:
            self._shown = shown
            # The layout is an offer: what the user has made of the last one for this network stays.
            self._recording.send_blueprint(layout(contents, self._words), make_active=False, make_default=True)

    def _application(self, batches: list[tuple[str, pa.RecordBatch]]) -> str:
        """Give an id that is the same for the same network: a layout that a user makes is kept under it."""
        whose: set[tuple[str, int]] = set()
        for name, batch in batches:
            if name == "listing":
                pairs = pa.table([batch.column("bus").dictionary_decode(), batch.column("node")], names=["bus", "node"])
                for row in pairs.group_by(["bus", "node"]).aggregate([]).to_pylist():
                    whose.add((row["bus"] or "", row["node"] or 0))
        buses = sorted({bus for bus, _ in whose})
        # What is on a live bus within the first moments is chance.
        nodes = [] if self._live else sorted(one for one in whose if one[1])
        digest = hashlib.sha256(json.dumps([buses, nodes, self._configuration]).encode("utf-8", "surrogatepass"))
        readable = _SAFE.sub("-", "-".join(buses))[:_LONGEST].strip("-")
        return "-".join(one for one in ("canalyze", readable, digest.hexdigest()[:10]) if one)


def _framed(batches: list[tuple[str, pa.RecordBatch]]) -> "Iterable[Places]":
    """Give where rows stand that belong to a frame each."""
    return (places(batch) for name, batch in batches if name != "load")


def _outline(contents: Contents) -> tuple[object, ...]:
    """Give what a new layout would differ by."""
    return (
        tuple((plot.entity, tuple(one.varies for one in plot.series)) for plot in contents.plots.values()),
        tuple(contents.lanes),
        frozenset(contents.sync),
        frozenset(contents.windows),
        tuple(contents.delays),
        tuple(contents.load),
        contents.frames > 0,
        contents.logged > 0,
        contents.summary,
        contents.timed,
    )
