"""One pass over a capture: sources in, a session between, results out.

The only loop that reads, of the command and of the library. It hands over every result at once and complaints in their
place. It must not write, print or know a signal: what becomes of a result, of a complaint, of an input that cannot be
read, and of a wish to end, says who reads.
"""

import os
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import ExitStack
from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol, TypeVar

from canalyze.errors import SourceError
from canalyze.sources import Capture, input_formats, open_capture
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Expectations, Network, Session
    from canalyze.sources.compressed import Damage
    from canalyze.sources.live import Live


class SessionOptions(NamedTuple):
    """Options of a session; each has the value that a session has without it."""

    lang: str = "zh"
    """zh | en."""
    format: str = "text"
    """The form of the output: text |
    jsonl (frame, note, finding, transfer) |
    events (the same, for a library: with `incidents` what diagnosis has at the end, too) |
    transfers (JSON lines of transfers only) |
    transfers-text (the same with names in the language of the session, for a table) |
    transfers-csv (the same as CSV, a line of headings first) |
    signals (JSON lines of decoded signals) |
    signals-csv (the same as CSV, a line of headings first) |
    objects (JSON lines of what the traffic shows of each object of the devices, from finish()) |
    objects-text (the same with names in the language of the session, for a table) |
    objects-csv (the same as CSV, a line of headings first) |
    pdos (JSON lines of PDOs with their mappings, from finish(): `tables/jsonl/pdos.rs` has the keys) |
    history (JSON lines of all that is seen of objects, as it comes) |
    history-text, history-csv (the same) |
    summary (JSON lines, one object a record, all of them from finish()) |
    observed (the lines of transfers as they end; from finish() those of summary, then observed_...) |
    lines (JSON lines of `line`: what text has of each frame, with its number) |
    records (JSON lines: transfers and findings as they come, and what summary has from finish()) |
    info (JSON lines, one object a file, from its end(); nothing is decoded) |
    check (JSON lines of findings only, with `lines`, the annotated lines that led to each) |
    diagnosis (JSON lines of incidents, from finish()) |
    columns (nothing comes out as bytes: for tables alone) |
    digest (nothing comes out: it is kept for a Comparison) |
    monitor (nothing comes out: what holds now is asked for with snapshot() and trace()) |
    convert (the frames that pass the filter, in another capture format; its trailer comes from finish())."""
    depth: str = "default"
    """brief | default | explain; text only."""
    stamps: str = "auto"
    """The kind of the time stamps: auto | absolute | zero | delta."""
    time: str | None = None
    """Their form: a d z A n, as -t; None: as recorded. In JSON lines each t is that of the capture."""
    filter: str | None = None
    """The expression of --filter."""
    extract: bool = False
    """True if the data of transfers are kept for pieces()."""
    network: "Network | None" = None
    """The known network."""
    select: str | None = None
    """The globs of --select; signals, signals-csv and tables only."""
    topics: Sequence[str] = ()
    """Globs of the topics that are read of an MCAP file; none: all."""
    time_source: str | None = None
    """The time of its messages: stamp | publish | log; None: found out for each topic."""
    mcap_maps: Sequence[str] = ()
    """Fields of its messages, each `topic=/x,id=can_id,data=payload` as in --mcap-map."""
    to: str = "candump"
    """One of WRITERS; convert only."""
    decoded: bool = False
    """True if topics of what the frames mean are written as well, where the format has such."""
    mcap_fd_schema: str = "ros2"
    """ros2 | dataspeed."""
    mcap_archive: bool = False
    """True if an MCAP file is written without message indexes."""
    tables: Sequence[str] = ()
    """The ones of TABLES that are built beside, for batches(); with every format but info."""
    expectations: "Expectations | None" = None
    """The expectations of the capture; one that does not hold is a finding like others."""
    incidents: bool = False
    """True if problems are written, too: in text as they begin, are linked to a cause and end, in jsonl both so and
    at the end, in check and observed at the end."""
    masks: Sequence[str] = ()
    """Channels, each with candump's filters behind its name (`can0,123:7FF,#1F`): which of its frames are shown. Of
    channels that are not named, or have no filters, all are."""
    limit: int | None = None
    """Frames that are shown at most: the capture ends behind the last of them, see done()."""
    until_ns: int | None = None
    """The capture ends with this time, counted from its first frame."""
    threads: int | None = None
    """Threads that share the work on a piece of a file; None: as many as there are processors to use. What comes out is
    the same."""
    coloured: bool = False
    """True if text has the colours of a terminal."""
    numbered: bool = False
    """True if text begins with the numbers of frames."""


T = TypeVar("T")

_HELD: Final = 100
"""Complaints kept about a file in which no frame was found yet."""
_FIRST: Final = 60
"""Characters that are shown of a line."""
_LISTED: Final = 20
"""Topics of a file without frames that are named."""
_JOINED: Final = 4 << 20
"""Bytes that are fed of all files together at once, where they are joined by time: their frames wait in memory."""
_LEAST: Final = 16 << 10
"""Bytes that are fed of one of them at least."""
_RESULT: Final = 2 << 20
"""Bytes that a result has at most, about: as many are fed at once as come to that, of what came before."""
_BEGINNING: Final = 128 << 10
"""Bytes that are fed of an input before that is known."""


