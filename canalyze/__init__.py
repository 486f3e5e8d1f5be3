"""canalyze: a passive CANopen analyzer.

Public names only; what is not in `__all__` may change without notice. Importing this loads nothing else: a name is
imported when it is first asked for, so that the command can answer Ctrl-C from its first moment on.
"""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from canalyze.errors import CanalyzeError, ConfigError, CoreError, OutputError, ReaderGone, SourceError

__version__ = "0.1.0"
__all__ = ["CanalyzeError", "ConfigError", "CoreError", "OutputError", "ReaderGone", "SourceError", "__version__"]


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from canalyze import errors

    value: object = getattr(errors, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
