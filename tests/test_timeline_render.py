"""Timelines drawn by Rerun itself: every view draws without a complaint, in both languages.

Skipped with a line where there is no Vulkan driver (Mesa's lavapipe will do) or no virtual screen. What it must not do:
compare pictures; people look at them (`CANALYZE_PICTURES=FOLDER` keeps them).
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

pytest.importorskip("rerun")

from captures import SAMPLES
from conftest import NOTES, Runner
from test_mcap_writing import NETWORK
from timeline_viewer import Drawn, draw

CAPTURES = {
    "network/sync-and-pdos.log": {"StateTimeline", "TimeSeries", "TextLog", "TextDocument"},
    "network/drive-states.log": {"StateTimeline", "TimeSeries", "TextLog"},
    "sdo-abort.log": {"StateTimeline", "TextLog"},
    "problems.log": {"StateTimeline", "TextLog", "TextDocument"},
}


def drawn(canalyze: Runner, folder: Path, capture: Path, lang: str, *, screen: bool) -> Drawn:
    done = canalyze("--lang", lang, "view", *NETWORK, "--bitrate", "500k", str(capture), "--save", "out.rrd")
    assert done.code == 0, done.err
    kept = os.environ.get("CANALYZE_PICTURES")
    picture = Path(kept) / f"{capture.stem}.{lang}.png" if kept else None
    return draw(folder / "out.rrd", folder, screen=screen, picture=picture)


def agreed(found: Drawn, kinds: set[str]) -> None:
    assert "panicked" not in found.log, found.log
    assert found.reports == []
    assert {view.view_class for view in found.views} >= kinds


@pytest.mark.parametrize("capture", CAPTURES)
def test_every_view_draws(capture: str, canalyze: Runner, tmp_path: Path) -> None:
    agreed(drawn(canalyze, tmp_path, SAMPLES / capture, "en", screen=False), CAPTURES[capture])


def test_without_stamps(canalyze: Runner, tmp_path: Path) -> None:
    """There is no time then, only frames one after the other."""
    (tmp_path / "notes.log").write_text(NOTES)
    agreed(drawn(canalyze, tmp_path, tmp_path / "notes.log", "en", screen=False), {"StateTimeline", "TextLog"})


def test_chinese_draws(canalyze: Runner, tmp_path: Path) -> None:
    capture = "network/drive-states.log"
    agreed(drawn(canalyze, tmp_path, SAMPLES / capture, "zh", screen=True), CAPTURES[capture])
