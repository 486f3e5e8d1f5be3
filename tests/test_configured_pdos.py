"""TPDOs against the configuration that the capture shows: never sent, at another interval, or without SYNC.

Each capture is made, so that the truth is known: the fault at several magnitudes, and beside it what is none. What it
must not do: test PDOs that came as configured and stopped.
"""

from __future__ import annotations

import pytest
from captures import Row
from diagnoses import diagnosed
from test_neighbouring_verdicts import Frames, beats, log

NODE = 5
START: Frames = [(0.5, "000#0100")]
OTHERS = [(1 + place / 5, "186#0102") for place in range(150)]
"""TPDOs of another node: the recorder has not left PDOs out."""


def written(*writes: str, since: float = 0.1) -> Frames:
    """Acknowledged writes of index, sub-index and data, as in the frame."""
    rows: Frames = []
    for place, (at, data) in enumerate((one[:6], one[6:]) for one in writes):
        command = f"{0x2F - 4 * (len(data) // 2 - 1):02X}"
        moment = since + place / 100
        rows.append((moment, f"{0x600 + NODE:03X}#{command}{at}{data:0<8}"))
        rows.append((moment + 0.001, f"{0x580 + NODE:03X}#60{at}00000000"))
    return rows


def configured(kind: int, timer_ms: int = 0, *, used: bool = True) -> Frames:
    """The configuration of TPDO1."""
    timer = timer_ms.to_bytes(2, "little").hex().upper()
    cob = "85010040" if used else "850100C0"
    return written("001801850100C0", f"001802{kind:02X}", f"001805{timer}", f"001801{cob}")


def up(until: float = 31, state: str = "05") -> Frames:
    """Heartbeats of the node, Operational from 0.6 s on."""
    return [*beats(NODE, 0.2, 0.4, "7F"), *beats(NODE, 0.2, until, state, 0.6)]


def sent(interval: float, since: float = 1.0, until: float = 31) -> Frames:
    """TPDO1."""
    return [(since + place * interval, "185#0102") for place in range(round((until - since) / interval))]


def syncs(interval: float = 0.02, count: int = 1500) -> Frames:
    return [(1 + place * interval, "080#") for place in range(count)]


def roots(*parts: Frames) -> list[tuple[str, str]]:
    """Kind and status of what is not harmless."""
    return [(one["problem"], one["status"]) for one in diagnosed(log(*parts)).roots]


def first(*parts: Frames) -> Row:
    return diagnosed(log(*parts)).roots[0]


@pytest.mark.parametrize("timer_ms", [20, 100, 500, 2000])
def test_a_tpdo_with_an_event_timer_that_never_comes(timer_ms: int) -> None:
    parts = (configured(255, timer_ms), START, up(), OTHERS)
    assert roots(*parts) == [("pdo-never-sent", "open")]
    assert first(*parts)["subject"]["node"] == NODE
    assert not roots(*parts, sent(timer_ms / 1000)), "it comes"
    assert not roots(*parts, [(30.99, "185#0102")]), "it comes once, at the end"


@pytest.mark.parametrize("kind", [1, 2, 10, 60])
def test_a_synchronous_tpdo_that_never_comes(kind: int) -> None:
    parts = (configured(kind), START, up(), syncs())
    assert roots(*parts) == [("pdo-never-sent", "open")]
    as_due = [(at + 0.001, "185#0102") for at, _ in syncs()[::kind]]
    assert not roots(*parts, as_due)


@pytest.mark.parametrize("kind", [0, 1, 252, 253, 254, 255])
def test_what_does_not_ask_for_a_tpdo(kind: int) -> None:
    """SYNC alone, or nothing at all: a PDO of these types needs an event, a request or SYNC."""
    parts = (configured(kind), START, up(), OTHERS)
    assert roots(*parts) == ([("sync-never", "open")] if kind == 1 else [])
    if kind != 1:
        assert not roots(*parts, syncs())


def test_a_tpdo_that_is_not_in_use_is_not_owed() -> None:
    for kind in (1, 255):
        assert not roots(configured(kind, 100, used=False), START, up(), syncs(), OTHERS)
        assert not roots(configured(kind, 100), up(state="7F"), syncs(), OTHERS), "not Operational"
        assert not roots(configured(kind, 100), written("001A0000", since=0.05), START, up(), syncs(), OTHERS), (
            "maps nothing"
        )


@pytest.mark.parametrize("kind", [1, 255])
@pytest.mark.parametrize("cob", ["181", "201", "381", "690"])
def test_a_tpdo_with_the_can_id_of_another_kind_comes(kind: int, cob: str) -> None:
    """As where nodes exchange PDOs without a master, which is how a TPDO has the default CAN-ID of an RPDO."""
    place = f"{cob[1:]}0{cob[0]}00"
    linked = written(f"001801{place}C0", f"001802{kind:02X}", "0018056400", f"001801{place}40")
    came = [(1.001 + number / 50, f"{cob}#0102") for number in range(1500)]
    assert not roots(linked, START, up(), beats(1, 0.2, 31), syncs(), came)


@pytest.mark.parametrize("kind", [1, 255])
def test_a_multiplex_pdo_comes(kind: int) -> None:
    came = [(1.001 + number / 50, "185#0500200111223344") for number in range(1500)]
    assert not roots(written("001A00FE", since=0.05), configured(kind, 100), START, up(), syncs(), came)


def test_a_second_sync_producer_explains_the_number_of_syncs() -> None:
    """The PDO follows one of two: it comes with every other SYNC."""
    parts = (configured(1), START, up(), syncs(), [(at + 0.001, "185#0102") for at, _ in syncs()])
    assert not roots(*parts)
    kinds = [kind for kind, _ in roots(*parts, [(at + 0.003, "080#") for at, _ in syncs()])]
    assert kinds == ["two-sync-producers"]


