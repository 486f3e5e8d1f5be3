"""A capture as a timeline in Rerun, out of the core's tables of columns; the only part that imports `rerun` (extra).

No Python object a frame: batches go from the core to Rerun as Arrow columns. Must not: know what a frame means.
"""

from typing import Final

TABLES: Final = ("listing", "lanes", "log", "load", "sync_cycles", "pdo", "problems")
"""Tables of the core that a timeline is made of."""
