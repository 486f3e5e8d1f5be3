"""The application: the layout of the views, the actions of keys, and the refresh of the screen.

Ten times per second it takes one snapshot and passes it to the visible views; each draws the differences. Must not:
decode, judge, or wait for the source.
"""

import asyncio
import os
import select
import signal
import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Any, ClassVar, Final

from rich.console import RenderableType
from textual import events
from textual.app import App, ComposeResult
from textual.containers import Horizontal, Vertical
from textual.dom import DOMNode
from textual.driver import Driver
from textual.widget import Widget

from canalyze.monitor import views
from canalyze.monitor.around import (
    VIEWS,
    Below,
    Foot,
    Page,
    Prompt,
    Status,
    bindings,
    help_page,
    of_finding,
    of_frame,
    of_node,
)
from canalyze.monitor.grid import Grid, Row, rate
from canalyze.monitor.trace import Trace
from canalyze.records import SEVERITIES
from canalyze.records.live import Snapshot, Tally, Transfers
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze.monitor.opening import Watch

_BEAT_S: Final = 0.1
_WIDE: Final = 120
"""Minimum columns for findings and transfers in the overview."""
_HIGH: Final = 34
"""Minimum lines for them."""
_AROUND: Final = 3
"""Lines of status and foot."""
_TABLES: Final = ("nodes", "objects", "transfers", "findings", "problems")
"""Views with rows from a snapshot."""
_LOW: Final = 12
"""Minimum lines for the last finding in the overview, if the findings themselves are not visible."""
_COUNTS: Final = Tally(0, 0, dict.fromkeys(SEVERITIES, 0), {}, None, ())
NOTHING: Final = Snapshot(None, None, _COUNTS, (), (), (), 0, Transfers((), ()), (), ())
"""An empty snapshot, before the first one."""


def _hangup() -> Any:
    """Returns a poll object that reports that the terminal is gone, because a closed window may send no signal.

    Returns None if standard input is no terminal, or if the system has no poll.
    """
    if sys.platform == "win32" or not os.isatty(0):
        return None
    gone = select.poll()
    gone.register(0, 0)
    return gone