@pytest.mark.parametrize("kind", [1, 255])
def test_a_configuration_from_before_a_boot_up_need_not_hold(kind: int) -> None:
    booted = [(0.45, "705#00")]
    rest = syncs() if kind == 1 else []
    found = {one for one, _ in roots(configured(kind, 100), booted, START, up(), OTHERS, rest)}
    assert not found & {"pdo-never-sent", "sync-never"}


def test_a_recorder_may_have_left_pdos_out() -> None:
    """Without any PDO or SYNC in the capture nothing is known of them."""
    for kind in (1, 255):
        assert not roots(configured(kind, 100), START, up())


@pytest.mark.parametrize("until", [1.0, 1.5])
def test_an_excerpt_may_end_before_it_comes(until: float) -> None:
    for kind in (1, 255):
        assert not roots(configured(kind, 100), START, up(until), OTHERS[:2], syncs(count=15))


@pytest.mark.parametrize("timer_ms", [30, 100, 500])
@pytest.mark.parametrize("part", [1.5, 2.0, 2.5, 3.0, 10.0])
def test_a_tpdo_that_always_comes_at_a_longer_interval(timer_ms: int, part: float) -> None:
    until = 1 + 30 * part * timer_ms / 1000
    parts = (configured(255, timer_ms), START, up(until))
    assert roots(*parts, sent(part * timer_ms / 1000, until=until + 0.5)) == [("pdo-interval", "open")]
    assert not roots(*parts, sent(timer_ms / 1000, until=until + 0.5)), "as configured"
    assert not roots(*parts, sent(timer_ms / 2500, until=until + 0.5)), "more often, by events"


@pytest.mark.parametrize("missing", [1, 2, 5])
def test_tpdos_that_are_missing_now_and_then_are_no_interval(missing: int) -> None:
    every = sent(0.1)
    some = [frame for place, frame in enumerate(every) if place % 30 >= missing]
    kinds = {kind for kind, _ in roots(configured(255, 100), START, up(), some)}
    assert "pdo-interval" not in kinds


def test_a_longer_interval_that_stops_has_stopped() -> None:
    parts = (configured(255, 100), START, up(), sent(0.3, until=15), OTHERS)
    assert sorted(roots(*parts)) == [("pdo-interval", "open"), ("pdo-missing", "open")]


@pytest.mark.parametrize(("kind", "every"), [(1, 2), (1, 5), (2, 1), (2, 4), (4, 2), (10, 3)])
def test_a_synchronous_tpdo_with_another_number_of_syncs(kind: int, every: int) -> None:
    parts = (configured(kind), START, up(), syncs())
    found = [(at + 0.001, "185#0102") for at, _ in syncs()[::every]]
    assert roots(*parts, found) == [("pdo-interval", "open")]


def test_a_timer_that_is_written_to_fit_is_kept() -> None:
    again = [(15.0, "605#2B001805C8000000"), (15.001, "585#6000180500000000")]
    assert "pdo-interval" not in {kind for kind, _ in roots(configured(255, 100), START, up(), sent(0.2), again)}


def test_an_interval_that_is_right_again_is_none() -> None:
    parts = (configured(255, 100), START, up())
    assert not roots(*parts, sent(0.13, until=15), sent(0.1, 15.1, 31))


@pytest.mark.parametrize("inhibit_ms", [150, 200, 500])
def test_an_inhibit_time_that_is_longer_than_the_event_timer(inhibit_ms: int) -> None:
    inhibit = (inhibit_ms * 10).to_bytes(2, "little").hex().upper()
    parts = (written(f"001803{inhibit}", since=0.05), configured(255, 100), START, up())
    assert not roots(*parts, sent(inhibit_ms / 1000))
    assert roots(*parts, sent(2 * inhibit_ms / 1000)) == [("pdo-interval", "open")]


@pytest.mark.parametrize("start", [1, 100, 240])
def test_a_tpdo_may_wait_for_the_sync_of_its_start_value(start: int) -> None:
    counted = [(at, f"080#{number % 240 + 1:02X}") for number, (at, _) in enumerate(syncs(0.1, 90))]
    waits = written("001019F0", f"001806{start:02X}", since=0.02)
    assert "pdo-never-sent" not in {kind for kind, _ in roots(waits, configured(1), START, up(10), counted)}


@pytest.mark.parametrize(("timer_ms", "tick"), [(400, 0.5), (80, 0.1), (40, 0.055), (20, 0.0156)])
def test_coarse_stamps_show_no_longer_interval(timer_ms: int, tick: float) -> None:
    parts = (configured(255, timer_ms), START, up(), sent(timer_ms / 1000), OTHERS)
    coarse = [(round(at // tick * tick, 6), frame) for part in parts for at, frame in part]
    for last in range(20):
        cut = sorted(coarse)[: len(coarse) - 7 * last]
        assert "pdo-interval" not in {kind for kind, _ in roots(cut)}


def test_a_node_that_left_operational_by_itself_may_have_restarted() -> None:
    fell = [*beats(NODE, 0.2, 12, "05", 0.6), *beats(NODE, 0.2, 15, "7F", 14), *beats(NODE, 0.2, 31, "05", 15.2)]
    again = [(15.1, "000#0105")]
    kinds = {
        kind
        for kind, _ in roots(configured(255, 100), START, fell, again, OTHERS, sent(0.1, until=12), sent(0.3, 15.3))
    }
    assert "pdo-interval" not in kinds
