"""What a sample of a kind of incident is: traffic with a fault, and the same without it.

Why it exists: samples stand in several files by what they are about, and one table holds them all. What it must not
do: make a frame.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from captures import SAMPLES, log_text, read_log
from network import Frames, find

Node = int | tuple[int, ...] | None
"""A node; several; None: the bus or the capture."""


@dataclass(frozen=True, slots=True)
class Sample:
    """A capture in which a kind of incident is told, and its clean neighbour."""

    make: Callable[[bool], Frames | bytes]
    """The traffic; True: with the fault."""
    node: Node
    status: str
    begin: tuple[int, int] | None = None
    """The frame by which it begins: the n-th on a CAN-ID, from 0 or from the end; None: not looked at."""
    described: Path | None = None
    """The sample beside which the descriptions of its nodes lie."""
    defect: str = ""
    """What is known to be wrong in what is told."""

    def text(self, faulty: bool) -> bytes:
        """The capture in candump's log form."""
        made = self.make(faulty)
        return made if isinstance(made, bytes) else log_text(made)

    def begin_frame(self) -> int | None:
        """The number of the frame by which it begins."""
        return None if self.begin is None else find(read_log(self.text(True)), *self.begin) + 1


def of_rule(name: str, node: Node, status: str, *, described: bool = False) -> Sample:
    """The sample of a rule by itself, and its clean neighbour."""
    path = SAMPLES / "rules" / f"{name}.log"
    clean = path.with_name(f"{name.split('-')[0]}.clean.log")
    own = path.with_name(f"{name}.clean.log")
    neighbour = own if own.is_file() else clean
    return Sample(
        lambda faulty: (path if faulty else neighbour).read_bytes(), node, status, described=path if described else None
    )
