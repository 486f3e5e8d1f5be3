"""The name of a file as a URI reference: relative to where we are if it is below, percent-encoded, with slashes.

Must not: look at a file system.
"""

import os
from pathlib import PurePath, PurePosixPath, PureWindowsPath
from urllib.parse import quote


def file_uri(file: str, *, windows: bool = os.name == "nt", here: str | None = None) -> str:
    """Returns the URI of a name as it was given; `here` is the working directory, an absolute path.

    A relative name stays relative. Bytes of a POSIX name that are no UTF-8 are encoded as they are.
    """
    path: PurePath = PureWindowsPath(file) if windows else PurePosixPath(file)
    root = here and (PureWindowsPath(here) if windows else PurePosixPath(here))
    if root and path.is_absolute() and path.is_relative_to(root) and path != root:
        path = path.relative_to(root)
    text = path.as_posix()
    if not path.is_absolute():
        if path.drive:  # C:part of a directory of its own on that drive
            return f"file:///{_encoded(text)}"
        return _encoded(text)
    if path.drive.startswith("\\\\"):
        return f"file:{_encoded(text)}"
    if path.drive:
        return f"file:///{text[0]}:{_encoded(text[2:])}"
    return f"file://{_encoded('/' + text.lstrip('/'))}"


def _encoded(text: str) -> str:
    try:
        return quote(text.encode("utf-8", "surrogateescape"))
    except UnicodeEncodeError:  # half a character, which only Windows lets into a name
        return quote(text.encode("utf-8", "surrogatepass"))
