"""A table for people: laid out for the width of a terminal, aligned plain columns in a pipe or a file.

Nothing is ever cut. Columns are as wide as their cells, Chinese counted double. Rows of a file are gathered, put in
their order and measured, up to a bound; rows of a live source are written when they come. No cell's meaning is known
here: what may go from a narrow terminal, and when, the columns say.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Final, NamedTuple

from canalyze.output import Output, dyed, printable
from canalyze.output.layout import folded, pad, width
from canalyze.words import Words

EMPTY: Final = "-"
"""A cell without anything in it."""

_GATHERED: Final = 2000
"""Rows kept before the layout is settled."""
_WIDEST: Final = 80
"""Columns up to which plain text is aligned; a longer cell pushes the rest of its line."""
_GAP: Final = "  "
_LINES: Final = 3
"""Lines that a folded cell may take before more columns leave."""
_LEAST: Final = 8
"""Columns of a folded cell at least."""
_LIVE: Final = 24
"""Columns of a folded cell where the longest is not known yet."""
_MEASURED: Final = 40
"""Cells, the longest of a column, by which its folded width is found."""

SPARE: Final = 10
"""From this `leaves` on a column leaves only where folded cells would take more than a few lines otherwise."""


class Column(NamedTuple):
    """A column of a table."""

    heading: str
    right: bool = False
    """Aligned to the right, as numbers are."""
    folds: bool = False
    """May be folded where the terminal is too narrow, after columns have left; all others stay on one line."""
    leaves: int = 0
    """Its turn to leave where the terminal is too narrow, the lowest first; 0 stays."""
    if_alike: bool = False
    """It leaves only when all its cells are alike."""
    short_heading: str = ""
    shorten: Callable[[list[str]], Callable[[str], str]] | None = None
    """Instead of leaving at its turn it becomes shorter: from the cells in order, how a cell is then written."""
    short_leaves: int = 0
    """The turn of the shortened column to leave after all."""
    colour: Callable[[str], str] | None = None
    """From a cell, the colour of it in the core's table; "" for none."""


class Row(NamedTuple):
    """A row of a table."""

    cells: list[str]
    order: int = 0
    """Gathered rows are sorted by this."""


class _Shown(NamedTuple):
    """A column as it is laid out on a terminal."""

    place: int
    """The number of its cell in a row."""
    column: Column
    write: Callable[[str], str] | None = None


class Table:
    """Rows on their way to an output."""

    def __init__(self, columns: Sequence[Column], out: Output, *, live: bool) -> None:
        """Begins a table with these columns. `live`: rows may not wait for others."""
        self._columns = columns
        self._out = out
        self._live = live
        self._rows: list[Row] = []
        self._shown: list[_Shown] = []
        self._widths: list[int] = []

    def add(self, rows: list[Row]) -> None:
        """Adds rows; they are written at once if they may not wait."""
        self._rows += (Row([printable(cell) for cell in row.cells], row.order) for row in rows)
        if self._live or self._widths or len(self._rows) > _GATHERED:
            self._write()

    def close(self) -> None:
        """Writes the gathered rows."""
        self._write()

    def _write(self) -> None:
        if not self._rows:
            return
        rows = [row.cells for row in sorted(self._rows, key=lambda row: row.order)]
        self._rows = []
        if not self._widths:
            self._settle(rows)
            heading = self._line([shown.column.heading for shown in self._shown])
            self._out.text(dyed(heading, "own", out=self._out) + "\n")
        for start in range(0, len(rows), _GATHERED):
            some = rows[start : start + _GATHERED]
            self._out.text("".join(self._laid_out([_written(shown, row) for shown in self._shown]) for row in some))

    def _settle(self, rows: list[list[str]]) -> None:
        """Decides which columns are shown, and how wide."""
        shown = [_Shown(place, column) for place, column in enumerate(self._columns)]
        if self._out.is_terminal:
            import shutil

            room = shutil.get_terminal_size().columns
            self._shown, self._widths = _fitted(shown, rows, room, live=self._live)
        else:
            self._shown = shown
            self._widths = [min(size, _WIDEST) for size in _measured(shown, rows, live=False)]

    def _laid_out(self, cells: list[str]) -> str:
        """Returns the line of a row, or its lines where a cell is folded."""
        fold = self._out.is_terminal
        colours = [
            shown.column.colour(cell) if shown.column.colour else ""
            for cell, shown in zip(cells, self._shown, strict=True)
        ]
        parts = []
        for place, (cell, shown) in enumerate(zip(cells, self._shown, strict=True)):
            if fold and shown.column.folds:
                parts.append(folded(cell, self._widths[place]))
            else:
                parts.append([cell])
                if fold or width(cell) <= _WIDEST:  # later rows may be wider than those that were measured
                    self._widths[place] = max(self._widths[place], width(cell))
        height = max(map(len, parts))
        lines = zip(*(part + [""] * (height - len(part)) for part in parts), strict=True)
        return "".join(self._line(line, colours) + "\n" for line in lines)

    def _line(self, cells: Sequence[str], colours: Sequence[str] = ()) -> str:
        filled = zip(cells, self._widths, self._shown, strict=True)
        padded = [pad(cell, size, right=shown.column.right) for cell, size, shown in filled]
        if self._out.coloured and any(colours):
            dye = zip(padded, colours, strict=True)
            padded = [dyed(cell, colour, out=self._out) if colour else cell for cell, colour in dye]
        return _GAP.join(padded).rstrip()


