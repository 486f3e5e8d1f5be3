"""canalyze: a passive CANopen analyzer.

Public names only; what is not in `__all__` may change without notice. Importing this loads nothing else: a name is
imported when it is first asked for, so that the command can answer Ctrl-C from its first moment on.
"""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from canalyze._core import Batch, Table
    from canalyze.errors import CanalyzeError, ConfigError, CoreError, OutputError, ReaderGone, SourceError
    from canalyze.finding import Finding, Line
    from canalyze.incident import Cause, Incident, Moment, Step
    from canalyze.library import Options, open
    from canalyze.library.capture import Capture
    from canalyze.library.event import Abort, Event, Frame, Hole, Note, Transfer
    from canalyze.library.incident import Incidents
    from canalyze.library.node import Aborts, Emcy, Node, Nodes, Spread, StateChange
    from canalyze.library.rows import Findings, Transfers
    from canalyze.library.series import Series, Signal, Signals

__version__ = "0.1.0"
_FROM = {
    "_core": ("Batch", "Table"),
    "library.capture": ("Capture",),
    "errors": ("CanalyzeError", "ConfigError", "CoreError", "OutputError", "ReaderGone", "SourceError"),
    "library.event": ("Abort", "Event", "Frame", "Hole", "Note", "Transfer"),
    "finding": ("Finding", "Line"),
    "library": ("Options", "open"),
    "incident": ("Cause", "Incident", "Moment", "Step"),
    "library.incident": ("Incidents",),
    "library.node": ("Aborts", "Emcy", "Node", "Nodes", "Spread", "StateChange"),
    "library.rows": ("Findings", "Transfers"),
    "library.series": ("Series", "Signal", "Signals"),
}
__all__ = [
    "Abort",
    "Aborts",
    "Batch",
    "CanalyzeError",
    "Capture",
    "Cause",
    "ConfigError",
    "CoreError",
    "Emcy",
    "Event",
    "Finding",
    "Findings",
    "Frame",
    "Hole",
    "Incident",
    "Incidents",
    "Line",
    "Moment",
    "Node",
    "Nodes",
    "Note",
    "Options",
    "OutputError",
    "ReaderGone",
    "Series",
    "Signal",
    "Signals",
    "SourceError",
    "Spread",
    "StateChange",
    "Step",
    "Table",
    "Transfer",
    "Transfers",
    "__version__",
    "open",
]


def __getattr__(name: str) -> object:
    module = next((module for module, names in _FROM.items() if name in names), None)
    if module is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    value: object = getattr(importlib.import_module(f"{__name__}.{module}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
