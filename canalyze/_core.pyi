"""The Rust core as Python sees it: bytes in, annotated bytes out.

Words in the core's output are in the session's language; nothing here raises on the content of a capture.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, final

from canalyze.running.reading import SessionOptions

__version__: str

FORMATS: list[str]
"""Names of the formats that the core reads, for --input-format."""

SERVICES: list[str]
"""Services of frames, as named in filters, JSON and tables."""

SEVERITIES: list[str]
"""Severities of findings, ascending."""

DATA_TYPES: dict[int, tuple[str, int | None]]
"""Name and width of each data type by its code (CiA 301 7.4.7); bits as in a PDO, None without a fixed size."""

COLOURS: dict[str, str]
"""The control sequences that begin the colours of a terminal, by severity, service and other emphasis."""

PLAIN: str
"""The control sequence that ends a colour."""

WRITERS: list[str]
"""Names of the formats that the core writes, for `convert --to`."""

PROBLEMS: list[str]
"""Names of the kinds of problems, such as `node-silent`."""

TABLES: list[str]
"""Names of the tables that a session builds; `pdo` and `wide` each mean the tables of all PDOs."""

SETTINGS: dict[str, dict[str, dict[str, tuple[str, str]]]]
"""Keys of canalyze.toml (`config`) and of expectations (`expect`), by their tables, "" outside of tables.

Of each key the sentence about it, `config.NAME` in `words`, and what it allows where the sentence leaves that open.
"""

class SettingsError(Exception):
    """An error in a file written by the user."""

    args: tuple[str, dict[str, str]]
    """The key of the sentence in `words`, and its facts."""

@final
class Check:
    """[check] of canalyze.toml; missing values are None or empty."""

    fail_on: Literal["error", "warning", "info", "never"] | None
    problems: Literal["open", "ended", "never"] | None
    incidents: Literal["stands", "over", "never"] | None
    select: list[str]
    ignore: list[str]
    baseline: str | None
    at: tuple[str, str]
    """FILE:LINE of `select` and `ignore`."""
    overrides: list[
        tuple[list[str], Literal["ignore", "info", "warning", "error"], str, list[str], list[int], str | None, str]
    ]
    """Codes, severity, reason, globs of files, nodes, bus, FILE:LINE of the codes."""

@final
class Settings:
    """The content of canalyze.toml; missing values are None or empty. An identifier is (value, 29 bits)."""

    lang: str | None
    descriptions: list[tuple[str | None, list[int], str]]
    """Bus, node-IDs, file as written."""
    cobs: list[tuple[str | None, tuple[int, bool], int, Literal["tpdo", "rpdo"], int]]
    """Bus, identifier, node-ID, direction and number of the PDO."""
    sdos: list[tuple[str | None, tuple[int, bool], tuple[int, bool], int]]
    """Bus, identifiers client to server and server to client, node-ID of the server."""
    sync_period_ns: int | None
    sync_window_ns: int | None
    jitter_ns: int | None
    bitrate: int | None
    check: Check | None

@final
class Dictionary:
    """The flat table of one device description, with `$NODEID` unresolved, shared by all its nodes."""

    def __init__(
        self,
        *,
        file: str,
        form: str,
        device: str,
        rows: Sequence[tuple[int, int, str, int, str, int | None, bool, bool, bool, str, float]],
    ) -> None:
        """Creates the table of a description.

        file: its name, for provenance. form: eds | dcf | xdd | concise. device: the product's name, "" where there is
        none.
        rows: one a sub-object, in any order; of two with the same index and sub the first one counts:
            index 1000h to FFFFh; sub 0 to 255; name;
            data type code as the file has it (CiA 301 7.4.7), 0 where it has none;
            access: ro | wo | rw | rwr | rww | const;
            value: what the device starts with, of integers only, as many bits of it as its type has; None for
            everything else and where there is none;
            relative: the value is this plus the node-ID, modulo the type's width;
            configured: it is a DCF's ParameterValue, else the DefaultValue;
            mappable into a PDO; unit, "" if there is none; factor: physical value = value * factor, 1.0 if none.
        ValueError for a form, an access or a number that is none of these.
        """
    file: str
    """The name of its file, for provenance."""
    def pdos(self, dummies: Sequence[int]) -> list[Pdo]:
        """Returns the PDOs that it presets: RPDOs, then TPDOs, by number.

        dummies: codes of data types that may be mapped to skip bits, beside numbers without a sign.
        """

@final
class Pdo:
    """One PDO with its initial configuration."""

    number: int
    direction: Literal["rpdo", "tpdo"]
    communication: int
    """Index of its communication parameter."""
    cob_id: CobId
    transmission: int | None
    inhibit: int | None
    """In 100 us."""
    event_timer: int | None
    """In ms."""
    sync_start: int | None
    multiplex: Literal["sam", "dam"] | None
    """An MPDO: it has no mapping."""
    mapped: list[Mapped]
    """In the order of the payload, up to the first missing entry."""
    bits: int
    """Length of the payload."""

@final
class Mapped:
    """One entry of a mapping: `bits` bits of the payload from bit `offset` on."""

    index: int
    sub: int
    offset: int
    bits: int
    dummy: bool
    """The index is a data type: these bits are skipped."""

@final
class CobId:
    """A COB-ID entry of a PDO (CiA 301 7.5.2.35 and .37), taken apart."""

    valid: bool
    """Bit 31 is 0: the PDO exists."""
    rtr_allowed: bool
    """Bit 30 is 0; only of a TPDO."""
    extended: bool
    """Bit 29 is 1: a 29-bit identifier."""
    base: int
    """The identifier, without the node-ID where `relative`."""
    relative: bool
    """The node-ID is to be added."""
    assumed: bool
    """Not in the file: the pre-defined connection set, or no PDO at all."""

    def at(self, node: int | None) -> int | None:
        """Returns the identifier for a node; None if it needs a node-ID and there is none."""

def mapping_parameter(direction: str, number: int) -> int:
    """Returns the index of the mapping parameter of a PDO; direction: rpdo | tpdo."""

class DescriptionError(Exception):
    """The reason for which a file is no description."""

    args: tuple[str, dict[str, int | str]]
    """The key of the sentence in `words`, and its facts without the file's name."""

