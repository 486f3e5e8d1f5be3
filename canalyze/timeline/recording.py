"""A recording for Rerun out of the core's tables: what is in which entity, from the first batch to the last.

`timeline/__init__` lists the tables; each has a writer in this folder. A recording begins with the first rows: until a
frame is listed, rows wait, because their application id and the beginning of time come from them. Must not: start a
viewer, or know what a frame means.
"""

import errno
import hashlib
import json
import os
import re
import shutil
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import pyarrow as pa
import rerun as rr

from canalyze.errors import OutputError
from canalyze.timeline.clock import Clock, places
from canalyze.timeline.contents import Contents
from canalyze.timeline.incidents import IncidentWriter
from canalyze.timeline.lanes import LaneWriter
from canalyze.timeline.logs import LogWriter
from canalyze.timeline.offering import Offering
from canalyze.timeline.series import SeriesWriter
from canalyze.timeline.stream import Stream
from canalyze.timeline.summary import facts, listed, markdown
from canalyze.timeline.transfers import TransferWriter
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Batch

_WAITING: Final = 64
"""Batches that wait at most for the first annotated frame."""
_UNWRITTEN: Final = 1 << 20
"""Rows that may be on their way into a file."""
_INDEXED: Final = 100
"""Nodes up to which a file has an index: with 127 nodes of an hour Rerun 0.41 does not get through one."""
_COLOURED: Final = 64
"""States of a lane up to which the colour of a new one is told with it: all of them are told anew each time."""
_LEAST_ROOM: Final = 4 << 20
"""Bytes of a disk below which nothing is begun."""
_TIMES: Final = 4
"""What the first rows take in a file at most, by what they take in memory."""
_SYSTEM: Final = re.compile(r"\(os error (\d+)\)")
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
        """Nothing in it yet, and nothing written. What cannot be written to a file is an OutputError, of any method.

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
        self._unwritten = 0
        self._nodes = 0
        """Nodes in the rows that the recording began with."""

    def take(self, batches: "Iterable[tuple[str, Batch]]") -> None:
        """Take batches as they come from a session."""
        taken = [(name, pa.record_batch(batch)) for name, batch in batches if batch.num_rows]
        if self._waiting is None:
            self._write(taken)
            if self._live or self._connect:
                self._lanes.colour(_COLOURED)
            if self._offering.due() and (self._live or self._connect):
                self._renew()
            self._unwritten += sum(len(batch) for _, batch in taken)
            if self._recording and not self._connect and self._unwritten > _UNWRITTEN:
                self._unwritten = 0
                with self._writing():
                    self._recording.flush()
            return
        self._waiting += taken
        if len(self._waiting) >= _WAITING or any(name == "listing" for name, _ in self._waiting):
            self._begin()

    def finish(self, summary: bytes = b"", lines: Sequence[str] = ()) -> None:
        """End the recording with a summary: JSON lines, or lines for people."""
        self._begin()
        if self._recording and (stories := self._incidents.finish()):
            self.contents.stories = True
            self._stream.always("/diagnosis", rr.TextDocument(stories, media_type="text/markdown"))
        if self._recording and (summary or lines):
            self.contents.summary = True
            text = markdown(summary, self._words, dated=self.contents.dated) if summary else listed(lines, self._words)
            self._stream.always("/summary", rr.TextDocument(text, media_type="text/markdown"))
            if summary:
                self._recording.send_property("capture", rr.AnyValues(**facts(summary)))
        self.close()

    def close(self) -> None:
        """End the recording as it is; whatever was taken is in it."""
        self._begin()
        if self._recording is not None:
            self._renew()
            recording, self._recording = self._recording, None
            try:
                with self._writing():
                    recording.flush()
            finally:
                recording.disconnect()

    def _begin(self) -> None:
        """Create the recording out of the rows that wait, unless there is one."""
        if self._waiting is None:
            return
        waited, self._waiting = self._waiting, None
        recording = self._recording = rr.RecordingStream(self._application(waited))
        contents = self.contents
        self._clock = Clock(contents)
        self._clock.start(places(batch) for name, batch in waited if name != "load")
        stream = self._stream = Stream(recording, self._clock)
        series = SeriesWriter(stream, contents, self._words)
        transfers = TransferWriter(stream, contents, self._words)
        self._lanes = LaneWriter(stream, contents, transfers, ends=series.ends, at_once=self._live)
        self._series = series
        logs = LogWriter(stream, contents)
        self._incidents = IncidentWriter(stream, contents, self._words)
        self._writers: dict[str, Callable[[pa.RecordBatch], None]] = {
            "pdo": series.pdo,
            "sync_cycles": series.sync,
            "load": series.load,
            "lanes": self._lanes.take,
            "log": logs.log,
            "listing": logs.frames,
            "problems": self._incidents.take,
        }
        self._offering = Offering(recording, contents, self._words, viewer=self._connect, live=self._live)
        recording.send_recording_name(self._name)
        stream.always("/time_span", rr.SeriesLines(visible_series=[False], names=[""]))
        # Rows are kept until there is somewhere to send them, so that a layout of them can come first.
        self._write(waited)
        self._lanes.flush()
        self._lanes.colour()
        self._need_room(sum(batch.nbytes for _, batch in waited))
        with self._writing():
            recording.set_sinks(*self._sinks(), default_blueprint=self._offering.first())

    def _need_room(self, size: int) -> None:
        """Make sure that the disk has room for the first rows: Rerun waits without end where these do not fit."""
        if self._save and Path(self._save).is_file():
            free = shutil.disk_usage(Path(self._save).parent).free
            if free < _LEAST_ROOM + _TIMES * size:
                raise OutputError("output.write", name=self._save, error=OSError(errno.ENOSPC, ""))

    def _sinks(self) -> list[Any]:
        sinks: list[Any] = []
        if self._connect:
            sinks.append(rr.GrpcSink(self._connect))
        if self._save:
            # The index at the end of a file takes memory for every piece of it: not without end. It has columns for
            # every entity besides, and a viewer that fails on a wide one reads the file without it.
            sinks.append(rr.FileSink(self._save, write_footer=not self._live and self._nodes <= _INDEXED))
        return sinks

    def _write(self, batches: list[tuple[str, pa.RecordBatch]]) -> None:
        for name, batch in batches:
            writer = self._writers.get(name.partition("/")[0])
            if writer:
                writer(batch)

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Say what is wrong with the file. That a viewer is gone is no fault: its user has closed it."""
        try:
            yield
        except RuntimeError as error:
            text = str(error)
            if self._save is None or "gRPC" in text:
                return
            found = _SYSTEM.search(text)
            number = int(found[1]) if found else errno.EIO
            raise OutputError("output.write", name=self._save, error=OSError(number, os.strerror(number))) from error

    def _renew(self) -> None:
        """Bring up to date what the recording has only once: colours, extent, layout."""
        self._lanes.flush()
        self._lanes.colour()
        self._series.flush()
        if self.contents.last_frame:
            nothing = rr.Scalars.columns(scalars=np.full(2, np.nan))
            rr.send_columns("/time_span", self._clock.span(), nothing, recording=self._recording)
        self._offering.renew()

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
        self._nodes = len({one for one in whose if one[1]})
        nodes = [] if self._live else sorted(one for one in whose if one[1])
        digest = hashlib.sha256(json.dumps([buses, nodes, self._configuration]).encode("utf-8", "surrogatepass"))
        readable = _SAFE.sub("-", "-".join(buses))[:_LONGEST].strip("-")
        return "-".join(one for one in ("canalyze", readable, digest.hexdigest()[:10]) if one)
