"""The options of one session of the core.

Must not: read a file, or check what the core checks itself.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from canalyze._core import Expectations, Network


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
    """Which of TABLES are built beside, to be taken with batches(); with every format but info."""
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