def columns(
    words: Words,
    keys: Sequence[str],
    *,
    of: str = "col",
    right: Collection[str] = (),
    folds: Collection[str] = (),
    leaves: Mapping[str, int] = MappingProxyType({}),
) -> list[Column]:
    """Returns a column for each key, headed by the words `of.KEY`; leaves: the turn of some to leave."""
    return [
        Column(words(f"{of}.{key}"), right=key in right, folds=key in folds, leaves=leaves.get(key, 0)) for key in keys
    ]


def write(columns: Sequence[Column], rows: Iterable[Iterable[str]], out: Output) -> None:
    """Writes a whole table, its rows in their order."""
    table = Table(columns, out, live=False)
    table.add([Row(list(cells)) for cells in rows])
    table.close()


def _written(shown: _Shown, row: list[str]) -> str:
    cell = row[shown.place]
    return shown.write(cell) if shown.write else cell


def _cells(shown: _Shown, rows: list[list[str]]) -> list[str]:
    return [_written(shown, row) for row in rows]


def _measured(columns: list[_Shown], rows: list[list[str]], *, live: bool) -> list[int]:
    """Returns the width of each column when nothing is folded."""
    widths = [max(width(shown.column.heading), *map(width, _cells(shown, rows))) for shown in columns]
    if live:  # longer cells are still to come
        widths = [max(size, _LIVE * shown.column.folds) for size, shown in zip(widths, columns, strict=True)]
    return widths


def _total(widths: list[int]) -> int:
    return sum(widths) + len(_GAP) * (len(widths) - 1)


def _fitted(columns: list[_Shown], rows: list[list[str]], room: int, *, live: bool) -> tuple[list[_Shown], list[int]]:
    """Drops columns until the rest fits, at last with folded cells; returns the rest and its widths."""
    widths = _measured(columns, rows, live=live)
    if _total(widths) > room and not live:
        columns = [shown for shown in columns if set(_cells(shown, rows)) - {EMPTY, ""}] or columns
        widths = _measured(columns, rows, live=live)
    while _total(widths) > room:
        leaving = [shown for shown in columns if shown.column.leaves and _may_leave(shown, rows, live=live)]
        if not leaving or min(shown.column.leaves for shown in leaving) >= SPARE:
            folded, lines = _folds(columns, widths, rows, room)
            if lines <= _LINES or not leaving:
                return columns, folded
        first = min(leaving, key=lambda shown: shown.column.leaves)
        place = columns.index(first)
        columns = columns[:place] + _after_its_turn(first, rows) + columns[place + 1 :]
        widths = _measured(columns, rows, live=live)
    return columns, widths


def _may_leave(shown: _Shown, rows: list[list[str]], *, live: bool) -> bool:
    return not shown.column.if_alike or (not live and len(set(_cells(shown, rows))) == 1)


def _after_its_turn(shown: _Shown, rows: list[list[str]]) -> list[_Shown]:
    """Returns a column after its turn to leave: nothing, or its shorter form if that is shorter."""
    column = shown.column
    if column.shorten is None:
        return []
    cells = _cells(shown, rows)
    write = column.shorten(cells)
    later = column._replace(leaves=column.short_leaves, shorten=None)
    if max(map(width, map(write, cells))) >= max(map(width, cells)):
        return [shown._replace(column=later)]
    return [_Shown(shown.place, later._replace(heading=column.short_heading), write)]


def _folds(columns: list[_Shown], widths: list[int], rows: list[list[str]], room: int) -> tuple[list[int], int]:
    """Shares the remaining room among columns that fold; returns all widths and the lines of the highest cell.

    Every folding column gets as little as it needs for the same number of lines, the first ones what is over.
    """
    places = [place for place, shown in enumerate(columns) if shown.column.folds]
    if not places:
        return widths, 1
    cells = {place: sorted(set(_cells(columns[place], rows)), key=width)[-_MEASURED:] for place in places}
    least = {place: max(_LEAST, width(columns[place].column.heading)) for place in places}
    room -= _total(widths) - sum(widths[place] for place in places)
    widest = max(widths[place] for place in places)
    lines = 1
    needed = {place: widths[place] for place in places}
    while sum(needed.values()) > room and lines <= widest // _LEAST + 1:
        lines += 1
        needed = {
            place: _narrowest(cells[place], lines, min(least[place], widths[place]), widths[place]) for place in places
        }
    over = max(0, room - sum(needed.values()))
    for place in places:
        more = min(over, widths[place] - needed[place])
        needed[place] += more
        over -= more
    return [needed.get(place, size) for place, size in enumerate(widths)], lines


def _narrowest(cells: list[str], lines: int, least: int, widest: int) -> int:
    """Finds how narrow a column may be for its cells to take that many lines."""
    while least < widest:
        middle = (least + widest) // 2
        if max(len(folded(cell, middle)) for cell in cells) <= lines:
            widest = middle
        else:
            least = middle + 1
    return widest
