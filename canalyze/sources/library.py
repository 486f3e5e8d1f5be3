"""python-can, imported with no more than what is read needs.

That library looks for asammdf when it is imported, which is there for MF4 alone and takes four times as long as all the
rest. So it does not find it until an MF4 file comes. Must not: read or write anything.
"""

import importlib
import importlib.util
import sys
from types import ModuleType
from typing import Final

_MF4: Final = "can.io.mf4"
_ASAMMDF: Final = "asammdf"


def library(*, mf4: bool = False) -> ModuleType:
    """Give python-can, its reader and writer of MF4 only if asked for; ImportError if asammdf is not there then."""
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
    """Whether asammdf is installed."""
    return importlib.util.find_spec(_ASAMMDF) is not None


def _without_asammdf() -> ModuleType:
    if "can" not in sys.modules and _ASAMMDF not in sys.modules:
        sys.modules[_ASAMMDF] = None  # type: ignore[assignment]  # as the import system has it: this cannot be imported
        try:
            return importlib.import_module("can")
        finally:
            del sys.modules[_ASAMMDF]
    return importlib.import_module("can")