_FiledValue = int | float | str | bytes | tuple[int] | None
"""A value of a description; a tuple is an offset to the node-ID."""

def description(
    content: bytes, file: str
) -> tuple[
    Literal["eds", "dcf", "xdd", "concise"],
    str,
    tuple[str, str, str, str, str, str, str],
    tuple[
        str | None,
        int | None,
        str | None,
        int | None,
        int | None,
        str | None,
        tuple[int, ...],
        int | None,
        int | None,
        bool | None,
    ],
    tuple[str, ...],
    int | None,
    str,
    int | None,
    list[
        tuple[
            int,
            str,
            int,
            list[
                tuple[
                    int,
                    int,
                    str,
                    int,
                    Literal["ro", "wo", "rw", "rwr", "rww", "const"],
                    _FiledValue,
                    _FiledValue,
                    bool,
                    int | float | None,
                    int | float | None,
                    str,
                    float,
                    int,
                ]
            ],
            int,
        ]
    ],
    list[int],
    Dictionary,
    list[Pdo],
    list[tuple[int, str, dict[str, object]]],
]:
    """Reads a description of any form; file: its name for provenance. Raises DescriptionError for other files.

    Form, encoding, the fields of `FileInfo`, of `Device`, comments, node-ID, name of the node, bit rate, objects with
    the fields of `Object` and `Entry`, dummies, table, PDOs, defects with the fields of `Defect`: all as
    `canalyze.dictionary` documents them.
    """

def is_description(head: bytes) -> bool:
    """Returns true if a file with this beginning is a description and not a capture."""

def configured(
    content: bytes, values: Mapping[tuple[int, int], bytes], node: int, keys: Sequence[tuple[str, str]]
) -> tuple[str, list[tuple[int, int]]]:
    """Inserts values, as SDO transfers them, into a description; returns a DCF, and the addresses left out.

    keys: of [FileInfo]. DescriptionError where `content` is no description.
    """

