"""The table of SDO transfers: its columns, the cells of a transfer; and below it the files that transfers have moved.

A file is a line, with what it is, its size and its check sums. What a transfer is, the core says.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from canalyze.output import Output
from canalyze.records import records
from canalyze.records.objects import Transfer
from canalyze.reports import table
from canalyze.reports.table import EMPTY, SPARE, Column, Row, Table
from canalyze.words import Words

RIGHT: Final = frozenset({"number", "time", "node", "size", "duration", "frames"})
FOLDING: Final = frozenset({"value", "outcome", "findings"})
LEAVING: Final = (
    *(("bus", 1), ("name", 2), ("frames", 3), ("size", 4), ("time", 5)),
    *(("mode", SPARE), ("number", SPARE + 1), ("duration", SPARE + 3), ("direction", SPARE + 4)),
    *(("node", SPARE + 5), ("findings", SPARE + 6)),
)
"""In which order columns leave a terminal that is too narrow; time and direction become shorter first."""
_COLOURS: Final = {"aborted": "error", "failed": "error", "incomplete": "warning"}
"""Of outcomes."""
COLUMNS: Final = (
    *("number", "time", "bus", "node", "direction", "object", "name", "value", "size", "mode", "duration"),
    *("outcome", "findings", "frames"),
)


class Transfers:
    """Transfers as rows of a table, as they come."""

    def __init__(self, words: Words, out: Output, *, live: bool, moments: bool, since_start: bool) -> None:
        """Begins the table. live: rows are shown as they come. moments, since_start: as of `columns`."""
        self._words = words
        self._table = Table(columns(words, moments=moments, since_start=since_start), out, live=live)
        self.close = self._table.close

    def put(self, result: bytes) -> None:
        """Adds JSON lines of the core."""
        self._table.add([row(one, self._words) for one in records(result, Transfer)])


def list_files(files: list[dict[str, Any]], out: Output, words: Words, *, as_json: bool) -> None:
    """Lists the files that were taken out."""
    if as_json:
        out.write("".join(json.dumps(file) + "\n" for file in files).encode())
    elif files:
        out.text("\n")
        show_files(files, out, words)


def columns(words: Words, *, moments: bool = True, since_start: bool = False) -> list[Column]:
    """Returns the columns of the table.

    moments: times are not asked for: they may become shorter, and leave. since_start: they are short already.
    """
    made = dict(
        zip(COLUMNS, table.columns(words, COLUMNS, right=RIGHT, folds=FOLDING, leaves=dict(LEAVING)), strict=True)
    )
    for key in ("bus", "node"):
        made[key] = made[key]._replace(if_alike=True)
    if moments and since_start:
        made["time"] = made["time"]._replace(leaves=SPARE + 2)
    elif moments:
        made["time"] = made["time"]._replace(
            short_heading=words("col.relative"), shorten=_relative, short_leaves=SPARE + 2
        )
    else:
        made["time"] = made["time"]._replace(leaves=0)
    ill = {words(f"status.{status}"): colour for status, colour in _COLOURS.items()}
    made["outcome"] = made["outcome"]._replace(
        colour=lambda cell: next((colour for said, colour in ill.items() if cell.startswith(said)), "")
    )
    briefly = {words(f"direction.{value}"): words(f"access.{value}") for value in ("upload", "download")}
    made["direction"] = made["direction"]._replace(
        short_heading=words("col.read_write"), shorten=lambda _: lambda cell: briefly.get(cell, cell)
    )
    return list(made.values())


def row(one: Transfer, words: Words) -> Row:
    """Returns the cells of one transfer, and its first frame as its order."""
    cells = [
        str(one.number),
        one.t,
        one.bus,
        # The server; of a USDO transfer with its client before and its session behind.
        str(one.node) if one.client is None else f"{one.client} -> {one.node} ({one.session})",
        words.of("direction", one.direction),
        one.object,
        one.name,
        one.text,
        str(one.size),
        words.of("mode", one.mode),
        None if one.duration is None else f"{one.duration * 1000:.3f} ms",
        _outcome(one, words),
        " ".join(one.findings),
        str(one.first_frame) if one.first_frame == one.last_frame else f"{one.first_frame}-{one.last_frame}",
    ]
    return Row([cell or EMPTY for cell in cells], one.first_frame)


def _relative(times: list[str]) -> Callable[[str], str]:
    """Returns the function that writes a time relative to the first one: in seconds, with all its digits."""
    from decimal import Decimal, InvalidOperation

    first = next((Decimal(time) for time in times if time != EMPTY), Decimal(0))

    def write(time: str) -> str:
        try:
            return f"{Decimal(time) - first:f}"
        except InvalidOperation:
            return time

    return write


def _outcome(one: Transfer, words: Words) -> str:
    said, abort = words.of("status", one.status), one.abort
    if abort is None:
        return said
    return " ".join(filter(None, (said, f"({words.of('by', abort.by)})", f"{abort.digits}h", abort.text)))


_FILE: Final = ("file", "size", "contents", "crc", "software", "outcome")


def show_files(files: Sequence[Mapping[str, Any]], out: Output, words: Words) -> None:
    """Writes them."""
    names = {key: words(f"col.{key}" if key in ("size", "outcome") else f"contents.{key}") for key in _FILE}
    rows = [_file(file, words) for file in files]
    kept = [place for place, _ in enumerate(_FILE) if any(row[place] for row in rows)]
    columns = [Column(names[_FILE[place]], folds=_FILE[place] == "contents") for place in kept]
    table.write(columns, ([row[place] or EMPTY for place in kept] for row in rows), out)


def _file(file: Mapping[str, Any], words: Words) -> list[str]:
    found, damage = file["contents"], file["damage"]
    said = words(f"contents.{found['kind']}", **found) if found else ""
    if damage:
        said += "; " + words("contents_damage.damaged", problem=words(f"contents_damage.{damage['kind']}", **damage))
    size = str(file["size"])
    if file["size_indicated"] not in (None, file["size"]):
        size = words("contents.of", size=size, indicated=file["size_indicated"])
    crc = "" if file["crc"] is None else file["crc"] + "h" + ("" if file["crc_ok"] else f" {words('contents.wrong')}")
    software = "" if file["software"] is None else f"{file['software']:08X}h"
    return [file["file"], size, said, crc, software, words.of("status", file["status"])]
