"""PDOs as a DBC file: cantools decodes by it what `canalyze signals` shows, and what it cannot hold is named."""

from __future__ import annotations

import random
import sys
from pathlib import Path

import bench_captures
import pytest
from captures import DATA, EDS, SAMPLES, CanFrame, log_text, run_canalyze
from dbc_decoding import compare

DEVICES = ["--eds", f"5={EDS / 'drive.eds'}", "--eds", f"6={EDS / 'io.eds'}", "--eds", f"7={EDS / 'encoder.eds'}"]


def test_random_payloads_are_decoded_alike(tmp_path: Path) -> None:
    source = random.Random(2106)
    ids = [(0x185, False), (0x285, False), (0x1F385, True), (0x1A0, False)]
    frames = [
        CanFrame("can0", can_id, source.randbytes(8), number * 1000, extended)
        for number, (can_id, extended) in enumerate(source.choices(ids, k=2000))
    ]
    (tmp_path / "odd.log").write_bytes(log_text(frames))
    counted = compare(tmp_path / "odd.log", ["--eds", f"5={DATA / 'dbc_odd.eds'}"], tmp_path)
    assert counted["equal"] > 4000 and not counted["another mapping"] and not counted["only DBC"]


@pytest.mark.parametrize(
    ("capture", "options", "equal", "others"),
    [
        ("network/sync-and-pdos", DEVICES, 333, {}),
        ("network/remapping", DEVICES, 113, {"another mapping": 19}),
        ("network/remapping", [], 54, {"another mapping": 12, "only DBC": 9}),
        ("network/multiplex-and-safety", [], 20, {}),
        ("network/drive-states", DEVICES, None, {}),
        ("stacks/c3-pdo-remap-master-sync", [], 165, {"another mapping": 13}),
    ],
)
def test_captures_are_decoded_alike(
    capture: str, options: list[str], equal: int | None, others: dict[str, int], tmp_path: Path
) -> None:
    """Where a mapping has changed, frames by an earlier one are not compared, and how many these are is known."""
    counted = compare(SAMPLES / f"{capture}.log", options, tmp_path)
    assert equal is None or counted.pop("equal") == equal
    assert {key: count for key, count in counted.items() if count and key != "equal"} == others


def test_a_large_capture_is_decoded_alike(tmp_path: Path) -> None:
    """The benchmark's traffic; of a million frames `tests/dbc_decoding.py` tells the same."""
    capture = tmp_path / "capture.log"
    bench_captures.make(capture, 20_000)
    counted = compare(capture, ["--eds", f"1-8={EDS / 'drive.eds'}"], tmp_path)
    assert counted["equal"] > 20_000 and counted["equal"] == sum(counted.values())


def test_the_listing_alone_does_not_need_cantools() -> None:
    """It is imported where a file is made."""
    code = "import sys, canalyze.commands.od, canalyze.commands.eds; print('cantools' in sys.modules)"
    import subprocess

    assert subprocess.check_output([sys.executable, "-c", code], text=True).strip() == "False"
    assert run_canalyze(["eds", EDS / "drive.eds"])