def standard_object(index: int, sub: int, profile: int, lang: str) -> tuple[str | None, str | None]:
    """Returns name and type of an object of the standards; None for other objects.

    profile: of the device, as 402; 0 where it is not known. The type is one of the names in DATA_TYPES.
    """

def object_text(index: int, sub: int, data: bytes, kind: int, profile: int, lang: str) -> str:
    """Returns the value of an object as shown in listings.

    kind: code of its type; 0: that of the standards, else what the bytes look like. profile: of the device, or 0.
    """

@final
class Network:
    """The known properties of a network. The content of a capture overrides them."""

    def __init__(
        self,
        *,
        descriptions: Sequence[tuple[str | None, int, Dictionary]] = (),
        cobs: Sequence[tuple[str | None, int, bool, int, str, int]] = (),
        values: Sequence[tuple[str | None, int, int, int, int]] = (),
        profiles: Sequence[tuple[str | None, int, int]] = (),
        sdos: Sequence[tuple[str | None, int, bool, int, bool, int]] = (),
        sync_period_ns: int | None = None,
        sync_window_ns: int | None = None,
        jitter_ns: int | None = None,
        bitrate: int | None = None,
    ) -> None:
        """Creates the network. A bus is the name in the capture, None every bus; an entry with a bus has precedence.

        descriptions: bus, node-ID 1 to 127, what describes the node.
        cobs: bus, CAN-ID, whether it has 29 bits, node-ID, tpdo | rpdo, number of the PDO 1 to 512.
        values: bus, node-ID, index, sub-index, value of the object.
        profiles: bus, node-ID, number of the profile whose default mappings it has: 401 or 402.
        sdos: bus, CAN-ID client to server, whether it has 29 bits, CAN-ID server to client, whether it has 29 bits,
        node-ID of the server.
        sync_period_ns, sync_window_ns: 1006h and 1007h, above 0. jitter_ns: error of the stamps to allow for, 0 or
        more. bitrate: in bit/s. None: the capture tells.
        ValueError for a number or word that is none of these.
        """
    def pdos(self) -> str:
        """Returns the PDOs known before a capture, as JSON lines of the format `pdos`."""

@final
class Expectations:
    """A file of expectations, read and checked."""

    def __init__(self, content: bytes, file: str) -> None:
        """Reads a file with this content; file: its name in messages. Raises SettingsError for an invalid file."""
    normal: str
    """The normalized form as JSON, as the core judges by it: `file`, and a list for each kind.

    Each row has `line`; times are in ns; a bus is the name in the capture; null is the same as no key.
    sdo: node index sub, and bus, direction upload | download, value {"number"} | {"text"} | {"bool"} |
    {"data": hex}, outcome ok | aborted | any, abort, sequence, count (at least; 0: never), within_ns.
    state: node, either state boot-up | stopped | operational | pre-operational, or drive (a state of CiA 402 in
    kebab-case) and axis 1 to 8; and bus, by_ns, since start | boot-up, stays.
    signal: select (globs as --select), and bus, min, max, period_ns with tolerance_ns.
    heartbeat: node period_ns tolerance_ns, and bus. sync: period_ns tolerance_ns, and bus.
    emcy: occurs must | may | never, and bus, node, code [value, mask].
    latency: of sdo | sync | nmt, max_ns, and bus, node, index and sub (sdo), pdo (sync).
    load: max_percent, and bus, bit_rate in bit/s, window_ns.
    problem: one or more of occurs [least, most or null], ends_within_ns and cause (a glob of PROBLEMS), and bus,
    node, kind (a glob of them).
    """

