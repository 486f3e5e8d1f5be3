"""Compressed files and text of another encoding are read as what is in them; damage costs little and is reported."""

from __future__ import annotations

import bz2
import gzip
import json
import lzma
import random
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import NOTES, Runner, environment, runner

from canalyze.sources.compressed import PIECE, Damage, Unpacked

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd


@pytest.fixture
def canalyze(tmp_path: Path) -> Runner:
    """One process runs all of them: there are many, and they only read and write."""
    return runner(tmp_path, kept=True)


def _zstd(data: bytes) -> bytes:
    return zstd.compress(data, options={zstd.CompressionParameter.checksum_flag: 1})


PACK: dict[str, Callable[[bytes], bytes]] = {
    "gzip": gzip.compress,
    "xz": lzma.compress,
    "bzip2": bz2.compress,
    "zstd": _zstd,
}
ENDINGS = {"gzip": "gz", "xz": "xz", "bzip2": "bz2", "zstd": "zst"}
FORMS = sorted(PACK)
RANDOM = random.Random(5)
LOG = b"".join(b"(%d.%06d) can0 185#%016X\n" % (n // 1000, n, RANDOM.getrandbits(64)) for n in range(20_000))


class Bytes:
    """A layer of bytes that come in pieces."""

    damage = None
    begins = False

    def __init__(self, data: bytes, piece: int = PIECE) -> None:
        """Take them, and how many come at once."""
        self.data = data
        self.piece = piece

    def read(self) -> bytes:
        given, self.data = self.data[: self.piece], self.data[self.piece :]
        return given


def unpacked(data: bytes, form: str, piece: int = PIECE) -> tuple[bytes, Damage | None]:
    layer = Unpacked(Bytes(data, piece), form)
    found = b""
    while got := layer.read():
        assert len(got) <= PIECE
        found += got
    assert layer.read() == b""
    return found, layer.damage


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("piece", [1, 5, 4096, PIECE])
def test_any_chunking_gives_the_same(form: str, piece: int) -> None:
    text = LOG[:100_000]
    assert unpacked(PACK[form](text), form, piece) == (text, None)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("piece", [3, PIECE])
def test_members_one_after_the_other(form: str, piece: int) -> None:
    pack = PACK[form]
    data = pack(b"one\n") + pack(b"") + pack(b"two\n") + bytes(512) + pack(b"three\n") + bytes(64)
    assert unpacked(data, form, piece) == (b"one\ntwo\nthree\n", None)
    assert unpacked(pack(b"one\n") + b"no member", form, piece) == (b"one\n", Damage("rest", len(pack(b"one\n")), 9))


@pytest.mark.parametrize("form", FORMS)
def test_cut_at_every_byte(form: str) -> None:
    whole = PACK[form](LOG[:300]) + PACK[form](LOG[300:600])
    first = len(PACK[form](LOG[:300]))
    for end in range(8, len(whole)):
        found, damage = unpacked(whole[:end], form)
        assert LOG.startswith(found)
        assert damage == (None if end == first else Damage("cut", end, None)) or end in range(first, first + 6), end
        if end >= first:
            assert len(found) >= 300


@pytest.mark.parametrize("form", FORMS)
def test_damage_keeps_what_comes_before_it(form: str) -> None:
    whole = PACK[form](LOG) * 2
    for at in (len(whole) * 3 // 4, len(whole) - 3):
        data = bytearray(whole)
        data[at] ^= 0x40
        found, damage = unpacked(bytes(data), form)
        assert found[: len(LOG)] == LOG
        assert damage is not None and (damage.kind, damage.since) == ("compression", len(whole) // 2)
        assert damage.lost == len(whole) - damage.offset
    small = PACK[form](b"kept\n" * 20)
    for at in range(10, len(small)):
        data = bytearray(small)
        data[at] ^= 0x40
        unpacked(bytes(data), form)  # never raises


@pytest.mark.parametrize("form", FORMS)
def test_a_wrong_check_sum_costs_nothing(form: str) -> None:
    data = bytearray(PACK[form](b"kept\n" * 20))
    data[-1 if form == "zstd" else -6] ^= 0x40
    found, damage = unpacked(bytes(data), form)
    assert found == b"kept\n" * 20
    assert damage is not None


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the peak of memory stands in /proc")
@pytest.mark.parametrize("form", FORMS)
def test_memory_does_not_grow_with_what_is_unpacked(form: str, tmp_path: Path) -> None:
    lines = b"# nothing but a comment that takes its time\n" * 50_000
    (tmp_path / "bomb").write_bytes(PACK[form](lines) * 100)
    script = (
        "from canalyze.sources import open_capture\n"
        "with open_capture('bomb') as capture:\n"
        "    size = 0\n"
        "    while data := capture.read():\n"
        "        size += len(data)\n"
        "peak = next(line for line in open('/proc/self/status') if line.startswith('VmHWM'))\n"
        "print(size, peak.split()[1])\n"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, check=True, text=True)
    size, kibibytes = map(int, done.stdout.split())
    assert size == 100 * len(lines)  # 220 MB
    assert kibibytes < 60_000


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("command", ["decode", "sdo", "summary"])
def test_a_compressed_file_is_what_is_in_it(
    canalyze: Runner, notes: str, tmp_path: Path, form: str, command: str
) -> None:
    packed = PACK[form](NOTES.encode())
    (tmp_path / "any name").write_bytes(packed)
    plain = canalyze(command, notes)
    assert canalyze(command, "any name") == plain
    assert canalyze(command, "-", stdin=packed) == plain
    assert canalyze(command, "--input-format", "candump", "any name") == plain


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("form", [None, "gzip"])
def test_text_in_utf_16(canalyze: Runner, notes: str, tmp_path: Path, encoding: str, form: str | None) -> None:
    data = NOTES.encode(encoding)
    (tmp_path / "wide.txt").write_bytes(PACK[form](data) if form else data)
    assert canalyze("decode", "wide.txt") == canalyze("decode", notes)


def test_lines_of_a_compressed_pipe_come_at_once() -> None:
    import zlib

    packer = zlib.compressobj(wbits=31)
    decode = subprocess.Popen(
        [sys.executable, "-m", "canalyze", "decode", "-"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environment(),
    )
    assert decode.stdin and decode.stdout
    for line in NOTES.encode().splitlines(keepends=True)[:3]:
        decode.stdin.write(packer.compress(line) + packer.flush(zlib.Z_SYNC_FLUSH))
        decode.stdin.flush()
        assert decode.stdout.readline().startswith(line.rstrip())
    decode.stdin.close()
    decode.stdout.close()
    decode.wait()


def test_one_compression_only(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "twice.gz").write_bytes(gzip.compress(lzma.compress(NOTES.encode())))
    for lang, said in (("zh", "只支持一层"), ("en", "xz compressed inside gzip")):
        done = canalyze("--lang", lang, "decode", "twice.gz")
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
        assert said in done.err


@pytest.mark.parametrize("form", FORMS)
def test_an_empty_one(canalyze: Runner, tmp_path: Path, form: str) -> None:
    (tmp_path / "empty").write_bytes(PACK[form](b""))
    done = canalyze("decode", "empty")
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)


@pytest.mark.parametrize("form", FORMS)
def test_a_cut_one_is_told_once(canalyze: Runner, tmp_path: Path, form: str) -> None:
    packed = PACK[form](LOG)
    (tmp_path / "cut").write_bytes(packed[: len(packed) - 9])
    done = canalyze("--lang", "en", "decode", "--format", "jsonl", "cut")
    rows = [json.loads(line) for line in done.lines]
    findings = [row for row in rows if row["kind"] == "finding" and row["code"].startswith("CAP")]
    assert [(row["code"], row["facts"]["offset"]) for row in findings] == [("CAP005", len(packed) - 9)]
    assert done.code == 0
    assert [line for line in done.complaints if "CAP005" in line] == done.complaints
    if form in ("gzip", "bzip2"):
        assert len(rows) >= 10_000


@pytest.mark.parametrize("form", FORMS)
def test_a_damaged_one_is_told_once(canalyze: Runner, tmp_path: Path, form: str) -> None:
    packed = PACK[form](LOG)
    (tmp_path / "bad").write_bytes(
        packed + packed[: len(packed) // 2] + bytes([0xFF] * 64) + packed[len(packed) // 2 :]
    )
    done = canalyze("--lang", "en", "summary", "bad")
    assert done.code == 0
    assert "CAP004" in done.out
    assert any(line.startswith("bad: byte ") and "CAP004" in line for line in done.complaints)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("before", [0, 1, 2])
@pytest.mark.parametrize("lines", [40, 20_000])
def test_all_of_a_member_is_doubtful_whose_check_sum_fails(
    canalyze: Runner, tmp_path: Path, form: str, before: int, lines: int
) -> None:
    pack, text = PACK[form], b"".join(LOG.splitlines(keepends=True)[:lines])
    sound, damaged = pack(text), bytearray(pack(text))
    damaged[-1 if form == "zstd" else -6] ^= 0x40  # the check sum itself
    if form == "bzip2" and lines > 40:
        pytest.skip("a block as large as that goes with its check sum")
    (tmp_path / "bad").write_bytes(sound * before + damaged)
    done = canalyze("--lang", "en", "info", "--format", "jsonl", "bad")
    record = json.loads(done.out)
    (damage,) = record["damage"]
    doubtful = record["frames"] - before * lines
    assert doubtful == lines if form == "gzip" or lines == 40 else doubtful > lines * 0.8
    assert (record["damages"], record["checked"]) == (1, True)
    assert (damage["kind"], damage["offset"], damage["frames"]) == ("doubtful", len(sound) * before, doubtful)
    said = f"everything decompressed from here on ({doubtful} frames) may be wrong"
    for command in (["decode"], ["summary"], ["check"], ["convert", "--to", "candump"]):
        done = canalyze("--lang", "en", *command, "bad", *(["-"] if command[0] == "convert" else []))
        (line,) = done.complaints
        assert line.startswith(f"bad: byte {len(sound) * before}: CAP004 ") and said in line
        assert done.code == (command == ["check"])
    done = canalyze("--lang", "en", "info", "bad")
    assert f"{doubtful} frames may be wrong" in done.out and "frames lost" not in done.out


def test_every_changed_byte_is_told(canalyze: Runner, tmp_path: Path) -> None:
    text = LOG[:3000]
    for form in FORMS:
        (tmp_path / "a.log").write_bytes(text)
        name = f"a.log.{ENDINGS[form]}"
        assert canalyze("convert", "--force", "a.log", name).code == 0
        written = (tmp_path / name).read_bytes()
        whole, damage = unpacked(written, form)
        assert whole and damage is None
        silent = 0
        for at in range(len(written)):
            data = bytearray(written)
            data[at] ^= 0x10
            found, damage = unpacked(bytes(data), form)
            silent += found != whole and damage is None
        assert silent == 0, form


def test_a_file_without_a_check_sum_says_so(canalyze: Runner, tmp_path: Path) -> None:
    files = {
        "without.zst": (zstd.compress(LOG), False),
        "partly.zst": (_zstd(LOG) + zstd.compress(LOG), False),
        "with.zst": (_zstd(LOG), True),
        "skipping.zst": (b"\x50\x2a\x4d\x18\x04\0\0\0abcd" + _zstd(LOG), True),
        "without.xz": (lzma.compress(LOG, check=lzma.CHECK_NONE), False),
        "with.xz": (lzma.compress(LOG), True),
        "with.gz": (gzip.compress(LOG), True),
        "with.bz2": (bz2.compress(LOG), True),
        "plain.log": (LOG, None),
    }
    for name, (data, checked) in files.items():
        (tmp_path / name).write_bytes(data)
        assert json.loads(canalyze("info", "--format", "jsonl", name).out)["checked"] is checked, name
        said = "no checksum" in canalyze("--lang", "en", "info", name).out
        assert said == (checked is False), name


@pytest.mark.parametrize("piece", [7, 4096, PIECE])
def test_a_read_is_of_whole_members_or_of_one(piece: int) -> None:
    members = [b"a" * 10, b"b" * 5000, b"c" * (PIECE + 9), b"d", b"e" * 100]
    layer = Unpacked(Bytes(b"".join(map(gzip.compress, members)), piece), "gzip")
    found, last = b"", b""
    while got := layer.read():
        assert layer.begins or got[:1] == last, "a member begins"
        assert not layer.begins or got[:1] != last, "a member goes on"
        found, last = found + got, got[-1:]
    assert found == b"".join(members)
