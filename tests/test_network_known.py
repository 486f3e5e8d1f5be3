"""From options, canalyze.toml and descriptions to what the core is told: rows of a description, who carries which."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest
from captures import DATA

from canalyze import _core
from canalyze.configuration import network
from canalyze.configuration.config import Config, read
from canalyze.configuration.network import Known
from canalyze.configuration.network import network as told
from canalyze.dictionary import Dictionary, load, rows, table
from canalyze.dictionary import read as read_description
from canalyze.errors import ConfigError, SourceError
from canalyze.words import Words

OWN = Path(__file__).parent.parent / "eds"
DCF = (DATA / "five.dcf").read_text()
ROWS = [
    (0x1014, 0, "COB-ID EMCY", 7, "rw", 0x80, True, False, False, "", 1.0),
    (0x1017, 0, "Heartbeat", 6, "rw", 500, False, True, False, "", 1.0),
    (0x2000, 0, "negative", 2, "rww", -2, False, False, True, "", 1.0),
    (0x2001, 0, "text", 9, "const", None, False, True, False, "", 1.0),
    (0x2002, 0, "real", 8, "ro", None, False, False, False, "", 1.0),
    (0x2003, 0, "wide", 0x1B, "wo", 0xFFFF_FFFF_FFFF_FFFF, False, False, False, "", 1.0),
    (0x2004, 0, "named by its node", 7, "rwr", 0x4000_0180, True, True, False, "", 1.0),
    (0x2005, 0, "scaled", 3, "ro", None, False, False, False, "degC", 0.1),
    (0x2006, 0, "below", 4, "ro", -8, True, False, False, "", 1.0),
    (0x2007, 0, "flag", 1, "ro", 1, False, False, False, "", 1.0),
]


class Recorder:
    """Stands for a class of the core: keeps what it was made of."""

    def __init__(self, **given: Any) -> None:
        """Keep it."""
        self.given = given


@pytest.fixture
def recorded(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let what is told to the core be seen."""
    monkeypatch.setattr(_core, "Network", Recorder, raising=False)


def tell(filed: Known = Known(), given: Known = Known()) -> dict[str, Any]:  # noqa: B008
    """Give what the core is told."""
    found: Any = told(filed, given, Words("en"))
    return dict(found.given)


def on(*texts: str) -> Known:
    """Give what --eds says."""
    return Known(descriptions=tuple(found for text in texts if (found := network.description(text))))


def carried(said: dict[str, Any]) -> list[tuple[str | None, int, str]]:
    """Give who carries which file."""
    return [(bus, node, Path(table.file).name) for bus, node, table in said["descriptions"]]


def test_rows_of_a_dcf() -> None:
    assert list(rows(read_description(DCF.encode(), "five.dcf").objects)) == ROWS


def test_node_that_is_asked_for_leaves_the_rows_alone() -> None:
    assert list(rows(read_description(DCF.encode(), "five.dcf", 9).objects)) == ROWS


@pytest.mark.parametrize("name", ["drive.eds", "io.eds", "encoder.eds"])
def test_rows_hold_every_entry(name: str) -> None:
    found = load(str(OWN / name))
    made = list(rows(found.objects))
    assert [row[:3] for row in made] == [(e.index, e.sub, e.name) for thing in found.objects for e in thing.entries]


@pytest.mark.parametrize("name", ["drive.eds", "io.eds", "encoder.eds"])
def test_core_takes_rows(name: str) -> None:
    """Rows of what is put together in Python have the same PDOs as the table that the core has read."""
    found = load(str(OWN / name))
    made = table(name, found.form, found.device.product_name, found.objects)
    pdos = [[(pdo.number, pdo.cob_id, pdo.bits) for pdo in of.pdos([])] for of in (made, found.table)]
    assert pdos[0] == pdos[1] != []


def test_a_file_name_that_is_no_text() -> None:
    assert read_description(DCF.encode(), "f\udcff.dcf").table.file == "f\\xff.dcf"


def test_nothing_known_is_nothing_told(recorded: None) -> None:
    assert told(Known(), Known(), Words("en")) is None


def test_one_file_for_many_nodes_is_read_once(recorded: None, monkeypatch: pytest.MonkeyPatch) -> None:
    loads: list[str] = []

    def counted(name: str, node: int | None = None) -> Dictionary:
        loads.append(name)
        return load(name, node)

    monkeypatch.setattr("canalyze.dictionary.load", counted)
    name = str(OWN / "io.eds")
    said = tell(on(f"20={name}"), on(f"1-3={name}", f"can1:9={name}"))
    assert carried(said) == [(bus, node, "io.eds") for bus, node in ((None, 1), (None, 2), (None, 3), ("can1", 9))] + [
        (None, 20, "io.eds")
    ]
    assert loads == [name]
    assert len({id(table) for _, _, table in said["descriptions"]}) == 1


