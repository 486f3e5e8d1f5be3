"""A first version of a file of expectations, from what the core says of a good capture.

How much room a figure gets is decided here, and each figure stands beside what was seen. Must not: measure anything;
that is the core's (`observed`), in the way in which it judges.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from canalyze.output import commandless, hexadecimal, printable
from canalyze.output.layout import wrap
from canalyze.words import Words

Row = Mapping[str, Any]

MOST_WRITES: Final = 200
"""SDO downloads that are written down; the rest is counted."""
MOST_ALIKE: Final = 8
"""Downloads of one object; what is written more often is no configuration but a setpoint."""
MOST_SIGNALS: Final = 500
"""Signals that get a range; the rest is counted."""
_LONGEST: Final = 32
"""Bytes of a value that is expected as it was; of a longer one only that it was sent."""
_IDENTITY: Final = frozenset({("1000", 0), ("1008", 0), ("1018", 1), ("1018", 2), ("1018", 3)})
"""Objects that say which device it is, but for its serial number: another one of its kind is as good."""
_FEWEST: Final = 5
"""Intervals from which a period is told."""
_LOOSE: Final = 0.5
"""The share of a period that it may be off: another recording on a busier host must pass, a missing frame must not."""
_TIGHT: Final = 0.2
"""That of SYNC, which is a clock."""
_UNTIMED: Final = {
    "heartbeat": "expect.no_heartbeat_period",
    "sync": "expect.no_sync_period",
    "signal": "expect.no_pdo_period",
}
"""The words for rows without a period, by table."""
_COMMENT: Final = 90
"""Characters of a comment behind a value."""


class Draft:
    """The knowledge of a capture, line by line; its size does not grow with the capture."""

    def __init__(self) -> None:
        """Starts empty."""
        self._capture: Row = {}
        self._rows: dict[str, list[Row]] = {}
        self._writes: list[Row] = []
        self._alike: dict[tuple[Any, ...], int] = {}
        self._identity: dict[tuple[Any, ...], Row | None] = {}
        self._left = {"more": 0, "aborted": 0, "incomplete": 0}

    @property
    def frames(self) -> int:
        """Frames of the capture."""
        return int(self._capture.get("frames", 0))

    @property
    def findings(self) -> list[str]:
        """Codes of the findings above info: a good capture has none."""
        return [row["code"] for row in self._of("summary_finding") if row["severity"] != "info"]

    def take(self, row: Row) -> None:
        """Adds a line of the core."""
        kind = row["kind"]
        if kind == "transfer":
            self._transfer(row)
        elif kind == "summary_capture":
            self._capture = row
        else:
            self._rows.setdefault(kind, []).append(row)

    def _of(self, kind: str) -> list[Row]:
        return self._rows.get(kind, [])

    def _transfer(self, row: Row) -> None:
        if row["status"] != "ok":
            self._left["aborted" if row["status"] == "aborted" else "incomplete"] += 1
            return
        if row["node"] is None or row["index"] is None or row["sub"] is None:
            return
        place = (row["bus"], row["node"], row["index"], row["sub"])
        if row["direction"] == "upload":
            if place[2:] in _IDENTITY:
                known = self._identity.setdefault(place, row)
                if known is not None and known["data"] != row["data"]:
                    self._identity[place] = None  # it says now this and now that: nothing to expect
            return
        if place in self._alike or len(self._alike) < MOST_WRITES:
            self._alike[place] = self._alike.get(place, 0) + 1
        if len(self._writes) < MOST_WRITES and self._alike.get(place, MOST_WRITES) <= MOST_ALIKE:
            self._writes.append(row)
        else:
            self._left["more"] += 1

    def text(self, words: Words, name: str) -> str:
        """Returns the content of the file; `name` is that of the capture."""
        self._words = words
        seconds = self._capture.get("seconds") or "?"
        shown = commandless(printable(name).encode()).decode()
        lines = [
            *self._said("expect.head", name=shown, frames=self.frames, seconds=seconds),
            *self._said("expect.head_use"),
        ]
        if self.findings:
            lines += self._said("expect.head_findings", codes=", ".join(self.findings))
        for section in (
            self._writing,
            self._reading,
            self._states,
            self._heartbeats,
            self._syncs,
            self._pdos,
            self._signals,
            self._emcys,
            self._incidents,
            self._latencies,
            self._loads,
        ):
            part = list(section())
            if part:
                lines += ["", *part] if lines[-1] else part
        return "".join(f"{line}\n" for line in lines)

    def _said(self, key: str, **facts: object) -> list[str]:
        return [f"# {line}" for line in wrap(self._words(key, **facts), 110)]

    def _entry(self, table: str, row: Row, *pairs: "Pair") -> list[str]:
        """Returns one table, with the bus if there are several."""
        bus = [("bus", _text(row["bus"]), "")] if self._capture.get("buses", 1) > 1 and row.get("bus") else []
        lines = [f"[[{table}]]"]
        for key, value, seen in (*pairs[:1], *bus, *pairs[1:]):
            lines.append(f"{key} = {value}" + (f"  # {_short(seen)}" if seen else ""))
        return [*lines, ""]

    def _whose(self, row: Row) -> str:
        """Returns the name of a node's sequence."""
        several = self._capture.get("buses", 1) > 1 and row["bus"]
        return f"{row['bus']} node {row['node']}" if several else f"node {row['node']}"

    def _writing(self) -> Iterator[str]:
        often = {place for place, count in self._alike.items() if count > MOST_ALIKE}
        writes = [row for row in self._writes if (row["bus"], row["node"], row["index"], row["sub"]) not in often]
        more = self._left["more"] + len(self._writes) - len(writes)
        if writes:
            yield from self._said("expect.writes", count=len(writes))
        if more:
            yield from self._said("expect.writes_left", count=more, most=MOST_WRITES, alike=MOST_ALIKE)
        for row in writes:
            sequence = ("sequence", _text(self._whose(row)), "")
            yield from self._entry("sdo", row, *_transfer(row), sequence)

    def _reading(self) -> Iterator[str]:
        rows = [row for row in self._identity.values() if row is not None]
        if rows:
            yield from self._said("expect.reads")
        for row in sorted(rows, key=lambda row: (str(row["bus"]), row["node"], row["index"], row["sub"])):
            yield from self._entry("sdo", row, *_transfer(row))
        if self._left["aborted"] or self._left["incomplete"]:
            yield from self._said("expect.transfers_left", **self._left)
            yield ""

    def _states(self) -> Iterator[str]:
        rows = [("state", row) for row in self._of("observed_state")]
        rows += [("drive", row) for row in self._of("observed_drive") if row["state"] == "operation-enabled"]
        if rows:
            yield from self._said("expect.states")
        boots = {(row["bus"], row["node"]): row["boot_ups"] for row in self._of("summary_node")}
        quickest: dict[tuple[Any, Any], float] = {}
        for key, row in rows:
            if key == "state" and row["state"] != "boot-up" and row["since_boot_up_ns"] is not None:
                whose = (row["bus"], row["node"])
                quickest[whose] = min(quickest.get(whose, math.inf), row["since_boot_up_ns"])
        for key, row in rows:
            pairs = [("node", str(row["node"]), ""), (key, _text(row["state"]), "")]
            if row.get("axis", 1) != 1:
                pairs.append(("axis", str(row["axis"]), ""))
            after, whose = row["since_boot_up_ns"], (row["bus"], row["node"])
            # What belongs to booting: it is due after every boot-up, which a capture with several may not show.
            booting = row["state"] in ("operational", "operation-enabled") or after == quickest.get(whose)
            if after is not None and booting and boots.get(whose) == 1:
                seen = self._words("expect.after_boot_up", seconds=_number(round(after / 1e9, 3)))
                pairs += [("by_s", _number(round_up(max(3 * after / 1e9, 1))), seen), ("since", '"boot-up"', "")]
            yield from self._entry("state", row, *pairs)

    def _heartbeats(self) -> Iterator[str]:
        yield from self._periods("heartbeat", self._of("observed_heartbeat"), "expect.heartbeats", _LOOSE, 2)

    def _syncs(self) -> Iterator[str]:
        yield from self._periods("sync", self._of("observed_sync"), "expect.syncs", _TIGHT, _FEWEST)

    def _pdos(self) -> Iterator[str]:
        # A PDO is selected by its signals: without a known mapping it has none.
        mapped = {(row["bus"], row["node"], row["pdo"]) for row in self._of("observed_signal")}
        rows = [row for row in self._of("observed_pdo") if (row["bus"], row["node"], row["pdo"]) in mapped]
        yield from self._periods("signal", rows, "expect.pdos", _LOOSE, _FEWEST)

    def _periods(self, table: str, rows: Sequence[Row], heading: str, share: float, fewest: int) -> Iterator[str]:
        entries: list[str] = []
        timed = [row for row in rows if row["period"]]
        for row in timed:
            times = row["period"]
            period = times["count"] >= fewest and period_of(times, share)
            if not period or (row["silence_us"] or 0) > sum(period):  # it stopped: that would be a finding
                continue
            unit, scale = ("ms", 1000) if period[0] >= 1000 else ("us", 1)
            who = [("node", str(row["node"]), "")] if table == "heartbeat" else []
            if table == "signal":
                who = [("select", _text(f"{row['node']}.{row['pdo']}.*"), "")]
            said = self._seen(times)
            entries += self._entry(
                table,
                row,
                *who,
                (f"period_{unit}", _number(period[0] / scale), said),
                (f"tolerance_{unit}", _number(period[1] / scale), ""),
            )
        if entries:
            yield from self._said(heading)
        yield from entries
        left = len(timed) - sum(line.startswith("[[") for line in entries)
        if left:
            yield from self._said(_UNTIMED[table], count=left)
            yield ""

    def _seen(self, times: Row) -> str:
        """Returns the intervals of a period, not the mean: some may be shorter than the least."""
        most = f"{times['max_us'] / 1000:.3f}"
        if times["min_us"] is None:
            return self._words("expect.seen_longest", most=most, count=times["count"])
        return self._words("expect.seen_period", least=f"{times['min_us'] / 1000:.3f}", most=most, count=times["count"])

    def _signals(self) -> Iterator[str]:
        rows = [row for row in self._of("observed_signal") if row["min"] is not None and row["max"] is not None]
        if rows:
            yield from self._said("expect.signals")
        for row in rows[:MOST_SIGNALS]:
            least, most = float(row["min"]), float(row["max"])
            low, high = range_of(least, most)
            unit = f" {row['unit']}" if row.get("unit") else ""
            seen = f"{row['signal']}: {_number(least)} .. {_number(most)}{unit}"
            yield from self._entry(
                "signal",
                row,
                ("select", _text(row["select"]), seen),
                ("min", _number(low), ""),
                ("max", _number(high), ""),
            )
        if len(rows) > MOST_SIGNALS:
            yield from self._said("expect.signals_left", count=len(rows) - MOST_SIGNALS)
            yield ""

    def _emcys(self) -> Iterator[str]:
        yield from self._said("expect.emcys")
        for row in self._of("observed_emcy"):
            seen = self._words("expect.seen_times", count=row["count"])
            pairs = [("node", str(row["node"]), ""), ("code", _text(row["code"]), seen), ("occurs", '"may"', "")]
            yield from self._entry("emcy", row, *pairs)
        yield from self._entry("emcy", {}, ("occurs", '"never"', ""))

    def _incidents(self) -> Iterator[str]:
        yield from self._said("expect.problems")
        seen: dict[tuple[Any, ...], Row] = {}
        for row in self._of("problem"):
            subject = row["subject"]
            if row["root"] and row["status"] != "harmless":
                seen.setdefault((subject["bus"], row["problem"], subject.get("node")), row)
        for (bus, kind, node), row in seen.items():
            said = self._words("expect.seen_at", frame=row["begin"]["frame"], message=row["message"])
            whose = [("node", str(node), "")] if node else []
            pairs = [("kind", _text(kind), said), *whose, ("occurs", '"0-"', "")]
            yield from self._entry("problem", {"bus": bus}, *pairs)
        yield from self._entry("problem", {}, ("occurs", "0", ""))

    def _latencies(self) -> Iterator[str]:
        slowest: dict[Any, Row] = {}
        for row in self._of("summary_node"):
            most = row["response"] and row["response"]["max_us"]
            if most and (row["bus"] not in slowest or most > slowest[row["bus"]]["response"]["max_us"]):
                slowest[row["bus"]] = row
        if slowest:
            yield from self._said("expect.latencies")
        for row in slowest.values():
            milliseconds = float(row["response"]["max_us"]) / 1000
            seen = self._words("expect.seen_slowest", milliseconds=f"{milliseconds:.3f}", node=row["node"])
            limit = _number(round_up(max(5 * milliseconds, 50)))
            yield from self._entry("latency", row, ("of", '"sdo"', ""), ("max_ms", limit, seen))

    def _loads(self) -> Iterator[str]:
        rate = self._capture.get("bit_rate")
        rows = [row for row in self._of("summary_bus") if rate and row["load_peak_100ms"] is not None]
        if rows:
            yield from self._said("expect.loads")
        for row in rows:
            peak = float(row["load_peak_100ms"])
            limit = min(5 * math.ceil((1.25 * peak + 2) / 5), 100)
            seen = self._words("expect.seen_load", percent=f"{peak:.1f}")
            yield from self._entry("load", row, ("max_percent", str(limit), seen), ("bitrate", str(rate), ""))


