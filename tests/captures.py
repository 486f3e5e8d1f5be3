"""Captures as the tests handle them: frames, their candump log text, and what canalyze says about that text.

Why it exists: every test here needs the same three steps (make or read frames, write them as `candump -l` text, ask
the program), and they must not differ from file to file. What it must not do: know anything of CANopen.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import forked

from canalyze import _core
from canalyze.dictionary import load
from canalyze.running.reading import SessionOptions
from canalyze.sources import Capture, Memory

TESTS = Path(__file__).resolve().parent
SAMPLES = TESTS.parent / "samples"
EDS = TESTS.parent / "eds"
DATA = TESTS / "data"
SHARED = TESTS.parent.parent / "shared"
"""Material that lies beside the checkout on some machines; tests that want it skip where it is missing."""

Row = dict[str, Any]
"""One line of the program's JSON output."""


@dataclass(frozen=True, slots=True)
class CanFrame:
    """One classic CAN frame of a capture."""

    bus: str
    can_id: int
    data: bytes
    t_us: int = 0
    extended: bool = False
    remote: bool = False
    _line: str = field(init=False, repr=False, compare=False)

    def log_line(self) -> str:
        """The frame as `candump -l` writes it; kept, since the frames of clean sessions are written again and again."""
        try:
            return self._line
        except AttributeError:
            object.__setattr__(self, "_line", self._written())
            return self._line

    def _written(self) -> str:
        can_id = f"{self.can_id:08X}" if self.extended else f"{self.can_id:03X}"
        shown = "R" if self.remote else self.data.hex().upper()
        return f"({self.t_us // 1_000_000}.{self.t_us % 1_000_000:06d}) {self.bus} {can_id}#{shown}\n"


def log_text(frames: Iterable[CanFrame]) -> bytes:
    """A capture file in `candump -l` form."""
    return "".join(frame.log_line() for frame in frames).encode()


def console_text(frames: Iterable[CanFrame]) -> bytes:
    """The same as candump prints it on a console without options: no stamps."""
    lines = []
    for frame in frames:
        can_id = f"{frame.can_id:08X}" if frame.extended else f"{frame.can_id:03X}"
        shown = f"[{len(frame.data)}]  {frame.data.hex(' ').upper()}" if frame.data else "[0] "
        shown = "[0]  remote request" if frame.remote else shown
        lines.append(f"  {frame.bus}  {can_id}   {shown}\n")
    return "".join(lines).encode()


def read_log(text: bytes) -> list[CanFrame]:
    """The data and remote frames of `candump -l` text; `#` lines and blank ones are passed over, others are errors."""
    return list(_read_log(text))


_LOG_LINE = re.compile(r"\((\d+)\.(\d{6})\) (\S+) ([0-9A-F]{3}|[0-9A-F]{8})#(R|(?:[0-9A-F]{2})*)")


def examples(path: Path) -> dict[str, list[CanFrame]]:
    """The frames of a sample, by the `# title` line that they stand under."""
    found: dict[str, list[CanFrame]] = {}
    title = ""
    for line in path.read_bytes().splitlines(keepends=True):
        if line.startswith(b"#"):
            title = line.decode().removeprefix("#").strip()
        else:
            found.setdefault(title, []).extend(read_log(line))
    return found


def _read_log(text: bytes) -> Iterator[CanFrame]:
    for line in text.decode().splitlines():
        if not line or line.startswith("#"):
            continue
        match = _LOG_LINE.fullmatch(line)
        if match is None:
            raise ValueError(f"not a plain data frame: {line!r}")
        seconds, micros, bus, can_id, data = match.groups()
        stamp = int(seconds) * 1_000_000 + int(micros)
        payload = b"" if data == "R" else bytes.fromhex(data)
        yield CanFrame(bus, int(can_id, 16), payload, stamp, extended=len(can_id) == 8, remote=data == "R")


def spaced(frames: Iterable[CanFrame], *, start_us: int = 1_700_000_000_000_000, step_us: int = 400) -> list[CanFrame]:
    """The frames with stamps in even steps, in the order given."""
    return [replace(frame, t_us=start_us + number * step_us) for number, frame in enumerate(frames)]


@dataclass(slots=True)
class Analysis:
    """Everything the program said about one capture, by kind."""

    frames: list[Row] = field(default_factory=list)
    notes: list[Row] = field(default_factory=list)
    findings: list[Row] = field(default_factory=list)
    transfers: list[Row] = field(default_factory=list)

    def above_info(self) -> list[Row]:
        """The findings that a clean capture must not have: all above info but what its devices report themselves."""
        return [finding for finding in self.findings if finding["severity"] != "info" and not self.is_reported(finding)]

    def is_reported(self, finding: Row) -> bool:
        """Whether a finding repeats what is in the capture: a device that has an error, or a controller, says so."""
        if finding["code"] == "BUS003":
            return True
        if finding["code"] not in {"EMC007", "EMC008"}:
            return False
        (frame,) = [row for row in self.frames if row["frame"] == finding["frame"]]
        return bool(frame["service"] == "emcy" and frame["emcy"]["code"] == finding["facts"].get("code", "") >= "0100")

    def complaint(self) -> str:
        """The findings above info, one line each, for a test's message."""
        return "\n".join(
            f"{f['code']} {f['severity']} frame {f['frame']} cause {f['cause_frame']} node {f['node']}: {f['message']}"
            for f in self.above_info()
        )


