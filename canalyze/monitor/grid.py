"""A table whose cells are updated in place: only changed ones are drawn again.

Columns adapt to the available width: they shrink, and the least important ones are hidden. Widths are measured in
columns of the terminal, of which a Chinese character takes two. Everything is drawn as text: no markup, and
characters that could control a terminal are escaped. Times, rates, sizes and bars take few columns. Must not: know the
subject of the rows.
"""

from collections.abc import Iterable, Sequence
from typing import Any, Final, NamedTuple

from rich.cells import cell_len, set_cell_size
from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.geometry import Region
from textual.message import Message
from textual.strip import Strip
from textual.widget import Widget

from canalyze.output import printable

BLANK: Final = "-"
"""Shown for an unknown value."""
_NS: Final = 1_000_000_000
_PARTS: Final = " ▏▎▍▌▋▊▉"


def period(ns: int | None) -> str:
    """Returns a time of up to some minutes with its unit, in at most seven columns."""
    if ns is None:
        return BLANK
    if ns <= 0:
        return "0"
    for limit, step, unit in ((1_000, 1, "ns"), (1_000_000, 1_000, "µs"), (_NS, 1_000_000, "ms")):
        if ns < limit:
            return f"{_three(ns / step)}{unit}"
    return f"{_three(ns / _NS)}s" if ns < 1000 * _NS else clock(ns)


def _three(value: float) -> str:
    """Returns about three digits, so that a value that hardly changes does not flicker."""
    return f"{value:.2f}" if value < 9.995 else f"{value:.1f}" if value < 99.95 else f"{value:.0f}"


def seconds(ns: int | None, digits: int = 1) -> str:
    """Returns a time in seconds without its unit."""
    return BLANK if ns is None else f"{ns / _NS:.{digits}f}"


def clock(ns: int | None) -> str:
    """Returns a time of any length as 1:02:03."""
    if ns is None:
        return BLANK
    whole = max(0, ns) // _NS
    return f"{whole // 3600}:{whole // 60 % 60:02}:{whole % 60:02}"


def rate(value: float | None) -> str:
    """Returns a rate, with one decimal if it is small."""
    if value is None:
        return BLANK
    return f"{value:.1f}" if 0 < value < 99.95 else f"{value:.0f}"


def size(octets: int | None) -> str:
    """Returns a number of bytes."""
    if octets is None:
        return BLANK
    if octets < 10_000:
        return str(octets)
    for step, unit in ((1 << 10, "Ki"), (1 << 20, "Mi"), (1 << 30, "Gi")):
        if octets < step * 1000 or unit == "Gi":
            return f"{_three(octets / step)}{unit}"
    return str(octets)


def bar(part: float, columns: int) -> str:
    """Returns a bar for a ratio of 0 to 1, in eighths of a column."""
    eighths = round(max(0.0, min(part, 1.0)) * columns * 8)
    full, rest = divmod(eighths, 8)
    return ("█" * full + (_PARTS[rest] if rest else "")).ljust(columns, "░")


STYLES: Final = {
    name: Style.parse(style)
    for name, style in {
        "": "",
        "dim": "dim",
        "strong": "bold",
        "good": "green",
        "info": "cyan",
        "warning": "bold yellow",
        "error": "bold red",
        "changed": "bold yellow",
        "found": "black on yellow underline",
        "heading": "bold underline",
        "focused": "bold reverse",
        "cursor": "reverse",
        "live": "bold green reverse",
        "halted": "bold yellow reverse",
        "lost": "bold red reverse",
        "over": "bold reverse",
        "key": "bold cyan",
        "here": "bold reverse",
    }.items()
}
"""Styles by their meaning.

They use the terminal's own colours, so that a light theme stays light; without colours, bold remains.
"""

Piece = tuple[str, str]
"""A text and its style."""
Cell = tuple[Piece, ...]
NOTHING: Final[Cell] = ()


def cell(text: object, look: str = "") -> Cell:
    """Returns a cell of one style."""
    return ((str(text), look),) if text not in ("", None) else NOTHING


class Column(NamedTuple):
    """The heading and the widths of a column."""

    heading: str
    least: int = 0
    """The width to which it may shrink; 0: it does not."""
    most: int = 40
    """Maximum width, unless it is the last column."""
    right: bool = False
    leaves: int = 0
    """The higher, the sooner it is hidden if the width does not suffice; 0: never."""


class Row(NamedTuple):
    """The content of a line."""

    key: Any
    """Hashable: the subject of the row, the same in the next snapshot."""
    cells: tuple[Cell, ...]
    whole: str = ""
    """The row in full, for the lines below the views."""
    look: str = ""
    leads: int | str | None = None
    """The frame to which it leads, or the filter for its frames."""
    about: tuple[str, ...] = ()
    """The kind of its page and the arguments of that; empty without a page."""


