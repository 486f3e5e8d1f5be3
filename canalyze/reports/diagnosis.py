"""The problems that are asked for, by node, bus and time, and the report of `diagnose` for people about them.

The verdict, the stories in the order in which they matter, the nodes: an ordinary capture takes at most 30 lines.
Where there is more, the least important is left out, and the last line says how to see it. Must not: judge, or read a
capture.
"""

import re
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final, NamedTuple

from msgspec.structs import replace

from canalyze.errors import SourceError
from canalyze.output import Output, dyed, printable
from canalyze.output.layout import pad, width, wrap
from canalyze.records.problems import Overview, Problem, Step
from canalyze.reports import wording
from canalyze.words import Words

LINES: Final = 30
"""Most lines of a report that does not show everything."""
_EFFECTS: Final = 4
"""Consequences that are shown of one story."""
_NODES: Final = 12
"""Nodes that are named."""
_COLUMN: Final = 100
"""The column of the numbers of frames."""
_NARROW: Final = 20
"""Columns that a text has, however narrow the terminal is."""
_AROUND: Final = 2
"""Frames that are shown before and behind a step."""
_FRAMES: Final = 8
"""Frames that are named of one rule."""
_STATES: Final = ("open", "unknown", "ended", "harmless")
_COLOURS: Final = {"open": "error", "unknown": "warning", "ended": "clean", "harmless": "quiet", "unjudged": "warning"}
"""By status."""


class Chosen(NamedTuple):
    """The problems that are asked for; a field that is None does not matter."""

    node: int | None
    bus: str | None
    since: float | None


def show(
    incidents: Sequence[Problem],
    whole: Overview,
    out: Output,
    words: Words,
    names: Sequence[str],
    *,
    everything: bool,
    chosen: Chosen,
) -> None:
    """Writes the report. incidents: those that are asked for, by `chosen`; names: the files, to be typed again."""
    by_id = {one.id: one for one in incidents}
    roots = [by_id[number] for number in whole.order if number in by_id]
    told = roots if everything else [one for one in roots if one.status != "harmless"]
    worst, said = verdict(roots, whole.nature, words)
    lines = [f"{said}{_only(chosen, words)}   {whole.extent}"]
    loose = [whole.loose_text] if whole.loose_text and chosen == Chosen(None, None, None) else []
    if not told:
        lines += [whole.notice] if whole.notice else [line for line in (whole.looked, whole.well) if line]
        lines += [*loose, *_nodes(whole, by_id, words, chosen)]
        hidden = len(roots)
    else:
        lines += [whole.notice] if whole.notice else []
        nodes = _nodes(whole, by_id, words, chosen)
        alike = _alike(told) if not everything else {}
        stories, hidden = _stories(
            [one for one in told if one.id not in alike],
            alike,
            by_id,
            words,
            LINES - len(lines) - len(loose) - len(nodes) - 1 if not everything else None,
        )
        lines += [*stories, *loose, *nodes]
    lines.append(_more(told, names, hidden, words))
    headings = {words.of("problem_heading", status): colour for status, colour in _COLOURS.items()}
    headings[lines[0]] = _COLOURS[worst]
    room = shutil.get_terminal_size().columns if out.is_terminal else None
    for line in lines:
        for piece in [line] if room is None else _fitted(line, room):
            out.text((dyed(piece, headings[line], out=out) if line in headings else piece) + "\n")


class Diagnosed(NamedTuple):
    """A recording and its problems."""

    names: tuple[str, ...]
    incidents: Sequence[Problem]
    order: Sequence[int]
    nature: str

    @property
    def roots(self) -> list[Problem]:
        """The problems that come from no other, most important first."""
        by_id = {one.id: one for one in self.incidents}
        return [by_id[number] for number in self.order if number in by_id]


def of_buses(incidents: Iterable[Problem]) -> list[Problem]:
    """Returns the incidents, each with its bus before its sentence if there are several."""
    return [replace(one, message=one.texts.title) for one in incidents]


def verdict(roots: Sequence[Problem], nature: str, words: Words) -> tuple[str, str]:
    """Returns the status of the worst of these problems, and the words of the verdict about them."""
    from canalyze._core import verdict

    return verdict(words.lang, nature, [sum(one.status == status for one in roots) for status in _STATES])


