"""Former names of the library, which are still accepted for a release; each use warns.

Those of classes stand in `canalyze/__init__.py`.
"""

import warnings
from typing import Any, Final

TABLES: Final = {"incidents": "problems"}
"""Former names of tables of columns, each with that of today."""


def renamed(name: str, today: str) -> property:
    """Returns an attribute by its former name, with a warning."""

    def get(self: Any) -> Any:
        warn(name, today)
        return getattr(self, today)

    return property(get, doc=f"Deprecated: the former name of `{today}`.")


def table(name: str) -> str:
    """Returns the present name of a table."""
    if name in TABLES:
        warn(name, TABLES[name])
    return TABLES.get(name, name)


def warn(name: str, today: str) -> None:
    """Warns about the use of a former name."""
    warnings.warn(f"{name} is called {today} now", DeprecationWarning, stacklevel=3)
