"""A capture as a timeline in Rerun, made from the core's tables; the only package that imports `rerun` (an extra).

No Python object is made per frame: batches go from the core to Rerun as Arrow columns. Must not: know the meaning
of a frame.
"""

from typing import Final

TABLES: Final = ("listing", "lanes", "log", "load", "sync_cycles", "pdo", "problems")
"""The core's tables that a timeline needs."""
