"""The line in which a filter or a search is typed. Must not: understand it."""

from typing import ClassVar

from rich.cells import cell_len
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal
from textual.message import Message
from textual.widgets import Input, Static


class Prompt(Horizontal):
    """Asks for one line; Enter takes it, Escape does not."""

    DEFAULT_CSS = """
    Prompt { height: 1; width: 1fr; display: none; }
    Prompt Static { height: 1; width: auto; text-style: bold; }
    Prompt Input { height: 1; width: 1fr; border: none; padding: 0; background: ansi_default; }
    Prompt Input:focus { border: none; background: ansi_default; }
    """
    BINDINGS: ClassVar = [Binding("escape", "cancel", show=False)]

    class Given(Message):
        """A line was given."""

        def __init__(self, purpose: str, text: str) -> None:
            """Take what was asked for, and the line."""
            super().__init__()
            self.purpose = purpose
            self.text = text

    class Cancelled(Message):
        """Nothing was given."""

    def __init__(self) -> None:
        """Ask for nothing yet."""
        super().__init__(id="prompt")
        self.purpose = ""

    def compose(self) -> ComposeResult:
        """Give the question and the field."""
        yield Static("", markup=False)
        yield Input(compact=True, select_on_focus=False)

    def ask(self, purpose: str, question: str, text: str) -> None:
        """Ask for a line; `text` is what stands there first."""
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
        """Let keys go into the field, at once: the next is its own."""
        self.screen.set_focus(self.query_one(Input))

    def close(self) -> None:
        """Go away."""
        self.display = False

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Take the line."""
        event.stop()
        self.post_message(self.Given(self.purpose, event.value.strip()))

    def action_cancel(self) -> None:
        """Take nothing."""
        self.post_message(self.Cancelled())
