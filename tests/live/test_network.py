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
from canalyze.sources.bridge import library
library()  # else python-can loads what only MF4 needs, which takes longer than all the rest
import record_network
record_network.main()
"""


ATTEMPTS = 8
"""Runs of a session: a master whose request was not answered in time, or a frame that was not sent, ends one."""

LATE = {
    *("DRV002", "GRD002", "HBT001", "HBT002", "HBT007", "NMT002", "NMT006", "PDO002", "PDO004", "PDO005", "SDO020"),
    *("SRD002", "SRD003", "SYN003", "SYN004", "SYN008", "SYN009", "SYN010", "SYN013"),
}
"""The findings that are true of a node whose machine gives it no time: it was late, whoever is to blame."""


@pytest.mark.parametrize("name", SESSIONS)
def test_a_session_as_it_happened(name: str, tmp_path: Path) -> None:
    """Where the recorder itself saw periods that were not kept, the nodes were late, and may be reported as that."""
    recorder = [sys.executable, "-c", RECORDER, "--into", str(tmp_path), "--stalled", name]
    for _ in range(ATTEMPTS):
        done = subprocess.run(recorder, capture_output=True, text=True, check=False, timeout=120, cwd=TESTS / "record")
        if done.returncode == 0:
            break
    assert done.returncode == 0, done.stdout + done.stderr
    judge(tmp_path / f"{name}.log", LATE if "attempt" in done.stdout else set())


def judge(log: Path, allowed: set[str]) -> None:
    truth = json.loads(log.with_suffix(".json").read_text())
    described = {row["node"]: row["eds"] for row in truth["nodes"] if row["eds"]}
    for eds in ({}, described):
        said = analyze(log.read_bytes(), eds=eds)
        assert {finding["code"] for finding in said.above_info()} <= allowed, said.complaint()
    for compare in (compared.test_nmt, compared.test_boot_ups_and_states, compared.test_emcy, compared.test_lss):
        compare(log)
    compared.compare_signals(log, described=True, only=None)