class Reader(Protocol):
    """Who reads: what a pass has to tell, and asks."""

    @property
    def ended(self) -> bool:
        """True if the end is wished before all is read."""

    def during(self, wait: Callable[[], T]) -> T | None:
        """Calls what may wait long; None where a wish for the end came first."""

    def complain(self, line: str) -> None:
        """Receives a line about the contents of a capture, for people."""

    def failed(self, error: SourceError) -> None:
        """Receives the reason why an input cannot be read, or no further; an error raised here ends the pass."""

    def step(self, size: int, frames: int) -> None:
        """Receives that `size` bytes more were read, and the number of frames by now."""


class _Input:
    """One open file of those that are read together."""

    def __init__(self, capture: "Capture | Live") -> None:
        self.capture = capture
        self.taken = 0
        self.data = b""
        """The bytes that were read last."""
        self.start = self.end = 0
        """The part of `data` to be fed: to copy it would cost as much as to read it."""

    def go_on(self, most: int) -> bool:
        """Returns true if there is a next part, of at most `most` bytes, and makes it the current one."""
        if self.at_rest:
            self.data, self.end = self.capture.read(), 0
        self.start, self.end = self.end, min(self.end + most, len(self.data))
        return self.start < self.end

    @property
    def at_rest(self) -> bool:
        """Returns true if no further part of what was read waits."""
        return self.end == len(self.data)

    def forget(self) -> None:
        """Frees what was read, once all of it was fed: other files may have their turn for long."""
        if self.at_rest:
            self.data, self.start, self.end = b"", 0, 0


