"""The lines around the views: the bus and the views above; notices and the full row below."""

from typing import Final

from rich.cells import cell_len
from textual.strip import Strip
from textual.widget import Widget

from canalyze.monitor.grid import Cell, Piece, cell, clock, line, rate
from canalyze.monitor.keys import VIEWS
from canalyze.monitor.views import MARKS, newest, open_roots
from canalyze.output import printable
from canalyze.output.layout import wrap
from canalyze.records.live import Bus, Snapshot
from canalyze.words import Words

_BADGES: Final = {
    "live": "live",
    "replay": "live",
    "paused": "halted",
    "waiting": "halted",
    "lost": "lost",
    "over": "over",
    "records": "live",
    "unrecorded": "lost",
}
"""Styles of the states of source and recording."""
_LOAD: Final = (("error", 80.0), ("warning", 50.0))
"""Bus loads in percent from which they are highlighted."""
_TITLE: Final = 30
"""Minimum columns for the title of a problem."""


class Lines(Widget):
    """Lines that are drawn again only if they change."""

    DEFAULT_CSS = "Lines { height: 1; width: 1fr; }"
    ALLOW_SELECT = False

    def __init__(self, name: str) -> None:
        """Creates empty lines; `name` is the id."""
        super().__init__(id=name)
        self._lines: list[Cell] = []

    def say(self, lines: list[Cell]) -> None:
        """Sets the lines."""
        if lines != self._lines:
            self._lines = lines
            self.refresh()

    def render_line(self, y: int) -> Strip:
        """Returns one of them."""
        return line(self._lines[y] if y < len(self._lines) else (), self.size.width)


