"""Captures that are made of configuration: what each write costs must not grow with what was written before.

Times are compared with each other, of files of which one is four times the other; the limits leave much room, and what
grows with the square of a file misses them by far.
"""

import resource
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from conftest import ran

NODES = range(1, 128)
Lines = Iterator[str]


def written(node: int, index: int, sub: int, value: int) -> Lines:
    address = f"{index & 0xFF:02X}{index >> 8:02X}{sub:02X}"
    yield f"{0x600 + node:03X}#23{address}{value.to_bytes(4, 'little').hex().upper()}"
    yield f"{0x580 + node:03X}#60{address}00000000"


def identifiers(count: int) -> Lines:
    """COB-IDs of all PDOs of all nodes."""
    for number in range(count):
        for node in NODES:
            yield from written(node, 0x1800 + number, 1, 1 << 29 | node << 12 | number)


def between_frames(count: int) -> Lines:
    """The same, a frame of a PDO behind each."""
    for number in range(count):
        for node in NODES:
            yield from written(node, 0x1400 + number, 1, 0x300)
            yield "300#0102"


def unanswered(count: int) -> Lines:
    """The same, of which the servers' side is not recorded."""
    for number in range(count):
        for node in NODES:
            yield next(written(node, 0x1800 + number, 1, 1 << 29 | node << 12 | number))
            yield "181#0102"


def resets(count: int) -> Lines:
    """A write and a reset of all nodes, where much is stored."""
    yield from identifiers(count)
    for node in NODES:
        yield from written(node, 0x1010, 1, 0x65766173)
    for number in range(count * 100):
        yield from written(1 + number % 127, 0x1800 + number % count, 1, number)
        yield "000#8100"


def heartbeats(count: int) -> Lines:
    """Who watches whom, and who sends how often."""
    for number in range(count):
        for node in NODES:
            yield from written(node, 0x1016, 1 + number, (1 + number) << 16 | 1000)
            yield from written(node, 0x1017, 0, 100 + number)


def safety(count: int) -> Lines:
    """Records of SRDOs, a frame behind each."""
    for number in range(count):
        for node in NODES:
            pair = 2 * ((node + number) % 64)
            for sub, value in ((1, 1), (5, 0x101 + pair), (6, 0x102 + pair)):
                yield from written(node, 0x1301 + number, sub, value)
            yield "101#01"


def device_types(count: int) -> Lines:
    """A node with many PDOs that is another kind of device again and again."""
    for number in range(count * 8):
        yield from written(5, 0x1400 + number, 1, 1 << 29 | number)
        yield from written(5, 0x1600 + number, 0, 0)
    for number in range(count * 100):
        yield from written(5, 0x1000, 0, 0x191 + number % 2)


def computed() -> float:
    """The seconds that the processes started here have computed; others on the machine do not count, nor do forks."""
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime


@pytest.mark.parametrize(
    "lines",
    [identifiers, between_frames, unanswered, resets, heartbeats, safety, device_types],
    ids=lambda lines: str(lines.__name__),
)
def test_time_is_that_of_the_length(tmp_path: Path, lines: Callable[[int], Lines]) -> None:
    lasted = []
    for count in (16, 64):
        rows = (f"({1_700_000_000 + no / 1000:.6f}) can0 {line}\n" for no, line in enumerate(lines(count)))
        (tmp_path / f"{count}.log").write_text("".join(rows))
        before = computed()
        done = ran(tmp_path, "convert", "--to", "mcap", "--decoded", f"{count}.log", f"{count}.mcap")
        lasted.append(computed() - before)
        assert done.returncode == 0, done.stderr
    short, long = lasted
    assert short > 0, "nothing is measured"
    assert long < 6 * short + 2, lasted
