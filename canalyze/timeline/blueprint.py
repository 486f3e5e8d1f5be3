"""What every layout is put together from: panels, columns of parts, and time axes that zoom as one.

`layout.py` makes one of a recording, `topics.py` one of an MCAP's own topics. Must not: know what is in a view.
"""

from collections.abc import Iterable
from typing import Final

import rerun as rr
import rerun.blueprint as rrb

Part = rrb.Container | rrb.View
Sized = tuple[Part, float]
"""A part and the height that it wants, in points; only proportions count."""

LANE: Final = 38
BAR: Final = 50
TEXT: Final = 400
"""Heights in points: of a lane, of what stands around lanes, of a log."""
TABS: Final = 8
"""Up to so many nodes have tabs beside the overview; more of them have theirs in one tab."""
LINKED: Final = rrb.archetypes.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal)
"""A time axis that zooms with all others."""
_GLOBAL: Final = "view/5c0dca6a-e63f-9cf7-f657-2602590474cc/TimeAxis"
"""The range that linked axes share. Rerun's own id, not public: under another one, only the first zoom is lost."""


class Blueprint(rrb.Blueprint):
    """A layout whose linked time axes open on a range of their own."""

    def __init__(self, root: Part, timeline: str, shown: rr.TimeRange, *, follows: bool = False) -> None:
        """Show `root` over a timeline. shown: its range at first. follows: it goes on with what comes."""
        super().__init__(
            root,
            rrb.BlueprintPanel(state="collapsed"),
            rrb.SelectionPanel(state="collapsed"),
            rrb.TimePanel(state="collapsed", timeline=timeline, play_state="following" if follows else "paused"),
            auto_views=False,
            auto_layout=False,
        )
        self.shown = shown

    def _log_to_stream(self, stream: rr.RecordingStream) -> None:
        super()._log_to_stream(stream)
        stream.log(_GLOBAL, rrb.archetypes.TimeAxis(view_range=self.shown))


def column(parts: Iterable[Sized], name: str | None = None) -> rrb.Container:
    """Put parts below each other, in proportion to the heights that they want."""
    parts = list(parts)
    return rrb.Vertical(*(part for part, _ in parts), row_shares=[height for _, height in parts], name=name)
