"""Snapshots of captures beside tests: where they are kept, comparing and writing them, and which ones nobody uses.

A pytest plugin object, which works in xdist's workers too: what a test has used travels with its report, what was
collected with the worker's end. It must not import the core.
"""

import difflib
import hashlib
import itertools
import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, Final

import pytest

from canalyze.library.plan import shown_as
from canalyze.output.writing import Part
from canalyze.words import Words

FOLDER: Final = "__canalyze__"
_LONGEST: Final = 120
"""Characters of a test's name that are kept in that of a file."""
_USED: Final = "canalyze_snapshots"
"""Attribute of reports, and key of what a worker hands over."""
_KEY: Final = pytest.StashKey[dict[str, bool]]()


class Snapshots:
    """The snapshots of one run."""

    def __init__(self, config: pytest.Config) -> None:
        """Nothing is known yet."""
        self._config = config
        self._update = bool(config.getoption("--canalyze-update"))
        self._stems: dict[str, set[str]] = {}
        """By test file: what names of snapshots of its tests begin with."""
        self._passed: set[str] = set()
        """Such beginnings, with their folder, of the tests that have passed."""
        self._used: set[str] = set()
        self._written = 0

    def compare(self, item: pytest.Item, text: str, name: str | None, words: Words) -> str | None:
        """Compare with the file, or write it; give what is wrong in words."""
        path = item.path.parent / FOLDER / f"{stem(item)}{'' if name is None else '.' + _safe(name)}.txt"
        shown = shown_as(path)
        used = item.stash.setdefault(_KEY, {})
        if str(path) in used:
            return words("test.again", file=shown)
        used[str(path)] = False
        test = "::".join([shown_as(item.path), *item.nodeid.split("::")[1:]])
        command = f'python -m pytest "{test}" --canalyze-update'
        try:
            kept = path.read_text(encoding="utf-8") if path.exists() else None
            if self._update:
                if kept != text:
                    path.parent.mkdir(exist_ok=True)
                    _put(path, text)
                    used[str(path)] = True
                return None
        except (OSError, UnicodeDecodeError) as error:
            return words("test.unreadable", file=shown, problem=error)
        if kept is None:
            return f"{words('test.missing', file=shown, command=command)}\n{words('test.shows')}\n{text}"
        if kept == text:
            return None
        return "\n".join([words("test.differs", file=shown, command=command), *_difference(kept, text)])

    def tell(self, item: pytest.Item, report: pytest.TestReport) -> None:
        """Put what the test has used into its report."""
        if report.when == "call":
            setattr(report, _USED, [str(item.path.parent / FOLDER / stem(item)), item.stash.get(_KEY, {})])

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Take what a test has used, here or in a worker."""
        told = getattr(report, _USED, None)
        if told is None:
            return
        begin, used = told
        self._used.update(used)
        self._written += sum(used.values())
        if report.passed:
            self._passed.add(begin)

    def pytest_deselected(self, items: Iterable[pytest.Item]) -> None:
        """Take note of tests that are there, though they do not run."""
        self._see(items)

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """Take note of the tests that run."""
        self._see(session.items)

    def _see(self, items: Iterable[pytest.Item]) -> None:
        for item in items:
            self._stems.setdefault(str(item.path), set()).add(stem(item))

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Hand over what was collected, in a worker."""
        output = getattr(session.config, "workeroutput", None)
        if output is not None:
            output[_USED] = {file: sorted(stems) for file, stems in self._stems.items()}

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any, error: object) -> None:
        """Take what a worker has collected."""
        for file, stems in (getattr(node, "workeroutput", None) or {}).get(_USED, {}).items():
            self._stems.setdefault(file, set()).update(stems)

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Say what was written, and which snapshots no test uses."""
        words = Words(str(self._config.getini("canalyze_lang")))
        if self._written:
            terminalreporter.write_line(words("test.written", count=self._written))
        for path in self._orphans():
            terminalreporter.write_line(words("test.orphan", file=shown_as(path)))

    def _orphans(self) -> list[Path]:
        """Give the files that no test has, or that a test which passed has not asked for."""
        orphans = []
        for folder in sorted({Path(file).parent for file in self._stems}):
            for path in sorted((folder / FOLDER).glob("*.txt")):
                module = path.name.partition(".")[0]
                file = str(folder / f"{module}.py")
                if file not in self._stems:
                    if not Path(file).exists():
                        orphans.append(path)
                    continue
                owners = [one for one in self._stems[file] if f"{path.name}.".startswith(f"{one}.")]
                owner = max(owners, key=len, default=None)
                gone = owner is None and self._is_whole(file)
                unused = owner is not None and str(folder / FOLDER / owner) in self._passed
                if gone or (unused and str(path) not in self._used):
                    orphans.append(path)
        return orphans

    def _is_whole(self, file: str) -> bool:
        """Tell whether all tests of a file were collected."""
        if any(self._config.getoption(option, False) for option in ("lf", "failedfirst")):
            return False
        parts = (arg.partition("::")[0] for arg in self._config.args if "::" in arg)
        return Path(file).name not in {Path(part).name for part in parts}


def _put(path: Path, text: str) -> None:
    """Write a file, all of it or nothing."""
    part = Part(path, replace=True)
    try:
        os.close(part.fd)
        part.append(text.encode())
        part.complete()
    finally:
        part.discard()


def _difference(kept: str, text: str) -> Iterator[str]:
    """Give what differs, each part under the node that it is about."""
    before = kept.splitlines()
    lines = difflib.unified_diff(before, text.splitlines(), lineterm="", n=1)
    for line in itertools.islice(lines, 2, None):
        if line.startswith("@@"):
            start = int(line[4:].partition(",")[0].partition(" ")[0])
            line = next((f"@@ {one}" for one in reversed(before[:start]) if one.startswith("node")), "@@")
        yield line


def stem(item: pytest.Item) -> str:
    """Give what names of a test's snapshots begin with: module, class, test and parameters, safe in every system."""
    return f"{item.path.stem}.{_safe('.'.join(item.nodeid.split('::')[1:]))}"


def _safe(name: str) -> str:
    """Give a name that a file can have; what would be another's gets a check sum."""
    plain = re.sub(r"\[(.*)\]$", r"-\1", name)
    safe = re.sub(r"[^\w.-]", "_", plain)[:_LONGEST].rstrip(".")
    return safe if safe == plain else f"{safe}-{hashlib.sha256(name.encode()).hexdigest()[:8]}"
