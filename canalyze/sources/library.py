"""Imports python-can without asammdf, unless MF4 is read or written.

python-can imports asammdf if it is installed, which takes four times as long as everything else and is needed for
MF4 alone; so it is hidden until then. Must not: read or write anything.
"""

import importlib
import importlib.util
import sys
from types import ModuleType
from typing import Final

_MF4: Final = "can.io.mf4"
_ASAMMDF: Final = "asammdf"


def library(*, mf4: bool = False) -> ModuleType:
    """Returns the module `can`. With `mf4` its MF4 classes work; raises ImportError if asammdf is not installed."""
    if not mf4:
        return _without_asammdf()
    import can

    importlib.import_module(_ASAMMDF)  # after python-can: it may import that, which then would miss it
    module = importlib.import_module(_MF4)
    if module.asammdf is None:  # python-can was imported without it
        module = importlib.reload(module)
        for name in ("MF4Reader", "MF4Writer"):
            setattr(can, name, getattr(module, name))
    return can


def has_asammdf() -> bool:
    """Returns true if asammdf is installed."""
    return importlib.util.find_spec(_ASAMMDF) is not None


def _without_asammdf() -> ModuleType:
    if "can" not in sys.modules and _ASAMMDF not in sys.modules:
        sys.modules[_ASAMMDF] = None  # type: ignore[assignment]  # as the import system has it: this cannot be imported
        try:
            return importlib.import_module("can")
        finally:
            del sys.modules[_ASAMMDF]
    return importlib.import_module("can")
