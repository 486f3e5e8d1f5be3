"""The diagnosis as one page for a browser: nothing is loaded, everything of a capture is escaped, both languages in it.

The template and what it shows are in `templates`; pictures are made by `diagnosis_chain` and `diagnosis_lanes`. Must
not: judge, or read a capture.
"""

import base64
import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any, Final, NamedTuple

from canalyze.errors import OutputError
from canalyze.output import printable
from canalyze.reports.diagnosis_axis import axis_of
from canalyze.reports.diagnosis_chain import chain
from canalyze.reports.diagnosis_lanes import KINDS, PLOTS, Beside, Lane, lanes, plots, tree_of
from canalyze.reports.diagnosis_text import tree, verdict
from canalyze.values import nanoseconds
from canalyze.words import Words

Record = Mapping[str, Any]
Pair = dict[str, str]
"""The same in both languages."""

MOST: Final = 1_000_000
"""Bytes of a page."""
_TEMPLATES: Final = Path(__file__).with_name("templates")
_STATES: Final = ("open", "unknown", "ended", "harmless")
_DEEPEST: Final = 3


class _Level(NamedTuple):
    """How much a page has."""

    stories: int
    """Stories that are told in full; of further ones only the first line."""
    steps: int
    """Steps of an incident."""
    parts: int
    """Problems of a story."""
    frames: int
    plots: int
    """Values that are drawn of a story."""
    others: int
    """Findings that belong to no incident."""


_LEVELS: Final = (
    _Level(1000, 16, 40, 4000, PLOTS, 200),
    _Level(100, 16, 40, 1500, PLOTS, 100),
    _Level(40, 16, 12, 1000, 3, 50),
    _Level(15, 16, 12, 500, 1, 20),
    _Level(5, 8, 4, 100, 0, 20),
    _Level(0, 0, 1, 0, 0, 0),
)
"""The first that fits counts."""


@dataclass(frozen=True)
class Told:
    """A diagnosis in one language."""

    incidents: Sequence[Record]
    whole: Record
    lines: Mapping[int, str]
    """The annotated frames around the steps, by number: several lines where there are findings."""
    beside: Beside = field(default_factory=Beside)
    """States, values, other findings."""
    every: Mapping[int, str] | None = None
    """The annotated frames, all of them, where they are to be in the page."""


def page(told: Mapping[str, Told], name: str, lang: str) -> bytes:
    """Give the page. told: by language, of the same capture; lang: the one that is shown first.

    OutputError where the library for templates is missing.
    """
    try:
        from jinja2 import Environment, FileSystemLoader, select_autoescape
        from markupsafe import Markup, escape
    except ImportError as error:
        raise OutputError("diagnose.needs_html", error=error) from error

    words = {one: Words(one) for one in told}
    style, script = ((_TEMPLATES / f"diagnosis.{end}").read_text(encoding="utf-8") for end in ("css", "js"))
    environment = Environment(loader=FileSystemLoader(_TEMPLATES), autoescape=select_autoescape(default=True))
    template = environment.get_template("diagnosis.html")
    first = told[lang]
    axis = axis_of(first.incidents, first.whole)
    of_lanes = {one: each.beside.lanes for one, each in told.items()}
    every = {one: escape(_every(each.every)) for one, each in told.items() if each.every is not None}
    most = MOST + sum(len(text.encode("utf-8", "backslashreplace")) for text in every.values())
    made = b""
    for level in _LEVELS:
        made = template.render(
            lang=lang,
            name=printable(name),
            words=words,
            style=Markup(style),
            script=Markup(script),
            style_hash=_hash(style),
            script_hash=_hash(script),
            verdict=_verdict(told, words),
            apart={one: each.whole["loose_text"] for one, each in told.items()},
            extent={one: each.whole["extent"] for one, each in told.items()},
            chain=Markup(chain({one: each.incidents for one, each in told.items()}, first.whole, axis, words)),
            lanes=Markup(lanes(of_lanes, first.incidents, first.whole, axis, words)),
            groups=list(_groups(told, words, level, Markup)),
            nodes=list(_nodes(told, words)),
            others=list(_others(told, level.others)),
            frames=list(_frames(told, level.frames)),
            every=every,
            steps=",".join(str(number) for number in sorted(_step_frames(first))),
        ).encode("utf-8", "backslashreplace")
        if len(made) < most:
            break
    return made


