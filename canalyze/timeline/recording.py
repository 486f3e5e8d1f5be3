"""Writes the core's tables to a Rerun recording, from the first batch to the last, and keeps its layout up to date.

`timeline/__init__` lists the tables; each has a writer in this folder. Rows wait until the first frame is listed,
because the application id and the start of time depend on them. While frames come a timeline is fed in a thread of
its own, so that the receiver never waits for it: a viewer may be slow, stopped or gone, and a disk full. Waiting
batches are bounded, beyond that whole batches are dropped and counted.

A file's layout is its default: the user's changes to an earlier one, for the same network, are kept. A viewer applies
a new default only if it has none; while a growing recording is shown, the new layout is therefore activated, unless
the user has changed the views. Must not: start a viewer, design a layout, or know the meaning of a frame.
"""

import contextlib
import errno
import hashlib
import json
import os
import re
import shutil
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np
import pyarrow as pa
import rerun as rr
import rerun.blueprint as rrb

from canalyze.errors import OutputError
from canalyze.timeline import charts
from canalyze.timeline.lanes import LaneWriter, ProblemWriter, TransferWriter
from canalyze.timeline.layout import layout
from canalyze.timeline.series import LogWriter, SeriesWriter, facts, listed, markdown
from canalyze.timeline.stream import Clock, Contents, Stream, places
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Batch

MOST_ROWS: Final = 1_000_000
"""Maximum number of waiting rows: some 100 MB."""


class Fed(Protocol):
    """The consumer of the batches: a `Timeline`."""

    def take(self, batches: "Sequence[tuple[str, Batch]]") -> None:
        """Appends batches."""

    def finish(self, summary: bytes = b"", lines: Sequence[str] = ()) -> None:
        """Completes the timeline; lines: a summary in words."""


class Feed:
    """A queue of batches for a timeline."""

    def __init__(self, timeline: Fed, *, most: int = MOST_ROWS) -> None:
        """Starts the thread; the timeline is used only there from here on."""
        self.left_out = 0
        """Number of dropped rows."""
        self.failure: Exception | None = None
        """The error after which batches are ignored, if any."""
        self._timeline = timeline
        self._most = most
        self._queue: deque[Sequence[tuple[str, Batch]]] = deque()
        self._waiting = 0
        self._over = False
        self._lines: Sequence[str] = ()
        self._arrived = threading.Condition()
        self._thread = threading.Thread(target=self._work, name="canalyze-timeline", daemon=True)
        self._thread.start()

    def give(self, batches: "Sequence[tuple[str, Batch]]") -> None:
        """Appends batches; never waits."""
        rows = sum(batch.num_rows for _, batch in batches)
        with self._arrived:
            if self.failure is not None or not rows:
                return
            if self._waiting + rows > self._most:
                self.left_out += rows
                return
            self._queue.append(batches)
            self._waiting += rows
            self._arrived.notify()

    def end(self, lines: Sequence[str] = ()) -> None:
        """Ends the input; waiting batches are still written. Calling it twice is harmless. lines: the summary."""
        with self._arrived:
            self._lines = self._lines or lines
            self._over = True
            self._arrived.notify()

    def ended(self, within_s: float) -> bool:
        """Waits up to `within_s` until the timeline is complete; returns true if it is."""
        self._thread.join(within_s)
        return not self._thread.is_alive()

    def _work(self) -> None:
        try:
            while True:
                with self._arrived:
                    self._arrived.wait_for(lambda: self._queue or self._over)
                    taken = list(self._queue)
                    self._queue.clear()
                if not taken:
                    break
                for batches in taken:
                    self._timeline.take(batches)
                    with self._arrived:
                        self._waiting -= sum(batch.num_rows for _, batch in batches)
            self._timeline.finish(lines=self._lines)
        except Exception as error:
            with self._arrived:
                self.failure = error
                self._queue.clear()


_LEAST_S: Final = 2.0
_MOST_S: Final = 30.0
_SHARE: Final = 0.1
"""Interval of layouts: this fraction of the time so far, within these limits."""


class Offering:
    """The layouts of one recording."""

    def __init__(
        self, recording: rr.RecordingStream, contents: Contents, words: Words, *, viewer: str | None, live: bool
    ) -> None:
        """Starts without a layout. viewer: shows the recording while it grows. live: shows it as it happens."""
        self._recording = recording
        self._contents = contents
        self._words = words
        self._viewer = viewer
        self._live = live
        self._client: Any = None
        self._outline: tuple[object, ...] = ()
        self._views: set[str] = set()
        """Ids of the views of the last layout."""
        self._since = self._last = time.monotonic()

    def due(self) -> bool:
        """Returns true if it is time to check for something new."""
        now = time.monotonic()
        return now - self._last >= min(max(_LEAST_S, _SHARE * (now - self._since)), _MOST_S)

    def first(self) -> rrb.Blueprint:
        """Returns the layout before all rows."""
        self._outline, self._last = _outline(self._contents, live=self._live), time.monotonic()
        return self._made()

    def renew(self) -> None:
        """Sends a new layout if it differs."""
        self._last = time.monotonic()
        outline = _outline(self._contents, live=self._live)
        if outline == self._outline:
            return
        self._outline = outline
        taken = self._shown() == self._views
        self._recording.send_blueprint(self._made(), make_active=taken, make_default=True)

    def _made(self) -> rrb.Blueprint:
        made = layout(self._contents, self._words, live=self._live)
        self._views = {str(view.id) for view in _views(getattr(made, "root_container", None))}
        return made

    def _shown(self) -> set[str] | None:
        """Returns the ids of the viewer's views; None if they are unknown."""
        if self._viewer is None:
            return None
        with contextlib.suppress(Exception):  # it is experimental: what it may raise is not said
            from rerun.experimental import ViewerClient

            self._client = self._client or ViewerClient.connect(self._viewer)
            return {str(view.view_id) for view in self._client.get_state().views}
        return None


def _views(part: Any) -> Iterator[Any]:
    if isinstance(part, rrb.Container):
        for one in part.contents:
            yield from _views(one)
    elif part is not None:
        yield part


def _outline(contents: Contents, *, live: bool) -> tuple[object, ...]:
    """Returns the contents as far as layouts depend on them.

    live: without ranges of values, because no axis depends on them.
    """
    return (
        tuple((plot.entity, tuple(one.varies for one in plot.series)) for plot in contents.plots.values()),
        () if live else tuple(contents.ranges.items()),
        () if live else tuple((one.least, one.greatest) for plot in contents.plots.values() for one in plot.series),
        tuple(contents.told),
        tuple((entity, len(levels) > 1) for entity, levels in contents.listed.items()),
        tuple((lane.entity, lane.fault) for lane in contents.lanes.values()),
        frozenset(contents.sync),
        frozenset(contents.windows),
        tuple(contents.delays),
        tuple((bus, charts.axis(contents.peaks.get(bus, 0))) for bus in contents.load),
        contents.frames > 0,
        bool(contents.logged),
        contents.crowded,
        contents.findings > 0,
        tuple(contents.durations) if contents.brief else (),
        contents.summary,
        contents.timed,
    )


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