def leads(bus: str, **conditions: object) -> str:
    """Returns a filter of these conditions, including the bus if its name is valid in a filter."""
    found = [f"{name}={value}" for name, value in conditions.items() if value is not None]
    if bus and bus.replace("-", "").replace("_", "").replace(".", "").isalnum():
        found.append(f"bus={bus}")
    return " ".join(found)


def fit(columns: Sequence[Column], natural: Sequence[int], room: int) -> list[tuple[int, int]]:
    """Returns the visible columns with their widths: pairs of number and width."""
    kept = list(range(len(columns)))

    def needed(number: int) -> int:
        column, wish = columns[number], min(natural[number], columns[number].most)
        return min(column.least or wish, wish)

    while sum(needed(number) + 1 for number in kept) - 1 > room:
        leaving = max(kept, key=lambda number: columns[number].leaves)
        if not columns[leaving].leaves:
            break
        kept.remove(leaving)
    widths = {number: needed(number) for number in kept}
    spare = room - sum(width + 1 for width in widths.values()) + 1
    for number in kept:
        more = max(0, min(spare, min(natural[number], columns[number].most) - widths[number]))
        widths[number] += more
        spare -= more
    if kept and spare > 0:
        widths[kept[-1]] += spare
    return [(number, widths[number]) for number in kept]


def draw(content: Cell, columns: int, look: Style, *, right: bool = False) -> list[Segment]:
    """Returns a cell in exactly `columns` columns; a longer text is cut and ends in an ellipsis."""
    if len(content) == 1 and content[0][0].isascii():
        text, name = content[0]
        text = printable(text)
        if len(text) <= columns:
            text = text.rjust(columns) if right else text.ljust(columns)
        else:
            text = text[: columns - 1] + "…" if columns else ""
        return [Segment(text, look + STYLES[name])]
    pieces = [(printable(text), name) for text, name in content]
    taken = sum(cell_len(text) for text, _ in pieces)
    if taken <= columns:
        blank = Segment(" " * (columns - taken), look)
        drawn = [Segment(text, look + STYLES[name]) for text, name in pieces]
        return [blank, *drawn] if right else [*drawn, blank]
    drawn, left = [], columns - 1
    for text, name in pieces:
        wide = cell_len(text)
        if wide > left:
            drawn.append(Segment(set_cell_size(text, max(left, 0)) + "…" * (columns > 0), look + STYLES[name]))
            break
        drawn.append(Segment(text, look + STYLES[name]))
        left -= wide
    return drawn


def line(content: Cell, columns: int) -> Strip:
    """Returns a whole line of one cell."""
    return Strip(draw(content, columns, STYLES[""]), columns)


def widest(content: Cell) -> int:
    """Returns the width of a cell in columns."""
    return sum(cell_len(text) for text, _ in content)