def show_each(
    rows: Sequence[Diagnosed], out: Output, words: Words, chosen: Chosen, *, unread: int, totals: bool = False
) -> None:
    """Writes a line for each recording, the worst first. unread: how many could not be read; totals: no such lines."""
    states = (*_STATES[:2], "unjudged", "ended")
    found = [(*verdict(row.roots, row.nature, words), row) for row in rows]

    def rank(one: tuple[str, str, Diagnosed]) -> tuple[int, int, int]:
        worst, _, row = one
        open_ones = sum(one.status == "open" for one in row.roots)
        told = sum(one.status != "harmless" for one in row.roots)
        return states.index(worst), -open_ones, -told

    cells = []
    for worst, said, row in [] if totals else sorted(found, key=rank):
        first, *further = (printable(name) for name in row.names)
        name = f"{first} ... {further[-1]} ({len(row.names)})" if further else first
        headline = next((printable(one.message) for one in row.roots if one.status != "harmless"), "")
        cells.append((worst, said, name, headline))
    wide, named = (max((width(cell[place]) for cell in cells), default=0) for place in (1, 2))
    room = shutil.get_terminal_size().columns if out.is_terminal else None
    for worst, said, name, headline in cells:
        line = f"{pad(said, wide)}  {pad(name, named)}  {headline}".rstrip()
        for piece in [line] if room is None else _fitted(line, room):
            out.text(dyed(piece, _COLOURS[worst], out=out) + "\n")
    counts = {state: sum(worst == state for worst, *_ in found) for state in states}
    parts = [words(f"diagnose_each.{state}", count=count) for state, count in counts.items() if count]
    parts += [words("diagnose_each.unread", count=unread)] if unread else []
    only = _only(chosen, words)
    total = words("diagnose.each", count=len(rows) + unread, said=words("check.then").join(parts))
    out.text(f"{total}{only}\n")


def further_of_each(rows: Sequence[Diagnosed], out: Output, words: Words) -> None:
    """Writes the commands to type next."""
    if rows:
        first = next((row for row in rows if verdict(row.roots, row.nature, words)[0] == "open"), rows[0])
        files = " ".join(map(wording.capture_name, first.names))
        out.text(words("diagnose.more", said=f"canalyze {files} · --join") + "\n")


def tell(
    story: int,
    incidents: Sequence[Problem],
    whole: Overview,
    lines: Mapping[int, str],
    out: Output,
    words: Words,
    names: Sequence[str],
) -> None:
    """Writes one story in full. lines: the annotated frames around its steps, by their number; names: the files."""
    from canalyze._core import rules

    by_id = {one.id: one for one in incidents}
    messages = {rule.code: rule.message for rule in rules(words.lang)}
    shown = set[int]()
    story_lines: list[str] = []
    for depth, one in tree(by_id[story], by_id):
        indent = "   " * depth
        told = [*_head(one, depth, words), *_steps(one, whole, lines, shown, words)]
        told += _advice(one, words)
        told += _findings(one, messages, words)
        story_lines += [indent + line for line in told]
        if not depth and any(effect in by_id and not by_id[effect].is_root for effect in one.effects):
            story_lines.append(words("diagnose.consequences"))
    story_lines.append(_further(by_id[story], names, words))
    for place, line in enumerate(story_lines):
        own = not place or line.lstrip().startswith("> #")
        out.text((dyed(line.rstrip(), "own", out=out) if own else line.rstrip()) + "\n")


def _head(one: Problem, depth: int, words: Words) -> list[str]:
    """Returns the lines about its kind, its status and its cause."""
    standing = words.of("problem_status", one.status)
    impact = words.of("problem_impact", one.impact)
    grade = words.of("problem_grade", one.grade)
    lines = [
        f"{'→ ' if depth else ''}{one.id}  {printable(one.message)}  [{standing}]",
        "   " + words("diagnose.meaning", impact=impact, grade=grade),
    ]
    texts = one.texts
    lines += [f"   {texts.repeats}"] if texts.repeats else []
    if texts.because:
        why = words("diagnose.between").join(filter(None, (texts.why, texts.delay)))
        lines += [f"   {texts.because}", "   " + words("diagnose.why", said=why)]
    return lines


