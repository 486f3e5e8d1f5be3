"""What the repository says to other programs that run it: workflows, and its pages' snippets for GitHub and GitLab.

Each is valid by the consumer's schema, and the commands of the snippets do what the page says. What it must not do:
know what `check` writes; its own tests do.
"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from captures import SAMPLES

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "canalyze/pages/en/ci.md").read_text(encoding="utf-8")
SNIPPETS = {"github": ".github/workflows/captures.yml", "gitlab": ".gitlab-ci.yml"}
SCHEMAS = {"github": "vendor.github-workflows", "gitlab": "vendor.gitlab-ci"}


def snippet(kind: str) -> str:
    """The page's snippet that begins with the name of its file."""
    found = re.search(rf"^```yaml\n(# {re.escape(SNIPPETS[kind])}\n.+?)^```$", PAGE, re.DOTALL | re.MULTILINE)
    assert found
    return found[1]


def commands(kind: str) -> list[str]:
    """The snippet's calls of the program."""
    return re.findall(r"^\s*- (?:run: )?(canalyze .+)$", snippet(kind), re.MULTILINE)


def is_valid(schema: str, file: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "check_jsonschema", "--builtin-schema", schema, str(file)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("file", sorted((ROOT / ".github/workflows").glob("*.yml")), ids=lambda file: file.name)
def test_workflows_are_valid(file: Path) -> None:
    is_valid(SCHEMAS["github"], file)


@pytest.mark.parametrize("kind", SNIPPETS)
def test_snippets_are_valid(kind: str, tmp_path: Path) -> None:
    file = tmp_path / Path(SNIPPETS[kind]).name
    file.write_text(snippet(kind), encoding="utf-8")
    is_valid(SCHEMAS[kind], file)


@pytest.mark.parametrize("kind", SNIPPETS)
@pytest.mark.parametrize(("sample", "code"), [("zephyr-sdo.log", 0), ("rules/SDO001.log", 1)])
def test_snippets_do_what_they_say(kind: str, sample: str, code: int, tmp_path: Path) -> None:
    (tmp_path / "captures/bench").mkdir(parents=True)
    shutil.copy(SAMPLES / sample, tmp_path / "captures/bench/one.log")
    (line,) = commands(kind)
    arguments = shlex.split(line)[1:]
    done = subprocess.run(
        [sys.executable, "-m", "canalyze", *arguments], capture_output=True, check=False, cwd=tmp_path
    )
    assert done.returncode == code, done.stderr.decode()
    written = {path.name for path in tmp_path.iterdir() if path.is_file()}
    assert written == set(re.findall(r"captures\.(?:xml|sarif)", snippet(kind))), "what the snippet goes on with"


def test_the_baseline_of_the_page_holds(tmp_path: Path) -> None:
    (tmp_path / "captures").mkdir()
    shutil.copy(SAMPLES / "rules/SDO001.log", tmp_path / "captures/old.log")
    lines = re.findall(r"^canalyze (check --baseline .+)$", PAGE, re.MULTILINE)
    assert len(lines) == 2
    for line in lines:
        done = subprocess.run([sys.executable, "-m", "canalyze", *shlex.split(line)], capture_output=True, cwd=tmp_path)
        assert done.returncode == 0, done.stdout.decode() + done.stderr.decode()
