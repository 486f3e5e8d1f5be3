"""A table for people: rich on a terminal, aligned plain columns in a pipe or a file.

Columns are as wide as their cells, Chinese counted double. Rows of a file are gathered before the widths are set, up to
a bound; rows of a live source are written when they come, and widths then only grow. No cell's meaning is
known here.
"""

from collections.abc import Sequence
from typing import Final

from canalyze.help import pad, width
from canalyze.output import Output, printable

_GATHERED: Final = 2000
"""Rows kept before the widths are set."""
_WIDEST: Final = 60
"""Columns of a cell in plain text; the machine format carries the whole."""


class Table:
    """Rows on their way to an output."""

    def __init__(self, headings: Sequence[tuple[str, bool]], out: Output, *, live: bool) -> None:
        """Take headings and whether a column stands to the right. `live`: rows may not wait for others."""
        self._headings = [heading for heading, _ in headings]
        self._right = [right for _, right in headings]
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
            self._widths = [width(heading) for heading in self._headings]
            rows.insert(0, self._headings)
        for row in rows:
            self._widths = [max(have, width(cell)) for have, cell in zip(self._widths, row, strict=True)]
        self._out.text("".join(self._line(row) + "\n" for row in rows))

    def _line(self, row: list[str]) -> str:
        cells = zip(row, self._widths, self._right, strict=True)
        return "  ".join(pad(cell, columns, right=right) for cell, columns, right in cells).rstrip()

    def _show(self) -> None:
        """Lay the table out for the width of the terminal."""
        import io
        import shutil

        from rich.console import Console
        from rich.table import Table as Grid
        from rich.text import Text

        grid = Grid(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
        for heading, right in zip(self._headings, self._right, strict=True):
            grid.add_column(Text(heading), justify="right" if right else "left", overflow="fold")
        for row in self._rows:
            grid.add_row(*map(Text, row))
        page = io.StringIO()
        columns = shutil.get_terminal_size().columns
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
