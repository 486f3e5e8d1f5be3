"""canalyze: a passive CANopen analyzer.

Public names only; what is not in `__all__` may change without notice. Importing this loads nothing else: a name is
imported when it is first asked for, so that the command can answer Ctrl-C from its first moment on.
"""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from canalyze._core import Batch
    from canalyze.errors import CanalyzeError, ConfigError, CoreError, OutputError, ReaderGone, SourceError
    from canalyze.library import Options, open
    from canalyze.library.capture import Capture, Series, Signals
    from canalyze.library.columns import Column, Table, column_tables, columns
    from canalyze.library.rows import Events, Findings, Frames, Nodes, Problems, Transfers
    from canalyze.library.stream import Bus, Listener, live
    from canalyze.library.whole import (
        Diagnosis,
        Diff,
        Inventory,
        Summary,
        convert,
        diagnose,
        diff,
        explain,
        od,
        rules,
        summary,
    )
    from canalyze.records.frames import Event, Frame, Note, Signal
    from canalyze.records.objects import Abort, Hole, Transfer
    from canalyze.records.problems import Cause, Finding, Line, Moment, Problem, ProblemChange, Step
    from canalyze.records.summary import Aborts, Emcy, Node, Spread, StateChange
    from canalyze.values import ObjectRef

__version__ = "0.1.0"
_FROM = {
    "_core": "Batch",
    "errors": "CanalyzeError ConfigError CoreError OutputError ReaderGone SourceError",
    "library": "Options open",
    "library.capture": "Capture Series Signals",
    "library.columns": "Column Table column_tables columns",
    "records.frames": "Event Frame Note Signal",
    "records.objects": "Abort Hole Transfer",
    "records.problems": "Cause Finding Line Moment Problem ProblemChange Step",
    "records.summary": "Aborts Emcy Node Spread StateChange",
    "library.rows": "Events Findings Frames Nodes Problems Transfers",
    "library.stream": "Bus Listener live",
    "library.whole": "Diagnosis Diff Inventory Summary convert diagnose diff explain od rules summary",
    "values": "ObjectRef",
}
"""The public names of each module."""
__all__ = ["Abort", "Aborts", "Batch", "Bus", "CanalyzeError", "Capture", "Cause", "Column", "ConfigError"]
__all__ += ["CoreError", "Diagnosis", "Diff", "Emcy", "Event", "Events", "Finding", "Findings", "Frame", "Frames"]
__all__ += ["Hole", "Inventory", "Line", "Listener", "Moment", "Node", "Nodes", "Note", "ObjectRef", "Options"]
__all__ += ["OutputError", "Problem", "ProblemChange", "Problems", "ReaderGone", "Series", "Signal", "Signals"]
__all__ += ["SourceError", "Spread", "StateChange", "Step", "Summary", "Table", "Transfer", "Transfers"]
__all__ += ["__version__", "column_tables", "columns", "convert", "diagnose", "diff", "explain", "live", "od", "open"]
__all__ += ["rules", "summary"]


_FORMER = {"Incident": "Problem", "IncidentChange": "ProblemChange", "Incidents": "Problems"}
"""Former names, which are still accepted for a release."""


def __getattr__(name: str) -> object:
    if name in _FORMER:
        import warnings

        warnings.warn(f"canalyze.{name} is called {_FORMER[name]} now", DeprecationWarning, stacklevel=2)
        name = _FORMER[name]
    module = next((module for module, names in _FROM.items() if name in names.split()), None)
    if module is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    value: object = getattr(importlib.import_module(f"{__name__}.{module}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