def _hash(text: str) -> str:
    digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
    return f"sha256-{digest}"


def _both(told: Mapping[str, Told], give: Any) -> Pair:
    return {lang: give(lang) for lang in told}


def _verdict(told: Mapping[str, Told], words: Mapping[str, Words]) -> dict[str, Any]:
    said = {lang: verdict(_roots(one), one.whole, words[lang]) for lang, one in told.items()}
    return {"said": {lang: text for lang, (_, text) in said.items()}, "mark": next(iter(said.values()))[0]}


def _roots(told: Told) -> list[Record]:
    by_id = {one["id"]: one for one in told.incidents}
    return [by_id[number] for number in told.whole["order"] if number in by_id]


def _groups(
    told: Mapping[str, Told], words: Mapping[str, Words], level: _Level, markup: Callable[[str], str]
) -> Iterator[dict[str, Any]]:
    by_id = {lang: {one["id"]: one for one in each.incidents} for lang, each in told.items()}
    roots = _roots(next(iter(told.values())))
    full = {one["id"] for one in roots[: level.stories]}
    brief = _LEVELS[-1]
    for status in _STATES:
        stories = [one for one in roots if one["status"] == status]
        if not stories:
            continue
        yield {
            "status": status,
            "heading": _both(told, lambda lang, status=status: words[lang].of("problem_heading", status)),
            "problems": [
                {
                    **_story(one, by_id, words, next(iter(told.values())).whole, level if one["id"] in full else brief),
                    "plots": markup(_plots(told, one, level.plots)) if one["id"] in full else "",
                }
                for one in stories
            ],
        }


def _plots(told: Mapping[str, Told], root: Record, most: int) -> str:
    first = next(iter(told.values()))
    values = {lang: one.beside.plots.get(root["id"], [])[:most] for lang, one in told.items()}
    story = tree_of(root, {one["id"]: one for one in first.incidents})
    return plots(values, story, nanoseconds(first.whole["begin"]) or 0)


def _story(
    root: Record,
    by_id: Mapping[str, Mapping[int, Record]],
    words: Mapping[str, Words],
    whole: Record,
    level: _Level,
) -> dict[str, Any]:
    first = next(iter(by_id.values()))
    return {
        "id": root["id"],
        "status": root["status"],
        "title": _message(root["id"], by_id),
        "parts": [
            _part(one, min(depth, _DEEPEST), by_id, words, (level.steps, whole))
            for depth, one in islice(tree(root, first), level.parts)
        ],
    }


def _message(number: int, by_id: Mapping[str, Mapping[int, Record]]) -> Pair:
    return {lang: printable(incidents[number]["message"]) for lang, incidents in by_id.items()}


def _part(
    one: Record,
    depth: int,
    by_id: Mapping[str, Mapping[int, Record]],
    words: Mapping[str, Words],
    shown: tuple[int, Record],
) -> dict[str, Any]:
    number, (steps, whole) = one["id"], shown
    caused = one["cause"] is not None
    return {
        "id": number,
        "depth": depth,
        "status": one["status"],
        "title": _message(number, by_id),
        "standing": {lang: words[lang].of("problem_status", one["status"]) for lang in by_id},
        "because": {lang: each[number]["texts"]["because"] for lang, each in by_id.items()} if caused else None,
        "checks": [
            {lang: incidents[number]["checks_left"][place] for lang, incidents in by_id.items()}
            for place in range(len(one["checks_left"]) if steps else 0)
        ],
        "apart": [
            {
                "told": one["apart"][place]["told"],
                "text": {
                    lang: printable(incidents[number]["apart"][place]["text"]) for lang, incidents in by_id.items()
                },
            }
            for place in range(len(one["apart"]) if steps else 0)
        ],
        "steps": [
            {
                "t": _since(step["t"], whole),
                "frame": step["frame"],
                "role": {lang: words[lang].of("problem_role", step["role"]) for lang in by_id},
                "text": {
                    lang: printable(incidents[number]["steps"][place]["text"]) for lang, incidents in by_id.items()
                },
            }
            for place, step in enumerate(one["steps"][:steps])
        ],
        "findings": ", ".join(
            f"{entry['code']} #{entry['about_frame']}" if entry["about_frame"] is not None else entry["code"]
            for entry in one["findings"][:steps]
        ),
    }


