"""Sessions of whole networks, recorded anew on real SocketCAN: what happened is said, and nothing above info.

The recordings under samples/network never change; here the same sessions run again, with this machine's timing. Needs
what `test_candump.py` needs. What it must not do: judge how fast the machine is.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
import test_network_truth as compared
from captures import TESTS, analyze
from record_network import SESSIONS
from test_candump import socketcan  # noqa: F401 - a fixture for every test here

RECORDER = """
from canalyze.sources.library import library
library()  # else python-can loads what only MF4 needs, which takes longer than all the rest
import record_network
record_network.main()
"""


ATTEMPTS = 40


@pytest.mark.parametrize("name", SESSIONS)
def test_a_session_as_it_happened(name: str, tmp_path: Path) -> None:
    """Where the machine has stalled, what comes of it counts only if it is right; else the session runs again."""
    for attempt in range(ATTEMPTS):
        folder = tmp_path / str(attempt)
        recorder = [sys.executable, "-c", RECORDER, "--into", str(folder), "--stalled", name]
        done = subprocess.run(recorder, capture_output=True, text=True, check=False, timeout=120, cwd=TESTS)
        stalled = "attempt" in done.stdout
        try:
            assert done.returncode == 0, done.stdout + done.stderr
            return judge(folder / f"{name}.log")
        except Exception:
            if not stalled or attempt == ATTEMPTS - 1:
                raise
    return None


def judge(log: Path) -> None:
    truth = json.loads(log.with_suffix(".json").read_text())
    described = {row["node"]: row["eds"] for row in truth["nodes"] if row["eds"]}
    for eds in ({}, described):
        said = analyze(log.read_bytes(), eds=eds)
        assert not said.above_info(), said.complaint()
    for compare in (compared.test_nmt, compared.test_boot_ups_and_states, compared.test_emcy, compared.test_lss):
        compare(log)
    compared.compare_signals(log, described=True, only=None)
