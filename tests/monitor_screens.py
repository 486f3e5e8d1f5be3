"""The screen of `canalyze monitor` as text: captures fully replayed, every view, in a terminal of a given size.

Why it exists: the golden files of the screen, their comparison and the tests of keys need the same application without
a terminal. What it must not do: judge.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

from captures import SAMPLES, described_beside

from canalyze import _core
from canalyze.monitor.app import Monitor
from canalyze.monitor.around import VIEWS
from canalyze.monitor.opening import Watch
from canalyze.running.reading import Reading, SessionOptions
from canalyze.sources import open_capture
from canalyze.sources.replay import Replay
from canalyze.words import Words

SCREENS = (
    SAMPLES / "network" / "sync-and-pdos.log",
    SAMPLES / "services.log",
    SAMPLES / "rules" / "HBT001.log",
    SAMPLES / "sdo-abort.log",
    SAMPLES / "problems.log",
)
"""Captures whose screens are golden files."""
SIZES = ((80, 24), (140, 40))
FOLDER = SAMPLES / "monitor"


def golden(capture: Path, size: tuple[int, int], lang: str) -> Path:
    """The golden file of a capture at a size."""
    return FOLDER / f"{capture.stem}.{size[0]}x{size[1]}.{lang}.txt"


def goldens() -> list[tuple[Path, tuple[int, int], str]]:
    """Every capture, size and language of which there is one."""
    return [(capture, size, lang) for capture in SCREENS for size in SIZES for lang in ("zh", "en")]


def replayed(capture: Path, lang: str) -> Watch:
    """A capture that was replayed as fast as can be."""
    words = Words(lang)
    known = described_beside(capture) or _core.Network(bitrate=500_000)
    session = _core.Session(SessionOptions(lang=lang, format="monitor", network=known))
    frames = _core.Session(SessionOptions(lang=lang, format="convert", to="packed"))

    def open_source(watch: Watch) -> Replay:
        names = (str(capture),)
        results = Reading(frames, words, watch, open_input=open_capture).over(names)
        return Replay(capture.name, results, speed=0.0)

    watch = Watch(session, words, capture.name, open_source, replay=True)
    watch.start()
    end = time.monotonic() + 30
    while not watch.over and time.monotonic() < end:
        time.sleep(0.01)
    assert watch.over and watch.crash is None, watch.crash
    return watch


def text(app: Monitor) -> str:
    """What is on the screen."""
    lines = ("".join(segment.text for segment in strip) for strip in app.screen._compositor.render_strips())
    return "".join(f"{line.rstrip()}\n" for line in lines)


async def settle(app: Monitor, pilot: Any) -> None:
    """Bring the screen up to date and wait until it is drawn."""
    for _ in range(2):
        app.beat()
        await pilot.pause()


def on_screen(
    watch: Any, lang: str, size: tuple[int, int], act: Callable[[Monitor, Any], Awaitable[Any]], **more: Any
) -> Any:
    """Run the application without a terminal and let `act` use it."""

    async def run() -> Any:
        app = Monitor(watch, Words(lang), beat=False, **more)
        async with app.run_test(size=size) as pilot:
            await settle(app, pilot)
            return await act(app, pilot)

    return asyncio.run(run())


def screens(capture: Path, size: tuple[int, int], lang: str) -> str:
    """Every view of a capture, and the page of help, one below the other."""

    async def act(app: Monitor, pilot: Any) -> str:
        shown = []
        for number, view in enumerate(VIEWS, 1):
            await pilot.press(str(number))
            await settle(app, pilot)
            shown.append(f"--- {number} {view}\n{text(app)}")
        await pilot.press("question_mark")
        await pilot.pause()
        shown.append(f"--- ? help\n{text(app)}")
        return "".join(shown)

    found: str = on_screen(replayed(capture, lang), lang, size, act)
    return found
