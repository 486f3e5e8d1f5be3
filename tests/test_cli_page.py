"""`canalyze page`: the file that it writes. What it must not do: open it; that is `test_web_page.py`."""

from __future__ import annotations

import base64
import bz2
import gzip
import json
import random
import re
from pathlib import Path

import pytest
from captures import EDS, SAMPLES, held
from conftest import Runner

import canalyze
from canalyze import html
from canalyze.cli import main
from canalyze.errors import OutputError, SourceError

CAPTURE = re.compile(
    r'<script type="text/plain" class="capture">([^<]*)</script><script type="application/json">([^<]*)</script>'
)


@pytest.fixture
def core(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> bytes:
    """A core that any checkout has."""
    content = b"\0asm" + bytes(range(256))
    (tmp_path / "core.wasm.lzma").write_bytes(content)
    monkeypatch.setattr(html, "WASM", tmp_path / "core.wasm.lzma")
    return content


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_it_holds_the_core_and_the_captures(lang: str, core: bytes, tmp_path: Path) -> None:
    captures = [SAMPLES / "problems.log", SAMPLES / "sdo-block.asc"]
    name = "\"<&'>.log"
    (tmp_path / name).write_bytes(b"(1.0) can0 701#05\n")
    captures.append(tmp_path / name)
    output = tmp_path / "page.html"
    assert main(["--lang", lang, "page", *map(str, captures), "-o", str(output)]) == 0
    text = output.read_text()
    found = CAPTURE.findall(text)
    said = [json.loads(one) for _, one in found]
    assert [one["name"] for one in said] == [one.name for one in captures]
    assert [one["format"] for one in said] == ["candump", "asc", "candump"]
    assert [one["recording"] for one in said] == [0, 1, 2]
    assert [gzip.decompress(base64.b64decode(data)) for data, _ in found] == [one.read_bytes() for one in captures]
    (wasm,) = re.findall(r'id="wasm">([^<]*)</script>', text)
    assert base64.b64decode(wasm) == core
    (settings,) = re.findall(r'id="settings">([^<]*)</script>', text)
    read = json.loads(settings)
    assert read["lang"] == lang and not read["merge"] and read["options"]["network"]["descriptions"] == []
    (words,) = re.findall(r'id="words">([^<]*)</script>', text)
    read = json.loads(words)
    assert set(read["zh"]) == set(read["en"]) and read["en"]["html.cancel"] == "Cancel"
    assert not re.search(r"\{\{\w+\}\}", text)


@pytest.mark.usefixtures("core")
def test_what_options_say_is_in_it(tmp_path: Path) -> None:
    output = tmp_path / "page.html"
    eds = next(EDS.glob("*.eds"))
    names = [str(SAMPLES / "problems.log"), str(SAMPLES / "sdo-abort.log")]
    options = [
        "--eds",
        f"5={eds}",
        "--cob",
        "185=5.TPDO1",
        "--bitrate",
        "500k",
        "--stamps",
        "absolute",
        "--topic",
        "/a*",
    ]
    assert main(["page", *names, "--merge", *options, "-o", str(output)]) == 0
    text = output.read_text()
    assert [json.loads(one)["recording"] for _, one in CAPTURE.findall(text)] == [0, 0]
    (said,) = re.findall(r'id="settings">([^<]*)</script>', text)
    read = json.loads(said)
    assert read["merge"] and read["options"]["stamps"] == "absolute" and read["options"]["topics"] == ["/a*"]
    known = read["options"]["network"]
    assert known["descriptions"] == [[None, 5, 0]] and known["bitrate"] == 500_000
    assert known["cobs"] == [[None, 0x185, False, 5, "tpdo", 1]]
    assert len(known["dictionaries"][0]["rows"]) > 10


@pytest.mark.usefixtures("core")
@pytest.mark.parametrize("damaged", [False, True])
def test_packed_captures_are_inside_as_they_are_fed(damaged: bool, tmp_path: Path) -> None:
    data = (SAMPLES / "problems.log").read_bytes() * 40
    packed = bz2.compress(data, 1)
    (tmp_path / "a.log.bz2").write_bytes(packed[: len(packed) // 2] if damaged else packed)
    output = tmp_path / "page.html"
    assert main(["page", str(tmp_path / "a.log.bz2"), "-o", str(output)]) == 0
    ((inside, said),) = CAPTURE.findall(output.read_text())
    about = json.loads(said)
    assert about["name"] == "a.log.bz2" and about["format"] == "candump"
    assert (about["damage"] is not None) == damaged
    read = gzip.decompress(base64.b64decode(inside))
    assert data.startswith(read) if damaged else read == data


@pytest.mark.usefixtures("core")
def test_captures_that_are_too_large_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(html, "MOST", 1 << 20)
    with pytest.raises(OutputError, match="1 MB"):
        html.page("en", {}, [[held("a.log", random.Random(1).randbytes(1 << 20))]])


def test_the_same_page_is_written_each_time(core: bytes) -> None:
    assert core
    assert html.page("en", {}, [[held("a.log", b"1")]]) == html.page("en", {}, [[held("a.log", b"1")]])
    assert html.page("en", {}, [[held("a.log", b"1")]]) != html.page("en", {}, [[held("a.log", b"2")]])


def test_all_words_that_it_says_are_in_it(core: bytes) -> None:
    assert core
    text = html.page("en", {}).decode()
    words = json.loads(re.findall(r'id="words">([^<]*)</script>', text)[0])["en"]
    said = set(re.findall(r'(?:say\(|data-say(?:-\w+)?=)["`](\w+\.\w+)"', text))
    assert len(said) > 30
    assert said <= set(words)


def test_it_is_said_where_the_core_was_not_built(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(html, "WASM", tmp_path / "no.wasm")
    with pytest.raises(OutputError, match=r"\.ci/web"):
        html.page("en", {})
    assert main(["--lang", "en", "page", "-o", str(tmp_path / "page.html")]) == 2
    assert not (tmp_path / "page.html").exists()


@pytest.mark.usefixtures("core")
def test_files_are_kept_and_missing_ones_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "page.html"
    assert main(["--lang", "en", "page", str(tmp_path / "no.log"), "-o", str(output)]) == 2
    assert not output.exists()
    output.write_text("mine")
    assert main(["--lang", "en", "page", "-o", str(output)]) == 2
    assert output.read_text() == "mine"
    assert main(["--lang", "en", "page", "-o", str(output), "--force"]) == 0
    assert output.stat().st_size > 10_000
    capsys.readouterr()


def test_the_output_is_required(canalyze: Runner) -> None:
    done = canalyze("page", "--lang", "en")
    assert done.code == 2 and "-o" in done.err


@pytest.mark.usefixtures("core")
@pytest.mark.parametrize("data", [b"nothing\n", b"", random.Random(1).randbytes(5000), b"no\n" * 100_000])
def test_what_holds_no_frame_is_refused_as_decode_does(
    data: bytes, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    noise = tmp_path / "noise.log"
    noise.write_bytes(data)
    assert main(["--lang", "en", "decode", str(noise)]) == 2
    wanted = capfd.readouterr()
    output = tmp_path / "page.html"
    assert main(["--lang", "en", "page", str(SAMPLES / "problems.log"), str(noise), "-o", str(output)]) == 2
    said = capfd.readouterr()
    assert said.err.splitlines() == wanted.err.splitlines()[-1:] != [] and not said.out
    assert not output.exists()
    with pytest.raises(SourceError, match=re.escape(str(noise))):
        canalyze.open(noise).html()
