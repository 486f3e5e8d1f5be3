"""`diagnose --html` and `capture.html()`: the page that they write, and when they write none.

What it must not do: open it; that is `test_web_diagnosis.py`.
"""

from __future__ import annotations

import base64
import gzip
import json
import os
import re
import sys
import tracemalloc
from pathlib import Path
from typing import Any

import can
import pytest
from bench_captures import capture_lines
from captures import EDS, SAMPLES
from test_cli_page import CAPTURE
from test_diagnosis import lost

import canalyze
from canalyze import html
from canalyze.cli import main

LIBRARY: Any = canalyze
"""For what is wrong on purpose."""
PROBLEMS = SAMPLES / "problems.log"


@pytest.fixture(autouse=True)
def core(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A core that any checkout has, and a folder to work in."""
    path = tmp_path / "core.wasm"
    path.write_bytes(b"\0asm")
    monkeypatch.setattr(html, "WASM", path)
    monkeypatch.chdir(tmp_path)
    return path


def diagnose(*args: str | Path) -> int:
    return main(["--lang", "en", "diagnose", *map(str, args)])


def inside(page: str) -> list[tuple[dict[str, Any], bytes]]:
    """The files in a page: what is said of each, and its bytes."""
    return [(json.loads(about), gzip.decompress(base64.b64decode(data))) for data, about in CAPTURE.findall(page)]


def settings(page: str) -> Any:
    (found,) = re.findall(r'id="settings">([^<]*)</script>', page)
    return json.loads(found)


def test_the_capture_is_inside_and_the_text_is_printed(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert diagnose(PROBLEMS, "--html", "page.html") == 0
    beside = capfd.readouterr()
    assert diagnose(PROBLEMS) == 0
    assert beside == capfd.readouterr() and beside.err == "" and "OPEN" in beside.out
    ((about, data),) = inside(Path("page.html").read_text())
    assert about == {"recording": 0, "name": "problems.log", "format": "candump", "damage": None, "problem": None}
    assert data == PROBLEMS.read_bytes()
    assert diagnose(PROBLEMS, "--html", "page.html") == 2, "a file is kept"
    assert "page.html" in capfd.readouterr().err
    assert diagnose(PROBLEMS, "--html", "page.html", "--force", "--fail-on", "open") == 1
    assert main(["--lang", "en", "page", str(PROBLEMS), "-o", "other.html"]) == 0
    assert Path("page.html").read_bytes() == Path("other.html").read_bytes()


@pytest.mark.parametrize("frames", [(), ("--frames", "near"), ("--frames", "all")])
def test_the_library_and_former_options_make_the_same_page(frames: tuple[str, ...]) -> None:
    eds = f"5={next(EDS.glob('*.eds'))}"
    assert diagnose(PROBLEMS, "--eds", eds, "--cob", "185=5.TPDO1", "--html", "page.html", *frames) == 0
    page = Path("page.html").read_text()
    capture = canalyze.open(PROBLEMS, eds=eds, cob="185=5.TPDO1")
    assert page == (
        LIBRARY.open(PROBLEMS, eds=eds, cob="185=5.TPDO1").html(frames=frames[1]) if frames else capture.html()
    )
    known = settings(page)["options"]["network"]
    assert known["descriptions"] == [[None, 5, 0]] and len(known["dictionaries"][0]["rows"]) > 10
    assert known["cobs"] == [[None, 0x185, False, 5, "tpdo", 1]]


def test_the_library_refuses_another_word_for_frames() -> None:
    with pytest.raises(ValueError, match="frames='some': one of near, all"):
        LIBRARY.open(PROBLEMS).html(frames="some")


def test_the_library_puts_in_what_is_in_memory_and_joins_files() -> None:
    message = can.Message(arbitration_id=0x705, data=[5], is_extended_id=False, timestamp=1.0)
    ((about, _),) = inside(canalyze.open([message]).html())
    assert (about["name"], about["format"]) == ("messages", "packed")
    page = canalyze.open([PROBLEMS, SAMPLES / "sdo-abort.log"], merge=True, lang="zh").html()
    assert [about["recording"] for about, _ in inside(page)] == [0, 0]
    assert settings(page)["merge"] and settings(page)["lang"] == "zh"


def test_an_object_dictionary_is_inside() -> None:
    dictionary = canalyze.open(PROBLEMS, eds=f"5={next(EDS.glob('*.eds'))}").nodes[5].dictionary
    assert dictionary is not None
    known = settings(canalyze.open(PROBLEMS, eds={5: dictionary}).html())["options"]["network"]
    assert known["descriptions"] == [[None, 5, 0]] and len(known["dictionaries"][0]["rows"]) > 10


def test_complaints_stay_complaints_of_the_capture() -> None:
    Path("cut.log").write_text("(1.0) can0 705#00\nnothing\n(1.1) can0 705#05\n")
    capture = canalyze.open("cut.log")
    capture.html()
    assert capture.complaints == canalyze.open("cut.log").complaints != ()


def test_recordings_are_all_inside(capfd: pytest.CaptureFixture[str]) -> None:
    Path("folder").mkdir()
    Path("folder/lost.log").write_bytes(lost(20))
    Path("folder/well.log").write_bytes((SAMPLES / "rules" / "HBT002.clean.log").read_bytes())
    Path("folder/noise.log").write_text("nothing\n")
    assert diagnose("folder", "--html", "page.html") == 2
    said = capfd.readouterr()
    assert "2 recordings" not in said.out and "1 unreadable" in said.out and "noise.log" in said.err
    assert [about["name"] for about, _ in inside(Path("page.html").read_text())] == ["lost.log", "well.log"]
    assert diagnose("folder/lost.log", "folder/well.log", "--join", "--html", "joined.html") == 0
    assert [about["recording"] for about, _ in inside(Path("joined.html").read_text())] == [0, 0]


def test_files_that_follow_one_another_are_one_recording() -> None:
    lines = PROBLEMS.read_bytes().splitlines(keepends=True)
    Path("a.log").write_bytes(b"".join(lines[:80]))
    Path("b.log").write_bytes(b"".join(lines[80:]))
    assert diagnose("b.log", "a.log", "--html", "page.html") == 0
    found = [(about["recording"], about["name"]) for about, _ in inside(Path("page.html").read_text())]
    assert found == [(0, "a.log"), (0, "b.log")]


def test_a_damaged_file_is_inside_up_to_the_damage() -> None:
    packed = gzip.compress(PROBLEMS.read_bytes())
    Path("cut.log.gz").write_bytes(packed[: len(packed) // 2])
    assert diagnose("cut.log.gz", "--html", "page.html") == 0
    ((about, data),) = inside(Path("page.html").read_text())
    assert about["damage"] == {"kind": "cut", "offset": len(packed) // 2, "bytes": None}
    assert data and PROBLEMS.read_bytes().startswith(data)


def test_standard_input_is_inside(monkeypatch: pytest.MonkeyPatch) -> None:
    kept = os.dup(0)
    try:
        reader, writer = os.pipe()
        os.write(writer, lost(20))
        os.close(writer)
        os.dup2(reader, 0)
        os.close(reader)
        assert diagnose("-", "-n", "1", "--html", "page.html") == 0
    finally:
        os.dup2(kept, 0)
        os.close(kept)
    ((about, data),) = inside(Path("page.html").read_text())
    assert about["name"] == "stdin" and data == lost(20)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_what_can_be_read_only_once_is_refused(capfd: pytest.CaptureFixture[str]) -> None:
    os.mkfifo("pipe.log")
    assert diagnose("pipe.log", "--html", "page.html") == 2
    assert "pipe.log can be read only once" in capfd.readouterr().err
    assert diagnose(PROBLEMS, "--html", "-") == 2
    assert not Path("page.html").exists() and not Path("-").exists()


@pytest.mark.parametrize(("lang", "said"), [("en", ".ci/web builds it"), ("zh", "由 .ci/web 构建")])
def test_without_the_core_it_fails_at_once(lang: str, said: str, core: Path, capfd: pytest.CaptureFixture[str]) -> None:
    core.unlink()
    assert main(["--lang", lang, "diagnose", str(PROBLEMS), "--html", "page.html"]) == 2
    shown = capfd.readouterr()
    assert shown.out == "" and said in shown.err and shown.err.count("\n") == 1
    assert not Path("page.html").exists()
    with pytest.raises(canalyze.OutputError, match=r"\.ci/web"):
        canalyze.open(PROBLEMS).html()


@pytest.mark.parametrize("form", ["text", "jsonl"])
def test_the_page_is_written_though_the_reader_has_gone(form: str, monkeypatch: pytest.MonkeyPatch) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    kept = os.dup(1)
    os.dup2(writer, 1)
    os.close(writer)
    try:
        assert diagnose(PROBLEMS, "--html", "page.html", "--format", form, "--fail-on", "open") == 1
        sys.stdout.flush()
    finally:
        os.dup2(kept, 1)
        os.close(kept)
    assert len(inside(Path("page.html").read_text())) == 1


def test_unreadable_files_make_no_page(capfd: pytest.CaptureFixture[str]) -> None:
    Path("noise.log").write_text("nothing\n")
    assert diagnose("noise.log", "--html", "page.html") == 2
    assert not Path("page.html").exists()


def test_names_cannot_end_an_element() -> None:
    name = '<script>alert(1)<!--"&.log'
    Path(name).write_bytes(lost(20))
    assert diagnose(name, "--html", "page.html") == 0
    page = Path("page.html").read_text()
    assert page.count("<script") == 7 and "<!--" not in page and "alert" in page
    ((about, _),) = inside(page)
    assert about["name"] == name
    odd = os.fsdecode(b"odd\xff.log")
    Path(odd).write_bytes(lost(20))
    assert diagnose(odd, "--html", "odd.html") == 0
    ((about, _),) = inside(Path("odd.html").read_text(encoding="utf-8"))
    assert about["name"] == odd


def test_memory_and_size_do_not_grow_with_the_capture() -> None:
    """A part of the bars for a million frames: 300 MB of memory and 45 MB of the file."""
    Path("large.log").write_text("".join(f"{line.rstrip()}\n" for line in capture_lines(200_000)))
    assert Path("large.log").stat().st_size > 7 << 20
    tracemalloc.start()
    try:
        assert main(["page", "large.log", "-o", "page.html"]) == 0
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 6 << 20
    assert Path("page.html").stat().st_size < 45e6 * 0.2
    assert len(inside(Path("page.html").read_text())[0][1]) == Path("large.log").stat().st_size