@final
class Session:
    """One capture, of one or several files, from bytes to text or JSON lines.

    A session is fed the raw bytes of each file between begin() and end(); what comes back is UTF-8 and belongs on
    standard output as it is. Only complete lines are answered; every call releases the GIL.
    """

    def __init__(self, options: SessionOptions) -> None:
        """Starts a capture.

        ValueError (one line, in the session's language) for a value that is none of those listed there, or a filter,
        map or mask that cannot be read.
        """
    def begin(self, name: str, regular: bool, format: str = "candump", input: int = 0) -> None:
        """Begins the next file, in one of FORMATS.

        name: for messages and JSON. regular: a whole file (not a pipe): dialects may be decided on its first 64 KiB,
        so output may lag by as much. input: files that are joined by time are numbered from 0 in the order in which
        they begin, and all of them begin before any is fed; a file by itself is 0. ValueError for a format that is
        neither in FORMATS nor `packed`, the records of another reader (`sources/bridge/`), nor `live`, the blocks
        of live buses (`sources/live.py`), which also tell the time.
        """
    def feed(self, data: bytes, input: int = 0, start: int = 0, end: int | None = None) -> bytes:
        """Reads more bytes of a file, in any chunking; returns the output so far.

        start, end: the part of `data` that is meant, all by default.
        """
    def rest(self) -> bytes:
        """Returns held back output, because nothing arrives at the moment, as in a pipe."""
    def damaged(self, kind: str, offset: int, bytes: int | None = None, input: int = 0) -> None:
        """Records that a file cannot be unpacked further; reported by end(), which must be called next.

        kind: cut (it ends too early) | checksum | structure | compression | rest | doubtful (all that was unpacked from
        `offset` on may be wrong). offset: where in the file as it is. bytes: how many of it are lost behind what was
        fed. ValueError for another kind.
        """
    def covered(self, input: int = 0) -> None:
        """Begins a part with a checksum of its own: damage reported as `doubtful` begins here."""
    def wants(self) -> int | None:
        """Returns the input to feed or end next; None if all are ended, refused, or done."""
    def refusal(self) -> tuple[str, list[int]] | None:
        """The reason for which the inputs cannot be joined by time: no_stamps (the input without any) | no_clock.

        no_clock: the first one's stamps are times of day, the second one's count from a start that is not told.
        """
    def end(self, interrupted: bool = False, input: int = 0) -> bytes:
        """Ends a file; returns the rest of its output.

        interrupted: it was the reading that stopped, not the file that ended: a partial line is dropped in silence.
        """
    def finish(self) -> bytes:
        """Ends the capture; returns open transfers and the final output."""
    def batches(self, flush: bool = False) -> list[tuple[str, Batch]]:
        """Returns the batches of tables completed since the last call, each with the name of its table.

        A batch ends after 65,536 rows or 16 MiB of text and data, those of PDOs also where all of them together would
        take more than 64 MiB. flush: those that run end now (live sources). After finish(): all of them, and of each
        table but those of PDOs that had none, one without rows, for its columns. Taken after each feed, memory does
        not grow with the capture.
        """
    def snapshot(self) -> str:
        """With monitor: what a view shows by now but the trace, a JSON object; "" in other formats.

        Whatever filter the session has, everything counts. Times are integers of ns on the clock of the frames, null
        for never and without stamps; rates count what came in the last 2 s, the load in the last 1 s. Texts are in the
        session's language; "" where there is none. A bus is its name in the capture, "" without.
        now_ns: the last stamp, or the time that live buses have told since. start_ns: the first stamp. tally: that of
        tally().
        buses: name, frames, frames_per_s, bits_per_s, bit_rate (of the network) and load_percent or null,
        error_frames, dropped, state (of the listening controller: null error-warning error-passive bus-off).
        nodes: bus, node, name (of its description, else by 1008h), state (hex, null: unknown) and state_text, frames,
        sent (by itself), frames_per_s, unknown (the bus was away since the state was seen: it may be any),
        heartbeat_age_ns (since boot-up, heartbeat or answer to guarding),
        heartbeat_period_ns (by 1017h or its heartbeats), silent (heartbeat or guarding: by which it should have been
        heard since and was not; else null), guarded, emcy (null, or the last error code, of those that stand if any
        do: code text t_ns, and active: how many stand, 0: none), boot_ups, drive (null, or its state), findings
        {error warning}, problem.
        objects, one an identifier, in order of bus, 11 bits before 29, identifier, data before remote frames: bus, id,
        ext, rtr, service, node, name, count, last_ns, period_ns (mean of the last 16), jitter_ns (by how much one of
        them differs from it at most; null of one alone), rate, len, data, changed (FF for each byte that changed in
        the last second, or with the last frame where there are no stamps), text (what the last frame says), severity
        (of the worst finding about its frames in the last 10 s, or null). All error frames of a bus are one, of
        service error.
        objects_more: identifiers for which there was no room (4096 objects, 1024 of 29-bit foreign ones).
        transfers: running (transfer bus node direction mode index sub name; size as indicated or null, bytes by now,
        since_ns), done, the last 200 (transfer bus node direction mode index sub name size value text status abort
        first_frame last_frame t_ns duration_ns, as in the lines of transfers; no value of more than 256 bytes).
        findings, the last 500: code, severity, frame (null: of the capture), t_ns, bus, node, text, count (above 1:
        more of its kind followed, which have no row of their own).
        problems, at most 256, in the order of reading, each cause before what it has caused, which has one more depth:
        id, kind, word (what kind it is), status and provisional (more of the capture may change what is said), impact,
        grade, bus, node, nodes, frame and t_ns (of the first evidence), noticed (frame), end_frame, end_ns, depth,
        cause (id), cause_grade, delay_ns (since the cause began), text, checks, count. Until the capture is over they
        are as they would be if it were over now. problems_more: those without a row. problem of a node: null, or
        the first that concerns it and is not over: id word provisional.
        """
    def page(self, bus: str, node: int) -> str:
        """Returns the details of a node as JSON (format `monitor`).

        `identity` is a list of `index`, `sub`, `name`, `text` of objects that were read of it; `pdos` one of `pdo`,
        `id`, `valid`, `type`, `from` (whence the mapping is known) and `objects`, each with `index`, `sub`, `name`,
        `bits`.
        """

    def trace(
        self, filter: str = "", search: str = "", frame: int | None = None, rows: int = 50, back: bool = True
    ) -> list[tuple[int, str, int | None, str, str, str, str]]:
        """With monitor: at most `rows` of the last 50,000 lines of frames that pass the session's filter, oldest first.

        filter: an expression as that of --filter. search: text that a line must contain, in any case of ASCII letters.
        frame: back, they end with the last line of this frame, None: with the newest one; else they begin with its
        first line, None: with the oldest one.
        Each: frame, severity ("" for none), time in ns, bus, identifier, data, text. Below a frame's own line stand
        notes and findings, whose identifier and data are ""; one about no frame has the number of the frame before it.
        ValueError (in words) for a filter that cannot be read.
        """
    def contents(self) -> str:
        """Returns the properties of the current or last file as a JSON object.

        dialect: {word of the format's own: value}. passed_over: [{kind, count}], records that are no frames.
        topics: [{name, schema, encoding, messages, read_as, bus}]; read_as: the fields in which a message holds a
        frame, "" where it is not read as one.
        """
    def complaints(self) -> list[str]:
        """Returns lines for standard error since the last call (unreadable lines, gaps), in words."""
    def losses(self, name: str, further: Mapping[str, int] = {}) -> list[str]:
        """Returns the data that the format cannot hold, counted by kind, in lines that begin with `name`.

        further: what a writer outside of the core has lost of what it was handed, by the names of the core's losses
        (`Loss::NAMES` in writers/loss.rs). ValueError for a name that is none.
        """
    def extracted(self) -> list[tuple[str, bytes, str, list[tuple[int, int | None]], str]]:
        """With extract: (file name, more bytes, status, holes, line) since the last call.

        status: "" while the transfer runs, else ok | aborted | incomplete | failed once. holes: offset and length of
        what is missing. line: the JSON line of a transfer that has ended, with English names. File names are safe:
        letters, digits, . _ - only.
        """
    def nodes(self) -> str:
        """Returns the activity of each node as a JSON list.

        Of `bus`, `node`, `state_text`, `silent` ("heartbeat", "guarding" or ""), `frames`, `errors`, `warnings`.
        """

    def tally(self) -> str:
        """Returns the counters so far as a JSON object.

        frames, shown. findings: {error, warning, info}, those that were told; repeats of one that are not come with
        finish(). transfers: {ok, aborted, incomplete, failed}, of SDO. expectations: {missed}, null without any.
        buses: [{name, frames, error_frames, dropped}];
        error frames are frames too, dropped ones are lost for the session.
        """
    @property
    def done(self) -> bool:
        """True if `count` frames have been shown; further bytes are ignored."""
    @property
    def holds(self) -> bool:
        """True if frames are held back until the next ones show what the recording did with them."""
    @property
    def frames(self) -> int:
        """Number of frames read so far, in all files."""
    @property
    def file_frames(self) -> int:
        """Number of frames read so far in the current or last file."""
    @property
    def date_ns(self) -> int | None:
        """The date from which relative stamps count, in ns since 1970, if a file has one."""
    @property
    def nature(self) -> Literal["silent", "foreign", "unproven", "canopen"]:
        """The nature of the buses of a finished capture, such as CANopen."""

