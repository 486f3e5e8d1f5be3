"""The view of annotated frames: it follows the newest frame, or stays where the user has scrolled to.

It holds only the visible lines and queries others from the core (`Session.trace`), with the filter. Must not:
interpret a line; matches of the search are only highlighted.
"""

from collections.abc import Callable, Sequence
from typing import Final

from canalyze.monitor.grid import NOTHING, Cell, Column, Grid, Row, cell, texts
from canalyze.words import Words

Line = tuple[int, str, int | None, str, str, str, str]
"""Number of the frame, severity, stamp in ns, bus, CAN-ID, data, meaning."""
Ask = Callable[[str, str, int | None, int, bool], Sequence[Line]]
"""`Session.trace`: filter, search text, frame, maximum number of lines, true if the lines end there."""

_LOOKS: Final = ("error", "warning")
_FINE: Final = 110
"""Minimum columns for full stamps and blanks between the bytes of the data."""


class Trace(Grid):
    """The view of some of the frames that the core keeps."""

    def __init__(self, ask: Ask, words: Words) -> None:
        """Creates the view; `ask` queries lines."""
        super().__init__("trace")
        self._ask = ask
        self._words = words
        self.filter = ""
        """The filter expression of the user."""
        self.search = ""
        """The text to search."""
        self.follows = True
        """True if the newest line is visible."""
        self.limit: int | None = None
        """The newest frame to show; None: the newest available."""
        self.start_ns: int | None = None
        self.buses = False
        """True if the bus has a column."""
        self._lines: list[Line] = []

    def update(self) -> None:
        """Shows the newest lines, unless the user has scrolled back."""
        if self.body <= 0:
            return
        self.empty = self._words.of("monitor_empty", "trace" if self.filter else "objects")
        if self.follows:
            self._lines = list(self._ask(self.filter, "", self.limit, self.body, True))
        elif len(self._lines) < self.body:
            self._fill()
        self.lay()

    def _fill(self) -> None:
        """Queries missing lines after the last line, then before the first one."""
        missing = self.body - len(self._lines)
        if missing > 0 and self._lines:
            self._lines += self._newer(missing)
            missing = self.body - len(self._lines)
            self._lines = self._older(missing) + self._lines if missing > 0 else self._lines
        if len(self._lines) > self.body:
            self._lines = self._lines[-self.body :] if self.body else []

    def _newer(self, rows: int) -> list[Line]:
        last = self._lines[-1][0]
        known = sum(line[0] == last for line in self._lines)
        found = [*self._ask(self.filter, "", last, rows + known, False)]
        if found and found[0][0] == last:
            found = found[known:]
        if self.limit is not None:
            found = [line for line in found if line[0] <= (self.limit or 0)]
        return found

    def _older(self, rows: int) -> list[Line]:
        first = self._lines[0][0]
        known = sum(line[0] == first for line in self._lines)
        found = [*self._ask(self.filter, "", first, rows + known, True)]
        return found[:-known] if found and found[-1][0] == first else found

    def lay(self) -> None:
        """Lays out the lines."""
        fine = self.size.width >= _FINE
        words = self._words
        heading = words("monitor.trace") if self.follows else words("monitor.trace_back")
        columns = [
            Column(words("col.time"), most=17, right=True, leaves=1),
            Column("ID"),
            Column(words("monitor.data"), least=16, most=48 if fine else 16),
            Column("  ".join([heading, *self.conditions()]), least=20, most=400),
        ]
        if self.buses:
            columns.insert(1, Column(words("col.bus"), most=10))
        place, before = 0, -1
        rows = []
        for line in self._lines:
            place = place + 1 if line[0] == before else 0
            before = line[0]
            rows.append(self._row(line, place, fine=fine))
        self.show(columns, rows)

    def conditions(self) -> list[str]:
        """Returns the filter and the search in words."""
        words = self._words
        found = [words("monitor.filtered", text=self.filter)] if self.filter else []
        return [*found, words("monitor.searched", text=self.search)] if self.search else found

    def _row(self, line: Line, place: int, *, fine: bool) -> Row:
        number, severity, at, bus, cob, data, text = line
        stamp = ""
        if at is not None:
            stamp = f"{(at - (self.start_ns or 0)) / 1e9:.{6 if fine else 4}f}"
        cells = [
            cell(stamp, "dim"),
            self._found(cob, "strong"),
            self._found(data if fine else _closer(data), ""),
            self._found(text, severity if severity in _LOOKS else "" if cob else "info"),
        ]
        if self.buses:
            cells.insert(1, cell(bus))
        whole = texts([f"#{number}", bus, cob, data, text])
        return Row((number, place), tuple(cells), whole, about=("frame", cob, data, text))

    def _found(self, text: str, look: str) -> Cell:
        """Returns a cell with the matches of the search highlighted."""
        if not text:
            return NOTHING
        wanted, lower = self.search.lower(), text.lower()
        if not wanted or wanted not in lower or len(lower) != len(text):
            return cell(text, look)
        pieces: list[tuple[str, str]] = []
        at = 0
        while (found := lower.find(wanted, at)) >= 0:
            if found > at:
                pieces.append((text[at:found], look))
            at = found + len(wanted)
            pieces.append((text[found:at], "found"))
        if at < len(text):
            pieces.append((text[at:], look))
        return tuple(pieces)

    def follow(self) -> None:
        """Shows the newest line again."""
        self.follows, self.cursor = True, None
        self.update()
        self.post_message(self.Moved())

    def choose(self, expression: str) -> None:
        """Sets the filter. Raises ValueError, in words, for an invalid expression."""
        self._ask(expression, "", None, 1, True)
        at = self.current
        self.filter = expression
        if self.follows or at is None or not isinstance(at.key, tuple):
            self.follow()
        else:
            self.go(at.key[0])

    def go(self, frame: int) -> bool:
        """Sets the cursor on a frame, or on the next visible one; returns true if it was that frame."""
        self.follows = False
        before = max(0, self.body // 2 - 1)
        behind = [*self._ask(self.filter, "", frame, max(1, self.body - before), False)]
        older = [*self._ask(self.filter, "", frame - 1, self.body, True)] if frame > 0 else []
        room = max(before, self.body - len(behind))
        self._lines = (older[-room:] if room else []) + behind
        if not self._lines:
            self.follow()
            return False
        here = behind[0][0] if behind else self._lines[-1][0]
        self.cursor = (here, 0)
        self.lay()
        self.refresh()
        self.post_message(self.Moved())
        return here == frame

    def find(self, *, back: bool) -> bool:
        """Goes to the next or the previous match of the search; returns false if there is none."""
        if not self.search:
            return False
        at = self.current
        frame: int | None = None
        if at is not None and isinstance(at.key, tuple):
            frame = at.key[0] - 1 if back else at.key[0] + 1
        elif back or self.follows:
            frame, back = self.limit, True
        elif self._lines:
            frame = self._lines[0][0]
        found = self._ask(self.filter, self.search, frame, 1, back) if frame is None or frame >= 0 else ()
        if not found:
            return False
        self.go(found[0][0])
        return True

    def move(self, rows: int) -> None:
        """Moves the cursor, scrolling at the edges."""
        if not self.rows:
            return
        self._stand()
        place = self._place()
        if place is None:
            super().move(rows)
            return
        wanted = place + rows
        if wanted < 0 and self._scroll(wanted):
            place = self._place() or 0
            wanted = max(0, place + rows)
        elif wanted >= len(self.rows):
            self._scroll(wanted - len(self.rows) + 1)
            place = self._place() if self._place() is not None else len(self.rows) - 1
            wanted = (place or 0) + rows
        if self.rows:
            self.put(max(0, min(wanted, len(self.rows) - 1)))

    def _stand(self) -> None:
        """Stops following."""
        if self.follows:
            self.follows = False
            self.lay()

    def _scroll(self, rows: int) -> int:
        """Scrolls the lines, back if negative; returns the number of new lines."""
        if not self._lines:
            return 0
        if rows < 0:
            more = self._older(-rows)
            self._lines = (more + self._lines)[: self.body]
        else:
            more = self._newer(rows)
            self._lines = (self._lines + more)[-self.body :]
        at = self.cursor
        self.lay()
        self.cursor = at
        if at is not None and self._place() is None and self.rows:
            self.cursor = self.rows[-1 if rows < 0 else 0].key
        self.refresh()
        return len(more)

    def roll(self, rows: int) -> None:
        """Scrolls the lines; at the newest one they follow again."""
        self._stand()
        if not self._scroll(rows) and rows > 0 and self.limit is None:
            self.follow()

    def edge(self, *, last: bool) -> None:
        """Goes to the oldest available line, or follows the newest."""
        if last:
            self.follow()
            return
        self.follows = False
        self._lines = list(self._ask(self.filter, "", None, self.body, False))
        self.cursor = (self._lines[0][0], 0) if self._lines else None
        self.lay()
        self.refresh()
        self.post_message(self.Moved())

    def leave(self) -> None:
        """Removes the cursor and follows."""
        self.follow()


def _closer(data: str) -> str:
    """Joins separate bytes; words stay as they are."""
    parts = data.split(" ")
    return "".join(parts) if all(len(part) == 2 for part in parts) else data
