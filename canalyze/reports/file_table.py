"""Files that SDO transfers have moved, for people: one a line, with what it is, its size and its check sums."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

from canalyze.output import Output
from canalyze.reports.table import EMPTY, Column, Row, Table
from canalyze.words import Words

_COLUMNS: Final = ("file", "size", "contents", "crc", "software", "outcome")


def show(files: Sequence[Mapping[str, Any]], out: Output, words: Words) -> None:
    """Writes them."""
    names = {key: words(f"col.{key}" if key in ("size", "outcome") else f"contents.{key}") for key in _COLUMNS}
    rows = [_row(file, words) for file in files]
    kept = [place for place, _ in enumerate(_COLUMNS) if any(row[place] for row in rows)]
    table = Table(
        [Column(names[_COLUMNS[place]], folds=_COLUMNS[place] == "contents") for place in kept], out, live=False
    )
    table.add([Row([row[place] or EMPTY for place in kept], number) for number, row in enumerate(rows)])
    table.close()


def _row(file: Mapping[str, Any], words: Words) -> list[str]:
    found, damage = file["contents"], file["damage"]
    said = words(f"contents.{found['kind']}", **found) if found else ""
    if damage:
        said += "; " + words("contents_damage.damaged", problem=words(f"contents_damage.{damage['kind']}", **damage))
    size = str(file["size"])
    if file["size_indicated"] not in (None, file["size"]):
        size = words("contents.of", size=size, indicated=file["size_indicated"])
    crc = "" if file["crc"] is None else file["crc"] + "h" + ("" if file["crc_ok"] else f" {words('contents.wrong')}")
    software = "" if file["software"] is None else f"{file['software']:08X}h"
    return [file["file"], size, said, crc, software, words.of("status", file["status"])]