@final
class Batch:
    """Rows of one table of columns, as Arrow's PyCapsule interface hands them over; it outlives its session.

    `render/columns/mod.rs` of the core lists the tables with their columns. `pyarrow.record_batch(batch)`,
    `polars.DataFrame(batch)` and the like take it as it is, without a copy.
    """

    @property
    def name(self) -> str:
        """The table: one of TABLES, or `pdo/BUS/NODE.PDO/VERSION`, `pdo/NODE.PDO/VERSION` on a bus without a name."""
    @property
    def num_rows(self) -> int:
        """Rows."""
    @property
    def column_names(self) -> list[str]:
        """Names of the columns, in order."""
    @property
    def metadata(self) -> dict[str, str]:
        """Metadata of the schema: `table`, its name; for PDOs also bus, node, pdo, version and lang."""
    def __len__(self) -> int: ...
    def column(self, name: str) -> list[Any]:
        """Returns the values of a column as int, float, str, bytes, bool, lists of these, or None. Raises KeyError."""
    def __arrow_c_array__(self, requested_schema: object | None = None) -> tuple[object, object]: ...
    def __arrow_c_schema__(self) -> object: ...

@final
class Table:
    """Batches of one table, as a stream for Arrow's readers: `pyarrow.table(table)`, `polars.DataFrame(table)`."""

    def __init__(self, batches: Sequence[Batch]) -> None:
        """Joins the batches in this order. Raises ValueError if there are none, or if they are of several tables."""
    @property
    def name(self) -> str:
        """As that of its batches."""
    @property
    def num_rows(self) -> int:
        """Rows of all batches."""
    @property
    def column_names(self) -> list[str]:
        """As those of its batches."""
    @property
    def metadata(self) -> dict[str, str]:
        """As that of its batches."""
    def __len__(self) -> int: ...
    def batches(self) -> list[Batch]:
        """Yields the batches."""
    def column(self, name: str) -> list[Any]:
        """Returns the values of a column of all batches. Raises KeyError for an unknown one."""
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...
    def __arrow_c_schema__(self) -> object: ...

