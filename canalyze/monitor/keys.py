"""Every key: what it does, and where people read of it. The foot line and the page of help are made of this table."""

from typing import ClassVar, Final, NamedTuple

from rich.cells import cell_len
from textual import events
from textual.app import ComposeResult
from textual.binding import Binding
from textual.screen import ModalScreen
from textual.strip import Strip
from textual.widget import Widget

from canalyze.layout import wrap
from canalyze.monitor.grid import Cell, cell, line
from canalyze.words import Words


class Key(NamedTuple):
    """Keys that do one thing."""

    keys: str
    """As textual names them, with commas between."""
    action: str
    shown: str
    """How people name them, or a key of `words`."""
    name: str
    """What it does, for the page of help: a key of `words`."""
    foot: str = ""
    """The same in a word, for the foot line: a key of `words`; without it, it does not stand there."""
    leaves: int = 0
    """The higher, the sooner it leaves the foot line for want of room; 0: never."""


VIEWS: Final = ("overview", "nodes", "objects", "transfers", "findings", "trace", "incidents")
"""What can be seen, in the order of the keys 1 to 7."""

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
    """Give what textual needs.

    All have priority: then the application takes them one by one, and what is typed or pasted right behind the key that
    opens the prompt goes into it. While something is asked, `Monitor.check_action` lets them pass.
    """
    return [Binding(key.keys, key.action, show=False, priority=True) for key in KEYS if key.keys]


def _name(key: Key, words: Words) -> str:
    return words(key.shown) if key.shown.startswith("monitor.") else key.shown


class Foot(Widget):
    """The foot line: the most important keys."""

    DEFAULT_CSS = "Foot { height: 1; width: 1fr; }"
    ALLOW_SELECT = False

    def __init__(self, words: Words) -> None:
        """Take the keys that stand in it."""
        super().__init__(id="foot")
        self._keys = [(key.leaves, _name(key, words), words(key.foot)) for key in KEYS if key.foot]

    def render_line(self, y: int) -> Strip:
        """Give the line; what has no room is left out, never what tells of all the others."""
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


class _Page(Widget):
    DEFAULT_CSS = "_Page { width: 100%; height: 100%; }"
    ALLOW_SELECT = False

    def __init__(self, words: Words, *, replay: bool) -> None:
        super().__init__()
        self._rows = [
            (_name(key, words), words(key.name))
            for key in KEYS
            if key.name and (replay or not key.action.startswith("speed"))
        ]
        self._words = words

    def render_line(self, y: int) -> Strip:
        return line(self._lines()[y] if y < len(self._lines()) else (), self.size.width)

    def _lines(self) -> list[Cell]:
        left = max(cell_len(key) for key, _ in self._rows)
        found = [cell(f" {self._words('monitor.help_title')}", "strong")]
        for key, what in self._rows:
            texts = wrap(what, max(20, self.size.width - left - 4))
            for place, text in enumerate(texts):
                name = key if place == 0 else ""
                found.append(((f" {name}{' ' * (left - cell_len(name))}  ", "key"), (text, "")))
        for text in wrap(self._words("monitor.help_looks"), max(20, self.size.width - 2)):
            found.append(cell(f" {text}", "dim"))
        return found


class Help(ModalScreen[None]):
    """The page of help; any key closes it."""

    BINDINGS: ClassVar = [Binding("ctrl+c,ctrl+q", "app.end", show=False, priority=True)]

    def __init__(self, words: Words, *, replay: bool) -> None:
        """Take the keys; those for speed only stand there of a replay."""
        super().__init__()
        self._words = words
        self._replay = replay

    def compose(self) -> ComposeResult:
        """Give the page."""
        yield _Page(self._words, replay=self._replay)

    def on_key(self, event: events.Key) -> None:
        """Close the page."""
        event.stop()
        event.prevent_default()
        self.dismiss()