class Grid(Widget, can_focus=True):
    """Rows below a line of headings, with an optional cursor."""

    DEFAULT_CSS = "Grid { height: 1fr; width: 1fr; }"
    ALLOW_SELECT = False

    class Picked(Message):
        """The user has asked for the details of a row."""

        def __init__(self, grid: "Grid", row: Row) -> None:
            """Creates the message for a row."""
            super().__init__()
            self.grid = grid
            self.row = row

    class Moved(Message):
        """The cursor has moved."""

    def __init__(self, name: str) -> None:
        """Creates an empty table; `name` is its id."""
        super().__init__(id=name)
        self.columns: Sequence[Column] = ()
        self.rows: Sequence[Row] = ()
        self.top = 0
        """The row that is drawn first."""
        self.cursor: Any = None
        """The key of the row with the cursor, if any."""
        self.empty = ""
        """Shown if there are no rows."""
        self._natural: list[int] = []
        self._widths: list[tuple[int, int]] = []
        self._drawn: list[Row | None] = []

    @property
    def body(self) -> int:
        """The number of visible rows."""
        return max(0, self.size.height - 1)

    @property
    def current(self) -> Row | None:
        """The row of the cursor."""
        place = self._place()
        return None if place is None else self.rows[place]

    def _place(self) -> int | None:
        if self.cursor is None:
            return None
        return next((place for place, row in enumerate(self.rows) if row.key == self.cursor), None)

    def show(self, columns: Sequence[Column], rows: Sequence[Row]) -> None:
        """Sets the rows and draws the differences."""
        natural = [cell_len(column.heading) for column in columns]
        if len(natural) == len(self._natural):  # never narrower, or the columns to the right would jump
            natural = [max(one) for one in zip(natural, self._natural, strict=True)]
        for row in rows:
            for number, content in enumerate(row.cells):
                wide = widest(content)
                if wide > natural[number]:
                    natural[number] = wide
        widths = fit(columns, natural, self.size.width)
        headings = [column.heading for column in columns] != [column.heading for column in self.columns]
        self.columns, self.rows, self._natural = columns, rows, natural
        self.top = max(0, min(self.top, len(rows) - self.body))
        if headings or widths != self._widths:
            self._widths = widths
            self._drawn = self._visible()
            self.refresh()
            return
        self._redraw()

    def _visible(self) -> list[Row | None]:
        shown: list[Row | None] = list(self.rows[self.top : self.top + self.body])
        return shown + [None] * (self.body - len(shown))

    def _redraw(self) -> None:
        """Draws the cells that differ from those on the screen."""
        now = self._visible()
        if len(now) != len(self._drawn):
            self._drawn = now
            self.refresh()
            return
        regions: list[Region] = []
        for y, (row, before) in enumerate(zip(now, self._drawn, strict=True), 1):
            if row == before:
                continue
            if row is None or before is None or row.look != before.look or self.cursor in (row.key, before.key):
                regions.append(Region(0, y, self.size.width, 1))
                continue
            x = 0
            for number, wide in self._widths:
                if row.cells[number] != before.cells[number]:
                    regions.append(Region(x, y, wide, 1))
                x += wide + 1
        self._drawn = now
        if regions:
            self.refresh(*regions)

    def on_resize(self) -> None:
        """Lays out the columns again."""
        self._natural, self._widths = [], []
        self.show(self.columns, self.rows)

    def on_focus(self) -> None:
        """Shows the focus in the line of headings."""
        self.refresh()

    def on_blur(self) -> None:
        """Shows the loss of focus in the line of headings."""
        self.refresh()

    def render_line(self, y: int) -> Strip:
        """Returns one line of the widget."""
        columns = self.size.width
        if y == 0:
            look = STYLES["focused" if self.has_focus else "heading"]
            cells = [cell(column.heading) for column in self.columns]
            return self._strip(cells, look, columns)
        place = self.top + y - 1
        if place >= len(self.rows):
            if y == 1 and self.empty and not self.rows:
                return line(cell(self.empty, "dim"), columns)
            return Strip.blank(columns)
        row = self.rows[place]
        look = STYLES[row.look]
        if row.key == self.cursor:
            look += STYLES["cursor"]
        return self._strip(row.cells, look, columns)

    def _strip(self, cells: Sequence[Cell], look: Style, columns: int) -> Strip:
        segments: list[Segment] = []
        blank = Segment(" ", look)
        for number, wide in self._widths:
            if segments:
                segments.append(blank)
            segments += draw(cells[number], wide, look, right=self.columns[number].right)
        return Strip(segments).adjust_cell_length(columns, look)

    def move(self, rows: int) -> None:
        """Moves the cursor, or sets it on a visible row."""
        if not self.rows:
            return
        place = self._place()
        if place is None:
            place = self.top if rows > 0 else min(self.top + self.body, len(self.rows)) - 1
        else:
            place = max(0, min(place + rows, len(self.rows) - 1))
        self.put(place)

    def put(self, place: int) -> None:
        """Sets the cursor on a row and scrolls to it."""
        self.cursor = self.rows[place].key
        self.top = max(min(self.top, place), place - self.body + 1, 0)
        self._drawn = self._visible()
        self.refresh()
        self.post_message(self.Moved())

    def leave(self) -> None:
        """Removes the cursor."""
        self.cursor = None
        self.refresh()
        self.post_message(self.Moved())

    def edge(self, *, last: bool) -> None:
        """Goes to the first or the last row."""
        if self.rows:
            self.put(len(self.rows) - 1 if last else 0)

    def roll(self, rows: int) -> None:
        """Scrolls without moving the cursor."""
        self.top = max(0, min(self.top + rows, len(self.rows) - self.body))
        self._drawn = self._visible()
        self.refresh()

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        """Scrolls down."""
        event.stop()
        self.roll(3)

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        """Scrolls up."""
        event.stop()
        self.roll(-3)

    def on_click(self, event: events.Click) -> None:
        """Sets the cursor on the row; a second click asks for its details."""
        place = self.top + event.y - 1
        if event.y < 1 or place >= len(self.rows):
            return
        row = self.rows[place]
        if event.chain > 1:
            self.post_message(self.Picked(self, row))
        else:
            self.put(place)


def texts(values: Iterable[object]) -> str:
    """Joins the non-empty values by two blanks, for the lines below the views."""
    return "  ".join(str(value) for value in values if value not in (None, ""))
