"""Everything around the views: the lines above and below, all keys and their actions, and the pages that they open.

The foot line and the page of help are made from the keys. A page lies over the screen until the next key: of help, of a
node, of a finding, of a frame. The prompt asks for a line: a filter or a search.
"""

from collections.abc import Sequence
from typing import ClassVar, Final, NamedTuple

from rich.cells import cell_len
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text
from textual import events
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal, VerticalScroll
from textual.message import Message
from textual.screen import ModalScreen
from textual.strip import Strip
from textual.widget import Widget
from textual.widgets import Input, Static

from canalyze import _core
from canalyze.monitor.grid import STYLES, Cell, Piece, cell, clock, line, rate
from canalyze.monitor.views import MARKS, newest, open_roots
from canalyze.output import printable
from canalyze.output.layout import wrap
from canalyze.records.live import Bus, MappedObject, Node, NodeDetails, Snapshot
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


_CLASSIC: Final = 8
"""Maximum number of data bytes of a classic CAN frame."""


class Page(ModalScreen[bool]):
    """A page; its result is True if Enter closed it."""

    CSS = """
    Page { background: ansi_default; }
    Page VerticalScroll { background: ansi_default; scrollbar-size-vertical: 1; }
    """
    BINDINGS: ClassVar = [Binding("ctrl+c,ctrl+q", "app.end", show=False, priority=True)]

    def __init__(self, shown: RenderableType) -> None:
        """Creates a page with its content."""
        super().__init__()
        self._shown = shown

    def compose(self) -> ComposeResult:
        """Yields the content."""
        with VerticalScroll():
            yield Static(self._shown)

    def on_key(self, event: events.Key) -> None:
        """Closes the page."""
        event.stop()
        event.prevent_default()
        self.dismiss(event.key == "enter")


def listed(title: str, rows: Sequence[tuple[str, str]], below: str) -> RenderableType:
    """Returns a page of names with their descriptions."""
    table = _grid(2)
    for name, what in rows:
        table.add_row(_text(f" {name}", "key"), _text(what))
    return Group(_text(f" {title}", "strong"), table, _text(f" {below}", "dim"))


def of_node(node: Node, known: NodeDetails, words: Words) -> RenderableType:
    """Returns the page of a node: `node` is its row of a snapshot, `known` its page of the core."""
    head = words("monitor.of_node", node=words("monitor.node", node=node.node), name=node.name).strip()
    identity = _grid(3)
    for one in known.identity:
        identity.add_row(_text(f"  {one.object}", "strong"), _text(one.name or ""), _text(one.text))
    pdos = _grid(4)
    for pdo in known.pdos:
        kind = "" if pdo.type is None else words("monitor.transmission", type=pdo.type)
        off = "" if pdo.valid else words("monitor.pdo_off")
        pdos.add_row(
            _text(f"  {pdo.pdo}", "strong" if pdo.valid else "dim"),
            _text(f"{pdo.id}h"),
            _text("  ".join(filter(None, (off or kind, words.of("monitor_from", pdo.origin or "")))), "dim"),
            Text("\n").join(_mapped(one, words) for one in pdo.objects),
        )
    parts: list[RenderableType] = [_text(f" {head}", "strong")]
    for key, table in (("identity", identity), ("pdos", pdos)):
        title = "monitor_known" if table.row_count else "monitor_unknown"
        parts += ["", _text(f" {words.of(title, key)}", "" if table.row_count else "dim"), table]
    return Group(*parts, "", _text(f" {words('monitor.page_frames')}", "dim"))


def of_finding(words: Words, code: str, text: str) -> RenderableType:
    """Returns the explanation of the rule of a finding."""
    explained = _core.explain(code, words.lang) or ""
    end = words("monitor.page_frame")
    return Group(_text(f" {code}  {text}", "strong"), "", *_lines(explained), "", _text(f" {end}", "dim"))


def of_frame(words: Words, cob: str, data: str, text: str) -> RenderableType:
    """Returns a frame field by field, below its line."""
    octets = "".join(part for part in data.split() if len(part) == 2)
    remote = bool(data) and not octets
    separator = "##0" if len(octets) > 2 * _CLASSIC else "#"
    explained = _core.explain(f"{cob}{separator}{'R' if remote else octets}", words.lang) if cob else None
    lines = (explained or "").splitlines()[1:]
    head = [_text(f" {part}", "strong") for part in (f"{cob}  {data}".strip(), text)]
    return Group(*head, "", *_lines("\n".join(lines)), "", _text(f" {words('monitor.page_back')}", "dim"))


def _lines(text: str) -> list[Text]:
    return [_text(f" {line.removeprefix('#')}") for line in text.splitlines()]


def _mapped(one: MappedObject, words: Words) -> Text:
    return _text(words("monitor.mapped", object=one.object, name=one.name or "", bits=one.bits))


def _grid(columns: int) -> Table:
    table = Table.grid(padding=(0, 2))
    for _ in range(columns):
        table.add_column()
    return table


def _text(text: str, look: str = "") -> Text:
    """Returns a text without markup or characters that could control a terminal."""
    return Text(printable(text), STYLES[look])


