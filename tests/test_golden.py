"""The wording, frozen: every sample decodes to the golden files beside it, whatever the chunks it comes in.

`python tests/regenerate.py` writes the files anew. Text output is input: decoding it again changes nothing.
"""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from capture_frames import annotated
from captures import SAMPLES, described_beside, expected_beside, run_canalyze, session_output
from regenerate import conversion, converted, goldens, input_format, output, samples

CAPTURES = [
    *samples(),
    *sorted((SAMPLES / "recorded").glob("session.*[gp]")),
    *sorted((SAMPLES / "stacks").glob("*.log")),
    *sorted((SAMPLES / "network").glob("*.log")),
    *sorted((SAMPLES / "rules").glob("*.clean.log")),
    *sorted((SAMPLES / "rules").glob("*.clean.mcap")),
]
"""The samples, and the captures without goldens (`.log` and `.candump`) that the laws of text must hold for as well."""

GOLDENS = [(capture, golden) for capture in samples() for golden in goldens(capture)]

FORMATS: list[dict[str, Any]] = [
    {"output_format": "text", "lang": "zh"},
    {"output_format": "text", "lang": "en", "depth": "explain"},
    {"output_format": "text", "lang": "zh", "depth": "brief"},
    {"output_format": "jsonl", "lang": "en"},
    {"output_format": "transfers", "lang": "en"},
    {"output_format": "summary", "lang": "en"},
    {"output_format": "check", "lang": "en"},
]


def in_chunks(text: bytes, source: random.Random) -> Iterator[bytes]:
    """The text in pieces of 0 to 200 bytes."""
    at = 0
    while at < len(text):
        length = source.randrange(0, 201)
        yield text[at : at + length]
        at += length


@pytest.mark.parametrize(("capture", "golden"), GOLDENS, ids=lambda path: path.name)
def test_the_output_is_the_golden_one(capture: Path, golden: Path) -> None:
    assert golden.is_file(), "no golden file: run tests/regenerate.py and read what it writes"
    assert output(capture, goldens(capture)[golden]).decode() == golden.read_text(encoding="utf-8")


@pytest.mark.parametrize("capture", converted(), ids=lambda path: path.name)
def test_a_sample_in_another_format_is_what_convert_makes(capture: Path) -> None:
    assert conversion(capture) == capture.read_bytes()


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize("capture", converted(), ids=lambda path: path.name)
def test_a_sample_in_another_format_is_annotated_alike(capture: Path, lang: str) -> None:
    """All that is said of each frame; stamps and columns look as the format has them."""
    said = [
        annotated(session_output([path.read_bytes()], name="x", lang=lang, depth="explain"))
        for path in (capture, capture.with_suffix(".log"))
    ]
    assert any(said[0])
    assert said[0] == said[1]


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_the_command_says_what_the_session_says(lang: str) -> None:
    capture = SAMPLES / "zephyr-sdo.log"
    written = run_canalyze(["decode", capture, "--lang", lang])
    assert written == session_output([capture.read_bytes()], name=capture.name, lang=lang)


@pytest.mark.parametrize("capture", CAPTURES, ids=lambda path: path.name)
def test_decoding_the_output_changes_nothing(capture: Path) -> None:
    for lang in ("zh", "en"):
        once = session_output([capture.read_bytes()], name=capture.name, lang=lang, input_format=input_format(capture))
        assert session_output([once], name=capture.name, lang=lang) == once, lang


@pytest.mark.parametrize("capture", CAPTURES, ids=lambda path: path.name)
def test_the_chunks_do_not_matter(capture: Path) -> None:
    text = capture.read_bytes()
    output = partial(
        session_output,
        name=capture.name,
        network=described_beside(capture),
        expectations=expected_beside(capture),
        input_format=input_format(capture),
    )
    for arguments in FORMATS:
        whole = output([text], **arguments)
        assert output((text[at : at + 1] for at in range(len(text))), **arguments) == whole, arguments
        source = random.Random(capture.name)
        for _ in range(3):
            assert output(in_chunks(text, source), **arguments) == whole, arguments


MAY_GO_ON = re.compile(rb"(?:#(?:[0-9A-F]{2}){0,7}|##[0-9A-F](?:[0-9A-F]{2}){0,63}|#R)\n\Z")
"""A last line whose frame is shorter than one can be."""


def test_line_ends_do_not_matter() -> None:
    """A file that went through Windows says the same."""
    for capture in (path for path in samples() if path.suffix == ".log"):
        text = capture.read_bytes()
        form = input_format(capture)
        said_of = partial(session_output, name=capture.name, output_format="jsonl", input_format=form)
        said = said_of([text.replace(b"\n", b"\r\n")])
        assert said == said_of([text])
        without_last_end = said_of([text.rstrip(b"\n")])
        # A frame that may be the beginning of a longer one is told, not read.
        told = b'"code":"CAP001"' in without_last_end and MAY_GO_ON.search(text)
        assert told or without_last_end == said_of([text])
