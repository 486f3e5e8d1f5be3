"""Names, types and error codes by the device profile of a node, which its device type (1000h) names.

Own figures: a node of each kind is read and sends a PDO. What it must not do: take names of another profile.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import Runner


def log(device_type: int, *, mapped: tuple[int, ...], payload: str, read: tuple[int, str], emcy: int = 0x3210) -> str:
    """Node 5 says what it is, maps its TPDO1, is read at one object, sends the PDO and an emergency."""
    frames = [("605", "4000100000000000"), ("585", "43001000" + device_type.to_bytes(4, "little").hex())]
    for sub, entry in enumerate((len(mapped), *mapped)):
        answer = (
            "4F001A00" + f"{entry:02x}000000" if sub == 0 else f"43001A{sub:02x}" + entry.to_bytes(4, "little").hex()
        )
        frames += [("605", f"40001A{sub:02x}00000000"), ("585", answer)]
    index, value = read
    address = (index >> 8).to_bytes(2, "little").hex() + f"{index & 0xFF:02x}"
    size = len(value) // 2
    frames += [("605", f"40{address}00000000"), ("585", f"{0x43 | (4 - size) << 2:02x}{address}{value:0<8}")]
    frames += [("185", payload), ("085", f"{emcy.to_bytes(2, 'little').hex()}030000000000")]
    return "".join(f"({1700000000 + no / 1000:.6f}) can0 {can_id}#{data}\n" for no, (can_id, data) in enumerate(frames))


@pytest.mark.parametrize(
    ("device_type", "mapped", "payload", "read", "in_sdo", "in_pdo", "in_emcy"),
    [
        (
            0x000F0191,
            (0x64010110, 0x60000108, 0x64110110, 0x61000110),
            "FFFFA5FEFF0100",
            (0x640101, "FFFF"),
            "6401h:01 = -1 (FFFFh)",
            "模拟输入(16位):01=-1, 数字输入(8位):01=A5h, 模拟输出(16位):01=-2, 数字输入(16位):01=0001h",
            "3210h 内部电压过高",
        ),
        (
            0x00020192,
            (0x60410010, 0x60640020),
            "3706FEFFFFFF",
            (0x607A00, "FFFFFFFF"),
            "607Ah:00 = -1 (FFFFFFFFh)",
            "状态字=0637h 运行使能, 位置实际值=-2",
            "3210h 直流母线过压",
        ),
        (
            0x00080196,
            (0x60040020, 0x60300110),
            "FFFFFFFFFEFF",
            (0x600400, "FEFFFFFF"),
            "6004h:00 = 4294967294 (FFFFFFFEh)",
            "位置值=4294967295, 速度值:01=-2",
            "3210h 设备内部电压",
        ),
        (
            0x0004019A,
            (0x60100010, 0x60200010),
            "FFFF0200",
            (0x601000, "FEFF"),
            "6010h:00 = -2 (FFFEh)",
            "纵向倾角(16位)=-1, 横向倾角(16位)=2",
            "3210h 设备内部电压",
        ),
        (
            0x00000000,
            (0x64010110, 0x60000108, 0x60410010),
            "FFFFA53706",
            (0x640101, "FFFF"),
            "6401h:01 = 65535 (FFFFh)",
            "6401h:01=65535 (FFFFh), 6000h:01=165 (A5h), 状态字=0637h 运行使能",
            "3210h 设备内部电压",
        ),
        (
            0x00000198,
            (0x60410010, 0x60400010),
            "37060F00",
            (0x604100, "3706"),
            "6041h:00 = 1591 (0637h)",
            "6041h:00=1591 (0637h), 6040h:00=15 (000Fh)",
            "3210h 设备内部电压",
        ),
    ],
    ids=["401", "402", "406", "410", "unknown", "408, of which nothing is known"],
)
def test_by_device_type(
    device_type: int,
    mapped: tuple[int, ...],
    payload: str,
    read: tuple[int, str],
    in_sdo: str,
    in_pdo: str,
    in_emcy: str,
    canalyze: Runner,
    tmp_path: Path,
) -> None:
    (tmp_path / "x.log").write_text(log(device_type, mapped=mapped, payload=payload, read=read))
    lines = canalyze("decode", "x.log").lines
    (pdo,) = [line for line in lines if "TPDO1:" in line]
    (emcy,) = [line for line in lines if "紧急报文:" in line]
    assert pdo.endswith(in_pdo)
    assert in_emcy in emcy
    assert any(in_sdo in line for line in lines)
    # The finding about the emergency calls it the same.
    assert any(f"报告{in_emcy}" in line for line in lines)


def test_a_drive_is_not_read_as_a_module_nor_the_other_way(canalyze: Runner, tmp_path: Path) -> None:
    both = {"mapped": (0x60070008, 0x60410010, 0x64010110), "payload": "0137060100", "read": (0x604100, "3706")}
    said = {}
    for number in (401, 402):
        (tmp_path / "x.log").write_text(log(number, **both))  # type: ignore[arg-type]
        said[number] = next(line for line in canalyze("--lang", "en", "decode", "x.log").lines if "TPDO1 of" in line)
    assert "statusword" not in said[401] and "6041h:00=" in said[401]
    assert "statusword=0637h" in said[402] and "6401h:01=" in said[402]


def test_machine_output(canalyze: Runner, tmp_path: Path) -> None:
    """The value is the signed number, the type is known."""
    (tmp_path / "x.log").write_text(
        log(0x191, mapped=(0x64010110,), payload="FEFF", read=(0x640101, "FFFF"), emcy=0x2320)
    )
    rows = [json.loads(line) for line in canalyze("--lang", "en", "sdo", "--format", "jsonl", "x.log").lines]
    (row,) = [row for row in rows if row["index"] == "6401"]
    assert (row["value"], row["name"]) == (-1, "read analogue input 16-bit")


def test_a_description_wins(canalyze: Runner, tmp_path: Path) -> None:
    """Its names stay, and its types: a device may differ."""
    (tmp_path / "x.eds").write_text(
        "[DeviceInfo]\n[MandatoryObjects]\nSupportedObjects=1\n1=0x1000\n[1000]\nParameterName=Device Type\n"
        "DataType=7\nAccessType=ro\nDefaultValue=0x00030191\n[OptionalObjects]\nSupportedObjects=1\n1=0x6401\n"
        "[6401]\nParameterName=Channels\nObjectType=8\nSubNumber=2\n[6401sub0]\nParameterName=Count\nDataType=5\n"
        "AccessType=ro\n[6401sub1]\nParameterName=Pressure\nDataType=6\nAccessType=ro\nPDOMapping=1\n"
    )
    (tmp_path / "x.log").write_text(
        log(0x30191, mapped=(0x64010110, 0x60000108), payload="FFFF05", read=(0x640101, "FFFF"))
    )
    (pdo,) = [line for line in canalyze("decode", "--eds", "5=x.eds", "x.log").lines if "TPDO1:" in line]
    assert pdo.endswith("Pressure=65535, 数字输入(8位):01=05h")


def test_explained_without_a_device(canalyze: Runner) -> None:
    said = canalyze("--lang", "en", "explain", "6401:01").out
    assert "  CiA 401: read analogue input 16-bit, INTEGER16\n" in said
    assert "  CiA 406: work area low limit, INTEGER32\n" in said
    assert "402" not in said
    said = canalyze("--lang", "en", "explain", "emcy", "3210").out
    assert "  CiA 401: internal voltage too high\n  CiA 402: DC link over-voltage\n" in said