Pair = tuple[str, str, str]
"""A key, its value as TOML, and what was seen."""


def _transfer(row: Row) -> list[Pair]:
    """Returns the expectation of a transfer: its object, its direction, and its value if it is short."""
    name = row.get("name") or ""
    pairs = [
        ("node", str(row["node"]), ""),
        ("object", _text(f"{row['index']}:{row['sub']:02X}"), name),
        ("direction", _text(row["direction"]), ""),
    ]
    value = _value(row)
    if value:
        pairs.append((*value, row.get("text") or ""))
    return pairs


def _value(row: Row) -> tuple[str, str] | None:
    """Returns the key and the value of a transfer's data: typed if its type is known, else its bytes."""
    value, kind, data = row["value"], row["type"], row["data"]
    if isinstance(value, bool):
        return "value", str(value).lower()
    if isinstance(value, int) and kind:
        return "value", hexadecimal(value, row.get("text")) or str(value)
    if isinstance(value, float) and math.isfinite(value):
        return "value", repr(value)
    if not data or len(data) != 2 * (row["size"] or 0) or row["size"] > _LONGEST:
        return None
    if isinstance(value, str) and kind == "VISIBLE_STRING" and value.isascii() and value.isprintable() and value:
        return "value", _text(value)
    return "data", _text(" ".join(data[at : at + 2] for at in range(0, len(data), 2)))


