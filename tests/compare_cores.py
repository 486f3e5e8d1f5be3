"""Two builds of the core over everything that is at hand: what one says and the other does not.

    python tests/compare_cores.py OLD.so NEW.so [--only WORD] [--random COUNT] [--show WORD] [--info]

Why it exists: after a change of many verdicts every difference must be a miss or a false alarm of the old core, or a
mistake of the new one; so they are listed, grouped and counted by code. Findings are compared as (code, frame, cause).
Each core runs in a process of its own over the samples, the captures beside the checkout, seeded faults, faults of
every class, clean sessions under every distortion, and so many random pieces of sessions under random distortions.

--only: captures whose name has the word; their kinds are sample, shared, seeded, fault, distorted, random.
--show: differences whose code or capture has the word, one line each. --info: compares findings of level info, too.
What it must not do: judge which core is right.
"""

from __future__ import annotations

import argparse
import importlib.machinery
import importlib.util
import json
import random
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from canalyze import _core

TESTS = Path(__file__).resolve().parent
FOLDERS = ("stacks", "stories", "corpus")
"""Folders beside the checkout that hold captures."""

Said = dict[tuple[str, int, int | None], dict[str, Any]]
"""Findings by code, frame and cause."""


@dataclass(frozen=True, slots=True)
class Capture:
    """One capture and what is known of its network."""

    name: str
    """Its kind, a colon, and what it is."""
    text: bytes
    network: _core.Network | None = None
    expectations: _core.Expectations | None = None
    file: str = "capture.log"


def files() -> Iterator[Capture]:
    """Samples with what lies beside them, and captures beside the checkout."""
    from captures import SAMPLES, SHARED, described_beside, expected_beside

    for path in sorted(path for path in SAMPLES.rglob("*.*") if path.suffix in (".log", ".candump", ".asc", ".mcap")):
        name = f"sample: {path.relative_to(SAMPLES)}"
        yield Capture(name, path.read_bytes(), described_beside(path), expected_beside(path), path.name)
    for folder in FOLDERS:
        for path in sorted(path for path in (SHARED / folder).rglob("*") if path.is_file()):
            if path.suffix not in (".json", ".md", ".eds", ".dcf", ".xdd", ".gz"):
                yield Capture(f"shared: {path.relative_to(SHARED)}", path.read_bytes(), file=path.name)


def faults() -> Iterator[Capture]:
    """Faults in SDO transfers, and every class of faults at every place."""
    from captures import log_text
    from fault_table import TABLE
    from test_seeded_faults import FAULTS, in_company

    for fault in FAULTS:
        session = list(fault.session)
        fault.change(session, fault.at)
        yield Capture(f"seeded: {fault.name}", log_text(in_company(session)[0]))
    for row in TABLE:
        for case in row.cases():
            yield Capture(f"fault: {row.row}, {case.where}", log_text(case.faulty.frames), case.network)


def distorted() -> Iterator[Capture]:
    """Clean sessions under every distortion."""
    from clean_sessions import beside, sessions
    from distortions import DISTORTIONS

    for name, session in sessions().items():
        for distortion in DISTORTIONS:
            for where, text in distortion.apply(session):
                for number, network in enumerate(beside(name)):
                    row = f"distorted: {name}, {distortion.name}, {where}{', described' * number}"
                    yield Capture(row, text, network, file=f"capture.{distortion.form}")


def shuffled(count: int) -> Iterator[Capture]:
    """Pieces of clean and of faulty sessions under one or two distortions of random magnitudes."""
    from captures import log_text
    from clean_sessions import sessions
    from distortions import copied, drifted, floored, late_echo, stalled
    from fault_table import TABLE
    from plants import Session

    names = list(sessions())
    faulty = list(islice(((row.row, case) for row in TABLE for case in row.cases()), 0, None, 29))
    for seed in range(count):
        chance = random.Random(seed)
        name = chance.choice(names)
        session, what = sessions()[name], [name]
        if chance.random() < 0.3:
            fault, case = chance.choice(faulty)
            session = replace(session, frames=tuple(case.faulty.frames), network=case.network)
            what = [fault, case.where]
        first, last = sorted(chance.sample(range(len(session.frames) + 1), 2))
        frames = list(session.frames[first:last])
        for kind in chance.sample(("none", "echo", "copies", "stall", "resolution", "drift"), 2):
            piece = Session(tuple(frames), session.own)
            if kind == "echo":
                frames = late_echo(piece, chance.randint(100, 8000), chance.random(), seed)
            elif kind == "copies":
                frames = copied(piece, chance.randint(1, 8000))
            elif kind == "stall":
                lasts = round(10 ** chance.uniform(4, 7.7))
                frames = stalled(frames, chance.randrange(len(frames)), lasts, chance.choice((20, 200, 1000)))
            elif kind == "resolution":
                frames = floored(frames, chance.choice((10, 100, 1000, 10_000)))
            elif kind == "drift":
                frames = drifted(frames, chance.randint(-10_000, 10_000))
            what.append(kind)
        yield Capture(f"random: {seed}: {', '.join(what)}", log_text(frames), session.network)