@final
class Comparison:
    """Two captures compared as CANopen."""

    def __init__(
        self,
        a: Session,
        b: Session,
        *,
        names: tuple[str, str],
        lang: str = "zh",
        tolerance: float = 0.1,
        buses: Sequence[tuple[str, str]] = (),
    ) -> None:
        """Compares two finished sessions of format `course`, whose contents are taken.

        names: of the files, for JSON. tolerance: by how much periods may differ, as a part of the shorter one.
        buses: names of buses that are one bus, in A and in B; others are matched by name, else by their nodes.
        ValueError for a session that has nothing kept.
        """
    @property
    def buses(self) -> tuple[list[str], list[str]]:
        """Names of the buses of A and of B, without unnamed ones."""
    @property
    def differences(self) -> int:
        """Number of differences; equal ones count once."""
    def first(self) -> tuple[int | None, int | None]:
        """The frame of the first difference in A and in B; None if unknown."""
    def head(self) -> bytes:
        """Returns the text above the lines around the first difference."""
    def body(self) -> bytes:
        """Returns the text below: every difference, by bus and node, and the extent of the comparison."""
    def jsonl(self) -> bytes:
        """Returns the comparison as JSON lines."""

@final
class Rule:
    """One rule of the catalogue."""

    code: str
    name: str
    severity: str
    clause: str
    message: str
    meaning: str
    cause: str

