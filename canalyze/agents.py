"""Tools for agents: captures of one folder, read-only, with bounded answers; `commands/mcp.py` serves them.

A truncated answer ends in a note, and an error is one line. Names must be within the folder: `..`, absolute names
and links out of it are refused. Must not: write, or print.
"""

import json
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePath
from typing import Any, Final

import canalyze
from canalyze.configuration.network import description
from canalyze.errors import CanalyzeError, SourceError, reason
from canalyze.output import json_text, printable
from canalyze.sources.names import below
from canalyze.words import Words

LINES: Final = 200
"""Maximum number of lines of an answer."""
BYTES: Final = 24_000
"""Maximum size of an answer, without the note that it is truncated."""
_LAST: Final = 4_294_967_295
"""A frame number beyond every capture."""
_LEFT_OUT: Final = frozenset({"kind", "data", "reordered", "retransmissions", "crc_negotiated"})
"""Keys of a transfer that are left out."""
_TEXT: Final = {"type": "string"}
_PARAMETERS: Final[dict[str, dict[str, Any]]] = {
    **dict.fromkeys(("capture", "filter", "select", "what"), _TEXT),
    "first": {"type": "integer", "minimum": 1, "maximum": _LAST},
    "last": {"type": "integer", "minimum": 1, "maximum": _LAST},
    "at": {"type": "number", "minimum": 0},
    "eds": {"type": "array", "items": _TEXT},
}
TOOLS: Final = {
    "captures": (),
    "diagnose": ("capture", "eds"),
    "decode": ("capture", "first", "last", "filter", "eds"),
    "explain": ("what", "eds"),
    "sdo": ("capture", "filter", "eds"),
    "od": ("capture", "filter", "at", "eds"),
    "signals": ("capture", "select", "eds"),
}
"""The tools and their parameters."""
_REQUIRED: Final = {"capture", "what"}


class Folder:
    """The tools on the files of a folder; each returns the lines of its answer."""

    def __init__(self, folder: str, words: Words) -> None:
        """Opens the folder. Raises SourceError if there is none."""
        self._words = words
        self._lang: Any = words.lang
        self._root = Path(folder).resolve()
        if not self._root.is_dir():
            raise SourceError("mcp.no_folder", name=folder)

    def captures(self) -> Iterator[str]:
        """Yields the captures and device descriptions, by their names, with their sizes."""
        described = (path for end in ("dcf", "eds", "xdd") for path in sorted(self._root.rglob(f"*.{end}")))
        for path in (*map(Path, below(str(self._root))), *described):
            if path.is_file() and path.resolve().is_relative_to(self._root):
                yield f"{path.relative_to(self._root).as_posix()}  {path.stat().st_size}"

    def diagnose(self, capture: str, **options: Any) -> Iterator[str]:
        """Yields the report, and the complaints about the file."""
        opened = self._opened(capture, **options)
        yield from str(canalyze.diagnose(opened)).splitlines()
        yield from opened.complaints

    def decode(self, capture: str, first: int = 1, last: int = _LAST, **options: Any) -> list[str]:
        """Returns annotated lines, each with the number of its frame."""
        expression = f"{options.pop('filter', '')} frame={first}-{max(first, last)}".strip()
        opened = self._opened(capture, filter=expression, **options)
        return opened.through("text", limit=LINES + 1, numbered=True)[1].decode("utf-8", "replace").splitlines()

    def explain(self, what: str, eds: Iterable[str] = ()) -> list[str]:
        """Returns the meaning of a frame, a code, an object or a term."""
        return canalyze.explain(what, eds=self._described(eds), lang=self._lang, folder=self._root).splitlines()

    def sdo(self, capture: str, **options: Any) -> Iterator[str]:
        """Yields transfers, a JSON object each, without their bytes."""
        for line in self._opened(capture, **options).through("transfers")[1].splitlines():
            row = json.loads(line)
            kept = {key: value for key, value in row.items() if key not in _LEFT_OUT and value not in (None, [])}
            yield json_text(kept, compact=True)

    def od(self, capture: str, at: float | None = None, **options: Any) -> list[str]:
        """Returns the objects of the devices."""
        return str(canalyze.od(self._opened(capture, **options), at=at)).splitlines()

    def signals(self, capture: str, select: str | None = None, **options: Any) -> Iterable[str]:
        """Returns a line for each signal, or for each value of one."""
        signals = self._opened(capture, **options).signals
        if select is not None:
            return (f"{row.frame}  {row.t or '-'}  {row.text or row.value}" for row in signals[select])
        return (repr(signals[name])[len("<Series ") : -1] for name in signals.names)

    def _opened(self, capture: str, eds: Iterable[str] = (), **options: Any) -> canalyze.Capture:
        described = self._described(eds)
        return canalyze.open(self._inside(capture), eds=described, lang=self._lang, folder=self._root, **options)

    def _described(self, eds: Iterable[str]) -> list[str]:
        """Returns the descriptions as given; each must be a file in the folder."""
        given = list(eds)
        for one in filter(None, map(description, given)):
            self._inside(one.file)
        return given

    def _inside(self, name: str) -> str:
        """Returns a name. Raises SourceError if it is no file in the folder."""
        path = PurePath(name)
        try:
            real = (self._root / path).resolve()
            inside = real.is_relative_to(self._root) and not path.is_absolute() and ".." not in path.parts
            if not inside or not real.is_file():
                raise SourceError("mcp.no_file" if inside else "mcp.outside", name=name)
        except (OSError, ValueError, RuntimeError) as error:  # too long, NUL, links in a circle
            raise SourceError("mcp.no_file", name=name) from error
        return name

    def answer(self, tool: str, arguments: dict[str, Any]) -> tuple[str, bool]:
        """Returns the text of an answer, and true if it is an error, in one line."""
        import jsonschema

        try:
            if tool not in TOOLS:
                raise ValueError(self._words("mcp.no_tool", name=tool, tools=", ".join(TOOLS)))
            jsonschema.validate(arguments, schema(tool, self._words))
            return self._bounded(getattr(self, tool)(**arguments)), False
        except jsonschema.ValidationError as error:
            said = f"{'.'.join(map(str, error.absolute_path))}: {error.message}".removeprefix(": ")
        except CanalyzeError as error:
            said = error.in_words(self._words)
        except OSError as error:
            said = reason(error, self._words)
        except (KeyError, TypeError, ValueError) as error:
            said = str(error.args[0])
        return printable(" ".join(said.split()))[:1000], True

    def _bounded(self, lines: Iterable[str]) -> str:
        kept: list[str] = []
        left = BYTES
        for line in map(printable, lines):
            left -= len(line.encode("utf-8")) + 1
            if len(kept) == LINES or left < 0:
                return "\n".join([*(kept or [line[: BYTES // 4]]), self._words("mcp.cut", lines=len(kept))])
            kept.append(line)
        return "\n".join(kept or [self._words("mcp.nothing")])


def schema(tool: str, words: Words) -> dict[str, Any]:
    """Returns the JSON schema of the parameters of a tool."""
    named = {name: {**_PARAMETERS[name], "description": words(f"mcp.{name}")} for name in TOOLS[tool]}
    required = [name for name in named if name in _REQUIRED]
    return {"type": "object", "properties": named, "required": required, "additionalProperties": False}
