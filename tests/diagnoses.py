"""What is diagnosed of a capture, as the core says it.

Why it exists: several tests ask for incidents. What it must not do: judge them.
"""

from __future__ import annotations

import json
from dataclasses import dataclass

from captures import Row, session_output

from canalyze import _core

ABOVE_HARMLESS = frozenset({"open", "unknown", "ended"})


@dataclass(frozen=True)
class Diagnosed:
    """The incidents of a capture, and what stands behind them."""

    incidents: list[Row]
    whole: Row

    @property
    def roots(self) -> list[Row]:
        """What nothing else has caused and is more than harmless."""
        return [one for one in self.incidents if one["root"] and one["status"] in ABOVE_HARMLESS]

    @property
    def said(self) -> list[str]:
        """The same in one line each, for messages."""
        return [f"{one['problem']} {one['status']} #{one['begin']['frame']} {one['message']}" for one in self.roots]


def diagnosed(text: bytes, network: _core.Network | None = None, lang: str = "en") -> Diagnosed:
    """Diagnose a capture in candump's log form."""
    output = session_output([text], output_format="diagnosis", lang=lang, network=network)
    rows: list[Row] = [json.loads(line) for line in output.decode().splitlines()]
    return Diagnosed([row for row in rows if row["kind"] == "problem"], rows[-1])
