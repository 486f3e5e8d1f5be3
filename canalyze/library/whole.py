"""Functions for whole captures: to compare two, to write one in another format, its figures, the rules.

What the commands of these names print, these give. Must not: print.
"""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar, Unpack

from canalyze.library import Descriptions, Options, Source, StrPath
from canalyze.library import open as open_
from canalyze.library.capture import Capture
from canalyze.library.columns import html_table
from canalyze.library.rows import ObjectLike, Problems, address, one_of
from canalyze.output import Kept
from canalyze.records.frames import Frame
from canalyze.records.problems import Problem

if TYPE_CHECKING:
    from can import Message

    from canalyze._core import Rule


T = TypeVar("T")


class _Told(Sequence[T]):
    """Records of the core, and the text of the command that shows them."""

    def __init__(self, rows: Sequence[T], text: str) -> None:
        self._rows = rows
        self._text = text

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, place: Any) -> Any:
        """Returns one, or some."""
        return self._rows[place]

    def __str__(self) -> str:
        return self._text


class Diff(_Told[Mapping[str, Any]]):
    """In what two captures differ: false where they do not, `str()` the text of `canalyze diff`.

    Its records are those of `canalyze diff --format jsonl`.
    """

    def __init__(self, text: str, records: Sequence[Mapping[str, Any]], count: int) -> None:
        """Creates a result of the core's records and text."""
        super().__init__(tuple(records), text)
        self.differences = count
        """The number of differences; several of the same count once."""

    def __bool__(self) -> bool:
        return self.differences > 0

    def __repr__(self) -> str:
        return f"<Diff: {self.differences} differences>"


class Summary:
    """A capture in figures: the records of `canalyze summary --format jsonl`, and `str()` the text of the command."""

    def __init__(self, records: Sequence[Mapping[str, Any]], text: str) -> None:
        """Creates a result of the core's records and text."""
        self.records = tuple(records)
        """All records, each with its `kind`."""
        self._text = text

    def of(self, kind: str) -> list[Mapping[str, Any]]:
        """Returns the records of a kind: capture, bus, node, identifier ... ValueError for a kind that is not there."""
        one_of("kind", kind, sorted({one["kind"].removeprefix("summary_") for one in self.records}))
        return [one for one in self.records if one["kind"] == f"summary_{kind}"]

    def __iter__(self) -> Iterator[Mapping[str, Any]]:
        return iter(self.records)

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"<Summary: {len(self.records)} records>"

    def _repr_html_(self) -> str:
        """Returns the nodes and their frames, for a notebook."""
        nodes = [one for one in self.records if one["kind"] == "summary_node"]
        rows = [(one["bus"], one["node"], one["name"], one["state_name"], one["frames"]) for one in nodes]
        return html_table(("bus", "node", "name", "state", "frames"), rows, f"{len(nodes)} nodes")


class Diagnosis(_Told[Problem]):
    """The problems that no other has caused, the most important first; harmless ones are left out.

    False where there are none; `str()` the text of `canalyze FILE`.
    """

    def __init__(self, problems: Problems, text: str) -> None:
        """Creates a result of the core's records and report."""
        self.problems = problems
        """All of them: what follows from others too, and what is harmless."""
        super().__init__([one for one in problems.roots if one.status != "harmless"], text)

    @property
    def open(self) -> list[Problem]:
        """Those that have not ended."""
        return [one for one in self if one.status == "open"]

    def __repr__(self) -> str:
        return f"<Diagnosis: {self._text.partition(chr(10))[0]}>"


