"""Compares two builds of canalyze over every capture and description at hand: the proof of a change of shape.

    python tests/net.py OLD NEW [--only WORD] [--show COUNT] [--sample K] [--jobs COUNT] [--list]

OLD and NEW are checkouts with a built core (`canalyze/_core.abi3.so`). Both run the same cases: captures (samples,
files beside the checkout, damaged copies) and device descriptions, through every command, form, language and table;
Arrow tables cell by cell; captures as blocks of a live bus; and commands without a capture. A case that gives other
bytes, another exit code, or none at all is printed with its first differing lines.

--only: cases whose name has the word; the name of a case is `KIND: CAPTURE | COMMAND`.
--sample: only one capture in K, always the same ones: an eighth takes about a minute on two processors, all eight.
--show: cases that are printed with their lines (default 20). --list: prints the names of the cases and runs nothing.

`net_accepted.toml` beside this file lists differences that are wanted, each with its reason; they are counted, not
printed. Ends with 1 if a difference is left, or if an accepted one does not occur in a run over all cases.
Answers of a build are kept in `.cache/net` by the bytes of its core and of its Python files.
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import importlib
import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path
from typing import Any
from zlib import crc32

TESTS = Path(__file__).resolve().parent
ROOT = TESTS.parent
SHARED = ROOT.parent / "shared"
CACHE = ROOT / ".cache" / "net"
ACCEPTED = TESTS / "net_accepted.toml"
LANGUAGES = ("zh", "en")
CAPTURES = {".log", ".candump", ".asc", ".mcap", ".blf", ".trc", ".pcapng", ".txt", ".csv", ".bin", ".gz", ".zst"}
DESCRIPTIONS = {".eds", ".dcf", ".xdd"}
FOLDERS = ("cases", "stacks", "stories", "usdo", "pasted", "damage", "limits", "corpus")
"""Folders beside the checkout that hold captures and descriptions."""
WIDE = 300_000
"""Bytes of a capture from which on only some commands run on it."""
TIMEOUT_S = 120

FORMS = (
    "text", "jsonl", "events", "transfers", "transfers-text", "transfers-csv", "signals", "signals-csv", "objects",
    "objects-text", "objects-csv", "pdos", "history", "history-text", "history-csv", "summary", "observed", "lines",
    "records", "check", "diagnosis",
)  # fmt: skip
"""Forms of a session, all of which the core makes alone."""

COMMANDS: tuple[tuple[str, ...], ...] = (
    ("FILE",),
    ("diagnose", "--all", "FILE"),
    ("diagnose", "--format", "jsonl", "FILE"),
    ("decode", "--problems", "FILE"),
    ("decode", "-n", "--color", "always", "--filter", "service=sdo,emcy,nmt", "FILE"),
    ("sdo", "FILE"),
    ("od", "FILE"),
    ("summary", "FILE"),
    ("check", "FILE"),
    ("check", "--format", "jsonl", "--problems", "open", "--junit", "OUT", "FILE"),
    ("check", "--format", "github", "--sarif", "OUT", "FILE"),
    ("info", "FILE"),
    ("info", "--format", "jsonl", "FILE"),
    ("expect", "FILE"),
    ("signals", "FILE"),
)
"""Command lines of each capture and language; FILE is the capture, OUT a file whose bytes belong to the answer."""

FEW: tuple[tuple[str, ...], ...] = (("FILE",), ("check", "FILE"), ("summary", "FILE"), ("info", "FILE"))
"""Those of a wide capture."""

OTHERS: tuple[tuple[str, ...], ...] = (
    *((topic, "--help") for topic in ("decode", "diagnose", "check", "od", "convert", "sniff", "monitor", "fleet")),
    ("--help",),
    ("rules",),
    ("rules", "--format", "jsonl"),
    ("explain", "60A#4008100000000000", "58A#4108100017000000", "080#", "000#0105", "705#05", "7E5#1100", "7E4#44"),
    ("explain", "085#1081010000000000", "100#0102030405060000", "20000004#0001000000000000", "185#3702", "7E5#04 01"),
    ("explain", "1017", "SYNC", "06090011", "8110", "6041", "toggle", "PDO004"),
    ("examples", "--help"),
)
"""Command lines without a capture."""


@dataclass(frozen=True, slots=True)
class Case:
    """One thing to be compared."""

    name: str
    run: Callable[[], bytes]


# The cases; this part runs in a process of one build.


def beside_options(path: Path) -> list[str]:
    """The options that name descriptions beside a sample: of node 5, or those that the truth of a network names."""
    name = path.name.split(".")[0]
    if path.parent.name == "network" and path.with_suffix(".json").is_file():
        nodes = json.loads(path.with_suffix(".json").read_text())["nodes"]
        rows = [(row["node"], ROOT / "eds" / row["eds"]) for row in nodes if row["eds"]]
        return [word for node, file in rows for word in ("--eds", f"{node}={file}")]
    for form in ("eds", "dcf"):
        if (file := path.with_name(f"{name}.{form}")).is_file():
            return ["--eds", f"5={file}"]
    return []


def files() -> Iterator[tuple[str, Path]]:
    """Name and path of every capture."""
    for path in sorted(path for path in (ROOT / "samples").rglob("*") if path.suffix in CAPTURES):
        if not path.name.endswith((".zh.txt", ".en.txt")):
            yield f"sample: {path.relative_to(ROOT / 'samples')}", path
    for folder in FOLDERS:
        for path in sorted(path for path in (SHARED / folder).rglob("*") if path.suffix in CAPTURES):
            if not path.name.endswith(".tax.txt"):
                yield f"shared: {path.relative_to(SHARED)}", path


def damaged(folder: Path) -> Iterator[tuple[str, Path]]:
    """Copies of samples with bytes that are missing, doubled or flipped, the same in every run."""
    chance = random.Random(34)
    names = [path for _, path in files() if path.is_relative_to(ROOT / "samples") and path.stat().st_size < WIDE]
    for number, path in enumerate(chance.sample(names, min(90, len(names)))):
        data = bytearray(path.read_bytes())
        for _ in range(chance.choice((1, 1, 3, 10))):
            at = chance.randrange(max(len(data), 1))
            match chance.choice(("cut", "flip", "double", "lose", "zero")):
                case "cut":
                    del data[max(at, 40) :]
                case "flip":
                    data[at : at + 1] = bytes([data[at] ^ 1 << chance.randrange(8)]) if data else b""
                case "double":
                    data[at:at] = data[at : at + chance.randrange(1, 200)]
                case "lose":
                    del data[at : at + chance.randrange(1, 200)]
                case "zero":
                    data[at : at + 8] = bytes(len(data[at : at + 8]))
        copy = folder / f"damaged{number:02}{path.suffix}"
        copy.write_bytes(data)
        yield f"damaged: {number:02} {path.relative_to(ROOT / 'samples')}", copy


def cases(folder: Path) -> Iterator[Case]:
    """All cases in a fixed order. folder: for files that the cases need or write."""
    captures = [*files(), *damaged(folder)]
    for place, (name, path) in enumerate(captures):
        yield from of_capture(name, path, folder, captures[place - 1][1])
    descriptions = [*(ROOT / "eds").glob("*"), *(ROOT / "samples").rglob("*"), *(SHARED / "corpus" / "eds").glob("*")]
    for path in sorted(path for path in descriptions if path.suffix in DESCRIPTIONS):
        for lang in LANGUAGES:
            for more in ((), ("--all",), ("--format", "jsonl")):
                line = ("--lang", lang, "eds", *more, str(path))
                yield Case(f"description: {path.name} | {lang} eds {' '.join(more)}", partial(command, line))
    for lang in LANGUAGES:
        for words in OTHERS:
            line = ("--lang", lang, *words)
            yield Case(f"alone: | {lang} {' '.join(words)}", partial(command, line))
        for topic in sorted(path.stem for path in (ROOT / "canalyze" / "pages" / "en").glob("*.md")):
            line = ("--lang", lang, "help", topic)
            yield Case(f"alone: | {lang} help {topic}", partial(command, line))


def of_capture(name: str, path: Path, folder: Path, before: Path) -> Iterator[Case]:
    """The cases of one capture. before: another one, which it is compared with."""
    is_wide = path.stat().st_size > WIDE or path.suffix in (".gz", ".zst")
    alone = not is_wide and path.suffix not in (".blf", ".trc", ".bin")
    eds = beside_options(path)
    run = partial(session, path, eds)
    for lang in LANGUAGES:
        if alone:
            for form in FORMS:
                yield Case(f"{name} | {lang} form {form}", partial(run, lang, form))
            for depth in ("brief", "explain"):
                yield Case(f"{name} | {lang} form text {depth}", partial(run, lang, "text", depth=depth))
            yield Case(f"{name} | {lang} tables", partial(tables, path, eds, lang))
            if not name.startswith("damaged"):  # a damaged stamp may be years of silence
                yield Case(f"{name} | {lang} live", partial(live, path, eds, lang))
            yield Case(f"{name} | {lang} monitor", partial(monitor, path, eds, lang))
        for words in FEW if is_wide else COMMANDS:
            line = ("--lang", lang, *words, *(eds if words[0] != "info" else ()))
            yield Case(f"{name} | {lang} {' '.join(words)}", partial(command, line, path, folder))
    if alone:
        for form in ("candump", "console", "asc", "mcap", "pcapng"):
            yield Case(f"{name} | convert {form}", partial(run, "en", "convert", to=form))
        yield Case(f"{name} | convert mcap decoded", partial(run, "en", "convert", to="mcap", decoded=True))
        yield Case(f"{name} | chunks", partial(run, "en", "jsonl", chunk=97))
        line = ("--lang", "en", "diff", str(before), str(path))
        yield Case(f"{name} | diff", partial(command, line))
        yield Case(f"{name} | diff jsonl", partial(command, (*line, "--format", "jsonl")))


def network(eds: list[str]) -> Any:
    """The network that the options describe; None without any."""
    from canalyze import _core
    from canalyze.dictionary import load

    rows = [word.partition("=") for word in eds[1::2]]
    if not rows:
        return None
    return _core.Network(descriptions=[(None, int(node), load(file, int(node)).table) for node, _, file in rows])


def opened(path: Path, data: bytes, **options: Any) -> Any:
    """A session that has begun with a capture."""
    from canalyze import _core
    from canalyze.running.reading import SessionOptions

    form = _core.sniff(data, True)
    one = _core.Session(SessionOptions(**options))
    one.begin(path.name, True, form if form in _core.FORMATS else "candump")
    return one


def session(path: Path, eds: list[str], lang: str, form: str, chunk: int = 0, **more: Any) -> bytes:
    """The output of a session over a capture, and its complaints."""
    data = path.read_bytes()
    incidents = form in ("text", "jsonl", "check", "observed") and not chunk
    one = opened(path, data, lang=lang, format=form, network=network(eds), incidents=incidents, **more)
    pieces = [data[at : at + chunk] for at in range(0, len(data), chunk)] if chunk else [data]
    out = [one.feed(piece) for piece in pieces]
    out += [one.end(), one.finish(), *(line.encode() + b"\n" for line in one.complaints()), one.tally().encode()]
    return b"".join(out)


def tables(path: Path, eds: list[str], lang: str) -> bytes:
    """The schema and the cells of all tables of a capture."""
    import pyarrow as pa

    from canalyze import _core

    data = path.read_bytes()
    one = opened(path, data, lang=lang, format="columns", network=network(eds), tables=list(_core.TABLES))
    out = []
    for part in (one.feed(data), one.end(), one.finish()):
        out.append(part)
        for table, batch in one.batches():
            rows = pa.record_batch(batch)
            out.append(f"\n== {table}: {rows.schema.to_string()}\n".encode())
            out.extend(f"{row}\n".encode() for row in rows.to_pylist())
    return b"".join(out)


def live(path: Path, eds: list[str], lang: str) -> bytes:
    """The lines of a capture whose frames come as blocks of a live bus."""
    from live_blocks import live_output

    from canalyze import _core

    data = path.read_bytes()
    form = _core.sniff(data, True)
    if form not in _core.FORMATS:
        return b""
    forms = ("jsonl", "text")
    return b"".join(live_output(data, lang=lang, output_format=one, network=network(eds), form=form) for one in forms)


def monitor(path: Path, eds: list[str], lang: str) -> bytes:
    """What a view shows in the middle of a capture and at its end."""
    data = path.read_bytes()
    one = opened(path, data, lang=lang, format="monitor", network=network(eds))
    out = []
    for piece in (data[: len(data) // 2], data[len(data) // 2 :]):
        one.feed(piece)
        out.append(one.snapshot())
    one.end()
    one.finish()
    out.append(one.snapshot())
    seen = json.loads(out[-1]) if out[-1] else {}
    for bus in {row.get("bus") or "" for row in seen.get("nodes", [])} if isinstance(seen, dict) else ():
        out.extend(one.page(bus, node) for node in (1, 2, 5, 10))
    out += [*map(repr, one.trace(rows=200)), one.nodes()]
    return "\n".join(out).encode()


def command(line: tuple[str, ...], path: Path | None = None, folder: Path | None = None) -> bytes:
    """Exit code, standard output and standard error of a command line that runs in this process."""
    written = folder / "out" if folder and "OUT" in line else None
    if written:
        written.unlink(missing_ok=True)
    words = [str(path) if word == "FILE" else str(written) if word == "OUT" else word for word in line]
    code, out, err = in_process(words)
    more = written.read_bytes() if written and written.exists() else b""
    more = re.sub(rb' time="[0-9.]+"', b"", more)  # of JUnit: the time that the check took
    return b"exit %d\n%b\n-- standard error\n%b\n-- file\n%b" % (code, out, err, more)


def in_process(words: list[str]) -> tuple[int, bytes, bytes]:
    from canalyze.cli import main

    sys.stdout.flush()
    sys.stderr.flush()
    kept = [os.dup(number) for number in (1, 2)]
    streams = [tempfile.TemporaryFile() for _ in kept]  # noqa: SIM115
    try:
        for number, stream in zip((1, 2), streams, strict=True):
            os.dup2(stream.fileno(), number)
        try:
            code = main(words)
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 1
        sys.stdout.flush()
        sys.stderr.flush()
    finally:
        for number, old in zip((1, 2), kept, strict=True):
            os.dup2(old, number)
            os.close(old)
    texts = []
    for stream in streams:
        stream.seek(0)
        texts.append(stream.read())
        stream.close()
    return code, texts[0], texts[1]


def moved() -> None:
    """Puts the options of a session where they are now, in a build from before they were moved."""
    reading: Any = importlib.import_module("canalyze.running.reading")
    if not hasattr(reading, "SessionOptions"):
        reading.SessionOptions = importlib.import_module("canalyze.running.options").SessionOptions


def answered(case: Case) -> bytes:
    """The answer of a case; what goes wrong in it is its answer."""
    moved()

    def late(*_: object) -> None:
        raise TimeoutError

    signal.signal(signal.SIGALRM, late)
    signal.alarm(TIMEOUT_S)
    try:
        return case.run()
    except Exception:
        return b"!! " + traceback.format_exc(limit=-3).encode()
    finally:
        signal.alarm(0)


@dataclass(frozen=True, slots=True)
class Chosen:
    """The cases to run: those with a word in their name, of one capture in `sample`."""

    only: str = ""
    sample: int = 1

    def has(self, name: str) -> bool:
        """Returns true if the case of this name is one of them."""
        return self.only in name and crc32(name.partition(" | ")[0].encode()) % self.sample == 0


def answer(part: int, parts: int, chosen: Chosen, kept: bool) -> None:
    """Writes a line a case to standard output: its name, the sum of its answer, and with `kept` the answer itself."""
    lines = os.fdopen(os.dup(1), "w")
    with tempfile.TemporaryDirectory() as outer:
        # A name of the same length in every process: paths are in the answers.
        folder = Path(outer)
        os.chdir(folder)
        place = Path(tempfile.gettempdir()) / f"canalyze-net-{os.getpid():08}"
        with suppress(FileNotFoundError):
            place.unlink()
        place.symlink_to(folder)
        for number, case in enumerate(cases(place)):
            # Cases of one capture follow each other: they are dealt by dozens.
            if number // 12 % parts != part or not chosen.has(case.name):
                continue
            began = time.process_time()
            said = answered(case).replace(place.name.encode(), b"NET")
            spent = round(time.process_time() - began, 3)
            row: dict[str, Any] = {"name": case.name, "sum": hashlib.sha256(said).hexdigest()[:24], "s": spent}
            if kept:
                row["text"] = said.decode("utf-8", "backslashreplace")
            lines.write(json.dumps(row) + "\n")
        lines.close()
        place.unlink()


# The processes of both builds.


def environment(checkout: Path) -> dict[str, str]:
    ours = {"CANALYZE_LANG", "NO_COLOR", "LC_ALL", "COLUMNS"}
    rest = {name: value for name, value in os.environ.items() if name not in ours}
    return rest | {
        "PYTHONPATH": f"{checkout}{os.pathsep}{TESTS}", "PYTHONHASHSEED": "0", "TERM": "xterm", "LC_MESSAGES": "C",
        "PYTHONDONTWRITEBYTECODE": "",
    }  # fmt: skip


def started(checkout: Path, part: int, parts: int, chosen: Chosen, kept: bool, into: Path) -> subprocess.Popen[bytes]:
    line = [sys.executable, __file__, "--answer", str(part), str(parts), "--only", chosen.only]
    line += ["--sample", str(chosen.sample), *(["--keep"] if kept else [])]
    with into.open("wb") as stream:
        return subprocess.Popen(line, env=environment(checkout), stdout=stream)


def answers(checkout: Path, jobs: int, chosen: Chosen, kept: bool = False) -> dict[str, dict[str, Any]]:
    """The answers of a build by the names of the cases."""
    store = CACHE / f"{fingerprint(checkout)}.{hashlib.sha256(repr(chosen).encode()).hexdigest()[:8]}.json.gz"
    if store.exists() and not kept:
        return dict(json.loads(gzip.decompress(store.read_bytes())))
    found: dict[str, dict[str, Any]] = {}
    with tempfile.TemporaryDirectory() as folder:
        into = [Path(folder) / f"{part}.jsonl" for part in range(jobs)]
        running = [started(checkout, part, jobs, chosen, kept, file) for part, file in enumerate(into)]
        ended = [process.wait() for process in running]
        for file in into:
            rows = (json.loads(line) for line in file.read_text().splitlines() if line.endswith("}"))
            found |= {row["name"]: row for row in rows}
    if any(ended):
        print(f"{checkout}: a process ended with {ended}", file=sys.stderr)
    elif not kept:
        CACHE.mkdir(parents=True, exist_ok=True)
        store.write_bytes(gzip.compress(json.dumps(found).encode()))
    return found


def fingerprint(checkout: Path) -> str:
    """Stands for all that the answers of a build depend on, the cases included."""
    known = hashlib.sha256(Path(__file__).read_bytes())
    for path in sorted((checkout / "canalyze").rglob("*")):
        if path.suffix in (".py", ".txt", ".toml", ".md", ".so") and "core" not in path.parts:
            known.update(path.read_bytes())
    for _, path in files():
        known.update(f"{path} {path.stat().st_size}".encode())
    return known.hexdigest()[:24]


# The comparison.


@dataclass(frozen=True, slots=True)
class Accepted:
    """A wanted difference: a glob over names of cases, and the lines that may differ (all, without a pattern)."""

    case: str
    reason: str
    lines: str | None = None

    def covers(self, name: str, lines: list[str]) -> bool:
        """Returns true if the difference of a case is this one alone."""
        if not fnmatchcase(name, self.case):
            return False
        return self.lines is None or all(re.search(self.lines, line) for line in lines)


def accepted() -> list[Accepted]:
    return [Accepted(**row) for row in tomllib.loads(ACCEPTED.read_text()).get("accepted", [])]


def differing(old: str, new: str) -> list[str]:
    """The lines of one text that the other does not have, each behind `-` or `+`."""
    import difflib

    lines = difflib.unified_diff(old.splitlines(), new.splitlines(), lineterm="", n=0)
    return [line for line in lines if not line.startswith(("---", "+++", "@@"))]


def compare(old: Path, new: Path, options: argparse.Namespace) -> int:
    """Prints the differences; returns the exit code."""
    chosen = Chosen(options.only, options.sample)
    first, second = (answers(checkout, options.jobs, chosen) for checkout in (old, new))
    names = [name for name in first if first[name]["sum"] != second.get(name, {}).get("sum")]
    names += [name for name in second if name not in first]
    rows, used, left = accepted(), Counter[str](), 0
    # A few are run again one by one for their lines, many all at once.
    again = [Chosen(name) for name in names] if len(names) <= 2 * options.show else [chosen]
    texts = [{**answers(old, 1, one, True)} for one in again], [{**answers(new, 1, one, True)} for one in again]
    a, b = ({name: row["text"] for part in parts for name, row in part.items()} for parts in texts)
    for name in names:
        lines = differing(a.get(name, "(no answer)"), b.get(name, "(no answer)"))
        cover = next((row for row in rows if row.covers(name, lines)), None)
        if cover:
            used[cover.reason] += 1
            continue
        left += 1
        if left <= options.show:
            print(f"\n{name}")
            print("\n".join(f"    {line[:240]}" for line in lines[:12]))
    for reason, count in used.items():
        print(f"accepted: {count} cases: {reason}")
    unused = [] if options.only or options.sample > 1 else [row for row in rows if row.reason not in used]
    for row in unused:
        print(f"accepted, but does not occur: {row.case}: {row.reason}")
    print(f"{len(first)} cases, {len(names)} differ, {left} of them unexplained")
    return 1 if left or unused else 0


def main() -> int:
    """Compares two builds, or answers as one of them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("builds", nargs="*", type=Path, metavar="CHECKOUT")
    parser.add_argument("--only", default="")
    parser.add_argument("--sample", type=int, default=1, metavar="K")
    parser.add_argument("--show", type=int, default=20)
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--keep", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--answer", nargs=2, type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.answer:
        part, parts = options.answer
        answer(part, parts, Chosen(options.only, options.sample), options.keep)
        return 0
    if options.list:
        with tempfile.TemporaryDirectory() as folder:
            print("\n".join(case.name for case in cases(Path(folder)) if options.only in case.name))
        return 0
    if len(options.builds) != 2:
        parser.error("two checkouts are needed: the old build and the new one")
    old, new = (checkout.resolve() for checkout in options.builds)
    for checkout in (old, new):
        if not list((checkout / "canalyze").glob("_core*.so")):
            parser.error(f"{checkout} has no built core")
    return compare(old, new, options)


if __name__ == "__main__":
    sys.exit(main())
