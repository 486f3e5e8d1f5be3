"""The diagnosis as one page for a browser: nothing is loaded, everything of a capture is escaped, both languages in it.

The template and what it shows are in `templates`; the picture is made by `diagnosis_chain`. Must not: judge, or read a
capture.
"""

import base64
import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from canalyze.errors import OutputError
from canalyze.output import printable
from canalyze.reports.diagnosis_chain import chain
from canalyze.reports.diagnosis_text import extent, verdict
from canalyze.words import LANGUAGES, Words

Record = Mapping[str, Any]
Pair = dict[str, str]
"""The same in both languages."""

MOST: Final = 1_000_000
"""Bytes of a page."""
_TEMPLATES: Final = Path(__file__).with_name("templates")
_STATES: Final = ("stands", "unknown", "over", "harmless")
_DEEPEST: Final = 3
_LEVELS: Final = ((16, 40, 4000), (8, 12, 1500), (4, 4, 500), (1, 1, 100), (0, 1, 0))
"""Steps of an incident, incidents of a story and frames that a page has: the first that fits counts."""


@dataclass(frozen=True)
class Told:
    """A diagnosis in one language."""

    incidents: Sequence[Record]
    whole: Record
    lines: Mapping[int, str]
    """The annotated frames around the steps, by number."""


def page(told: Mapping[str, Told], name: str, lang: str) -> bytes:
    """Give the page. told: by language, of the same capture; lang: the one that is shown first.

    OutputError where the library for templates is missing.
    """
    try:
        from jinja2 import Environment, FileSystemLoader, select_autoescape
        from markupsafe import Markup
    except ImportError as error:
        raise OutputError("diagnose.needs_html", error=error) from error

    words = {one: Words(one) for one in LANGUAGES}
    style, script = ((_TEMPLATES / f"diagnosis.{end}").read_text(encoding="utf-8") for end in ("css", "js"))
    environment = Environment(loader=FileSystemLoader(_TEMPLATES), autoescape=select_autoescape(default=True))
    template = environment.get_template("diagnosis.html")
    first = told[lang]
    made = b""
    for steps, parts, frames in _LEVELS:
        made = template.render(
            lang=lang,
            name=printable(name),
            words=words,
            style=Markup(style),
            script=Markup(script),
            style_hash=_hash(style),
            script_hash=_hash(script),
            verdict=_verdict(told, words),
            extent=extent(first.whole, words[lang]),
            chain=Markup(chain(first.incidents, first.whole, *_names(words[lang]))),
            groups=list(_groups(told, words, steps, parts)),
            nodes=list(_nodes(told, words)),
            frames=list(_frames(told, frames)),
        ).encode("utf-8", "backslashreplace")
        if len(made) < MOST:
            break
    return made


def _hash(text: str) -> str:
    digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
    return f"sha256-{digest}"


def _names(words: Words) -> tuple[str, str]:
    return words("diagnose.html_bus"), words("diagnose.html_node")


def _both(told: Mapping[str, Told], give: Any) -> Pair:
    return {lang: give(lang) for lang in told}


def _verdict(told: Mapping[str, Told], words: Mapping[str, Words]) -> dict[str, Any]:
    said = {lang: verdict(_roots(one), words[lang]) for lang, one in told.items()}
    first = next(iter(told.values()))
    states = {one["status"] for one in _roots(first)}
    mark = next((state for state in _STATES[:2] if state in states), "over")
    return {"said": said, "mark": mark}


def _roots(told: Told) -> list[Record]:
    by_id = {one["id"]: one for one in told.incidents}
    return [by_id[number] for number in told.whole["order"] if number in by_id]


def _groups(told: Mapping[str, Told], words: Mapping[str, Words], steps: int, parts: int) -> Iterator[dict[str, Any]]:
    by_id = {lang: {one["id"]: one for one in each.incidents} for lang, each in told.items()}
    roots = _roots(next(iter(told.values())))
    for status in _STATES:
        stories = [one for one in roots if one["status"] == status]
        if not stories:
            continue
        yield {
            "status": status,
            "heading": _both(told, lambda lang, status=status: words[lang].of("incident_heading", status)),
            "stories": [_story(one, by_id, words, steps, parts) for one in stories],
        }


def _story(
    root: Record, by_id: Mapping[str, Mapping[int, Record]], words: Mapping[str, Words], steps: int, parts: int
) -> dict[str, Any]:
    first = next(iter(by_id.values()))
    tree = list(_tree(root, first, 0))[:parts]
    return {
        "id": root["id"],
        "status": root["status"],
        "title": _message(root["id"], by_id),
        "parts": [_part(one, depth, by_id, words, steps) for depth, one in tree],
    }


def _tree(one: Record, by_id: Mapping[int, Record], depth: int) -> Iterator[tuple[int, Record]]:
    yield min(depth, _DEEPEST), one
    for effect in one["effects"]:
        if effect in by_id and not by_id[effect]["root"]:
            yield from _tree(by_id[effect], by_id, depth + 1)


def _message(number: int, by_id: Mapping[str, Mapping[int, Record]]) -> Pair:
    return {lang: printable(incidents[number]["message"]) for lang, incidents in by_id.items()}


def _part(
    one: Record, depth: int, by_id: Mapping[str, Mapping[int, Record]], words: Mapping[str, Words], steps: int
) -> dict[str, Any]:
    number = one["id"]
    because: Pair | None = None
    if one["cause"] is not None:
        because = {}
        for lang, incidents in by_id.items():
            cause = incidents[one["cause"]["id"]]
            grade = words[lang].of("incident_grade", one["cause"]["grade"])
            title = printable(cause["message"])
            because[lang] = words[lang]("diagnose.because", number=cause["id"], title=title, grade=grade)
    return {
        "depth": depth,
        "status": one["status"],
        "title": _message(number, by_id),
        "standing": {lang: words[lang].of("incident_status", one["status"]) for lang in by_id},
        "because": because,
        "checks": [
            {lang: incidents[number]["checks_text"][place] for lang, incidents in by_id.items()}
            for place in range(len(one["checks_text"]) if steps else 0)
        ],
        "steps": [
            {
                "t": step["t"] or "",
                "frame": step["frame"],
                "role": {lang: words[lang].of("incident_role", step["role"]) for lang in by_id},
                "text": {
                    lang: printable(incidents[number]["steps"][place]["text"]) for lang, incidents in by_id.items()
                },
            }
            for place, step in enumerate(one["steps"][:steps])
        ],
        "findings": ", ".join(f"{entry['code']} #{entry['frame']}" for entry in one["findings"][:steps]),
    }


def _nodes(told: Mapping[str, Told], words: Mapping[str, Words]) -> Iterator[dict[str, Any]]:
    first = next(iter(told.values()))
    by_id = {one["id"]: one for one in first.incidents}
    for node in first.whole["nodes"]:
        found = by_id.get(node["incident"])
        key = "diagnose.html_ok" if found is None else "diagnose.html_see"
        yield {
            "name": f"{printable(node['bus'] or '')} {node['node']}".strip(),
            "status": "over" if found is None else found["status"],
            "said": {lang: words[lang](key, number=node["incident"]) for lang in told},
        }


def _frames(told: Mapping[str, Told], most: int) -> Iterator[dict[str, Any]]:
    first = next(iter(told.values()))
    steps = {step["frame"] for one in first.incidents for step in one["steps"]}
    for number in sorted(first.lines)[:most]:
        text = {lang: printable(one.lines.get(number, "")) for lang, one in told.items()}
        yield {"number": number, "step": number in steps, "text": text}