class Inventory(_Told[Mapping[str, Any]]):
    """The objects of devices, by what the traffic shows: the records of `canalyze od --format jsonl`.

    `str()` is the text of the command.
    """

    def __init__(self, records: Iterable[Mapping[str, Any]], text: str) -> None:
        """Creates a result of the core's records and report."""
        records = list(records)
        self.nodes = tuple(one for one in records if one["kind"] == "od_node")
        """The records of the devices."""
        super().__init__(tuple(one for one in records if one["kind"] == "od_object"), text)

    def of(
        self,
        *,
        node: int | None = None,
        object: ObjectLike | None = None,  # noqa: A002  the standard's word
        bus: str | None = None,
    ) -> list[Mapping[str, Any]]:
        """Returns those of a node, an object (0x1017, (0x1018, 1), "1018:01") or a bus; ValueError for no object."""
        index, sub = (None, None) if object is None else address(object)
        wanted = {"node": node, "index": index, "sub": sub, "bus": bus}
        asked = {key: value for key, value in wanted.items() if value is not None}
        return [one for one in self if all(one[key] == value for key, value in asked.items())]

    def __repr__(self) -> str:
        return f"<Inventory: {len(self)} objects of {len(self.nodes)} nodes>"


def diff(
    a: "Source | Capture",
    b: "Source | Capture",
    *,
    tolerance: float = 0.1,
    buses: Iterable[tuple[str, str]] = (),
    **options: Unpack[Options],
) -> Diff:
    """Compares two captures as CANopen; captures of `open`, or sources of `open` with its options.

    tolerance: by how much periods may differ, as a part of the shorter one. buses: names of buses that are one bus, in
    `a` and in `b`; others are matched by name, else by their nodes. ValueError for a bus that is not there.
    """
    from canalyze._core import Comparison

    if isinstance(tolerance, bool) or not isinstance(tolerance, int | float) or not 0 <= tolerance <= 10:
        raise ValueError(f"tolerance={tolerance!r}: a number from 0 to 10")
    pairs = [tuple(pair) for pair in buses]
    if not all(len(pair) == 2 and all(isinstance(one, str) for one in pair) for pair in pairs):
        raise ValueError(f"buses={pairs!r}: pairs of names are needed")
    both = [_capture(one, options) for one in (a, b)]
    sessions = [one.through("digest")[0] for one in both]
    lang = both[0].lang
    names = (both[0].name, both[1].name)
    found = Comparison(*sessions, names=names, lang=lang, tolerance=tolerance, buses=[(x, y) for x, y in pairs])
    for pair in pairs:
        for name, there in zip(pair, found.buses, strict=True):
            one_of("buses", name, there)
    text = (found.head() + found.body()).decode("utf-8", "replace")
    return Diff(text, [json.loads(line) for line in found.jsonl().splitlines()], found.differences)


def summary(source: "Source | Capture", **options: Unpack[Options]) -> Summary:
    """Returns a capture in figures; a capture of `open`, or a source of `open` with its options."""
    from canalyze.reports.summary import show
    from canalyze.words import Words

    capture = _capture(source, options)
    result = capture.through("summary")[1]
    text = Kept()
    show(result, text, Words(capture.lang))
    return Summary([json.loads(line) for line in result.splitlines()], str(text))


def diagnose(source: "Source | Capture", **options: Unpack[Options]) -> Diagnosis:
    """Diagnoses a capture of `open`, or a source of `open` with its options; several files are one capture.

    `capture.html()` is the same as a page.
    """
    from canalyze.reports.diagnosis import Chosen, of_buses, show
    from canalyze.words import Words

    capture = _capture(source, options)
    found, whole = capture.diagnosed
    text = Kept()
    names = [capture.name] if len(capture.paths) == 1 else []
    everything = Chosen(None, None, None)
    show(of_buses(found), whole, text, Words(capture.lang), names, everything=False, chosen=everything)
    return Diagnosis(capture.problems, str(text))


def explain(
    what: "str | int | Frame | Message",
    *,
    eds: Descriptions = (),
    lang: Literal["en", "zh"] = "en",
    folder: StrPath | None = None,
) -> str:
    """Explains a frame field by field, a code, an object or a term, as `canalyze explain` does.

    what: a text as on the command line ("705#7F", "1017:00", "SDO001", "inhibit time"), a frame of a capture, a message
    of python-can, or an integer: from 10000h on an SDO abort code, below that the same as its text with an h behind it.
    eds, lang, folder: as for `open`. ValueError for what cannot be explained.
    """
    from canalyze._core import explain as explained
    from canalyze.library.plan import plan

    made = plan("explain", Options(eds=eds, lang=lang, folder=folder))
    text = _explained(what)
    found = explained(text, made.words.lang, made.options.network)
    if found is None:
        raise ValueError(made.words("explain.no_frame", line=text or '""'))
    return found.rstrip("\n")