class Prompt(Horizontal):
    """Asks for one line; Enter accepts, Escape cancels."""

    DEFAULT_CSS = """
    Prompt { height: 1; width: 1fr; display: none; }
    Prompt Static { height: 1; width: auto; text-style: bold; }
    Prompt Input { height: 1; width: 1fr; border: none; padding: 0; background: ansi_default; }
    Prompt Input:focus { border: none; background: ansi_default; }
    """
    BINDINGS: ClassVar = [Binding("escape", "cancel", show=False)]

    class Given(Message):
        """A line was entered."""

        def __init__(self, purpose: str, text: str) -> None:
            """Creates the message with the purpose and the line."""
            super().__init__()
            self.purpose = purpose
            self.text = text

    class Cancelled(Message):
        """The input was cancelled."""

    def __init__(self) -> None:
        """Creates a hidden prompt."""
        super().__init__(id="prompt")
        self.purpose = ""

    def compose(self) -> ComposeResult:
        """Yields the question and the field."""
        yield Static("", markup=False)
        yield Input(compact=True, select_on_focus=False)

    def ask(self, purpose: str, question: str, text: str) -> None:
        """Asks for a line; `text` is the initial content."""
        self.purpose = purpose
        label = self.query_one(Static)
        label.update(f"{question} ")
        label.styles.width = cell_len(question) + 1
        self.display = True
        field = self.query_one(Input)
        field.value = text
        field.cursor_position = len(text)
        self.take_keys()

    def take_keys(self) -> None:
        """Focuses the field at once, so that it gets the next key."""
        self.screen.set_focus(self.query_one(Input))

    def close(self) -> None:
        """Hides the prompt."""
        self.display = False

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Accepts the line."""
        event.stop()
        self.post_message(self.Given(self.purpose, event.value.strip()))

    def action_cancel(self) -> None:
        """Cancels the input."""
        self.post_message(self.Cancelled())


class Key(NamedTuple):
    """Keys with the same action."""

    keys: str
    """Their names in textual, separated by commas."""
    action: str
    shown: str
    """Their name for the user, or a key of `words`."""
    name: str
    """The description for the page of help: a key of `words`."""
    foot: str = ""
    """The description in one word for the foot line: a key of `words`; empty: not in the foot line."""
    leaves: int = 0
    """The higher, the sooner it is hidden in the foot line if the width does not suffice; 0: never."""


VIEWS: Final = ("overview", "nodes", "objects", "transfers", "findings", "trace", "problems")
"""The views, in the order of the keys 1 to 7."""

KEYS: Final = (
    *(Key(str(number), f"view('{name}')", "", "") for number, name in enumerate(VIEWS, 1)),
    Key("", "", "1-7", "monitor.help_views", "monitor.key_views", 1),
    Key("tab", "room(1)", "Tab", "monitor.help_tab", "monitor.key_tab", 5),
    Key("shift+tab", "room(-1)", "", ""),
    Key("down,j", "move(1)", "", ""),
    Key("up,k", "move(-1)", "", ""),
    Key("pagedown", "page(1)", "", ""),
    Key("pageup", "page(-1)", "", ""),
    Key("home,g", "edge(False)", "", ""),
    Key("end,G", "edge(True)", "", ""),
    Key("", "", "↑ ↓ PgUp PgDn", "monitor.help_move"),
    Key("", "", "Home End", "monitor.help_edge"),
    Key("enter", "pick", "Enter", "monitor.help_pick", "monitor.key_pick", 6),
    Key("space,p", "pause", "monitor.space", "monitor.help_pause", "monitor.key_pause", 2),
    Key("s", "severity", "s", "monitor.help_severity"),
    Key("f", "filter", "f", "monitor.help_filter", "monitor.key_filter", 3),
    Key("slash", "search", "/", "monitor.help_search", "monitor.key_search", 4),
    Key("n", "find(False)", "n", "monitor.help_next"),
    Key("N", "find(True)", "N", "monitor.help_previous"),
    Key("escape", "leave", "Esc", "monitor.help_leave"),
    Key("plus,equals_sign", "speed(True)", "+", "monitor.help_faster"),
    Key("minus", "speed(False)", "-", "monitor.help_slower"),
    Key("question_mark,f1", "help", "?", "monitor.help_help", "monitor.key_help"),
    Key("q", "stop", "q", "monitor.help_quit", "monitor.key_quit"),
    Key("ctrl+c,ctrl+q", "end", "", ""),
    Key("ctrl+z", "suspend_process", "", ""),
)
"""In the order of the page of help."""


def bindings() -> list[Binding | tuple[str, str] | tuple[str, str, str]]:
    """Returns the bindings for textual.

    All have priority, so that the application handles them one by one, and text typed or pasted right after the key
    that opens the prompt goes into it. `Monitor.check_action` disables them while the prompt is open.
    """
    return [Binding(key.keys, key.action, show=False, priority=True) for key in KEYS if key.keys]


def _name(key: Key, words: Words) -> str:
    return words(key.shown) if key.shown.startswith("monitor.") else key.shown


class Foot(Widget):
    """The foot line: the most important keys."""

    DEFAULT_CSS = "Foot { height: 1; width: 1fr; }"
    ALLOW_SELECT = False

    def __init__(self, words: Words) -> None:
        """Creates the line with its keys."""
        super().__init__(id="foot")
        self._keys = [(key.leaves, _name(key, words), words(key.foot)) for key in KEYS if key.foot]

    def render_line(self, y: int) -> Strip:
        """Returns the line; keys without room are left out, but never the one for help."""
        keys = list(self._keys)
        while sum(cell_len(key) + cell_len(what) + 3 for _, key, what in keys) - 1 > self.size.width:
            leaving = max(keys)
            if not leaving[0]:
                break
            keys.remove(leaving)
        pieces: list[tuple[str, str]] = []
        for _, key, what in keys:
            pieces += [(" " if not pieces else "  ", ""), (key, "key"), (f" {what}", "")]
        return line(tuple(pieces), self.size.width)


def help_page(words: Words, *, replay: bool) -> RenderableType:
    """Returns the page of help; the keys for speed are shown for a replay only."""
    rows = [
        (_name(key, words), words(key.name))
        for key in KEYS
        if key.name and (replay or not key.action.startswith("speed"))
    ]
    return listed(words("monitor.help_title"), rows, words("monitor.help_looks"))