class Monitor(App[int]):
    """The screen of `canalyze monitor`; its return value is the exit code."""

    ENABLE_COMMAND_PALETTE = False
    CSS = """
    Screen { layout: vertical; background: ansi_default; color: ansi_default; }
    #rooms { height: 1fr; }
    #upper { height: 1fr; }
    #side { width: 45%; margin: 0 0 0 1; }
    """
    BINDINGS: ClassVar = bindings()

    def __init__(
        self, watch: "Watch", words: Words, *, expression: str = "", beat: bool = True, bell: bool = False
    ) -> None:
        """Shows the source of `watch`; `expression` is the first filter of the trace.

        beat: refresh by a timer; otherwise the caller calls `beat()`, as tests do. bell: ring for each new problem that
        stops something or keeps it from starting, once per refresh.
        """
        super().__init__(driver_class=_driver(), ansi_color=True)
        self._watch = watch
        self._words = words
        self._beats = beat
        self._snapshot = NOTHING
        self._complete = False
        """True if the snapshot is final."""
        self._drawn: dict[str, Any] = {}
        self._view = "overview"
        self._notice = ""
        self.paused = False
        self._rung: set[tuple[object, ...]] | None = set() if bell else None
        """Problems for which the bell has rung; None if it is off."""
        self._unfolded = False
        """True if harmless problems are shown."""
        self._severity = views.LEVELS[0]
        """The least severity of the findings shown."""
        self.status = Status(words)
        self.trace = Trace(watch.trace, words)
        self.trace.filter = expression
        self.grids: dict[str, Grid] = {name: Grid(name) for name in _TABLES}
        self.grids["trace"] = self.trace
        for name in _TABLES:
            self.grids[name].empty = words.of("monitor_empty", name)
        self._latest, self._whole, self._said = Below("latest"), Below("whole"), Below("notice")
        self._prompt = Prompt()
        self._hangup: Any = None

    def compose(self) -> ComposeResult:
        """Yields all views; the current view decides which of them are visible."""
        yield self.status
        yield self._latest
        with Vertical(id="rooms"):
            with Horizontal(id="upper"):
                yield self.grids["nodes"]
                with Vertical(id="side"):
                    yield self.grids["findings"]
                    yield self.grids["transfers"]
            yield self.grids["objects"]
            yield self.grids["problems"]
            yield self.trace
        yield self._whole
        yield self._said
        yield self._prompt
        yield Foot(self._words)

    def on_mount(self) -> None:
        """Starts the refresh."""
        self.theme = "ansi-dark"
        loop = asyncio.get_running_loop()
        if self._beats:
            for name, code in (("SIGTERM", 143), ("SIGHUP", 129), ("SIGINT", 0)):  # not every system has all
                with suppress(AttributeError, NotImplementedError, ValueError, RuntimeError):
                    loop.add_signal_handler(getattr(signal, name), self.exit, code)
            self._hangup = _hangup()
            self.set_interval(_BEAT_S, self.beat)
        self.app_resume_signal.subscribe(self, lambda _: self.refresh(layout=True))  # what the shell drew is on it
        self._arrange()
        self.screen.set_focus(self.trace)

    def on_resize(self) -> None:
        """Lays out the views again."""
        self._drawn = {}
        self._arrange()
        self.call_after_refresh(self.draw)

    def beat(self) -> None:
        """Refreshes the screen."""
        if self._watch.crash is not None:
            self.exit(2)
            return
        if self._hangup is not None and self._hangup.poll(0):
            self.exit(129)
            return
        for complaint in self._watch.complaints():
            self._notice = complaint
        over = self._watch.over
        if not self.paused:
            if not self._complete:
                self._snapshot = self._watch.snapshot()
                self._complete = over
                self._ring()
            self.trace.limit = None
        self.draw()

    def _ring(self) -> None:
        """Rings for new problems."""
        if self._rung is None:
            return
        if new := views.loud(self._snapshot) - self._rung:
            self._rung |= new
            self.bell()

    def draw(self) -> None:
        """Passes the snapshot to the visible views."""
        snapshot, words = self._snapshot, self._words
        self.trace.start_ns = snapshot.start_ns
        several = len(snapshot.buses) > 1
        if several != self.trace.buses:
            self.trace.buses = several
            self._drawn = {}
        worst = views.latest(snapshot) if self._view == "overview" and self.size.height >= _LOW else ()
        self._latest.tell_cell(() if _seen(self.grids["findings"]) else worst)
        self._arrange()
        badges = [name for name in (self._badge(), self._watch.recording) if name]
        away = frozenset(bus.name for bus in snapshot.buses) if self._watch.failure else self._watch.away
        self.status.update(snapshot, badges, self._speed(), self._view, self.trace.conditions(), away)
        self._said.tell(self._notice, 3, "warning" if self._notice else "")
        for name in _TABLES:
            grid = self.grids[name]
            runs = (
                snapshot.transfers.running
                if name == "transfers"
                else name == "objects" or (name == "problems" and views.changing(snapshot))
            )
            part = (getattr(snapshot, name), snapshot.now_ns if runs else 0, away)
            if not grid.size.width or not _seen(grid) or self._drawn.get(name) == part:
                continue
            self._drawn[name] = part
            width = self.size.width
            if name == "nodes":
                grid.show(
                    views.node_columns(words, buses=several), views.node_rows(snapshot, words, buses=several, away=away)
                )
            elif name == "objects":
                shown = views.object_rows(snapshot, words, buses=several, width=width)
                grid.show(views.object_columns(words, buses=several, width=width), shown)
            elif name == "transfers":
                grid.show(
                    views.transfer_columns(words, buses=several), views.transfer_rows(snapshot, words, buses=several)
                )
            elif name == "findings":
                shown = views.finding_rows(snapshot, buses=several, least=self._severity)
                grid.show(views.finding_columns(words, buses=several, least=self._severity), shown)
            else:
                shown = views.problem_rows(snapshot, words, buses=several, unfolded=self._unfolded)
                grid.show(views.problem_columns(words, buses=several), shown)
        if _seen(self.trace) and (self._drawn.get("trace") != snapshot.tally.frames or not self.paused):
            self._drawn["trace"] = snapshot.tally.frames
            self.trace.update()
        self._tell_whole()

    def _badge(self) -> str:
        badge = self._watch.badge
        return "paused" if self.paused and badge not in ("over", "lost") else badge

    def _speed(self) -> str:
        replay = self._watch.replay
        if replay is None or self._watch.over:
            return ""
        if not replay.speed:
            return f" {self._words('monitor.fastest')}"
        if replay.fixed_rate is not None:
            return f" {self._words('monitor.fixed', rate=rate(replay.fixed_rate * replay.speed))}"
        return f" {replay.speed:g}x"

    # The layout of the views.

    def _arrange(self) -> None:
        view, size = self._view, self.size
        overview = view == "overview"
        wide = overview and size.width >= _WIDE and size.height >= _HIGH
        seen = {"nodes", "objects", "trace"} if overview else {view}
        if wide:
            seen |= {"findings", "transfers"}
        for name, grid in self.grids.items():
            _set(grid, name in seen)
        upper, side = self.query_one("#upper"), self.query_one("#side")
        _set(side, bool(seen & {"findings", "transfers"}))
        _set(upper, bool(seen & {"nodes", "findings", "transfers"}))
        side.styles.width = "45%" if wide else "100%"
        if not overview:
            upper.styles.height = self.grids["objects"].styles.height = "1fr"
            return
        room = size.height - _AROUND - self._latest.display
        highest = 1 + max(1, min(len(self._snapshot.nodes), room * 3 // 10 - 1))
        if wide:
            highest = max(highest, min(12, room // 4))
        _height(upper, highest)
        _height(self.grids["objects"], 1 + max(1, min(len(self._snapshot.objects), room * 4 // 10 - 1)))

    def _focused(self) -> Grid | None:
        return self.focused if isinstance(self.focused, Grid) else None

    def _tell_whole(self) -> None:
        grid = self._focused()
        row = grid.current if grid else None
        self._whole.tell(row.whole if row else "", 2 if self.size.height < 30 else 4, "info")

    def on_grid_moved(self) -> None:
        """Shows the row of the cursor in full."""
        self._tell_whole()

    def on_descendant_focus(self, _: events.DescendantFocus) -> None:
        """Shows the row of the cursor in full; an open prompt keeps the keys, even after a click."""
        if self._prompt.display and isinstance(self.focused, Grid):
            self._prompt.take_keys()
        self._tell_whole()

    def _say(self, key: str, **facts: object) -> None:
        self._notice = self._words(key, **facts)
        self._said.tell(self._notice, 3, "warning")

    @property
    def _asked(self) -> bool:
        """True if keys belong to the prompt or to a page."""
        return self._prompt.display or len(self.screen_stack) > 1

    # Keys.

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Disables actions while the prompt or a page is open, except those that end or suspend the program."""
        return not self._asked or action in ("end", "suspend_process") or not hasattr(Monitor, f"action_{action}")

    def action_view(self, name: str) -> None:
        """Shows one view, or the overview."""
        if name not in VIEWS:
            return
        self._view = name
        self._arrange()
        self.screen.set_focus(self.grids.get(name, self.trace))  # at once: the next key is its own, or the prompt's
        self._drawn = {}
        self.call_after_refresh(self.draw)

    def action_room(self, step: int) -> None:
        """Focuses the next visible view."""
        names = ("nodes", "findings", "transfers", "objects", "problems", "trace")
        seen = [self.grids[name] for name in names if _seen(self.grids[name])]
        at = next((place for place, grid in enumerate(seen) if grid is self.focused), -1)
        seen[(at + step) % len(seen)].focus()

    def action_move(self, rows: int) -> None:
        """Moves the cursor."""
        if grid := self._focused():
            grid.move(rows)

    def action_page(self, pages: int) -> None:
        """Moves the cursor by a screen."""
        if grid := self._focused():
            grid.move(pages * max(1, grid.body - 1))

    def action_edge(self, last: bool) -> None:
        """Goes to the first or the last row."""
        if grid := self._focused():
            grid.edge(last=last)

    def action_pick(self) -> None:
        """Opens the details of the row of the cursor."""
        grid = self._focused()
        if grid is not None and grid.current is not None:
            self._lead(grid.current)

    def on_grid_picked(self, event: Grid.Picked) -> None:
        """Opens the details of the row."""
        self._lead(event.row)

    def _lead(self, row: Row) -> None:
        """Opens the page of a row, or goes to its frames."""
        if row.key == views.FOLD:
            self._unfolded = not self._unfolded
            self._drawn.pop("problems", None)
            self.draw()
            return
        if row.about:
            self.push_screen(Page(self._page(row.about)), lambda on: self._follow(row) if on else None)
        else:
            self._follow(row)

    def _page(self, about: tuple[str, ...]) -> RenderableType:
        """Returns the page for the subject of a row."""
        kind, *facts = about
        if kind != "node":
            return (of_finding if kind == "finding" else of_frame)(self._words, *facts)
        node = next(node for node in self._snapshot.nodes if about == views.node_subject(node))
        return of_node(node, self._watch.page(node.bus, node.node), self._words)

    def _follow(self, row: Row) -> None:
        """Goes to the frame of a row, or filters its frames."""
        if row.leads is None:
            return
        if not _seen(self.trace):
            self.action_view("trace")
        self.screen.set_focus(self.trace)
        self.call_after_refresh(self._led, row.leads)

    def _led(self, leads: int | str) -> None:
        self._notice = ""
        if isinstance(leads, str):
            self._filter(leads)
            return
        if not self.trace.go(leads) and self.trace.filter:
            self.trace.filter = ""
            self.trace.go(leads)
            self._say("monitor.unfiltered")
        at = self.trace.current
        if at is None or not isinstance(at.key, tuple) or at.key[0] != leads:
            self._say("monitor.gone", frame=leads)
        self.draw()

    def action_pause(self) -> None:
        """Stops the screen, and a replay with it; reading and recording of a bus continue."""
        self.paused = not self.paused
        if self._watch.replay is not None:
            self._watch.replay.paused = self.paused
        self.trace.limit = self._snapshot.tally.frames if self.paused else None
        self.beat()

    def action_speed(self, faster: bool) -> None:
        """Doubles or halves the speed of a replay."""
        if self._watch.replay is not None:
            self._watch.replay.faster(faster)
            self.draw()

    def action_severity(self) -> None:
        """Raises the least severity of the findings shown, and restarts with all after the highest."""
        levels = views.LEVELS
        self._severity = levels[(levels.index(self._severity) + 1) % len(levels)]
        self._drawn.pop("findings", None)
        if _seen(self.grids["findings"]):
            self.draw()
        else:
            self.action_view("findings")

    def action_filter(self) -> None:
        """Asks for a filter of the trace."""
        self._ask("filter", self.trace.filter)

    def action_search(self) -> None:
        """Asks for a text to search in the trace."""
        self._ask("search", self.trace.search)

    def _ask(self, purpose: str, text: str) -> None:
        if not _seen(self.trace):
            self.action_view("trace")
        self._prompt.ask(purpose, self._words.of("monitor_ask", purpose), text)

    def on_prompt_given(self, event: Prompt.Given) -> None:
        """Applies the filter or the search."""
        self._notice = ""
        if event.purpose == "filter":
            if not self._filter(event.text):
                return
        else:
            self.trace.search = event.text
            if event.text and not self.trace.find(back=True):
                self._say("monitor.not_found", text=event.text)
        self._prompt.close()
        self.screen.set_focus(self.trace)
        self._drawn = {}
        self.call_after_refresh(self.draw)

    def _filter(self, expression: str) -> bool:
        try:
            self.trace.choose(expression)
        except ValueError as error:
            self._notice = str(error)
            self._said.tell(self._notice, 3, "error")
            return False
        self.draw()
        return True

    def on_prompt_cancelled(self) -> None:
        """Keeps the former filter or search."""
        self._notice = ""
        self._prompt.close()
        self.screen.set_focus(self.trace)
        self.draw()

    def action_find(self, back: bool) -> None:
        """Goes to the next or the previous match of the search."""
        if not self.trace.search:
            self.action_search()
            return
        if not _seen(self.trace):
            self.action_view("trace")
        self.screen.set_focus(self.trace)
        self._notice = ""
        if not self.trace.find(back=back):
            self._say("monitor.no_more", text=self.trace.search)
        self.draw()

    def action_leave(self) -> None:
        """Clears the first of these that is set: the notice, the cursor, the search, the filter."""
        grid = self._focused()
        if self._notice:
            self._notice = ""
        elif grid is not None and (grid.cursor is not None or (grid is self.trace and not self.trace.follows)):
            grid.leave()
        elif self.trace.search:
            self.trace.search = ""
            self.trace.lay()
        elif self.trace.filter:
            self._filter("")
        self.draw()

    def action_help(self) -> None:
        """Shows the page of help."""
        self.push_screen(Page(help_page(self._words, replay=self._watch.replay is not None)))

    def action_stop(self) -> None:
        """Ends the program."""
        self.exit(0)

    def action_end(self) -> None:
        """Ends the program, even if the prompt or a page is open."""
        self.exit(0)


def _driver() -> type[Driver] | None:
    """Returns a driver that draws on standard output, as every command does; textual's draws on standard error."""
    if sys.platform == "win32":
        return None
    from textual.drivers.linux_driver import LinuxDriver

    class Terminal(LinuxDriver):
        def __init__(self, *args: Any, **settings: Any) -> None:
            super().__init__(*args, **settings)
            self._file = sys.__stdout__

    return Terminal


def _set(widget: Widget, seen: bool) -> None:
    if widget.display != seen:
        widget.display = seen


def _height(widget: Widget, lines: int) -> None:
    if widget.styles.height is None or widget.styles.height.value != lines or widget.styles.height.is_fraction:
        widget.styles.height = lines


def _seen(widget: Widget) -> bool:
    """Returns true if a widget and all its ancestors are displayed."""
    return all(node.display for node in widget.ancestors_with_self if isinstance(node, DOMNode))