def _since(t: str | None, whole: Record) -> str:
    """Give a time from the begin of the capture."""
    t_ns, begin = nanoseconds(t), nanoseconds(whole["begin"])
    return "" if t_ns is None or begin is None else f"{(t_ns - begin) / 1e9:.3f} s"


def _nodes(told: Mapping[str, Told], words: Mapping[str, Words]) -> Iterator[dict[str, Any]]:
    first = next(iter(told.values()))
    by_id = {one["id"]: one for one in first.incidents}
    last = {lang: {(lane.kind, lane.key, lane.axis): lane for lane in one.beside.lanes} for lang, one in told.items()}
    for node in first.whole["nodes"]:
        found = by_id.get(node["problem"])
        key = "diagnose.html_ok" if found is None else "diagnose.html_see"
        mine = [lane for lane in last[next(iter(told))] if lane[1] == (node["bus"], node["node"])]
        yield {
            "name": f"{printable(node['bus'] or '')} {node['node']}".strip(),
            "status": "ended" if found is None else found["status"],
            "problem": None if found is None else found["id"],
            "said": {lang: words[lang](key, number=node["problem"]) for lang in told},
            "states": [
                {lang: f"{words[lang](KINDS[name[0]])}: {_last_state(last[lang][name]) or '-'}" for lang in told}
                for name in sorted(mine, key=lambda name: (name[0] != "nmt", name[2]))
            ],
        }


def _last_state(lane: Lane) -> str:
    return printable(lane.changes[-1][1] or "") if lane.changes else ""


def _others(told: Mapping[str, Told], most: int) -> Iterator[dict[str, Any]]:
    """Give the findings that belong to no incident, the most severe first."""
    grades = ("error", "warning", "info")
    same = list(zip(*(one.beside.others for one in told.values()), strict=True))
    same.sort(key=lambda one: grades.index(one[0].severity) if one[0].severity in grades else len(grades))
    for one in same[:most]:
        first = one[0]
        yield {
            "code": first.code,
            "severity": first.severity,
            "frame": first.frame,
            "count": first.count,
            "text": {lang: printable(each.message) for lang, each in zip(told, one, strict=True)},
        }


def _step_frames(told: Told) -> set[int]:
    return {step["frame"] for one in told.incidents for step in (one["begin"], *one["steps"])}


def _frames(told: Mapping[str, Told], most: int) -> Iterator[dict[str, Any]]:
    first = next(iter(told.values()))
    steps = _step_frames(first)
    for number in sorted(first.lines)[:most]:
        text = {lang: _lines(one.lines.get(number, "")) for lang, one in told.items()}
        yield {"number": number, "step": number in steps, "text": text}


def _lines(text: str) -> str:
    """Give the lines of a frame, each without what could break it."""
    return "\n".join(printable(line) for line in text.split("\n"))


def _every(lines: Mapping[int, str]) -> str:
    """Give all lines as the script reads them: the number, a tab, the line; without a number what follows a frame."""
    parts = []
    for number in sorted(lines):
        first, *more = lines[number].split("\n")
        parts.append(f"{number}\t{printable(first)}")
        parts += [f"\t{printable(line)}" for line in more if line]
    return "\n".join(parts)