def _explained(what: Any) -> str:
    """Returns the question as the command line has it."""
    if isinstance(what, str):
        return what
    if isinstance(what, int) and not isinstance(what, bool):
        return f"{what:08X}" if what > 0xFFFF else f"{what:X}h"
    if isinstance(what, Frame):
        number, data, flags = what.id, what.data, 1 * what.brs + 2 * what.esi
        extended, remote, fd, length = what.extended, what.remote, what.fd, what.length
    elif hasattr(what, "arbitration_id"):
        number, data, flags = (
            what.arbitration_id,
            bytes(what.data),
            1 * what.bitrate_switch + 2 * what.error_state_indicator,
        )
        extended, remote, fd, length = what.is_extended_id, what.is_remote_frame, what.is_fd, what.dlc
    else:
        raise TypeError(f"what={what!r}: a text, a number, a frame or a message is needed, not {type(what).__name__}")
    name = f"{number:08X}" if extended else f"{number:03X}"
    shown = f"R{length or ''}" if remote else data.hex().upper()
    return f"{name}##{flags:X}{shown}" if fd else f"{name}#{shown}"


def od(source: "Source | Capture", *, at: float | None = None, **options: Unpack[Options]) -> Inventory:
    """Returns the objects of the devices in a capture, as far as the traffic shows them.

    source, options: as for `diagnose`. at: the values so many seconds from its begin; those at its end otherwise.
    """
    from canalyze.reports.od import show
    from canalyze.words import Words

    if at is not None and (isinstance(at, bool) or not isinstance(at, int | float) or not 0 <= at < 1e12):
        raise ValueError(f"at={at!r}: seconds, 0 or more")
    capture = _capture(source, options)
    until_ns = None if at is None else round(at * 1e9)
    objects, shown = (capture.through(form, until_ns=until_ns)[1] for form in ("objects", "objects-text"))
    text = Kept()
    show(shown, text, Words(capture.lang))
    return Inventory(map(json.loads, objects.splitlines()), str(text))


def convert(
    source: "Source | Capture", out: StrPath, *, to: str | None = None, force: bool = False, **options: Unpack[Options]
) -> tuple[str, ...]:
    """Writes a capture in another format, by the name of the file or `to`; returns the losses, in words.

    The file is there only when it is complete. force: one that is there is replaced. OutputError for what cannot be
    written, ValueError for a format that there is none of.
    """
    import os

    from canalyze.errors import OutputError
    from canalyze.sinks import forms, open_target, target

    if not isinstance(out, str | os.PathLike):
        raise TypeError(f"out={out!r}: the name of a file is needed, not {type(out).__name__}")
    one_of("to", to, forms())
    capture = _capture(source, options)
    path = capture.folder / os.fspath(out)
    where = target(str(path), to)
    if where is None or (where.compression and where.written == "packed"):
        raise ValueError(f"out={os.fspath(out)!r}: its name does not say a format; to= one of {', '.join(forms())}")
    if any(path.exists() and one.samefile(path) for one in capture.paths):
        raise OutputError("convert.itself", name=str(path))
    output, losses = open_target(where, force=force)
    with output:
        session, _ = capture.through("convert", output.write, to=where.written)
    return tuple(session.losses(str(Path(out).name), dict(losses)))


def rules(lang: Literal["en", "zh"] = "en") -> "tuple[Rule, ...]":
    """Returns every rule: code, name, severity, clause of the standard, and in words message, meaning and cause."""
    from canalyze import _core

    one_of("lang", lang, ("en", "zh"))
    return tuple(_core.rules(lang))


def _capture(source: Any, options: Options) -> Capture:
    if isinstance(source, Capture):
        if options:
            raise TypeError(f"{', '.join(options)}: a capture that is open has its own options")
        return source
    return open_(source, **options)