def test_option_overrules_the_file_by_node_and_bus(recorded: None) -> None:
    drive, io = str(OWN / "drive.eds"), str(OWN / "io.eds")
    filed = on(f"5,6={drive}", f"can1:7={drive}", "8=missing.eds")
    assert carried(tell(filed, on(f"5,7,8={io}", f"can1:6={io}"))) == [
        (None, 5, "io.eds"),
        (None, 7, "io.eds"),
        (None, 8, "io.eds"),
        ("can1", 6, "io.eds"),
        (None, 6, "drive.eds"),
    ]


def test_node_of_a_dcf(recorded: None, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    dcf = tmp_path / "five.dcf"
    dcf.write_text(DCF)
    assert carried(tell(on(str(dcf)))) == [(None, 5, "five.dcf")]
    assert carried(tell(on(str(dcf)), on(f"5={OWN / 'io.eds'}"))) == [(None, 5, "io.eds")]
    assert "DCF of" not in capfd.readouterr().err
    assert carried(tell(on(f"5-7={dcf}"))) == [(None, node, "five.dcf") for node in (5, 6, 7)]
    (line,) = [line for line in capfd.readouterr().err.splitlines() if "DCF of" in line]
    assert line.startswith(f"canalyze: {dcf}: DCF of node 5, used for 6, 7;")


def test_description_without_a_node(recorded: None) -> None:
    with pytest.raises(SourceError, match=r"drive\.eds: no node-ID; give one, as --eds 5="):
        tell(on(str(OWN / "drive.eds")))


def test_two_descriptions_of_one_node(recorded: None) -> None:
    with pytest.raises(ConfigError, match=r"node 5 has two device descriptions, .*drive\.eds and .*io\.eds"):
        tell(on(f"5={OWN / 'drive.eds'}", f"1-9={OWN / 'io.eds'}"))
    with pytest.raises(ConfigError):
        tell(Known(), on(f"can1:5={OWN / 'drive.eds'}", f"can1:5={OWN / 'io.eds'}"))


def test_everything_else_as_the_core_wants_it(recorded: None) -> None:
    cob, sdo = network.cob("can1:000001A5=5.RPDO2"), network.sdo_channel("640,5C0=5")
    assert cob and sdo
    pdo, profile = network.pdo_mapping("185=6041:16"), network.profile("5-6=402")
    assert pdo and profile
    known = Known((), (cob,), (sdo,), 1_000_000, 500_000, 0, 125_000, (pdo,), (profile,))
    assert tell(given=known) == {
        "descriptions": [],
        "cobs": [("can1", 0x1A5, True, 5, "rpdo", 2)],
        "values": [(None, 5, 0x1A00, 0, 1), (None, 5, 0x1A00, 1, 0x60410010)],
        "profiles": [(None, 5, 402), (None, 6, 402)],
        "sdos": [(None, 0x640, False, 0x5C0, False, 5)],
        "sync_period_ns": 1_000_000,
        "sync_window_ns": 500_000,
        "jitter_ns": 0,
        "bitrate": 125_000,
    }


def test_defects_are_one_line_a_file(recorded: None, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    odd = tmp_path / "odd one.eds"
    odd.write_text("[1017]\nParameterName=a\nObjectType=7\nDataType=6\nAccessType=read\nDefaultValue=x\n" * 3)
    tell(on(f"1-9={odd}", f"20={OWN / 'drive.eds'}"))
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith(f"canalyze: {odd}: ")
    assert line.endswith(f"1 entry not used; see canalyze eds '{odd}'")


def test_defects_beyond_those_kept_are_counted(
    recorded: None, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    odd = tmp_path / "odd.eds"
    odd.write_text("[1017]\nParameterName=a\nObjectType=7\nDataType=6\nAccessType=rw\n" + "no equals\n" * 1500)
    tell(on(f"1={odd}"))
    assert "1500 entries not used;" in capfd.readouterr().err


def test_canalyze_toml(tmp_path: Path) -> None:
    file = tmp_path / "canalyze.toml"
    file.write_bytes((DATA / "network.toml").read_bytes())
    cob = network.cob("1A5=5.TPDO1")
    sdo = network.sdo_channel("can0:00000640,5C0=5")
    assert cob and sdo
    known = Known(
        (
            network.Description("can1", (5, 16), str(tmp_path / "eds/drive.eds")),
            network.Description(None, (1, 2, 3, 7), "/io.eds"),
            network.Description(None, (), str(tmp_path / "own.dcf")),
        ),
        (cob,),
        (sdo,),
        1_000_000,
        500,
        200_000,
        500_000,
    )
    assert read(str(file)) == Config("en", True, known)


@pytest.mark.parametrize("mistake", tomllib.loads((DATA / "settings.toml").read_text())["mistake"])
def test_what_cannot_be_in_canalyze_toml(tmp_path: Path, mistake: dict[str, str]) -> None:
    file = tmp_path / "canalyze.toml"
    file.write_text(mistake["content"])
    with pytest.raises(ConfigError) as raised:
        read(str(file))
    assert str(raised.value) == f"{file}{mistake['said']}"
    assert f"{file}{mistake['said'].partition(' ')[0][:-1]}：" in raised.value.in_words(Words("zh"))