class Reading:
    """One capture of one or several inputs through one session."""

    def __init__(
        self,
        session: "Session",
        words: Words,
        reader: Reader,
        *,
        open_input: Callable[[str], "Capture | Live"] = open_capture,
        merge: bool = False,
        given_format: bool = False,
        frameless: bool = False,
    ) -> None:
        """`open_input` opens an input by its name.

        merge: joined by time, not one after the other. given_format: nobody has guessed what the inputs are.
        frameless: a file without any frame is fine, if it has the sign of its format.
        """
        self._open_input = open_input
        self._merge = merge
        self._given_format = given_format
        self._frameless = frameless
        self._session = session
        self._words = words
        self._reader = reader
        self._name = ""
        self._held: list[str] = []
        self._more = 0
        self.last: Capture | Live | None = None
        """The input that was read last, closed: what is known of it."""
        self.understood = False
        """Something could be read of it."""

    def over(self, names: Sequence[str]) -> Generator[bytes, None, None]:
        """Reads all of them and finishes the capture; yields every result in order, also an empty one."""
        for group in [names] if self._merge else [(name,) for name in names]:
            if self._reader.ended:
                break
            try:
                yield from self._read(group)
            except SourceError as error:
                self._reader.failed(error)
        yield from self._results(self._session.finish(), hold=False)

    def _read(self, names: Sequence[str]) -> Iterator[bytes]:
        """Reads files together: each goes on when the session needs it."""
        with ExitStack() as stack:
            inputs: list[_Input] = []
            for name in names:
                capture: Capture | Live | None
                try:
                    capture = self._reader.during(partial(self._open_input, name))
                except SourceError as error:
                    self._reader.failed(error)
                    continue
                if capture is None:
                    break
                stack.callback(capture.__exit__, None, None, None)
                inputs.append(_Input(capture))
            yield from self._through(inputs)

    def _through(self, inputs: list[_Input]) -> Iterator[bytes]:
        session = self._session
        for place, one in enumerate(inputs):
            capture = self.last = one.capture
            session.begin(_utf8(capture.name), capture.regular, capture.format, place)
            self._name, self._held, self._more = capture.name, [], 0
        joined = len(inputs) > 1
        most = max(_LEAST, _JOINED // len(inputs)) if joined else _BEGINNING
        open_ = dict(enumerate(inputs))
        while open_ and not session.done and (number := session.wants()) is not None:
            one = open_[number]
            stopped: SourceError | None = None
            try:
                more = self._reader.during(partial(one.go_on, most))
            except SourceError as error:  # what came before it is said first
                more, stopped = False, error
            self._remarks(one.capture)
            if more is None:
                break
            hold = one.capture.regular and not joined
            if more:
                if one.capture.begins and one.start == 0:
                    session.covered(number)
                result = session.feed(one.data, number, one.start, one.end)
                yield from self._results(result, hold=hold)
                if not joined:
                    most = max(_BEGINNING, _RESULT * (one.end - one.start) // max(len(result), 1))
                one.forget()
                self._remarks(one.capture)
                self._reader.step(one.capture.taken - one.taken, session.frames)
                one.taken = one.capture.taken
                if session.holds and one.at_rest and self._reader.during(one.capture.rests):
                    yield from self._results(session.rest(), hold=hold)
                continue
            self._remarks(one.capture)
            del open_[number]
            yield from self._ended(number, one.capture, stopped, hold=hold)
        refusal = session.refusal()
        if refusal:
            reason, numbers = refusal
            names = [inputs[number].capture.name for number in numbers]
            raise SourceError(f"merge.{reason}", name=names[0], other=names[-1])
        for place, one in open_.items():  # broken off
            hold = one.capture.regular and not joined
            yield from self._results(session.end(interrupted=True, input=place), hold=hold)
        self._release()

    def _ended(
        self, number: int, capture: "Capture | Live", stopped: SourceError | None, *, hold: bool
    ) -> Iterator[bytes]:
        session = self._session
        self.understood = stopped is None or session.file_frames > 0
        if capture.damage:
            kind, offset, lost, since = capture.damage
            if since is not None:
                kind, offset = "doubtful", since
            session.damaged(kind, offset, lost, number)
        yield from self._results(session.end(input=number), hold=hold)
        if session.file_frames == 0:
            if stopped is None:
                stopped = nothing(
                    capture, session, self._words, given_format=self._given_format, frameless=self._frameless
                )
                if stopped and capture.format == "candump" and not capture.damage:
                    self._held, self._more = [], 0  # it is none: one line says it all
            self.understood = stopped is None
        self._release()
        if stopped:
            self._reader.failed(stopped)

    def _remarks(self, capture: "Capture | Live") -> None:
        for remark in capture.remarks():
            self._reader.complain(remark.in_words(self._words))

    def _results(self, result: bytes, *, hold: bool) -> Iterator[bytes]:
        """Yields a result, then passes complaints on; of a file that is no capture one line is enough."""
        yield result
        complaints = self._session.complaints()
        if hold and self._session.file_frames == 0:
            room = _HELD - len(self._held)
            self._held += complaints[:room]
            self._more += len(complaints[room:])
            return
        self._release()
        for line in complaints:
            self._reader.complain(line)

    def _release(self) -> None:
        for line in self._held:
            self._reader.complain(line)
        if self._more:
            self._reader.complain(self._words("source.more_complaints", name=self._name, count=self._more))
        self._held, self._more = [], 0


class Counted:
    """An open capture whose frames are counted while it is read, as bytes: SourceError at its end where it has none."""

    def __init__(self, capture: "Capture", session: "Session", words: Words, *, given_format: bool):
        """`session` counts; the format `info` does no more than that."""
        self.name, self.format = capture.name, capture.format
        self._capture, self._session, self._words, self._given_format = capture, session, words, given_format
        session.begin(_utf8(capture.name), capture.regular, capture.format)

    @property
    def damage(self) -> "Damage | None":
        """Why the file could be unpacked no further; known when nothing comes any more."""
        return self._capture.damage

    def read(self) -> bytes:
        """Returns the next bytes, b"" at the end."""
        if data := self._capture.read():
            self._session.feed(data)
        else:
            self._session.end()
            problem = nothing(self._capture, self._session, self._words, given_format=self._given_format)
            if self._session.file_frames == 0 and problem:
                raise problem
        return data


def nothing(
    capture: "Capture | Live",
    session: "Session",
    words: Words,
    *,
    given_format: bool,
    frameless: bool = False,
) -> SourceError | None:
    """Returns why there is no frame, unless that is no fault: of a file with topics, which ones there are."""
    if capture.format == "live":  # on a bus there may be silence
        return None
    if not capture.taken:
        return SourceError("source.empty", name=capture.name)
    if frameless and capture.format != "candump":
        return None
    from canalyze.records import decoder
    from canalyze.records.summary import Contents

    contents: Contents = decoder(Contents)(session.contents())
    if capture.format == "mcap":
        topics = sorted(contents.topics, key=lambda topic: topic.messages == 0)  # what holds nothing is listed last
        listed = ", ".join(f"{topic.name} ({topic.schema or '?'})" for topic in topics[:_LISTED])
        more = ", ..." if len(topics) > _LISTED else ""
        if topics and not any(topic.read_as for topic in topics):
            return SourceError("source.no_topic", name=capture.name, topics=f"{listed}{more}")
    # Of what could not be unpacked, or is said to be something, there is nothing to guess.
    if isinstance(capture, Capture) and capture.format == "candump" and not given_format and not capture.damage:
        return SourceError("source.nothing", name=capture.name, first=_first_line(capture.head))
    form = words.of("info.title", capture.kind)
    if contents.dialect.get("identifiers") == "implausible":
        return SourceError("source.implausible", name=capture.name, form=form)
    if given_format:
        return SourceError("source.unfit", name=capture.name, form=form, formats=", ".join(input_formats()))
    return SourceError("source.frameless", name=capture.name, form=form)


def _first_line(head: bytes) -> str:
    """Returns the first line of a file that is not blank, shortened."""
    lines = (line.strip() for line in head.decode("utf-8", "backslashreplace").splitlines())
    said = next((line for line in lines if line), "")
    first = "".join(char if char.isprintable() else "?" for char in said)
    return f'"{first[:_FIRST]}..."' if len(first) > _FIRST else f'"{first}"'


def _utf8(name: str) -> str:
    return os.fsencode(name).decode("utf-8", "backslashreplace")