class Status(Lines):
    """Two lines: the bus, and the views."""

    DEFAULT_CSS = "Status { height: 2; width: 1fr; }"

    def __init__(self, words: Words) -> None:
        """Creates empty lines."""
        super().__init__("status")
        self._words = words
        self._away: frozenset[str] = frozenset()
        self._widths: list[int] = []
        """Maximum widths so far of the items of the first line."""

    def update(
        self,
        snapshot: Snapshot,
        badges: list[str],
        speed: str,
        view: str,
        conditions: list[str],
        away: frozenset[str] = frozenset(),
    ) -> None:
        """Updates the lines.

        badges: states of the source and of the recording. speed: that of a replay or "". conditions: filter and search,
        in words. away: the lost buses.
        """
        words = self._words
        self._away = away
        heads: list[Cell] = [
            ((f" {words(f'monitor.{badge}')}{'' if place else speed} ", _BADGES[badge]),)
            for place, badge in enumerate(badges)
        ]
        trouble = newest(snapshot)
        items = [*heads, *self._figures(snapshot, short=False)]
        if sum(_width(item) + 2 for item in items) + (_TITLE if trouble else 0) > self.size.width:
            items = [*heads, *self._figures(snapshot, short=True, scarce=bool(trouble))]
        widths = [_width(item) for item in items]
        if len(widths) == len(self._widths):  # never narrower, or the items to the right would jump
            widths = [max(pair) for pair in zip(widths, self._widths, strict=True)]
        self._widths = widths if sum(widths) + 2 * len(widths) <= self.size.width else []
        first: list[Piece] = []
        for place, item in enumerate(items):
            first += [*((("  ", ""),) if first else ()), *item]
            if self._widths and (missing := self._widths[place] - _width(item)) > 0:
                first.append((" " * missing, ""))
        if trouble:
            first += [("  ", ""), *trouble]
        self.say([tuple(first), self._views(snapshot, view, conditions)])

    def on_resize(self) -> None:
        """Uses the new width."""
        self._widths = []

    def _figures(self, snapshot: Snapshot, *, short: bool, scarce: bool = False) -> list[Cell]:
        """Returns the figures of the buses, the most important first; short: in few columns.

        scarce: zeros are left out.
        """
        words = self._words
        buses = snapshot.buses
        start, now = snapshot.start_ns, snapshot.now_ns
        most = 2 if short else 6
        # One whose controller is in trouble is never among those left out.
        items: list[Cell] = [self._bus(bus) for bus in sorted(buses, key=self._is_well)[:most]]
        if len(buses) > most:
            items.append(cell(f"+{len(buses) - most}", "dim"))
        if start is not None and now is not None:
            items.append(cell(clock(now - start)))
        errors, dropped = sum(bus.error_frames for bus in buses), sum(bus.dropped for bus in buses)
        a_second = rate(sum(bus.frames_per_s or 0 for bus in buses))
        for long, brief, count, look in (
            ("monitor.long_frames", "monitor.short_frames", snapshot.tally.frames, ""),
            ("monitor.long_rate", "monitor.short_rate", a_second, ""),
            ("monitor.long_errors", "monitor.short_errors", errors, "error" if errors else ""),
            ("monitor.long_dropped", "monitor.short_dropped", dropped, "error" if dropped else ""),
        ):
            if count not in (0, "0") or not scarce:
                items.append(cell(words(brief if short else long, count=count), look))
        return items

    def _is_well(self, bus: Bus) -> bool:
        return bus.state is None and bus.name not in self._away

    def _bus(self, bus: Bus) -> Cell:
        """Returns name, load and, if it is not good, the state of a bus."""
        pieces: list[Piece] = [(bus.name or "-", "strong")]
        if bus.name in self._away:
            return (*pieces, (f" {self._words('monitor.bus_down')}", "error"))
        load = bus.load_percent
        if load is not None:
            look = next((look for look, least in _LOAD if load >= least), "good")
            pieces.append((f" {load:.1f}%", look))
        if bus.state:
            pieces.append((f" {self._words.of('bus_state', bus.state)}", "error"))
        return tuple(pieces)

    def _views(self, snapshot: Snapshot, view: str, conditions: list[str], *, scarce: bool = False) -> Cell:
        """Returns the views by number; scarce: without the numbers of their rows."""
        counts: dict[str, int] = {}
        if not scarce:
            counts = {
                "nodes": len(snapshot.nodes),
                "objects": len(snapshot.objects) + snapshot.objects_more,
                "transfers": len(snapshot.transfers.running),
            }
        open_count = len(open_roots(snapshot))
        pieces: list[Piece] = []
        for number, name in enumerate(VIEWS, 1):
            look = "here" if name == view else ""
            pieces.append((" ", ""))
            title = self._words.of("monitor_view", name)
            count = f" {counts[name]}" if counts.get(name) else ""
            pieces.append((f"{number} {title}{count}", look))
            if name == "findings":
                found = snapshot.tally.findings
                marks = ((f" {mark}{found[severity]}", severity) for severity, mark in MARKS.items() if found[severity])
                pieces += marks
            if name == "problems" and open_count:
                pieces.append((f" ✖{open_count}", "error"))
            pieces.append((" ", ""))
        for condition in conditions:
            pieces.append((f" {condition} ", "halted"))
        if _width(tuple(pieces)) > self.size.width:  # one blank apart where two have no room
            pieces = [
                one for place, one in enumerate(pieces) if place == 0 or one[0] != " " or pieces[place - 1][0] != " "
            ]
        if _width(tuple(pieces)) > self.size.width and not scarce:
            return self._views(snapshot, view, conditions, scarce=True)
        return tuple(pieces)


def _width(item: Cell) -> int:
    return sum(cell_len(text) for text, _ in item)


class Below(Lines):
    """Lines that are hidden while empty: the row of the cursor in full, or a notice."""

    DEFAULT_CSS = "Below { height: 1; width: 1fr; display: none; }"

    def tell(self, text: str, most: int, look: str = "") -> None:
        """Shows a text in at most `most` lines, or hides the lines if it is empty."""
        if not text:
            self.display = False
            self.say([])
            return
        lines = wrap(printable(text), max(20, self.size.width or self.app.size.width))
        if len(lines) > most:
            lines = [*lines[: most - 1], " ".join(lines[most - 1 :])]
        self.styles.height = len(lines)
        self.display = True
        self.say([cell(one, look) for one in lines])

    def tell_cell(self, said: Cell) -> None:
        """Shows a cell in one line, cut to the width."""
        self.display = bool(said)
        self.say([said])
