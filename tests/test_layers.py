"""The house order of the package, kept: which part of `canalyze/` may use which, at any place in a file.

`core/tests/layers/` does the same for the core. A part is a folder, or a file beside the folders.
"""

import ast
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from captures import TESTS

PACKAGE = TESTS.parent / "canalyze"
TABLE = tomllib.loads((TESTS / "layers.toml").read_text(encoding="utf-8"))


def parts(names: str) -> set[str]:
    """Returns the parts that a row names, by themselves or by a group of them."""
    groups: dict[str, str] = TABLE["groups"]
    return {part for name in names.split() for part in (parts(groups[name]) if name in groups else {name})}


MAY_USE = {row: parts(names) for row, names in TABLE["may_use"].items()}
"""A part, or a file of one, and what it may use."""


def imports(path: Path, *, typing: bool = True) -> set[str]:
    """Returns the imports of a file from the package, as dotted names behind `canalyze.`. typing: also for types."""
    found = set()
    tree = ast.parse(path.read_text(encoding="utf-8"))
    if not typing:
        tree.body = [one for one in tree.body if not ast.unparse(one).startswith("if TYPE_CHECKING:")]
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module == "canalyze":
            found |= {alias.name for alias in node.names if (PACKAGE / alias.name).is_dir() or is_file(alias.name)}
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("canalyze."):
            name = str(node.module).removeprefix("canalyze.")
            deeper = {f"{name}.{alias.name}" for alias in node.names if is_file(f"{name}.{alias.name}")}
            found |= deeper or {name}
    return found


def circle(uses: dict[str, set[str]]) -> set[str]:
    """Returns the files that are in a circle, or between two circles."""
    left = set(uses)
    while some := {one for one in left if not uses[one] & left or not any(one in uses[other] for other in left)}:
        left -= some
    return left


def test_no_files_use_each_other_in_a_circle() -> None:
    """Imports for types do not count; in two rooms an import within a function still closes a circle."""
    names = {
        ".".join(part for part in path.relative_to(PACKAGE).with_suffix("").parts if part != "__init__"): path
        for path in FILES
    }
    uses = {name: imports(path, typing=False) & names.keys() - {name} for name, path in names.items()}
    assert {one.split(".")[0] for one in circle(uses)} <= {"configuration", "library"}
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": set()}) == {"b", "c"}


def is_file(name: str) -> bool:
    path = PACKAGE.joinpath(*name.split("."))
    return path.with_suffix(".py").is_file() or path.with_suffix(".pyi").is_file()


FILES = sorted(path for path in PACKAGE.rglob("*.py") if "core" not in path.relative_to(PACKAGE).parts)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_file_uses_what_it_may(path: Path) -> None:
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    name = ".".join(part for part in parts if part != "__init__")
    row = name if name in MAY_USE else parts[0]
    if row not in MAY_USE:
        assert parts[0] in ("__init__", "__main__", "cli", "commands"), f"{parts[0]} needs a row"
        return
    allowed = MAY_USE[row] | (set() if "." in row else {row})
    used = {one for one in imports(path) if one not in allowed and one.split(".")[0] not in allowed}
    assert not used, f"{name} uses {', '.join(sorted(used))}"


OPTIONAL = {
    "cantools",
    "rerun",
    "rerun_cli",
    "pyarrow",
    "anyio",
    "matplotlib",
    "mcp",
    "numpy",
    "pandas",
    "polars",
    "obstore",
    "dask",
    "distributed",
    "ray",
}
"""What only extras bring."""
COMMANDS = ("view", "sniff", "export", "fleet", "mcp")
HEAVY = f"""import sys, canalyze.cli, canalyze.fleet.run, {", ".join(f"canalyze.commands.{name}" for name in COMMANDS)}
print(*sys.modules, sep="\\n")"""


def test_timelines_tables_and_fleets_alone_need_the_optional_part() -> None:
    """And only while one is made: the commands start without it."""
    users = set()
    for path in FILES:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) and not node.level else []
            if OPTIONAL & {name.split(".")[0] for name in names}:
                users.add(path.relative_to(PACKAGE).parts[0])
    assert users == {"commands", "dictionary", "timeline", "library", "exporting", "fleet", "running"}
    loaded = subprocess.run([sys.executable, "-c", HEAVY], capture_output=True, text=True, check=True).stdout.split()
    assert not OPTIONAL & set(loaded)


def test_a_command_is_short() -> None:
    """It has its options and its pass; what it does besides is in the room of its subject."""
    lengths = {path.name: len(path.read_text().splitlines()) for path in (PACKAGE / "commands").glob("*.py")}
    assert len(lengths) > 20 and not {name for name, lines in lengths.items() if lines > 120}


def test_the_rows_are_in_order() -> None:
    """What reads uses nothing that only shows, and no part stands above the commands."""
    assert not {name for name, may in MAY_USE.items() if may & {"cli", "commands", "help", "pytest_plugin"}}
    parts = {path.relative_to(PACKAGE).parts[0].removesuffix(".py") for path in FILES}
    assert {row.split(".")[0] for row in MAY_USE} <= parts
