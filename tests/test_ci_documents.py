"""The files by which other programs run this one: workflows, an action, a hook, and snippets on its pages.

Each is valid by the consumer's schema, and the commands of the snippets do what the page says. What it must not do:
know what `check` writes; its own tests do.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from captures import SAMPLES
from ruamel.yaml import YAML

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
    assert written == set(re.findall(r"captures\.(?:xml|sarif|json|md)\b", snippet(kind))), (
        "what the snippet goes on with"
    )


def test_the_baseline_of_the_page_holds(tmp_path: Path) -> None:
    (tmp_path / "captures").mkdir()
    shutil.copy(SAMPLES / "rules/SDO001.log", tmp_path / "captures/old.log")
    lines = re.findall(r"^canalyze (check --baseline .+)$", PAGE, re.MULTILINE)
    assert len(lines) == 2
    for line in lines:
        done = subprocess.run([sys.executable, "-m", "canalyze", *shlex.split(line)], capture_output=True, cwd=tmp_path)
        assert done.returncode == 0, done.stdout.decode() + done.stderr.decode()


# The action.

ACTION = ROOT / ".github/actions/canalyze/action.yml"
HOOKS = ROOT / ".pre-commit-hooks.yaml"


def loaded(text: str) -> Any:
    return YAML(typ="safe").load(text)


def step(name: str, folder: Path, **inputs: str) -> subprocess.CompletedProcess[str]:
    """Run the step of the action whose script has `name`, as a runner does: inputs are put where it names them."""
    action = loaded(ACTION.read_text(encoding="utf-8"))
    (found,) = [one for one in action["runs"]["steps"] if name in one.get("run", "")]
    assert found["shell"] == "bash" and "${{" not in found["run"], "an input is no part of a script"
    known = {f"inputs.{key}": str(row.get("default", "")) for key, row in action["inputs"].items()}
    known |= {f"inputs.{key}": value for key, value in inputs.items()}
    known |= {"steps.python.outputs.python-path": sys.executable, "github.action_path": str(ACTION.parent)}
    given = {
        key: re.sub(r"\$\{\{ (.+?) \}\}", lambda match: known[match[1]], text) for key, text in found["env"].items()
    }
    runner = {
        "RUNNER_TEMP": str(folder / "temp"),
        "GITHUB_STEP_SUMMARY": str(folder / "summary"),
        "PYTHONPATH": str(ROOT),
    }
    for made in (folder / "temp", folder / "captures"):
        made.mkdir(exist_ok=True)
    return subprocess.run(
        ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", found["run"]],
        env=os.environ | runner | given,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_action_is_valid() -> None:
    is_valid("vendor.github-actions", ACTION)


@pytest.mark.parametrize(("options", "code"), [("", 1), ("--fail-on never", 0), ("--ignore SDO --sarif a.sarif", 0)])
def test_the_action_checks_and_writes_a_summary(options: str, code: int, tmp_path: Path) -> None:
    (tmp_path / "summary").write_text("before\n")
    (tmp_path / "captures").mkdir()
    shutil.copy(SAMPLES / "rules/SDO001.log", tmp_path / "captures/a b.log")
    shutil.copy(SAMPLES / "zephyr-sdo.log", tmp_path / "captures/good.log")
    done = step("canalyze check", tmp_path, captures="captures/a b.log\n\ncaptures/g*.log\n", options=options)
    assert done.returncode == code, done.stderr
    summary = (tmp_path / "summary").read_text(encoding="utf-8")
    assert summary.startswith("before\n## canalyze check: 2 files, ")
    assert done.stdout.startswith("::error file=captures/a b.log,line=") == ("SDO" not in options)
    assert (tmp_path / "a.sarif").exists() == ("sarif" in options)


def test_nothing_in_an_input_of_the_action_is_run(tmp_path: Path) -> None:
    evil = '$(touch ran); `touch ran`; "; touch ran; #\n--help'
    done = step("canalyze check", tmp_path, captures=evil, options="$(touch ran) ; touch ran")
    assert done.returncode == 2 and not (tmp_path / "ran").exists()


def test_the_action_builds_its_own_checkout_or_takes_a_wheel(tmp_path: Path) -> None:
    pip = tmp_path / "python"
    pip.write_text('#!/bin/sh\nprintf "%s\\n" "$@"\n')
    pip.chmod(0o755)
    action = loaded(ACTION.read_text(encoding="utf-8"))
    (install,) = [one["run"] for one in action["runs"]["steps"] if "pip install" in one.get("run", "")]
    (tmp_path / "a.whl").touch()
    for package, installed in (("", str(ACTION.parent / "../../..")), ("*.whl", "a.whl")):
        given = {"PYTHON": str(pip), "PACKAGE": package, "CHECKOUT": f"{ACTION.parent}/../../.."}
        said = subprocess.run(
            ["bash", "-eo", "pipefail", "-c", install],
            env=os.environ | given,
            cwd=tmp_path,
            capture_output=True,
            text=True,
        )
        assert said.stdout.splitlines()[-1] == installed
    assert (ACTION.parent / "../../../pyproject.toml").resolve() == ROOT / "pyproject.toml"


# The hook.


def test_the_hook_checks_the_captures_of_a_commit(tmp_path: Path) -> None:
    (hook,) = loaded(HOOKS.read_text(encoding="utf-8"))
    assert {*hook} == {"id", "name", "description", "entry", "language", "files", "require_serial"}
    assert hook["language"] == "python"
    (tmp_path / "captures").mkdir()
    for name, sample in (("good", "zephyr-sdo.log"), ("bad", "rules/SDO001.log")):
        shutil.copy(SAMPLES / sample, tmp_path / f"captures/{name}.log")
    for names, code in ((["captures/good.log"], 0), (["captures/good.log", "captures/bad.log"], 1)):
        assert all(re.search(hook["files"], name) for name in names)
        command = [sys.executable, "-m", *shlex.split(hook["entry"]), *names]
        env = os.environ | {"PYTHONPATH": str(ROOT)}
        assert subprocess.run(command, cwd=tmp_path, env=env, capture_output=True, check=False).returncode == code
    for name in ("a.log", "captures.log", "captures/README.md", "mycaptures/a.log"):
        assert not re.search(hook["files"], name)
    assert re.search(hook["files"], "tests/captures/run 1/a.asc.zst")


def test_the_page_uses_the_action_and_the_hook_as_they_are() -> None:
    (used,) = [
        loaded(text)[0] for text in re.findall(r"^```yaml\n( +- uses: .+?)^```$", PAGE, re.DOTALL | re.MULTILINE)
    ]
    path = used["uses"].partition("@")[0].split("/", 2)[2]
    assert ROOT / path == ACTION.parent
    assert {*used["with"]} <= {*loaded(ACTION.read_text(encoding="utf-8"))["inputs"]}
    (config,) = re.findall(r"^```yaml\n(# \.pre-commit-config\.yaml\n.+?)^```$", PAGE, re.DOTALL | re.MULTILINE)
    ((repository,),) = (loaded(config)["repos"],)
    (hook,) = repository["hooks"]
    assert hook["id"] == loaded(HOOKS.read_text(encoding="utf-8"))[0]["id"]
