"""Five small captures, one scenario each, generated frame by frame; `canalyze/examples/` has them as files.

A capture is text in candump's log form. Its nodes behave as defined in CiA 301 and 402. `python tests/regenerate.py`
writes the files; `test_cli_examples.py` holds that they are current. Must not: know the program's output.
"""

from collections.abc import Callable, Mapping
from typing import Final

_BEGIN: Final = 1_700_000_000.0
"""The first stamp, in s."""
_ANSWER: Final = 0.0011
"""The response time of a server, in s."""


class _Log:
    """A capture under construction."""

    def __init__(self) -> None:
        self._frames: list[tuple[float, int, bytes]] = []

    def add(self, at: float, can_id: int, data: str = "") -> None:
        """Adds a frame at a time in s since the beginning."""
        self._frames.append((at, can_id, bytes.fromhex(data)))

    def write(self, at: float, node: int, index: int, sub: int, value: int, size: int, abort: int = 0) -> float:
        """Adds an expedited SDO write; returns the time for the next one. abort: the code of a refusal."""
        object_ = index.to_bytes(2, "little").hex() + f"{sub:02x}"
        command = {1: "2f", 2: "2b", 4: "23"}[size]
        self.add(at, 0x600 + node, command + object_ + value.to_bytes(4, "little").hex())
        answer = "80" + object_ + abort.to_bytes(4, "little").hex() if abort else "60" + object_ + "00000000"
        self.add(at + _ANSWER, 0x580 + node, answer)
        return at + 0.004

    def beat(self, node: int, state: int, since: float, until: float, period: float) -> None:
        """Adds heartbeats."""
        beats = int((until - since) / period)
        for beat in range(beats):
            self.add(since + beat * period, 0x700 + node, f"{state:02x}")

    def text(self) -> str:
        """Returns the capture."""
        frames = sorted(self._frames, key=lambda frame: frame[0])
        lines = (f"({_BEGIN + at:.6f}) can0 {can_id:03X}#{data.hex().upper()}\n" for at, can_id, data in frames)
        return "".join(lines)


def _booted(*nodes: int) -> _Log:
    """Returns a capture of nodes that boot, get a heartbeat time of 200 ms, and are started at 0.5 s."""
    log = _Log()
    for place, node in enumerate(nodes):
        log.add(0.01 * place, 0x700 + node, "00")
        log.write(0.1 + 0.02 * place, node, 0x1017, 0, 200, 2)
    log.add(0.5, 0, "0100")
    return log


def _lost() -> str:
    """Node 9 falls silent and stays so; node 4, which watches it, reports that."""
    log = _booted(3, 4, 9)
    log.write(0.3, 4, 0x1016, 1, 0x000901F4, 4)
    for node, last in ((3, 8.0), (4, 8.0), (9, 5.3)):
        log.beat(node, 5, 0.55 + node / 1000, last, 0.2)
    log.add(4.959 + 0.502, 0x084, "3081100000000000")
    return log.text()


def _restarted() -> str:
    """Node 3 loses its power, comes back with an unrequested boot-up, and is started again later."""
    log = _booted(3, 7)
    log.beat(7, 5, 0.557, 8.0, 0.2)
    log.beat(3, 5, 0.553, 2.5, 0.2)
    log.add(4.0, 0x703, "00")
    log.write(4.2, 3, 0x1017, 0, 200, 2)
    log.beat(3, 0x7F, 4.253, 5.0, 0.2)
    log.add(5.0, 0, "0103")
    log.beat(3, 5, 5.053, 8.0, 0.2)
    return log.text()


def _refused() -> str:
    """A PDO mapping is written in the wrong order, refused, and then written as it should be."""
    log = _booted(6, 7)
    at = log.write(0.30, 6, 0x1A00, 1, 0x60000108, 4, 0x06010000)
    at = log.write(at, 6, 0x1A00, 0, 2, 1, 0x06040041)
    at = log.write(at + 0.02, 6, 0x1800, 1, 0x80000186, 4)
    at = log.write(at, 6, 0x1A00, 0, 0, 1)
    at = log.write(at, 6, 0x1A00, 1, 0x60000108, 4)
    at = log.write(at, 6, 0x1A00, 2, 0x60000208, 4)
    at = log.write(at, 6, 0x1A00, 0, 2, 1)
    log.write(at, 6, 0x1800, 1, 0x00000186, 4)
    for node in (6, 7):
        log.beat(node, 5, 0.55 + node / 1000, 6.0, 0.2)
    for beat in range(50):
        log.add(0.61 + beat * 0.1, 0x186, f"{beat % 256:02x}01")
    return log.text()


def _drive() -> str:
    """The drive of node 5 faults with EMCY 2310h; the first reset has no effect, the second one has."""
    log = _booted(5, 7)
    at = 0.25
    for index, sub, value, size in (
        *((0x1A00, 0, 0, 1), (0x1A00, 1, 0x60410010, 4), (0x1A00, 0, 1, 1)),
        *((0x1600, 0, 0, 1), (0x1600, 1, 0x60400010, 4), (0x1600, 0, 1, 1)),
    ):
        at = log.write(at, 5, index, sub, value, size)
    steps = [(0.6, "0000", "5002"), (1.0, "0600", "3102"), (1.2, "0700", "3302"), (1.4, "0F00", "3702")]
    steps += [(4.0, "0F00", "1802"), (5.0, "8000", "1802"), (5.2, "0000", "1802"), (6.5, "8000", "5002")]
    steps += [(6.7, "0600", "3102"), (6.9, "0700", "3302"), (7.1, "0F00", "3702")]
    for (since, command, state), until in zip(steps, [*(step[0] for step in steps[1:]), 9.0], strict=True):
        for cycle in range(int((until - since) / 0.05)):
            log.add(since + cycle * 0.05, 0x205, command)
            log.add(since + cycle * 0.05 + 0.006, 0x185, state)
    log.add(4.002, 0x085, "1023030000000000")
    log.add(6.52, 0x085, "0000000000000000")
    for node in (5, 7):
        log.beat(node, 5, 0.55 + node / 1000, 9.0, 0.2)
    return log.text()


def _healthy() -> str:
    """No problem: the master resets all nodes on the way."""
    log = _booted(3, 4)
    for node in (3, 4):
        log.beat(node, 5, 0.55 + node / 1000, 3.0, 0.2)
        log.add(3.3 + node / 100, 0x700 + node, "00")
        log.write(3.4 + node / 50, node, 0x1017, 0, 200, 2)
        log.beat(node, 5, 4.05 + node / 1000, 8.0, 0.2)
    log.add(3.0, 0, "8100")
    log.add(4.0, 0, "0100")
    return log.text()


EXAMPLES: Final[Mapping[str, Callable[[], str]]] = {
    "node-lost.log": _lost,
    "node-restarted.log": _restarted,
    "mapping-refused.log": _refused,
    "drive-fault.log": _drive,
    "all-well.log": _healthy,
}
"""Functions that generate the captures, by file name."""
