"""The views of nodes, objects, SDO transfers, findings and problems: from a snapshot of the core to rows.

Nodes have their name, state, heartbeat and its period, EMCY, drive, rate and problem; objects are one line per COB-ID,
updated in place, with their last data. Running transfers come with their progress before the ended ones, newest first;
findings are newest first, too. Problems are in the order of `diagnose`: the most important first, each cause above its
effects; open ones show their duration so far, harmless ones are folded to one row. A finding or a problem leads to its
frame. Must not: judge, or sort again.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from canalyze.monitor.grid import (
    BLANK,
    NOTHING,
    Cell,
    Column,
    Row,
    bar,
    cell,
    leads,
    period,
    rate,
    seconds,
    size,
    texts,
)
from canalyze.records.live import Done, Emergency, Node, NodeProblem, Object, Problem, Running, Snapshot
from canalyze.words import Words

STATES: Final = {"05": "good", "7F": "warning", "04": "warning", "00": "info"}
"""Styles of the states, by the byte of the heartbeat: operational, pre-operational, stopped, booted up."""
_SECOND: Final = 1_000_000_000
_LATE: Final = 1.5
"""Number of periods without a heartbeat after which its age is highlighted; a missing one is `silent`."""


def node_columns(words: Words, *, buses: bool) -> list[Column]:
    """Returns the columns; that of the bus only with several buses."""
    given = [
        Column(words("col.node"), right=True),
        Column(words("col.name"), least=6, most=28, leaves=3),
        Column(words("col.node_state"), most=25),
        Column(words("col.heartbeat"), most=14),
        Column("EMCY", least=20, most=48),
        Column(words("monitor.drive"), least=10, most=30, leaves=2),
        Column(words("col.boot_ups"), most=8, right=True, leaves=5),
        Column(words("col.rate"), most=8, right=True, leaves=4),
        Column(words("col.findings"), least=16),
    ]
    return [Column(words("col.bus"), most=10), *given] if buses else given


def node_rows(snapshot: Snapshot, words: Words, *, buses: bool, away: frozenset[str] = frozenset()) -> list[Row]:
    """Returns one row per node; away: lost buses, whose nodes have an unknown state."""
    return [_node(node, snapshot, words, buses=buses, away=node.bus in away) for node in snapshot.nodes]


def node_subject(node: Node) -> tuple[str, ...]:
    """Returns the subject of the page of a node."""
    return "node", node.bus, str(node.node)


def _node(node: Node, snapshot: Snapshot, words: Words, *, buses: bool, away: bool) -> Row:
    state, look = node.state_text or BLANK, STATES.get(node.state or "", "dim")
    unknown = (away or node.unknown) and not node.silent
    last = words("monitor.last_state", state=state)
    if unknown:
        state, look = words("monitor.unknown"), "warning"
    elif _is_late(node):
        look = "dim"
    silent = words.of("monitor_silent", node.silent) if node.silent else ""
    trouble = of_node(node)
    cells = [
        cell(node.node, "strong"),
        cell(node.name),
        cell(silent or state, "error" if silent else look),
        _heartbeat(node, unknown=unknown),
        _emcy(node.emcy, words),
        cell(node.drive),
        cell(node.boot_ups or BLANK, "" if node.boot_ups else "dim"),
        cell(rate(node.frames_per_s)),
        cell(trouble, "error") if trouble else tally(node.findings),
    ]
    key = (node.bus, node.node)
    whole = texts(
        [
            words("monitor.node", node=node.node),
            node.name,
            trouble,
            silent,
            state if unknown else "",
            last if silent or unknown else state,
            _emcy_text(node.emcy, words),
            _emcy_since(node.emcy, snapshot.start_ns),
            node.drive,
        ]
    )
    where = leads(node.bus if buses else "", node=node.node)
    return Row(key, (cell(node.bus), *cells) if buses else tuple(cells), whole, leads=where, about=node_subject(node))


def _is_late(node: Node) -> bool:
    age, period = node.heartbeat_age_ns, node.heartbeat_period_ns
    return bool(period and age is not None and age > period * _LATE)


def _heartbeat(node: Node, *, unknown: bool) -> Cell:
    """Returns the age of the last heartbeat and its period; unknown: it may have been missed."""
    age, period = node.heartbeat_age_ns, node.heartbeat_period_ns
    if age is None:
        return cell(BLANK, "dim")
    if not period:
        return cell(f"{seconds(age)}s")
    digits = 1 if period >= _SECOND else 2
    look = "dim" if unknown else "error" if node.silent else "warning" if _is_late(node) else "good"
    return ((seconds(age, digits), look), (f"/{seconds(period, digits)}s", "dim"))


def _emcy(emcy: Emergency | None, words: Words) -> Cell:
    return cell(_emcy_text(emcy, words), "error" if emcy and emcy.active else "dim")


def _emcy_text(emcy: Emergency | None, words: Words) -> str:
    """Returns the last emergency, the number of further active ones, and its end."""
    if emcy is None:
        return ""
    text = f"{emcy.code}h {emcy.text}".rstrip()
    if not emcy.active:
        return words("monitor.emcy_over", text=text)
    return f"{text} (+{emcy.active - 1})" if emcy.active > 1 else text


def _emcy_since(emcy: Emergency | None, start_ns: int | None) -> str:
    """Returns the time of an emergency, as in the trace."""
    if emcy is None or emcy.t_ns is None or start_ns is None:
        return ""
    return f"@ {seconds(emcy.t_ns - start_ns, 3)}s"


def tally(found: Mapping[str, int]) -> Cell:
    """Returns the numbers of findings by severity, without zeros."""
    pieces: list[tuple[str, str]] = []
    for severity, mark in (("error", "✖"), ("warning", "▲")):
        if found.get(severity):
            pieces.append((f"{' ' if pieces else ''}{mark}{found[severity]}", severity))
    return tuple(pieces)


_STALE: Final = 3
"""Number of periods after which a periodic object is old."""
_LEAST_NS: Final = 200_000_000
"""Minimum age of an old object, for short periods."""
_SPACED: Final = 110
"""Minimum columns of the terminal for blanks between the bytes of the data."""


def object_columns(words: Words, *, buses: bool, width: int) -> list[Column]:
    """Returns the columns; that of the bus only with several buses."""
    given = [
        Column("ID"),
        Column(words("monitor.object"), least=7, most=24),
        Column(words("col.count"), most=9, right=True, leaves=4),
        Column(words("col.period"), most=12, right=True, leaves=2),
        Column(words("monitor.jitter"), most=8, right=True, leaves=3),
        Column(words("col.rate"), most=8, right=True, leaves=5),
        Column(words("monitor.data"), least=16, most=16 if width < _SPACED else 48),
        Column(words("col.meaning"), least=24, most=400),
    ]
    return [Column(words("col.bus"), most=10), *given] if buses else given


def object_rows(snapshot: Snapshot, words: Words, *, buses: bool, width: int) -> list[Row]:
    """Returns one row per object."""
    now = snapshot.now_ns
    return [_object(one, now, words, buses=buses, spaced=width >= _SPACED) for one in snapshot.objects]


def _object(one: Object, now: int | None, words: Words, *, buses: bool, spaced: bool) -> Row:
    name = _name(one, words)
    age = _age(one, now)
    ago = "" if age is None else words("monitor.ago", age=period(age))
    fresh = "" if age is None else "dim"
    cells = (
        cell(one.id, fresh or "strong"),
        cell(name, fresh),
        cell(one.count, fresh),
        cell(ago, "warning") if ago else cell(period(one.period_ns)),
        cell(period(one.jitter_ns), "dim"),
        cell(rate(one.rate), fresh),
        cell(_closer(one.data, " " if spaced else ""), fresh)
        if ago
        else _data(one.data, one.changed, " " if spaced else ""),
        cell(_meaning(one), one.severity if one.severity in ("error", "warning") else fresh),
    )
    key = (one.bus, one.id, one.rtr)
    whole = texts([one.id, name, ago, one.data, one.text])
    where = leads(one.bus if buses else "", id=one.id)
    return Row(key, (cell(one.bus), *cells) if buses else cells, whole, leads=where)


def _age(one: Object, now: int | None) -> int | None:
    """Returns the age of the last frame if a periodic object has stopped, or else None."""
    last, usual, jitter = one.last_ns, one.period_ns, one.jitter_ns
    if now is None or last is None or usual is None or jitter is None or jitter > usual // 2:
        return None
    age = now - last
    return age if age > max(_STALE * usual, _LEAST_NS) else None


def _closer(data: str, gap: str) -> str:
    return gap.join(data[place : place + 2].upper() for place in range(0, len(data), 2))


def _name(one: Object, words: Words) -> str:
    """Returns the name of an object: the PDO or the service, with its node if it has one."""
    name = one.name or one.service
    return name if one.node is None else words("monitor.of_node", node=one.node, name=name)


def _meaning(one: Object) -> str:
    """Returns the meaning of its last frame, without a name that is shown already."""
    head, colon, rest = one.text.partition(": ")
    return rest if colon and rest and one.name and one.name in head else one.text


def _data(data: str, changed: str, gap: str) -> Cell:
    """Returns the bytes, with the changed ones highlighted."""
    pieces: list[tuple[str, str]] = []
    for place in range(0, len(data), 2):
        look = "changed" if changed[place : place + 2].upper() == "FF" else ""
        text = data[place : place + 2].upper() + (gap if place + 2 < len(data) else "")
        if pieces and pieces[-1][1] == look:
            pieces[-1] = (pieces[-1][0] + text, look)
        else:
            pieces.append((text, look))
    return tuple(pieces)


_BAR: Final = 10
_OUTCOMES: Final = {"ok": "good", "aborted": "error", "failed": "error", "incomplete": "warning"}


def transfer_columns(words: Words, *, buses: bool) -> list[Column]:
    """Returns the columns; that of the bus only with several buses."""
    given = [
        Column(words("col.time"), most=10, right=True, leaves=3),
        Column(words("col.node"), right=True),
        Column(words("col.read_write")),
        Column(words("col.object")),
        Column(words("col.name"), least=8, most=40, leaves=1),
        Column(words("col.mode"), most=10, leaves=4),
        Column(words("col.size"), most=12, right=True),
        Column(words("col.duration"), most=8, right=True, leaves=2),
        Column(words("col.outcome"), least=24, most=60),
    ]
    return [Column(words("col.bus"), most=10), *given] if buses else given


def transfer_rows(snapshot: Snapshot, words: Words, *, buses: bool) -> list[Row]:
    """Returns the running transfers, then the ended ones, newest first."""
    start = snapshot.start_ns
    found = snapshot.transfers
    running = [_running(one, snapshot, words, buses=buses) for one in found.running]
    done = [_done(one, start, words, buses=buses) for one in reversed(found.done)]
    return running + done


def _running(one: Running, snapshot: Snapshot, words: Words, *, buses: bool) -> Row:
    start, now, since = snapshot.start_ns, snapshot.now_ns, one.since_ns
    cells = (
        *_transfer(one, since, start, words),
        cell(_progress(one), "info"),
        cell(period(None if since is None or now is None else max(0, now - since))),
        _bar(one, words),
    )
    key = ("runs", one.bus, one.node, one.direction, one.index, one.sub)
    whole = texts([one.object, one.name, _progress(one)])
    where = leads(one.bus if buses else "", service="sdo", node=one.node)
    return Row(key, (cell(one.bus), *cells) if buses else cells, whole, leads=where)


def _transfer(one: Running | Done, at: int | None, start: int | None, words: Words) -> Iterator[Cell]:
    """Yields the cells that running and ended transfers have in common."""
    yield _since(at, start)
    yield cell(one.node, "strong")
    yield cell(words.of("access", one.direction))
    yield cell(one.object)
    yield cell(one.name)
    yield cell(words.of("mode", one.mode))


def _since(at: int | None, start: int | None) -> Cell:
    return cell(seconds(None if at is None or start is None else at - start, 3), "dim")


def _progress(one: Running) -> str:
    return size(one.bytes) if one.size is None else f"{size(one.bytes)}/{size(one.size)}"


def _bar(one: Running, words: Words) -> Cell:
    if not one.size:
        return cell(words("monitor.runs"), "info")
    part = one.bytes / one.size
    return ((f"{min(part, 1.0):4.0%} ", ""), (bar(part, _BAR), "info"))


def _done(one: Done, start: int | None, words: Words, *, buses: bool) -> Row:
    status = words.of("status", one.status)
    abort = one.abort
    outcome = texts([status, f"{abort.digits}h", abort.text] if abort else [status, one.text])
    cells = (
        *_transfer(one, one.t_ns, start, words),
        cell(size(one.size)),
        cell(period(one.duration_ns)),
        cell(outcome, _OUTCOMES.get(one.status, "")),
    )
    return Row(
        ("ended", one.number, one.last_frame),
        (cell(one.bus), *cells) if buses else cells,
        texts([one.object, one.name, outcome]),
        leads=one.first_frame,
    )


LEVELS: Final = ("info", "warning", "error")
"""Severities, from the least on."""
MARKS: Final = {"error": "✖", "warning": "▲", "info": "i"}
"""Of severities."""


def finding_columns(words: Words, *, buses: bool, least: str = LEVELS[0]) -> list[Column]:
    """Returns the columns; that of the bus only with several buses. least: the least severity shown."""
    heading = words("monitor.finding")
    if least != LEVELS[0]:
        heading += f"  {words.of('monitor_severity', least)}"
    given = [
        Column(words("col.time"), most=12, right=True, leaves=2),
        Column(words("monitor.frame"), right=True, leaves=1),
        Column(words("monitor.rule")),
        Column(words("col.node"), right=True),
        Column(heading, least=30, most=400),
    ]
    return [given[0], Column(words("col.bus"), most=10), *given[1:]] if buses else given


def finding_rows(snapshot: Snapshot, *, buses: bool, least: str = LEVELS[0]) -> list[Row]:
    """Returns one row per finding of at least this severity."""
    start = snapshot.start_ns
    found = []
    for place, one in enumerate(snapshot.findings):
        if one.severity not in LEVELS[LEVELS.index(least) :]:
            continue
        look = one.severity
        cells = [
            _since(one.t_ns, start),
            cell(one.frame),
            cell(one.code, look),
            cell("" if one.node is None else one.node),
            cell(one.text, look if look == "error" else ""),
        ]
        if one.count > 1:
            cells[4] = (*cells[4], (f" x{one.count}", "strong"))
        if buses:
            cells.insert(1, cell(one.bus))
        key = (one.frame, one.code, one.t_ns, one.node, place if one.frame is None else 0)
        about = ("finding", one.code, one.text)
        found.append(Row(key, tuple(cells), texts([one.code, one.text]), leads=one.frame, about=about))
    found.reverse()
    return found


def latest(snapshot: Snapshot) -> Cell:
    """Returns the last error or warning in a line, or else the last info; nothing without findings."""
    found = snapshot.findings
    if not found:
        return NOTHING
    one = next((one for one in reversed(found) if one.severity in ("error", "warning")), found[-1])
    start, look = snapshot.start_ns, one.severity
    at = "" if one.t_ns is None or start is None else f"{seconds(one.t_ns - start, 3)}  "
    return ((f" {MARKS.get(look, '')} ", look), (at, "dim"), (f"{one.code}  ", look), (one.text, ""))


FOLD: Final = "harmless"
"""The key of the row for the folded harmless problems."""
_STATUSES: Final = {"open": "error", "unknown": "warning", "ended": "good", "harmless": "dim"}
_OPEN: Final = ("open", "unknown")
"""Not ended, as far as is known."""
_LOUD: Final = ("A", "B")
"""Something has stopped, or does not start."""


def problem_columns(words: Words, *, buses: bool) -> list[Column]:
    """Returns the columns; that of the bus only with several buses."""
    given = [
        Column(words("monitor.number"), right=True),
        Column(words("col.state"), least=6, most=12),
        Column(words("monitor.lasts"), most=9, right=True, leaves=2),
        Column(words("monitor.frame"), right=True, leaves=1),
        Column(words("monitor.problem"), least=30, most=400),
    ]
    return [given[0], Column(words("col.bus"), most=10), *given[1:]] if buses else given


def problem_rows(snapshot: Snapshot, words: Words, *, buses: bool, unfolded: bool) -> list[Row]:
    """Returns one row per problem; unfolded: including the harmless ones."""
    found = snapshot.problems
    harmless = _harmless(found)
    shown = [_problem(one, snapshot, words, buses=buses) for one in found if unfolded or one.id not in harmless]
    if not harmless:
        return shown
    place = next(place for place, one in enumerate(found) if one.id in harmless)
    key = "monitor.hide_harmless" if unfolded else "monitor.show_harmless"
    text = words(key, count=sum(one.id in harmless and not one.depth for one in found))
    cells = [(), (), (), (), cell(text, "dim")]
    fold = Row(FOLD, ((), *cells) if buses else tuple(cells), text)
    return [*shown[:place], fold, *shown[place:]]


def changing(snapshot: Snapshot) -> bool:
    """Returns true if rows change with time alone, because a problem has not ended."""
    return any(one.end_ns is None for one in snapshot.problems)


def open_roots(snapshot: Snapshot) -> list[Problem]:
    """Returns the root problems that are open, or whose status is not known yet."""
    roots = (one for one in snapshot.problems if not one.depth)
    return [one for one in roots if one.status == "open" or (one.status == "unknown" and one.provisional)]


def newest(snapshot: Snapshot) -> Cell:
    """Returns the number of open problems and the title of the newest one; empty if there are none."""
    found = open_roots(snapshot)
    if not found:
        return ()
    last = max(found, key=lambda one: (one.noticed, one.id))
    return ((f"✖{len(found)} ", "error"), (last.text + _mark(last), "error"))


def loud(snapshot: Snapshot) -> set[tuple[object, ...]]:
    """Returns identifiers of the problems that have stopped something, or keep it from starting."""
    found = (one for one in snapshot.problems if one.impact in _LOUD and one.status != "harmless")
    return {(one.bus, one.kind, one.frame) for one in found}


def of_node(node: Node) -> str:
    """Returns the word for the problem of a node, or ""."""
    one = node.problem
    return f"{one.word}{_mark(one)}" if one else ""


def _harmless(found: Sequence[Problem]) -> set[int]:
    """Returns the ids of the harmless problems and their effects."""
    under: set[int] = set()
    for one in found:
        if (one.status == "harmless" and not one.depth) or one.cause in under:
            under.add(one.id)
    return under


def _mark(one: Problem | NodeProblem) -> str:
    return "?" if one.provisional else ""


def _problem(one: Problem, snapshot: Snapshot, words: Words, *, buses: bool) -> Row:
    status = _status(one, words)
    look = _STATUSES.get(one.status, "")
    told = f"{'  ' * (one.depth - 1)}→ {one.text}" if one.depth else one.text
    cells = [
        cell(one.id),
        cell(status, look),
        cell(_lasts(one, snapshot.now_ns)),
        cell(one.frame),
        (*cell(told, look if one.status in _OPEN else ""), *cell("".join(_cause(one, words)), "dim")),
    ]
    if buses:
        cells.insert(1, cell(one.bus))
    checks = words("diagnose.between").join(one.checks)
    caused = words("monitor.caused", number=one.cause) if one.cause is not None else ""
    whole = texts(
        [
            one.id,
            status,
            one.text + "".join(_cause(one, words)),
            caused,
            words("diagnose.check_first", said=checks) if checks else "",
        ]
    )
    return Row(one.id, tuple(cells), whole, leads=one.frame)


def _status(one: Problem, words: Words) -> str:
    """Returns the status in words; a provisional unknown status is shown as open."""
    known = "open" if one.provisional and one.status == "unknown" else one.status
    return words.of("problem_status", known) + _mark(one)


def _lasts(one: Problem, now: int | None) -> str:
    end = now if one.end_ns is None else one.end_ns
    if end is None or one.t_ns is None:
        return BLANK
    return period(max(0, end - one.t_ns))


def _cause(one: Problem, words: Words) -> Iterator[str]:
    """Yields the delay after its cause, and the confidence of that."""
    if one.cause_grade is None:
        return
    if one.delay_ns is not None and one.delay_ns >= 0:
        yield words("diagnose.after", ms=f"{one.delay_ns / 1e6:.0f}")
    yield f"  {words.of('problem_grade', one.cause_grade)}"
