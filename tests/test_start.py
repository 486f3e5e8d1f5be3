"""What the command loads before its first line: the start is short because this is little."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from captures import EDS, TESTS
from conftest import environment

SAMPLE = TESTS.parent / "samples" / "zephyr-sdo.log"
RUN = """
import json, sys
bare = set(sys.modules)
from canalyze.__main__ import main
sys.argv = ["canalyze", *sys.argv[1:]]
code = main()
print(json.dumps([code, sorted(set(sys.modules) - bare)]), file=sys.stderr)
"""
ELSEWHERE = {
    *("asammdf", "asyncio", "backports", "can", "canopen", "importlib.metadata", "logging", "mcap"),
    *("multiprocessing", "numpy", "pyarrow", "rerun", "rich", "secrets", "socket", "sqlite3", "ssl", "subprocess"),
    *("tempfile", "textual", "tomllib", "urllib.request", "xml", "zstandard"),
}
"""What a pass over a file never needs: others' libraries, and what is slow to load of Python's own."""
BESIDE = {
    "dataclasses",
    "msgspec",
    "pathlib",
    "json",
    "shlex",
    "canalyze.check",
    "canalyze.library",
    "canalyze.reports",
}
"""What a listing does not need either."""


RERUN = "timelines need Rerun; install it: pip install 'canalyze[rerun]'"
EXTRAS = [
    ("textual", ["monitor", str(SAMPLE)], "monitor needs textual: pip install 'canalyze[tui]'"),
    (
        "pyarrow",
        ["export", str(SAMPLE), "-o", "lake"],
        "pyarrow is needed and not installed: pip install 'canalyze[parquet]'",
    ),
    ("mcp", ["mcp", "."], "mcp needs the Python SDK of MCP: pip install 'canalyze[mcp]'"),
    ("rerun", ["view", "--save", "x.rrd", str(SAMPLE)], RERUN),
    ("rerun", ["sniff", "bus", "-i", "virtual", "--save", "x.rrd"], RERUN),
    (
        "cantools",
        ["eds", "--node", "5", "--dbc", "x.dbc", str(EDS / "drive.eds")],
        "cantools is needed and not installed: pip install 'canalyze[dbc]'",
    ),
]


@pytest.mark.parametrize(("module", "args", "said"), EXTRAS, ids=[f"{args[0]} {module}" for module, args, _ in EXTRAS])
def test_an_extra_that_is_missing_is_named_in_one_line(tmp_path: Path, module: str, args: list[str], said: str) -> None:
    program = f"import sys; sys.modules[{module!r}] = None; from canalyze.cli import main; sys.exit(main(sys.argv[1:]))"
    line = [sys.executable, "-c", program, "--lang", "en", *args]
    done = subprocess.run(line, capture_output=True, text=True, check=False, cwd=tmp_path, env=environment())
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"canalyze: {said}\n")
    assert not list(tmp_path.iterdir())


def loaded(directory: Path, *args: str) -> set[str]:
    done = subprocess.run(
        [sys.executable, "-c", RUN, *args], capture_output=True, text=True, check=True, cwd=directory, encoding="utf-8"
    )
    code, modules = json.loads(done.stderr.splitlines()[-1])
    assert code in (0, 1)
    return set(modules)


@pytest.mark.parametrize(
    ("args", "least", "most"),
    [(["decode"], 15, 30), ([], 15, 40), (["diagnose"], 15, 40), (["check"], 15, 50)],
    ids=["decode", "no command", "diagnose", "check"],
)
def test_a_file_loads_little(tmp_path: Path, args: list[str], least: int, most: int) -> None:
    modules = loaded(tmp_path, *args, str(SAMPLE))
    assert not {name for name in modules for heavy in ELSEWHERE if name == heavy or name.startswith(f"{heavy}.")}
    assert least <= sum(name.split(".")[0] == "canalyze" for name in modules) <= most


def test_a_listing_loads_least(tmp_path: Path) -> None:
    modules = loaded(tmp_path, "decode", str(SAMPLE))
    assert not BESIDE & modules


def test_the_end_of_a_run_looks_for_no_garbage() -> None:
    code = "import gc; from canalyze.__main__ import main; main(); print(gc.get_freeze_count() - len(gc.get_objects()))"
    done = subprocess.run([sys.executable, "-c", code, "rules"], capture_output=True, check=True, encoding="utf-8")
    assert int(done.stdout.splitlines()[-1]) > 10_000


def test_what_a_run_asks_for_is_loaded_then(tmp_path: Path) -> None:
    """The lists above would be empty of meaning if nothing were ever loaded."""
    (tmp_path / "canalyze.toml").write_text('lang = "en"\n')
    modules = loaded(tmp_path, "decode", str(SAMPLE), "-o", "out.txt", "--eds", f"5={TESTS.parent / 'eds/drive.eds'}")
    assert {"pathlib", "canalyze.dictionary"} <= modules
