"""`canalyze page`: the file that it writes. What it must not do: open it; that is `test_web_page.py`."""

from __future__ import annotations

import base64
import gzip
import json
import re
from html import unescape
from pathlib import Path

import pytest
from captures import SAMPLES
from conftest import Runner

from canalyze import html
from canalyze.cli import main
from canalyze.errors import OutputError

CAPTURE = re.compile(r'<script type="text/plain" class="capture" data-name="([^"]*)">([^<]*)</script>')


@pytest.fixture
def core(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> bytes:
    """A core that any checkout has."""
    content = b"\0asm" + bytes(range(256))
    (tmp_path / "core.wasm").write_bytes(content)
    monkeypatch.setattr(html, "WASM", tmp_path / "core.wasm")
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
    assert [json.loads(unescape(said)) for said, _ in found] == [one.name for one in captures]
    assert [gzip.decompress(base64.b64decode(data)) for _, data in found] == [one.read_bytes() for one in captures]
    (wasm,) = re.findall(r'id="wasm">([^<]*)</script>', text)
    assert gzip.decompress(base64.b64decode(wasm)) == core
    (settings,) = re.findall(r'id="settings">([^<]*)</script>', text)
    assert json.loads(settings)["lang"] == lang
    (words,) = re.findall(r'id="words">([^<]*)</script>', text)
    read = json.loads(words)
    assert set(read["zh"]) == set(read["en"]) and read["en"]["html.cancel"] == "Cancel"
    assert not re.search(r"\{\{\w+\}\}", text)


def test_the_same_page_is_written_each_time(core: bytes) -> None:
    assert core
    assert html.page("en", {}, [("a.log", b"1")]) == html.page("en", {}, [("a.log", b"1")])
    assert html.page("en", {}, [("a.log", b"1")]) != html.page("en", {}, [("a.log", b"2")])


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