def _steps(one: Problem, whole: Overview, lines: Mapping[int, str], shown: set[int], words: Words) -> list[str]:
    """Returns the steps, with the annotated frames around them; a frame is shown once."""
    found: list[str] = []
    steps = one.steps or (Step(one.begin.frame, one.begin.t, "sign", one.message, None),)
    for step in steps:
        role = words.of("problem_role", step.role)
        at = _seconds(step.t, whole, words)
        found.append(f"   {at} #{step.frame} {role}: {printable(step.text)}".replace("    #", "   #"))
        for frame in range(step.frame - _AROUND, step.frame + _AROUND + 1):
            if frame not in lines or frame in shown:
                continue
            shown.add(frame)
            mark = ">" if frame == step.frame else " "
            first, *notes = lines[frame].split("\n")
            found.append(f"     {mark} #{frame} {printable(first)}")
            found += [f"            {printable(note)}" for note in notes if note]
    return found


def _advice(one: Problem, words: Words) -> list[str]:
    """Returns the signs that distinguish causes, and the checks to begin with."""
    lines = []
    if one.apart:
        lines.append("   " + words("diagnose.apart"))
        lines += [f"     {'+' if tell.told else '?'} {printable(tell.text)}" for tell in one.apart]
    if one.checks_left:
        lines.append("   " + words("diagnose.html_check") + words("diagnose.colon"))
        lines += [f"     {place}. {printable(text)}" for place, text in enumerate(one.checks_left, 1)]
    return lines


def _findings(one: Problem, rules: Mapping[str, str], words: Words) -> list[str]:
    """Returns the findings in it, those of one rule in a line."""
    frames: dict[str, list[int]] = {}
    for entry in one.cited:
        frames.setdefault(entry.code, []).extend([entry.about_frame] if entry.about_frame else [])
    lines = [] if not frames else ["   " + words("diagnose.found")]
    for code, numbers in frames.items():
        at = ", ".join(f"#{number}" for number in sorted(numbers)[:_FRAMES])
        more = " …" if len(numbers) > _FRAMES else ""
        lines.append(f"     {f'{code} {at}'.rstrip()}{more}  {rules.get(code, '')}")
    return lines


def _further(one: Problem, names: Sequence[str], words: Words) -> str:
    """Returns the commands to type next."""
    file = wording.capture_name(names[0]) if len(names) == 1 else "FILE"
    commands = [f"canalyze explain {one.kind}", f"canalyze decode {file} --frame {_around(one.begin.frame)}"]
    if one.cause is not None:
        commands.insert(0, f"canalyze {file} -n {one.cause.id}")
    return str(words("diagnose.more", said=" · ".join(commands)))


def stories(roots: Sequence[Problem], incidents: Sequence[Problem], words: Words) -> list[str]:
    """Returns the lines of some stories as the report has them, each with its consequences and what to check first."""
    by_id = {one.id: one for one in incidents}
    return [line for one in roots for line in _story(one, by_id, words, _EFFECTS, checks=True)]


def tree(one: Problem, by_id: Mapping[int, Problem], depth: int = 0) -> Iterator[tuple[int, Problem]]:
    """Returns an incident and its consequences, each with the number of causes between."""
    yield depth, one
    for effect in one.effects:
        if effect in by_id and not by_id[effect].is_root:
            yield from tree(by_id[effect], by_id, depth + 1)


def root(one: Problem, by_id: Mapping[int, Problem]) -> Problem:
    """Returns the incident from which this one comes."""
    for _ in by_id:
        if one.is_root or one.cause is None or one.cause.id not in by_id:
            break
        one = by_id[one.cause.id]
    return one


def near(incidents: Iterable[Problem]) -> set[int]:
    """Returns the numbers of the frames around each step."""
    steps = {frame for one in incidents for frame in (one.begin.frame, *(step.frame for step in one.steps))}
    return {frame + place for frame in steps for place in range(-_AROUND, _AROUND + 1)}


def _only(chosen: Chosen, words: Words) -> str:
    """Returns the part of the capture that the verdict is about, empty if that is all."""
    node, bus, since = chosen
    parts = [] if node is None else [words("reports.node", node=node)]
    if bus is not None:
        parts.append(words("diagnose.only_bus", bus=printable(bus)))
    if since is not None:
        parts.append(words("diagnose.only_since", seconds=f"{since:g}"))
    return words("diagnose.only", said=words("reports.list").join(parts)) if parts else ""


