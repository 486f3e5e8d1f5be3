"""The layout of a recording, updated if there is something new to show.

A file's layout is its default: the user's changes to an earlier one, for the same network, are kept. A viewer applies
a new default only if it has none; while a growing recording is shown, the new layout is therefore activated, unless
the user has changed the views. Must not: design a layout.
"""

import contextlib
import time
from collections.abc import Iterator
from typing import Any, Final

import rerun as rr
import rerun.blueprint as rrb

from canalyze.timeline import charts
from canalyze.timeline.contents import Contents
from canalyze.timeline.layout import layout
from canalyze.words import Words

_LEAST_S: Final = 2.0
_MOST_S: Final = 30.0
_SHARE: Final = 0.1
"""Interval of layouts: this fraction of the time so far, within these limits."""


class Offering:
    """The layouts of one recording."""

    def __init__(
        self, recording: rr.RecordingStream, contents: Contents, words: Words, *, viewer: str | None, live: bool
    ) -> None:
        """Starts without a layout. viewer: shows the recording while it grows. live: shows it as it happens."""
        self._recording = recording
        self._contents = contents
        self._words = words
        self._viewer = viewer
        self._live = live
        self._client: Any = None
        self._outline: tuple[object, ...] = ()
        self._views: set[str] = set()
        """Ids of the views of the last layout."""
        self._since = self._last = time.monotonic()

    def due(self) -> bool:
        """Returns true if it is time to check for something new."""
        now = time.monotonic()
        return now - self._last >= min(max(_LEAST_S, _SHARE * (now - self._since)), _MOST_S)

    def first(self) -> rrb.Blueprint:
        """Returns the layout before all rows."""
        self._outline, self._last = _outline(self._contents, live=self._live), time.monotonic()
        return self._made()

    def renew(self) -> None:
        """Sends a new layout if it differs."""
        self._last = time.monotonic()
        outline = _outline(self._contents, live=self._live)
        if outline == self._outline:
            return
        self._outline = outline
        taken = self._shown() == self._views
        self._recording.send_blueprint(self._made(), make_active=taken, make_default=True)

    def _made(self) -> rrb.Blueprint:
        made = layout(self._contents, self._words, live=self._live)
        self._views = {str(view.id) for view in _views(getattr(made, "root_container", None))}
        return made

    def _shown(self) -> set[str] | None:
        """Returns the ids of the viewer's views; None if they are unknown."""
        if self._viewer is None:
            return None
        with contextlib.suppress(Exception):  # it is experimental: what it may raise is not said
            from rerun.experimental import ViewerClient

            self._client = self._client or ViewerClient.connect(self._viewer)
            return {str(view.view_id) for view in self._client.get_state().views}
        return None


def _views(part: Any) -> Iterator[Any]:
    if isinstance(part, rrb.Container):
        for one in part.contents:
            yield from _views(one)
    elif part is not None:
        yield part


def _outline(contents: Contents, *, live: bool) -> tuple[object, ...]:
    """Returns the contents as far as layouts depend on them.

    live: without ranges of values, because no axis depends on them.
    """
    return (
        tuple((plot.entity, tuple(one.varies for one in plot.series)) for plot in contents.plots.values()),
        () if live else tuple(contents.ranges.items()),
        () if live else tuple((one.least, one.greatest) for plot in contents.plots.values() for one in plot.series),
        tuple(contents.told),
        tuple((entity, len(levels) > 1) for entity, levels in contents.listed.items()),
        tuple((lane.entity, lane.fault) for lane in contents.lanes.values()),
        frozenset(contents.sync),
        frozenset(contents.windows),
        tuple(contents.delays),
        tuple((bus, charts.axis(contents.peaks.get(bus, 0))) for bus in contents.load),
        contents.frames > 0,
        bool(contents.logged),
        contents.crowded,
        contents.findings > 0,
        tuple(contents.durations) if contents.brief else (),
        contents.summary,
        contents.timed,
    )
