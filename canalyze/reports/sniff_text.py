"""The summary of a live bus when listening ends, for people: buses, findings, transfers, nodes."""

from collections.abc import Iterator, Sequence
from typing import Final

from canalyze.output import Output
from canalyze.records.live import CountedNode, Tally
from canalyze.reports.table import EMPTY, Column, write
from canalyze.words import Words

_FINDINGS: Final = ("error", "warning", "info")
_TRANSFERS: Final = ("ok", "aborted", "incomplete", "failed")


def show_nodes(nodes: Sequence[CountedNode], words: Words, out: Output, *, several: bool) -> None:
    """Shows below the listing what each node was seen to do; the column of the bus only where there are several."""
    keys = ["col.node", "sniff.frames", "col.node_state", "sniff.errors", "sniff.warnings"]
    columns = [Column(words(key), right=key != "col.node_state") for key in keys]
    rows = []
    for node in nodes:
        state = words.of("monitor_silent", node.silent) if node.silent else node.state_text or EMPTY
        cells = [node.node, node.frames, state, node.errors, node.warnings]
        rows.append(map(str, [node.bus, *cells] if several else cells))
    out.text("\n")
    write([Column(words("col.bus")), *columns] if several else columns, rows, out)


def held(tally: Tally, words: Words) -> Iterator[str]:
    """Yields how the expectations came out, if there are any: nothing is known of a bus that was silent."""
    if expected := tally.expectations:
        key = "sniff.unchecked" if not tally.frames else "sniff.missed" if expected.missed else "sniff.met"
        yield words(key, count=expected.missed)


def seen(tally: Tally, seconds: float, unshown: int, recorded: bool, words: Words) -> Iterator[str]:
    """Yields what was seen, a line each: the buses, findings, SDO transfers, what was not shown."""
    comma = words("listen.comma")
    # The core counts what it was not given as dropped, too; it is reported apart below.
    unshown_here = unshown if len(tally.buses) == 1 else 0
    for bus in tally.buses:
        frames = bus.frames
        facts = {"bus": bus.name, "frames": frames, "seconds": f"{seconds:.1f}"}
        rate = _rounded(frames / max(seconds, 0.001))
        parts = [words("sniff.bus" if frames else "sniff.nothing", rate=rate, **facts)]
        lost = {"error_frames": bus.error_frames, "dropped": bus.dropped - unshown_here}
        parts += [words(f"sniff.{key}", count=count) for key, count in lost.items() if count > 0]
        yield comma.join(parts)
    lines = []
    for title, counts, keys in (("findings", tally.findings, _FINDINGS), ("transfers", tally.transfers, _TRANSFERS)):
        if listed := comma.join(words(f"sniff.{key}", count=counts[key]) for key in keys if counts[key]):
            lines.append(words(f"sniff.{title}", listed=listed))
    if lines:
        yield words("sniff.then").join(lines)
    if tally.shown not in (0, tally.frames):  # that nothing passes a filter, the core says
        yield words("sniff.shown", shown=tally.shown)
    if unshown:
        yield words("sniff.unshown_recorded" if recorded else "sniff.unshown", count=unshown)


def _rounded(rate: float) -> str:
    return f"{rate:.1f}" if rate < 100 else f"{rate:.0f}"
