"""Writes the expected output beside the samples anew.

    python tests/regenerate.py [NAME...]
    python tests/regenerate.py pages [PAGE...]

Without names all samples, what the pages for users show, `command_lines/` and `console/`; `pages` are the pages alone.
Read the difference (`git diff`) before it is kept: a golden file is only as right as the eye that passed it.
`zephyr-sdo.brief.zh.txt` is never written: it is the listing that the program reproduces.

What it must not do: judge; test_golden.py compares, the other tests know what is true.
"""

from __future__ import annotations

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import console
import example_captures
import generated_pages
import page_examples
import test_command_lines
from captures import SAMPLES, described_beside, eds_options, expected_beside, run_canalyze, session_output
from monitor_screens import golden as screen_golden
from monitor_screens import goldens as screen_goldens
from monitor_screens import screens

from canalyze._core import sniff
from canalyze.commands import examples

BRIEF = {"zephyr-sdo", "zephyr-sdo-causal", "string-5-bytes", "string-100-bytes", "sdo-block", "two-nodes-interleaved"}
EXPLAIN = {"zephyr-sdo", "sdo-block", "services"}
SUMMARY = {"services", "two-nodes-interleaved"}
OD = {"services", "sync-and-pdos"}
HANDMADE = ("dialects.asc",)
"""Captures in other formats than candump's that have goldens."""
CONVERTED = ("zephyr-sdo", "services", "sdo-block", "two-nodes-interleaved")
"""Samples that exist in other formats as well, as `canalyze convert` makes them."""
FORMATS = ("asc", "mcap")
"""These formats; their names end so."""
GIVEN = {"zephyr-sdo.brief.zh.txt"}
NETWORKS = ("drive-states", "sync-and-pdos")
"""Sessions of whole networks that have goldens, decoded with the descriptions of their nodes."""
CAPTURES = (".log", ".mcap")
"""Names of captures end so. `python tests/mcap_files.py` makes those of the rules about damaged files."""
PIPED = {"CAP003"}
"""Captures whose goldens are those of a pipe."""


def samples() -> list[Path]:
    """The captures that have goldens: those directly in the samples' directory, some networks, and those of a rule."""
    rules = (path for path in (SAMPLES / "rules").glob("*.*") if path.suffix in CAPTURES and ".clean." not in path.name)
    networks = (SAMPLES / "network" / f"{name}.log" for name in NETWORKS)
    handmade = (SAMPLES / name for name in HANDMADE)
    return [*sorted(SAMPLES.glob("*.log")), *handmade, *networks, *sorted(rules)]


def goldens(capture: Path) -> dict[Path, dict[str, str]]:
    """The golden files of a capture, and the session's arguments (or the command) that make each."""
    name = capture.stem
    made: dict[str, dict[str, str]] = {
        f"{name}.zh.txt": {"lang": "zh"},
        f"{name}.en.txt": {"lang": "en"},
        f"{name}.jsonl": {"lang": "en", "output_format": "jsonl"},
    }
    if name in NETWORKS:  # their JSON is compared with the truth, value by value
        del made[f"{name}.jsonl"]
    if name in BRIEF:
        made[f"{name}.brief.zh.txt"] = {"lang": "zh", "depth": "brief"}
    if name in EXPLAIN:
        made |= {f"{name}.explain.{lang}.txt": {"lang": lang, "depth": "explain"} for lang in ("zh", "en")}
    if name in SUMMARY:
        made |= {f"{name}.summary.{lang}.txt": {"lang": lang, "command": "summary"} for lang in ("zh", "en")}
    if name in OD:
        made |= {f"{name}.od.{lang}.txt": {"lang": lang, "command": "od"} for lang in ("zh", "en")}
        made[f"{name}.od.jsonl"] = {"lang": "en", "command": "od", "format": "jsonl"}
    return {capture.parent / file: arguments for file, arguments in made.items()}


def converted() -> list[Path]:
    """The samples in other formats; what they hold stands in the `.log` of that name."""
    return [SAMPLES / f"{name}.{form}" for name in CONVERTED for form in FORMATS]


def conversion(capture: Path) -> bytes:
    """What the program makes of the `.log` of that name now. The file that is written names the one it was made of."""
    arguments = ["convert", f"{capture.stem}.log", "-", "--to", capture.suffix[1:]]
    return run_canalyze(arguments, folder=capture.parent)


def input_format(capture: Path) -> str:
    """The capture's format."""
    return sniff(capture.read_bytes(), True) or ""


def output(capture: Path, arguments: dict[str, str]) -> bytes:
    """What the program says now."""
    if "command" in arguments:
        further = ["--bitrate", "500k"] if arguments["command"] == "summary" else eds_options(capture)
        shown = ["--format", arguments.get("format", "text"), "--lang", arguments["lang"]]
        return run_canalyze([arguments["command"], capture, *shown, *further])
    regular = capture.stem not in PIPED
    known, expected = described_beside(capture), expected_beside(capture)
    form = input_format(capture)
    return session_output(
        [capture.read_bytes()],
        regular,
        name=capture.name,
        network=known,
        input_format=form,
        expectations=expected,
        **arguments,
    )


def main() -> None:
    """Every golden file of the samples named on the command line, these in other formats, the screens, and pages."""
    names = set(sys.argv[1:])
    if "pages" in names:
        pages(names - {"pages"})
        return
    for capture in samples():
        if names and capture.stem not in names:
            continue
        for golden, arguments in goldens(capture).items():
            if golden.name not in GIVEN:
                keep(golden, output(capture, arguments))
    for capture in converted():
        if not names or capture.stem in names:
            keep(capture, conversion(capture))
    for capture, size, lang in screen_goldens():
        if not names or capture.stem in names:
            keep(screen_golden(capture, size, lang), screens(capture, size, lang).encode())
    if not names:
        for name, made in example_captures.EXAMPLES.items():
            keep(examples.FOLDER / name, made().encode())
        pages(set())
        for path in sorted(test_command_lines.FOLDER.iterdir()):
            keep(path, test_command_lines.rerun(path).encode())
        for path in sorted(console.FOLDER.iterdir()):
            keep(path, console.rerun(path).encode())


def pages(names: set[str]) -> None:
    """The pages that are made of the core's tables, and the listings on all others, or on those of these names."""
    for path in generated_pages.write():
        print(path.relative_to(SAMPLES.parent))
    chosen = [page for page in page_examples.PAGES if not names or page.stem in names]
    with ThreadPoolExecutor(os.cpu_count()) as side_by_side:  # each waits for the commands that it shows
        for page, new in zip(chosen, side_by_side.map(page_examples.rewritten, chosen), strict=True):
            keep(page, new.encode())


def keep(file: Path, new: bytes) -> None:
    """Write a file that is another one now."""
    if not file.exists() or file.read_bytes() != new:
        file.write_bytes(new)
        print(file.relative_to(SAMPLES.parent))


if __name__ == "__main__":
    main()
