"""Rerun's viewer drawing a recording without a screen: what its views report, and a picture of them.

English is drawn without a window. The font built into that form has no Chinese, so a virtual screen has to do, where
the system's fonts are used. What it must not do: judge what is drawn.
"""

from __future__ import annotations

import importlib
import os
import shutil
import signal
import socket
import subprocess
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import pytest

RERUN = Path(str(importlib.import_module("rerun_cli").__file__)).with_name("rerun")
SCREEN = ["xvfb-run", "-a", "-s", "-screen 0 1920x1200x24"]
DEADLINE_S = 120.0
SETTLED_S = 3.0
"""Drawing by software: ranges of axes and tables take a while to settle."""


@dataclass(frozen=True)
class Drawn:
    """What came of drawing."""

    views: list[Any]
    """Rerun's own descriptions of views that are in sight."""
    log: str

    @property
    def reports(self) -> list[str]:
        """Complaints of views."""
        return [f"{view.name}: {report.summary}: {report.details}" for view in self.views for report in view.reports]


def missing(what: str) -> NoReturn:
    """Skips the test, unless nothing may be missing."""
    if os.environ.get("CANALYZE_TOOLS") == "required":
        pytest.fail(f"{what}, and CANALYZE_TOOLS=required")
    pytest.skip(f"nothing is drawn: {what}")


def draw(recording: Path, folder: Path, *, screen: bool, picture: Path | None = None) -> Drawn:
    """Draws a recording's first view; the test is skipped where there is nothing to draw with."""
    if screen and shutil.which("xvfb-run") is None:
        missing("xvfb-run is not installed")
    port = free_port()
    line = [str(RERUN), str(recording), "--port", str(port), "--bind", "127.0.0.1", "--window-size", "1920x1200"]
    line += ["--hide-welcome-screen"] if screen else ["--headless", "--hide-welcome-screen"]
    said = folder / "viewer.log"
    environment = os.environ | {"CI": "1", "XDG_RUNTIME_DIR": str(folder), "RUST_LOG": "warn"}
    with (
        said.open("wb") as log,
        subprocess.Popen(
            [*(SCREEN if screen else []), *line], stdout=log, stderr=log, env=environment, start_new_session=True
        ) as viewer,
    ):
        try:
            views = _views(viewer, f"rerun+http://127.0.0.1:{port}/proxy", picture)
        finally:
            # xvfb-run ends its screen when it is told to end, and leaves it when it is killed.
            viewer.terminate()
            try:
                viewer.wait(20)
            except subprocess.TimeoutExpired:
                viewer.kill()
            with suppress(ProcessLookupError):  # a viewer that has lost its screen may go on, and draws for ever
                os.killpg(viewer.pid, signal.SIGKILL)
    text = said.read_text(errors="replace")
    if views is None and ("adapter" in text or "render context" in text):
        missing("the viewer finds no Vulkan driver (mesa-vulkan-drivers)")
    assert views is not None, text
    return Drawn(views, text)


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def _views(viewer: subprocess.Popen[bytes], address: str, picture: Path | None) -> list[Any] | None:
    """Gives the views when they have had time to draw; None where the viewer ends by itself or says nothing."""
    from rerun.experimental import ViewerClient

    until = time.monotonic() + DEADLINE_S
    while time.monotonic() < until and viewer.poll() is None:
        try:
            client = ViewerClient.connect(address)
            state = client.get_state()
        except (ConnectionError, TimeoutError):
            time.sleep(0.2)
            continue
        if state.recordings and state.views and not state.loading:
            time.sleep(SETTLED_S)
            if picture:
                client.save_screenshot(str(picture))
            return list(client.get_state().views)
        time.sleep(0.2)
    return None