def _stories(
    roots: Sequence[Problem], alike: Mapping[int, int], by_id: Mapping[int, Problem], words: Words, room: int | None
) -> tuple[list[str], int]:
    """Returns the lines of the stories, and how many stories are left out. room: lines that there are for them."""
    for effects, checks in ((_EFFECTS, True), (2, True), (2, False), (1, False), (0, False)):
        blocks = [_story(one, by_id, words, effects, checks=checks or one.status == "open") for one in roots]
        for one, block in zip(roots, blocks, strict=True):
            if more := sum(first == one.id for first in alike.values()):
                block.insert(1, f"     {words('diagnose.alike', count=more)}")
        headings = len({one.status for one in roots})
        if room is None or sum(map(len, blocks)) + headings <= room:
            break
    lines, left, heading = list[str](), 0, ""
    for one, block in zip(roots, blocks, strict=True):
        fresh = [words.of("problem_heading", one.status)] if one.status != heading else []
        if room is not None and len(lines) + len(fresh) + len(block) > room:
            left += 1
            continue
        heading = one.status
        lines += [*fresh, *block]
    return lines, left


def _alike(roots: Sequence[Problem]) -> dict[int, int]:
    """Returns the stories that repeat an earlier one, of the same kind, subject and status, with that."""
    first: dict[tuple[object, ...], int] = {}
    alike = {}
    for one in roots:
        key = (one.kind, one.subject, one.status)
        if key in first:
            alike[one.id] = first[key]
        first.setdefault(key, one.id)
    return alike


def _story(one: Problem, by_id: Mapping[int, Problem], words: Words, effects: int, *, checks: bool) -> list[str]:
    below = [entry for entry in tree(one, by_id) if entry[0]]
    # Whose consequences have no line of their own: their numbers are missing below.
    untold = f" → {words('diagnose.more_effects', count=len(below))}" if below and not effects else ""
    lines = [_placed(f" {one.id:>2}  {printable(one.message)}{untold}", one.begin.frame)]
    for depth, effect in below[:effects]:
        grade = words.of("problem_grade", effect.cause.grade if effect.cause else "")
        lines.append(
            _placed(
                f"     {'  ' * (depth - 1)}→ {effect.id}  {printable(effect.message)}{effect.texts.after}  {grade}",
                effect.begin.frame,
            )
        )
    if len(below) > effects and effects:
        lines.append(f"     → {words('diagnose.more_effects', count=len(below) - effects)}")
    if effects >= _EFFECTS - 2 and not below:
        lines += [
            _placed(f"     → {printable(step.text)}", step.frame)
            for step in one.steps
            if step.role in ("reaction", "attempt", "recovery")
        ][:2]
    if checks and one.checks and one.status != "harmless":
        said = words("diagnose.between").join(one.checks[:3])
        lines.append(f"     {words('diagnose.check_first', said=said)}")
    return lines


def _fitted(line: str, columns: int) -> list[str]:
    """Returns a line as a narrow terminal has room for it: no word is broken, the frame's number is at its edge."""
    if (placed := re.fullmatch(r"( *)(\S.*?)  +(#[0-9]+)", line)) is None:
        indent, text, frame = line[: len(line) - len(line.lstrip())], line.lstrip(), ""
    else:
        indent, text, frame = placed.groups()
    if width(line) <= columns:
        return [line]
    room = max(columns - len(indent) - len(frame) - 4, _NARROW)
    pieces: list[str] = []
    for part in text.split("  "):  # how certain a cause is stands in one piece behind two blanks
        if pieces and width(pieces[-1]) + 2 + width(part) <= room:
            pieces[-1] += f"  {part}"
        else:
            pieces += wrap(part, room)
    if " · " in text:  # commands are not parted, nor others that have room
        pieces = [""]
        for part in text.split(" · "):
            if pieces[-1] and width(pieces[-1]) + 3 + width(part) > room:
                pieces.append("")
            pieces[-1] += f" · {part}" if pieces[-1] else part
        pieces = [part for piece in pieces for part in ([piece] if "canalyze " in piece else wrap(piece, room))]
    hanging = indent + "   "
    found = [(hanging if number else indent) + piece for number, piece in enumerate(pieces)]
    if frame:
        found[-1] = f"{pad(found[-1], columns - len(frame) - 1)} {frame}"
    return found


def _placed(line: str, number: int) -> str:
    frame = f"#{number}"
    return f"{pad(line, _COLUMN)} {frame}" if width(line) < _COLUMN else f"{line}  {frame}"


