"""The benchmark's capture is valid CANopen: a program must not be measured on traffic that makes it complain."""

from __future__ import annotations

import itertools
from collections import Counter

import bench_captures
from captures import analyze, read_log
from sdo_reading import read_transfers

FRAMES = 40_000
TEXT = "".join(bench_captures.capture_lines(FRAMES)).encode()


def test_the_mix() -> None:
    kinds = Counter(frame.can_id >> 7 for frame in read_log(TEXT))
    assert kinds.total() == FRAMES
    assert 0.86 < sum(kinds[code] for code in range(3, 0xB)) / FRAMES < 0.90
    assert 0.07 < (kinds[0xB] + kinds[0xC]) / FRAMES < 0.085
    transfers = read_transfers(read_log(TEXT), cut_short=True)
    modes = Counter(transfer.mode for transfer in transfers)
    assert min(modes["expedited"], modes["segmented"], modes["block"]) > 10
    assert sum(transfer.status == "aborted" for transfer in transfers) > 10


def test_time_goes_forward() -> None:
    stamps = [frame.t_us for frame in read_log(TEXT)]
    assert all(before < after for before, after in itertools.pairwise(stamps))


def test_the_program_has_nothing_to_say_about_it() -> None:
    said = analyze(TEXT)
    assert len(said.frames) == FRAMES
    assert not said.above_info(), said.complaint()
    assert len(said.transfers) == len(read_transfers(read_log(TEXT), cut_short=True))
