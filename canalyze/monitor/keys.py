"""All keys and their actions, from which the foot line and the page of help are made; and the prompt for a line."""

from typing import ClassVar, Final, NamedTuple

from rich.cells import cell_len
from rich.console import RenderableType
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal
from textual.message import Message
from textual.strip import Strip
from textual.widget import Widget
from textual.widgets import Input, Static

from canalyze.monitor.grid import line
from canalyze.monitor.pages import listed
from canalyze.words import Words


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