def _text(text: str) -> str:
    """Returns a text as a TOML string."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("##[", "##\\u005b")
    return '"' + "".join(c if c.isprintable() else _escaped(c) for c in escaped) + '"'


def _escaped(char: str) -> str:
    code = ord(char)
    if 0xD800 <= code <= 0xDFFF:  # no character, which TOML cannot hold
        return "?"
    return f"\\u{code:04X}" if code < 0x10000 else f"\\U{code:08X}"


def _short(seen: str) -> str:
    """Returns a comment in one line of bounded length."""
    text = printable(seen)
    return text if len(text) <= _COMMENT else text[: _COMMENT - 3] + "..."


def _number(value: float) -> str:
    """Writes a number without an exponent where it has none to need."""
    if value == int(value) and abs(value) < 1e15:
        return str(int(value))
    return repr(float(f"{value:.12g}"))


def round_up(value: float) -> float:
    """Returns the least of 1, 2, 5, 10, 20, ... (and 0.5, 0.2, ...) that is not below a value above 0."""
    power = 10.0 ** math.floor(math.log10(value))
    steps = (step * power for step in (1, 2, 5, 10))
    return float(f"{next((step for step in steps if value <= step * (1 + 1e-9)), 10 * power):.6g}")


def period_of(row: Row, share: float) -> tuple[float, float] | None:
    """Returns the period of times in µs, and a tolerance of at least that share of it; None if there is none."""
    mean = float(row["mean_us"])
    if row["min_us"] is not None and mean < row["min_us"]:  # the mean has also those that may be too short
        mean = (row["min_us"] + row["max_us"]) / 2
    if mean <= 0:
        return None
    period = next(
        near for digits in (1, 2, 3, 17) if abs((near := float(f"{mean:.{digits - 1}e}")) - mean) <= mean / 100
    )
    least = float(mean if row["min_us"] is None else row["min_us"])
    off = max(float(row["max_us"]) - period, period - least)
    # Below the period itself: that a frame is missing must show.
    tolerance = max(share * period, min(round_up(1.5 * off) if off else 0.0, 0.75 * period))
    return (period, tolerance) if off <= period / 2 else None


def range_of(least: float, most: float) -> tuple[float, float]:
    """Returns a range with room on both sides, in round numbers; one that was never negative stays so."""
    room = max((most - least) / 4, max(abs(least), abs(most)) / 10) or 1.0
    step = 10.0 ** math.floor(math.log10(room))
    low, high = math.floor((least - room) / step) * step, math.ceil((most + room) / step) * step
    low = max(low, 0.0) if least >= 0 else low
    high = min(high, 0.0) if most <= 0 and least < 0 else high
    return float(f"{low:.12g}"), float(f"{high:.12g}")