def analyze(
    text: bytes,
    *,
    name: str = "capture.log",
    lang: str = "en",
    regular: bool = True,
    eds: Mapping[int, str] | None = None,
    network: _core.Network | None = None,
    expectations: _core.Expectations | None = None,
) -> Analysis:
    """What the program says about a capture, in process and at once.

    eds: files of eds/ by the node-IDs that they describe.
    """
    known = network or described(tuple(sorted((eds or {}).items())))
    output = session_output(
        [text], regular, name=name, output_format="jsonl", lang=lang, network=known, expectations=expectations
    )
    return sort_rows(output)


@cache
def described(eds: tuple[tuple[int, str], ...]) -> _core.Network | None:
    """What `--eds NODE=FILE` tells the core, for files of eds/."""
    if not eds:
        return None
    return _core.Network(descriptions=[(None, node, load(str(EDS / name)).table) for node, name in eds])


def described_beside(capture: Path) -> _core.Network | None:
    """What is known of a sample's nodes; None where there is nothing.

    The truth beside a session of a network names files of eds/; `NAME.eds` or `NAME.dcf` is that of node 5.
    """
    name = capture.name.split(".")[0]
    if capture.parent.name == "network":
        nodes = json.loads(capture.with_suffix(".json").read_text())["nodes"]
        return described(tuple((row["node"], row["eds"]) for row in nodes if row["eds"]))
    for file in (capture.with_name(f"{name}.{form}") for form in ("eds", "dcf")):
        if file.is_file():
            return _core.Network(descriptions=[(None, 5, load(str(file), 5).table)])
    return None


def eds_options(capture: Path) -> list[str]:
    """The options that give the nodes of a session of a network their descriptions, by the truth beside it."""
    if capture.parent.name != "network":
        return []
    nodes = json.loads(capture.with_suffix(".json").read_text())["nodes"]
    return [f"--eds={row['node']}={EDS / row['eds']}" for row in nodes if row["eds"]]


def expected_beside(capture: Path) -> _core.Expectations | None:
    """What is expected of a sample, and of its clean neighbour; None where nothing is."""
    file = capture.with_name(f"{capture.name.split('.')[0]}.expect.toml")
    if not file.is_file():
        return None
    return _core.Expectations(file.read_bytes(), file.name)


def sort_rows(output: bytes) -> Analysis:
    """JSON lines of `decode --format jsonl`, by kind; those of incidents, which `sniff` has, are left out."""
    said = Analysis()
    places = {"frame": said.frames, "note": said.notes, "finding": said.findings, "transfer": said.transfers}
    for line in output.decode().splitlines():
        row: Row = json.loads(line)
        if row["kind"] not in {"problem", "diagnosis"}:
            places[row["kind"]].append(row)
    return said


def session_output(
    chunks: Iterable[bytes],
    regular: bool = True,
    /,
    *,
    name: str = "capture.log",
    output_format: str = "text",
    lang: str = "zh",
    depth: str = "default",
    network: _core.Network | None = None,
    input_format: str | None = None,
    expectations: _core.Expectations | None = None,
) -> bytes:
    """The output of one session over one file (or pipe: not regular) that came in these chunks."""
    session = _core.Session(
        SessionOptions(lang=lang, format=output_format, depth=depth, network=network, expectations=expectations)
    )
    chunks = list(chunks)
    form = input_format or _core.sniff(b"".join(chunks), True)
    session.begin(name, regular, form if form in _core.FORMATS else "candump")
    output = [session.feed(chunk) for chunk in chunks]
    output.append(session.end())
    output.append(session.finish())
    return b"".join(output)


def held(name: str, data: bytes) -> Capture:
    """Text of candump as an open capture."""
    return Capture(Memory(name, data), "candump")


def placed(finding: Row) -> str:
    """The sentence in English for whoever sees it at its frame: another frame that it is about comes first."""
    about = finding["about_frame"]
    if about is None or about == finding["frame"]:
        return str(finding["message"])
    return f"frame {about}{'' if finding['node'] else ':'} {finding['message']}"


def run_canalyze(arguments: Sequence[str | Path], *, expected_exit: int = 0, folder: Path | None = None) -> bytes:
    """Standard output of the command line program, run in this folder; its exit status must be the expected one."""
    line = [str(argument) for argument in arguments]
    done = forked.run(line, cwd=folder, env=os.environ, timeout_s=600, kept=True)
    if done.returncode != expected_exit:
        raise AssertionError(f"{line} ended with {done.returncode}:\n{done.stderr.decode(errors='replace')}")
    return done.stdout


def sdo_rows(path: Path) -> list[Row]:
    """The lines of `canalyze sdo FILE --format jsonl`."""
    output = run_canalyze(["sdo", path, "--format", "jsonl"]).decode()
    rows: list[Row] = [json.loads(line) for line in output.splitlines()]
    return rows


def decoded(path: Path) -> Analysis:
    """What `canalyze decode FILE --format jsonl` says."""
    return sort_rows(run_canalyze(["decode", path, "--format", "jsonl", "--lang", "en"]))


def frame_identity(row: Row) -> tuple[str, str, bool, bool, int, str]:
    """What makes two frame rows the same frame of the bus, whatever the dialect they were read from."""
    return (row["bus"], row["id"], bool(row["ext"]), bool(row["rtr"]), row["len"], row["data"].upper())
