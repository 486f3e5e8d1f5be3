"""The table of SDO transfers: its columns, the cells of a transfer, and files that were taken out below it.

What a transfer is, the core says.
"""

import json
from collections.abc import Callable
from typing import Any, Final

from canalyze.output import Output
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
        self._table.add([row(json.loads(line), self._words) for line in result.splitlines()])


def list_files(files: list[dict[str, Any]], out: Output, words: Words, *, as_json: bool) -> None:
    """Lists the files that were taken out."""
    if as_json:
        out.write("".join(json.dumps(file) + "\n" for file in files).encode())
    elif files:
        from canalyze.reports.file_table import show

        out.text("\n")
        show(files, out, words)


def columns(words: Words, *, moments: bool = True, since_start: bool = False) -> list[Column]:
    """Returns the columns of the table.

    moments: times are not asked for: they may become shorter, and leave. since_start: they are short already.
    """
    leaving = dict(LEAVING)
    made = {
        key: Column(words(f"col.{key}"), right=key in RIGHT, folds=key in FOLDING, leaves=leaving.get(key, 0))
        for key in COLUMNS
    }
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


def row(transfer: dict[str, Any], words: Words) -> Row:
    """Returns the cells of one transfer, and its first frame as its order."""
    cells = [
        _cell(transfer.get("transfer")),
        _cell(transfer.get("t")),
        _cell(transfer.get("bus")),
        _node(transfer),
        words.of("direction", _cell(transfer.get("direction"))),
        _object(transfer),
        _cell(transfer.get("name")),
        _cell(transfer.get("value") if transfer.get("text") is None else transfer["text"]),
        _cell(transfer.get("size")),
        words.of("mode", _cell(transfer.get("mode"))),
        _duration(transfer.get("duration")),
        _outcome(transfer, words),
        " ".join(transfer.get("findings") or ()),
        _frames(transfer),
    ]
    return Row([cell or EMPTY for cell in cells], int(transfer.get("first_frame") or 0))


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


def _cell(value: object) -> str:
    return "" if value is None else str(value)


def _node(transfer: dict[str, Any]) -> str:
    """Returns the server; for a USDO transfer with its client before and its session behind."""
    node, client = _cell(transfer.get("node")), transfer.get("client")
    return node if client is None else f"{client} -> {node} ({transfer.get('session')})"


def _object(transfer: dict[str, Any]) -> str:
    index, sub = transfer.get("index"), transfer.get("sub")
    if index is None:
        return ""
    return f"{index}h" if sub is None else f"{index}h:{int(sub):02X}"


def _duration(seconds: object) -> str:
    try:
        return "" if seconds is None else f"{float(str(seconds)) * 1000:.3f} ms"
    except ValueError:
        return str(seconds)


def _outcome(transfer: dict[str, Any], words: Words) -> str:
    said = words.of("status", _cell(transfer.get("status")))
    abort = transfer.get("abort")
    if not abort:
        return said
    by = words.of("by", _cell(abort.get("by")))
    code = f"{abort['code']}h" if abort.get("code") is not None else ""
    return " ".join(part for part in (said, by and f"({by})", code, _cell(abort.get("text"))) if part)


def _frames(transfer: dict[str, Any]) -> str:
    first, last = _cell(transfer.get("first_frame")), _cell(transfer.get("last_frame"))
    return first if first == last or not last else f"{first}-{last}"
