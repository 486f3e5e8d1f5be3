"""The Rust core, as Python sees it: bytes in, annotated bytes out.

Words in the core's output are in the session's language; nothing here raises on the content of a capture.
"""

from typing import final

__version__: str

@final
class Session:
    """One capture, of one or several files, from bytes to text or JSON lines.

    A session is fed the raw bytes of each file between begin() and end(); what comes back is UTF-8 and belongs on
    standard output as it is. Only complete lines are answered; every call releases the GIL.
    """

    def __init__(
        self,
        *,
        lang: str = "zh",
        format: str = "text",
        depth: str = "default",
        stamps: str = "auto",
        time: str | None = None,
        filter: str | None = None,
        extract: bool = False,
    ) -> None:
        """Start a capture.

        lang: zh | en.
        format: text | jsonl (frame, note, finding, transfer) | transfers (JSON lines of transfers only).
        depth: brief | default | explain (text only).
        stamps: auto | absolute | zero | delta.
        time: None (as they came) or one of a d z A n.
        filter: the expression of --filter.
        ValueError (one line, in the session's language) for a value that is none of these or a filter that cannot be
        read.
        """
    def begin(self, name: str, regular: bool) -> None:
        """The next file starts.

        name: for messages and JSON. regular: a whole file (not a pipe): dialects may be decided on its first 64 KiB,
        so output may lag by as much.
        """
    def feed(self, data: bytes) -> bytes:
        """More bytes of the current file, in any chunking; what is known by now, ready for standard output."""
    def end(self, interrupted: bool = False) -> bytes:
        """The current file is over: the rest of its output.

        interrupted: it was the reading that stopped, not the file that ended: a partial line is dropped in silence.
        """
    def finish(self) -> bytes:
        """The capture is over: transfers still open, and what else is said at the end."""
    def complaints(self) -> list[str]:
        """Lines for standard error since the last call (unreadable lines, gaps), each one line, in words."""
    def extracted(self) -> list[tuple[str, bytes, str]]:
        """With extract: (file name, more bytes, status) since the last call.

        status: "" while the transfer runs, else ok | aborted | incomplete | failed once. File names are safe: letters,
        digits, . _ - only.
        """
    @property
    def frames(self) -> int:
        """Frames read so far, over all files."""
    @property
    def file_frames(self) -> int:
        """Frames read so far in the current (or last) file."""

@final
class Rule:
    """One rule of the catalogue."""

    code: str
    name: str
    severity: str
    clause: str
    message: str
    meaning: str
    cause: str

def rules(lang: str = "zh") -> list[Rule]:
    """Every rule, in order of its code, in words of that language."""

def explain(line: str, lang: str = "zh") -> str | None:
    """One frame (candump log or console form, or cansend's ID#DATA) field by field; None when the line is no frame."""