def everything(count: int) -> Iterator[Capture]:
    """All captures, always in the same order."""
    yield from files()
    yield from faults()
    yield from distorted()
    yield from shuffled(count)


# In the process of one core.


def load_core(path: Path) -> None:
    """Make an extension the core of this process."""
    loader = importlib.machinery.ExtensionFileLoader("canalyze._core", str(path))
    spec = importlib.util.spec_from_file_location("canalyze._core", path, loader=loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["canalyze._core"] = module
    loader.exec_module(module)


def say(path: Path, output: Path, only: str, count: int) -> None:
    """Write a line for each capture: its name and its findings."""
    load_core(path)
    from captures import session_output

    from canalyze import _core

    with output.open("w") as lines:
        for capture in everything(count):
            if only not in capture.name:
                continue
            form = _core.sniff(capture.text, True)
            said = session_output(
                [capture.text],
                name=capture.file,
                output_format="check",
                lang="en",
                network=capture.network,
                input_format=form if form in _core.FORMATS else "candump",
                expectations=capture.expectations,
            )
            rows = [json.loads(line) for line in said.decode().splitlines()]
            kept = ("code", "severity", "frame", "cause_frame", "because_of", "node", "message")
            found = [{key: row.get(key) for key in kept} for row in rows if row["kind"] == "finding"]
            lines.write(json.dumps({"name": capture.name, "findings": found}) + "\n")


# In the process that compares.


def by_place(findings: list[dict[str, Any]], info: bool) -> Said:
    """The findings of a capture that count."""
    loud = [f for f in findings if info or (f["severity"] != "info" and f["because_of"] is None)]
    return {(f["code"], f["frame"], f["cause_frame"]): f for f in loud}


def differences(name: str, old: Said, new: Said) -> Iterator[tuple[str, str, str]]:
    """Each difference of a capture: what it is, its code, and a line about it."""
    gone, come = [old[key] for key in old if key not in new], [new[key] for key in new if key not in old]
    for finding in gone:
        twin = next((other for other in come if other["code"] == finding["code"]), None)
        if twin is not None:
            come.remove(twin)
        kind = "only old" if twin is None else "elsewhere"
        to = f" -> frame {twin['frame']} cause {twin['cause_frame']}" if twin else ""
        yield kind, finding["code"], f"{name}: {line(finding)}{to}"
    for finding in come:
        yield "only new", finding["code"], f"{name}: {line(finding)}"
    for key in old.keys() & new.keys():
        if old[key]["severity"] != new[key]["severity"]:
            level = f"{old[key]['severity']} -> {new[key]['severity']}"
            yield "severity", key[0], f"{name}: {level}: {line(new[key])}"


def line(finding: dict[str, Any]) -> str:
    return f"{finding['code']} frame {finding['frame']} cause {finding['cause_frame']}: {finding['message']}"


def run_both(old: Path, new: Path, only: str, count: int, folder: Path) -> list[Path]:
    """Both cores at the same time; what each said."""
    outputs = [folder / "old.jsonl", folder / "new.jsonl"]
    running = [
        subprocess.Popen([sys.executable, __file__, "--say", core, output, "--only", only, "--random", str(count)])
        for core, output in zip((old.resolve(), new.resolve()), outputs, strict=True)
    ]
    ended = [process.wait() for process in running]
    if any(ended):
        raise SystemExit("a core failed")
    return outputs


def compare(old: Path, new: Path, options: argparse.Namespace) -> None:
    """Print the differences, grouped and counted."""
    counts: dict[str, Counter[tuple[str, str]]] = {}
    captures, differing = Counter[str](), Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        first, second = run_both(old, new, options.only, options.random, Path(folder))
        with first.open() as olds, second.open() as news:
            for said_old, said_new in zip(map(json.loads, olds), map(json.loads, news), strict=True):
                name = said_old["name"]
                assert name == said_new["name"]
                kind = name.partition(":")[0]
                captures[kind] += 1
                places = [by_place(said["findings"], options.info) for said in (said_old, said_new)]
                found = list(differences(name, *places))
                differing[kind] += bool(found)
                for what, code, text in found:
                    counts.setdefault(kind, Counter())[what, code] += 1
                    if options.show is not None and options.show in text:
                        print(f"{what}: {text}")
    for kind, number in captures.items():
        print(f"{kind}: {number} captures, {differing[kind]} differ")
        for (what, code), times in sorted(counts.get(kind, Counter()).items()):
            print(f"    {what:9} {code} {times}")


def main() -> None:
    """One core, or both."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("cores", nargs=2, type=Path, metavar="CORE.so")
    parser.add_argument("--only", default="")
    parser.add_argument("--random", type=int, default=2000)
    parser.add_argument("--show")
    parser.add_argument("--info", action="store_true")
    parser.add_argument("--say", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.say:
        core, output = options.cores
        say(core, output, options.only, options.random)
    else:
        compare(options.cores[0], options.cores[1], options)


if __name__ == "__main__":
    main()
