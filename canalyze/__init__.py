"""canalyze: a passive CANopen analyzer.

Public names only; what is not in `__all__` may change without notice. Importing this loads neither the compiled core
nor click.
"""

from canalyze.errors import CanalyzeError, ConfigError, CoreError, OutputError, ReaderGone, SourceError

__version__ = "0.1.0"
__all__ = ["CanalyzeError", "ConfigError", "CoreError", "OutputError", "ReaderGone", "SourceError", "__version__"]