def rules(lang: str = "zh") -> list[Rule]:
    """Returns all rules, in order of their codes, in words of that language."""

def diagnosis_words(lang: str) -> list[tuple[str, str]]:
    """Returns the words of a diagnosis, by the values of machine output: `status.open`."""

def verdict(lang: str, nature: str, counts: Sequence[int]) -> tuple[str, str]:
    """Returns the verdict on some roots: the worst status, and its words.

    nature: of the capture; counts: how many are open, of unknown status, ended, harmless.
    """

def explain(line: str, lang: str = "zh", network: Network | None = None) -> str | None:
    """Explains a frame (candump log or console form, or cansend's ID#DATA) field by field, or a code.

    A code is that of a rule, a kind of problem, an abort code, `8130h`, `1016h:01`, `182`, one with a word before it
    (`emcy 8130`, `register 11`, `statusword 0218`), or a term of CANopen (`inhibit time`). None for anything else;
    ValueError, in words, for a line that is meant as a frame and cannot be read.
    network: descriptions of devices; one of node 0 is of a node that is not known.
    """

def sniff(head: bytes, complete: bool) -> str | None:
    """Returns the format of the input that begins with `head`; None if more bytes are needed.

    complete: there are no more bytes. Beside FORMATS: blf mf4 sqlite trc csv (other programs' readers), gzip xz zstd
    bzip2 (to be unpacked first), utf-16 utf-16le utf-16be (text of another encoding).
    """

def omission(line: bytes) -> int | None:
    """Returns the number of rows that a line of a listing marks as omitted, -1 if unknown; None for other lines."""

def may_hold_command(lines: bytes) -> bool:
    """Returns true if the lines may contain a command of GitHub's runner: `::` or `##[`."""

def schema() -> bytes:
    """Returns the schema of all records as a JSON list.

    Each has `table` (its Arrow table) and `kind` (of its JSON lines; `frame.pdo` is an object in another one), null if
    there is none, its documentation `en` and `zh`, the headings of `csv`, and `columns`. A column has its name `column`
    and its type `arrow` in the table, its `key` and its type `json` (integer, number, string, boolean, array, object or
    any) in the object, null where it is not there, `nullable`, `optional` (the key may be absent), `en` and `zh`.
    """

def settings(content: bytes, file: str) -> Settings:
    """Reads a canalyze.toml; file: its name in messages. Raises SettingsError for an invalid file."""

def node(text: str) -> int | None:
    """Parses a node-ID, decimal or hexadecimal with 0x; this and all following return None for invalid text."""

def nodes(text: str) -> tuple[int, ...] | None:
    """Parses node-IDs: a list of single ones and of ranges such as 1-4."""

def can_id(text: str) -> tuple[int, bool] | None:
    """Parses an identifier: up to three hexadecimal digits; eight are the 29-bit format, the second value."""

def pdo(text: str) -> tuple[Literal["tpdo", "rpdo"], int] | None:
    """Parses the name of a PDO, such as TPDO1."""

def pdo_mapping(text: str) -> tuple[int, Literal["tpdo", "rpdo"], int, list[tuple[int, int, int]]] | None:
    """Parses PDO=MAPPING: node-ID, direction, number, and the objects of its mapping parameter (index, sub, value)."""

def profile(text: str) -> int | None:
    """Parses the number of a device profile with known default mappings."""

def address(text: str) -> tuple[int, int | None] | None:
    """Parses the address of an object, 1017:00 in hexadecimal (1017h:0, 0x1017:00); no sub-index: all of them."""

def tolerance(text: str) -> int | None:
    """Parses a time from zero on, in microseconds or with the suffix us, ms or s; returns it in nanoseconds."""

def bit_rate(text: str) -> int | None:
    """Parses a bit rate in bit/s, or with the suffix k or M."""

def codes(text: str) -> tuple[str, ...] | None:
    """Parses codes of rules, or their beginnings, separated by commas: `SDO001,HBT`."""
