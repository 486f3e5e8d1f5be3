"""Signals of PDOs, typed: long rows, one a value, and the values of one signal as a series.

It must not read a capture, judge or print.
"""

import difflib
from collections.abc import Iterable
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, ClassVar, overload

from canalyze.library.columns import needs
from canalyze.library.rows import Rows, number
from canalyze.records import Value
from canalyze.records.frames import Signal
from canalyze.values import DATES_NS

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class _Values(Rows[Signal]):
    """Values of signals as a table."""

    _what = "values"
    _table = "signals"
    _row_type = Signal
    _values: ClassVar = {
        "object": lambda one: f"{one.index}:{one.sub:02X}",
        "value": number,
        "integer": lambda one: one.value if isinstance(one.value, int) else None,
        "raw": lambda one: one.raw if isinstance(one.raw, int) else None,
    }
    _first = ("frame", "t_ns", "node", "pdo", "signal", "value", "unit", "text")


class Series(_Values):
    """All values of one signal, in the order of frames."""

    @property
    def name(self) -> str:
        """The name by which it is found: 5.TPDO4.velocity actual value."""
        return "".join(f"{row.node}.{row.pdo}.{row.signal}" for row in self._rows[:1])

    @property
    def unit(self) -> str | None:
        """The unit of the values."""
        return self._rows[0].unit if self._rows else None

    @property
    def values(self) -> list[Value]:
        """The values, with sign, type and factor applied."""
        return [row.value for row in self._rows]

    @property
    def times_ns(self) -> list[int | None]:
        """The times of the values in nanoseconds, as the capture has them; None without stamps."""
        return [row.t_ns for row in self._rows]

    @property
    def times(self) -> list[float | None]:
        """The times of the values in seconds, as the capture has them; None without stamps."""
        return [row.t_s for row in self._rows]

    def plot(self, axes: "Axes | None" = None, **options: Any) -> "Axes":
        """Draws the values as steps over their times with matplotlib; returns the axes (extra `plot`).

        axes: where it is drawn; a new figure otherwise. options: those of `Axes.step`, such as `color`. Times that are
        dates are in UTC; without stamps the numbers of the frames take their place. ValueError where no value is a
        number, CanalyzeError without matplotlib.
        """
        self._numbers()
        if axes is None:
            axes = needs("matplotlib.pyplot", "plot").figure().add_subplot()
        drawn = [row for row in self._rows if isinstance(row.value, int | float)]
        times = [row.t_s for row in drawn]
        at: list[Any]
        if None in times:
            at, label = [row.frame for row in drawn], "frame"
        elif (times[0] or 0) * 1e9 >= DATES_NS:
            at, label = [datetime.fromtimestamp(time or 0, UTC) for time in times], "UTC"
        else:
            at, label = times, "s"
        axes.step(at, [row.value for row in drawn], **{"where": "post", "label": self.name} | options)
        axes.set_xlabel(label)
        axes.set_ylabel(self.unit or "")
        return axes

    @property
    def frames(self) -> list[int]:
        """The frames of the values."""
        return [row.frame for row in self._rows]

    @property
    def min(self) -> float:
        """The least value. ValueError where no value is a number."""
        return min(self._numbers())

    @property
    def max(self) -> float:
        """The greatest value. ValueError where no value is a number."""
        return max(self._numbers())

    @property
    def last(self) -> Value:
        """The last value; None where there is none."""
        return self._rows[-1].value if self._rows else None

    def _numbers(self) -> list[int | float]:
        numbers = [row.value for row in self._rows if isinstance(row.value, int | float)]
        if not numbers:
            raise ValueError(f"{self.name}: no value is a number")
        return numbers

    def __repr__(self) -> str:
        try:
            between = f", {self.min} to {self.max}" + (f" {self.unit}" if self.unit else "")
        except ValueError:
            between = ""
        return f"<Series {self.name}: {len(self)} values{between}>"


class Signals(_Values):
    """Every value of every signal, in the order of frames; `signals["5.TPDO4.velocity actual value"]` is a series."""

    def __init__(self, rows: Iterable[Signal]) -> None:
        """Creates a list of the rows, in the order of frames."""
        super().__init__(rows)
        self._grouped: dict[tuple[str | None, int, str, str, int, str], list[Signal]] | None = None

    @property
    def _groups(self) -> dict[tuple[str | None, int, str, str, int, str], list[Signal]]:
        if self._grouped is None:
            self._grouped = {}
            for row in self._rows:
                key = (row.bus, row.node, row.pdo, row.index, row.sub, row.signal)
                self._grouped.setdefault(key, []).append(row)
        return self._grouped

    def _one(self, row: Signal) -> str:
        return f"{row.node}.{row.pdo}.{row.signal}"

    @property
    def names(self) -> list[str]:
        """The names of all signals, with the bus before them (can1:5.TPDO1.statusword) where there are several."""
        return [self._name(key) for key in self._groups]

    def _name(self, key: tuple[str | None, int, str, str, int, str]) -> str:
        bus, node, pdo, _, _, signal = key
        several = len({key[0] for key in self._groups}) > 1
        return (f"{bus}:" if several else "") + f"{node}.{pdo}.{signal}"

    @overload
    def __getitem__(self, place: int) -> Signal: ...
    @overload
    def __getitem__(self, place: slice) -> "Signals": ...
    @overload
    def __getitem__(self, place: str) -> Series: ...
    def __getitem__(self, place: int | slice | str) -> "Signal | Signals | Series":
        """Returns one value, some, or the series of a signal.

        A signal is named as for --select: by its name or its object (6041:00), alone, behind the node (`5.`) or behind
        node and PDO (`5.TPDO4.`), with the bus before it where needed (`can1:`); case does not matter. KeyError if no
        signal is called so, or several.
        """
        if isinstance(place, int):
            return self._rows[place]
        if isinstance(place, slice):
            return Signals(self._rows[place])
        if not isinstance(place, str):
            raise TypeError(f"signals[{place!r}]: a name or a number is needed, not {type(place).__name__}")
        wanted = place.lower()
        found = [key for key in self._groups if wanted in _names(key)]
        if len(found) == 1:
            return Series(self._groups[found[0]])
        if found:
            several = ", ".join(map(self._name, found))
            raise KeyError(f"{place!r} is the name of several signals: {several}")
        near = difflib.get_close_matches(place, self.names, 3, 0.4) or self.names[:3]
        hint = f"; there are {', '.join(near)}" if near else ""
        raise KeyError(f"no signal {place!r}{hint}")


def _names(key: tuple[str | None, int, str, str, int, str]) -> set[str]:
    bus, node, pdo, index, sub, signal = key
    own = [signal, index, f"{index}:{sub:02X}", f"{index}h:{sub:02X}"]
    names = [prefix + name for name in own for prefix in ("", f"{node}.", f"{node}.{pdo}.")]
    return {name.lower() for name in [*names, *(f"{bus}:{name}" for name in names)]}
