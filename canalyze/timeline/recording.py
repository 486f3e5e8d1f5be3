"""Writes the core's tables to a Rerun recording, from the first batch to the last.

`timeline/__init__` lists the tables; each has a writer in this folder. Rows wait until the first frame is listed,
because the application id and the start of time depend on them. Must not: start a viewer, or know the meaning of a
frame.
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
from canalyze.timeline.contents import Contents
from canalyze.timeline.lanes import LaneWriter
from canalyze.timeline.logs import LogWriter, facts, listed, markdown
from canalyze.timeline.offering import Offering
from canalyze.timeline.problems import ProblemWriter
from canalyze.timeline.series import SeriesWriter
from canalyze.timeline.stream import Clock, Stream, places
from canalyze.timeline.transfers import TransferWriter
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Batch

_WAITING: Final = 64
"""Maximum number of batches that wait for the first annotated frame."""
_UNWRITTEN: Final = 1 << 20
"""Maximum number of rows that wait to be written to a file."""
_INDEXED: Final = 100
"""Maximum number of nodes for which a file has an index; Rerun 0.41 fails on one of 127 nodes and an hour."""
_COLOURED: Final = 64
"""Maximum number of states of a lane whose colours are updated with each new one, because all are written again."""
_LEAST_ROOM: Final = 4 << 20
"""Minimum free bytes of the disk."""
_TIMES: Final = 4
"""Maximum ratio of the size of the first rows in a file to that in memory."""
_SYSTEM: Final = re.compile(r"\(os error (\d+)\)")
_SAFE: Final = re.compile("[^A-Za-z0-9]+")
_LONGEST: Final = 24
"""Maximum length of the readable part of an application id."""


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
        """Creates the timeline without writing. All methods raise OutputError if the file cannot be written.

        name: of the recording, for people. save: the file. connect: the viewer, as rerun+http://127.0.0.1:9876/proxy.
        configuration: distinguishes networks, such as the descriptions of their nodes; each has its own layout. live:
        rows come as they happen, without end.
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
        """Number of nodes in the first rows."""

    def take(self, batches: "Iterable[tuple[str, Batch]]") -> None:
        """Appends batches from a session."""
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
        """Ends the recording with a summary: JSON lines, or lines for people."""
        self._begin()
        if self._recording and (problems := self._problems.finish()):
            self.contents.diagnosis = True
            self._stream.always("/diagnosis", rr.TextDocument(problems, media_type="text/markdown"))
        if self._recording and (summary or lines):
            self.contents.summary = True
            text = markdown(summary, self._words, dated=self.contents.dated) if summary else listed(lines, self._words)
            self._stream.always("/summary", rr.TextDocument(text, media_type="text/markdown"))
            if summary:
                self._recording.send_property("capture", rr.AnyValues(**facts(summary)))
        self.close()

    def close(self) -> None:
        """Ends the recording; everything taken is in it."""
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
        """Creates the recording from the waiting rows, unless it exists."""
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
        self._problems = ProblemWriter(stream, contents, self._words)
        self._writers: dict[str, Callable[[pa.RecordBatch], None]] = {
            "pdo": series.pdo,
            "sync_cycles": series.sync,
            "load": series.load,
            "lanes": self._lanes.take,
            "log": logs.log,
            "listing": logs.frames,
            "problems": self._problems.take,
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
        """Checks that the disk has room for the first rows, without which Rerun would wait forever."""
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
        """Converts errors of the file; a closed viewer is no error."""
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
        """Updates the parts of the recording that exist only once: colours, extent, layout."""
        self._lanes.flush()
        self._lanes.colour()
        self._series.flush()
        if self.contents.last_frame:
            nothing = rr.Scalars.columns(scalars=np.full(2, np.nan))
            rr.send_columns("/time_span", self._clock.span(), nothing, recording=self._recording)
        self._offering.renew()

    def _application(self, batches: list[tuple[str, pa.RecordBatch]]) -> str:
        """Returns an id that is the same for the same network; layouts of the user are stored under it."""
        whose: set[tuple[str, int]] = set()
        for name, batch in batches:
            if name == "listing":
                pairs = pa.table([batch.column("bus").dictionary_decode(), batch.column("node")], names=["bus", "node"])
                for row in pairs.group_by(["bus", "node"]).aggregate([]).to_pylist():
                    whose.add((row["bus"] or "", row["node"] or 0))
        buses = sorted({bus for bus, _ in whose})
        # The nodes in the first moments of a live bus are random.
        self._nodes = len({one for one in whose if one[1]})
        nodes = [] if self._live else sorted(one for one in whose if one[1])
        digest = hashlib.sha256(json.dumps([buses, nodes, self._configuration]).encode("utf-8", "surrogatepass"))
        readable = _SAFE.sub("-", "-".join(buses))[:_LONGEST].strip("-")
        return "-".join(one for one in ("canalyze", readable, digest.hexdigest()[:10]) if one)
