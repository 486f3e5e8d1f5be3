"""Checks if the viewer of a timeline can draw Chinese, for which a window uses the fonts of the system.

Must not: start a viewer, or draw.
"""

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Final

_FOLDERS: Final = ("/usr/share/fonts", "/usr/local/share/fonts", "~/.fonts", "~/.local/share/fonts")
_LETTERS: Final = frozenset({".ttf", ".ttc", ".otf"})
_WAIT_S: Final = 10.0


def has_chinese(*, web: bool) -> bool:
    """Returns true if Chinese can be drawn, or if that is unknown.

    web: in a browser page, which has only its own fonts.
    """
    if web:
        return False
    if not sys.platform.startswith("linux"):
        return True
    program = shutil.which("fc-list")
    if program is None:
        # Without fontconfig: no font at all is no Chinese one.
        return any(_any_font(Path(folder).expanduser()) for folder in _FOLDERS)
    try:
        line = [program, ":lang=zh", "file"]
        found = subprocess.run(line, stdin=subprocess.DEVNULL, capture_output=True, timeout=_WAIT_S, check=False)
    except (OSError, subprocess.SubprocessError):
        return True
    return found.returncode != 0 or bool(found.stdout.strip())


def _any_font(folder: Path) -> bool:
    try:
        return any(one.suffix.lower() in _LETTERS for one in folder.rglob("*"))
    except OSError:
        return False