def _seconds(t: str | None, whole: Overview, words: Words) -> str:
    if t is None or whole.begin is None:
        return ""
    return str(words("diagnose.seconds", seconds=f"{float(t) - float(whole.begin):.3f}"))


def _nodes(whole: Overview, by_id: Mapping[int, Problem], words: Words, chosen: Chosen) -> list[str]:
    if whole.nature != "canopen":  # nothing shows that these are nodes
        return []
    # What is not asked for is not said to be well.
    nodes = [
        node
        for node in whole.nodes
        if chosen.node in (None, node.node)
        and chosen.bus in (None, node.bus)
        and (node.problem is None or node.problem in by_id)
    ]
    # Where there is no room for all, those with problems come first.
    chosen_nodes = sorted(nodes, key=lambda node: node.problem is None)[:_NODES] if len(nodes) > _NODES else nodes
    cells = [node.cells for node in chosen_nodes]
    wide = [max(map(width, column)) for column in zip(*cells, strict=True)]
    lines = [
        "  ".join(
            pad(cell, most, right=not place) for place, (cell, most) in enumerate(zip(row, wide, strict=True)) if most
        ).rstrip()
        for row in cells
    ]
    if len(nodes) > _NODES:
        lines.append(words("diagnose.node_more", count=len(nodes) - _NODES))
    return [words("diagnose.heading_nodes"), *(f"  {line}" for line in lines)] if lines else []


def _more(told: Sequence[Problem], names: Sequence[str], hidden: int, words: Words) -> str:
    """Returns the commands to type next."""
    file = wording.capture_name(names[0]) if len(names) == 1 else "FILE"
    commands = []
    if told:
        first = told[0]
        commands = [f"canalyze {file} -n {first.id}", f"canalyze decode {file} --frame {_around(first.begin.frame)}"]
    else:
        commands = [f"canalyze summary {file}", f"canalyze decode {file}"]
    if hidden:
        commands.insert(1, f"canalyze {file} --all")
    return words("diagnose.more", said=" · ".join(commands))


def _around(frame: int) -> str:
    return f"{max(frame - 5, 1)}-{frame + 5}"


FAIL_ON: Final = {"open": ("open",), "unknown": ("open", "unknown"), "ended": ("open", "unknown", "ended")}
"""Statuses of problems that make the command fail, by --fail-on."""


def fails(shown: Iterable[Problem], fail_on: str | None) -> bool:
    """Returns true if a problem is there that --fail-on is about."""
    failing = FAIL_ON.get(fail_on or "", ())
    return any(one.status in failing and one.is_root for one in shown)


def check_places(chosen: Chosen, incidents: list[Problem], whole: Overview, words: Words) -> None:
    """Raises where the bus or the node that is asked for is not in the capture."""
    places = {(one.bus, one.node) for one in whole.nodes}
    places |= {(one.bus, number) for one in incidents for number in _concerned(one)}
    buses = sorted({bus for bus in (*whole.buses, *(one.bus for one in incidents)) if bus})
    if chosen.bus is not None and chosen.bus not in buses:
        key = "diagnose.no_bus" if buses else "diagnose.no_buses"
        raise SourceError(key, bus=chosen.bus or '""', buses=words("reports.list").join(buses))
    nodes = {node for bus, node in places if chosen.bus in (None, bus)}
    if chosen.node is not None and chosen.node not in nodes:
        if not nodes:
            raise SourceError("diagnose.no_nodes", node=chosen.node)
        key = "diagnose.no_node" if chosen.bus is None else "diagnose.no_node_on"
        raise SourceError(key, node=chosen.node, bus=chosen.bus, nodes=wording.ranges(nodes, ", "))


def _concerned(one: Problem) -> tuple[int, ...]:
    """Returns the nodes of a problem."""
    return one.nodes if one.node is None else (one.node, *one.nodes)


def select(incidents: list[Problem], whole: Overview | None, chosen: Chosen) -> list[Problem]:
    """Returns the problems that are asked for, each with its causes and consequences."""
    node, bus, since = chosen
    begin = float((whole and whole.begin) or 0)
    by_id = {one.id: one for one in incidents}

    def fits(one: Problem) -> bool:
        late = since is None or one.end is None or one.end.t is None or float(one.end.t) - begin >= since
        about = node is None or node in _concerned(one)
        return late and about and (bus is None or one.bus == bus)

    roots = {root(one, by_id).id for one in incidents if fits(one)}
    return [one for one in incidents if root(one, by_id).id in roots]
