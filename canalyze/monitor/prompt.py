"""The input line for a filter or a search. Must not: interpret it."""

from typing import ClassVar

from rich.cells import cell_len
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal
from textual.message import Message
from textual.widgets import Input, Static


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
