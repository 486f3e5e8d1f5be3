"""A table for people: rich on a terminal, aligned plain columns in a pipe or a file.

Columns are as wide as their cells, Chinese counted double. Rows of a file are gathered before the widths are set, up to
a bound; rows of a live source are written when they come, and widths then only grow. No cell's meaning is
known here.
"""

from collections.abc import Sequence
from typing import Final, Literal, NamedTuple

from canalyze.help import pad, width
from canalyze.output import Output, printable

_GATHERED: Final = 2000
"""Rows kept before the widths are set."""
_WIDEST: Final = 60
"""Columns of a cell in plain text; the machine format carries the whole."""
_FOLDED: Final = 16
"""Columns that a folding cell keeps on a narrow terminal."""


class Column(NamedTuple):
    """A column of a table."""

    heading: str
    right: bool = False
    """Stands to the right, as numbers do."""
    folds: bool = False
    """May be folded where the terminal is too narrow; all others stay on one line."""


class Table:
    """Rows on their way to an output."""

    def __init__(self, columns: Sequence[Column], out: Output, *, live: bool) -> None:
        """Take the columns. `live`: rows may not wait for others."""
        self._columns = columns
        self._out = out
        self._live = live
        self._rows: list[list[str]] = []
        self._widths: list[int] = []

    def add(self, rows: list[list[str]]) -> None:
        """Add rows; they are written at once if they may not wait."""
        self._rows += ([printable(cell) for cell in row] for row in rows)
        if self._live or self._widths or len(self._rows) > _GATHERED:
            self._write()

    def close(self) -> None:
        """Write what was gathered."""
        if self._rows and self._out.is_terminal and not self._widths:
            self._show()
        else:
            self._write()

    def _write(self) -> None:
        rows = [[_cut(cell) for cell in row] for row in self._rows]
        if not rows:
            return
        self._rows = []
        if not self._widths:
            headings = [column.heading for column in self._columns]
            self._widths = [width(heading) for heading in headings]
            rows.insert(0, headings)
        for row in rows:
            self._widths = [max(have, width(cell)) for have, cell in zip(self._widths, row, strict=True)]
        self._out.text("".join(self._line(row) + "\n" for row in rows))

    def _line(self, row: list[str]) -> str:
        cells = zip(row, self._widths, self._columns, strict=True)
        return "  ".join(pad(cell, size, right=column.right) for cell, size, column in cells).rstrip()

    def _show(self) -> None:
        """Lay the table out for the width of the terminal."""
        import io
        import shutil

        from rich.console import Console
        from rich.table import Table as Grid
        from rich.text import Text

        grid = Grid(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
        least = 0
        for place, column in enumerate(self._columns):
            justify: Literal["left", "right"] = "right" if column.right else "left"
            grid.add_column(Text(column.heading), justify=justify, overflow="fold", no_wrap=not column.folds)
            widest = max(width(column.heading), *(width(row[place]) for row in self._rows))
            least += 2 + (min(widest, _FOLDED) if column.folds else widest)
        for row in self._rows:
            grid.add_row(*map(Text, row))
        page = io.StringIO()
        # A terminal too narrow even so wraps the lines itself: nothing is cut off.
        columns = max(shutil.get_terminal_size().columns, least)
        Console(file=page, force_terminal=True, width=columns, highlight=False, legacy_windows=False).print(grid)
        self._out.text(page.getvalue())
        self._rows = []


def _cut(cell: str) -> str:
    """Shorten a cell to what a line can bear."""
    if width(cell) <= _WIDEST:
        return cell
    kept = ""
    room = _WIDEST - 1
    for char in cell:
        room -= width(char)
        if room < 0:
            break
        kept += char
    return kept + "…"
