"""A sample of every kind of incident, and its clean neighbour.

Why it exists: a kind is told where it happens, and is not told where it nearly does. What it must not do: make frames.
"""

from __future__ import annotations

from typing import Final

import kinds_of_control
import kinds_of_data
import kinds_of_drives
import kinds_of_nodes
from kind_row import Sample
from kinds_further import FURTHER, Further

__all__ = ["FURTHER", "TABLE", "Further"]

TABLE: Final[dict[str, Sample]] = {
    **kinds_of_nodes.SAMPLES,
    **kinds_of_data.SAMPLES,
    **kinds_of_drives.SAMPLES,
    **kinds_of_control.SAMPLES,
}
"""By the name of the kind."""
