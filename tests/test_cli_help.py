"""Help and version, and what is loaded; usage errors and languages are in `console/usage.txt`."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from captures import EDS
from conftest import Runner, environment, ran
from test_cli_terminal import on_terminal

from canalyze.cli import COMMANDS
from canalyze.output.layout import width

CHINESE = re.compile("[\u4e00-\u9fff]")
UNFILLED = re.compile(r"\{[a-z_]+\}")


@pytest.mark.parametrize("name", COMMANDS)
def test_help_is_in_one_language(canalyze: Runner, name: str) -> None:
    en, zh = canalyze("--lang", "en", name, "--help"), canalyze(name, "--help", "--lang=zh")
    assert (en.code, en.err, zh.code, zh.err) == (0, "", 0, "")
    assert en.out.startswith(f"Usage: canalyze {name} ") and zh.out.startswith(f"用法：canalyze {name} ")
    assert "Examples" in en.lines and "例子" in zh.lines
    assert ("Options" in en.lines) != ("Usual options" in en.lines)
    assert not CHINESE.search(en.out) and not re.search("Usage|Options|Commands|Show this|Examples", zh.out)
    assert not UNFILLED.search(en.out + zh.out)


def test_help_lists_every_command(canalyze: Runner) -> None:
    done = canalyze("--help", "--lang", "en")
    assert done.code == 0
    for name in COMMANDS:
        assert re.search(rf"^  {name} +\S", done.out, re.MULTILINE)
    assert "_CANALYZE_COMPLETE=bash_source" in done.out


def test_no_command_is_wrong_usage(tmp_path: Path) -> None:
    done = ran(tmp_path, stdin=subprocess.DEVNULL)
    assert (done.returncode, done.stdout) == (2, b"")
    assert done.stderr.decode().startswith("用法：canalyze ")
    code, shown = on_terminal(tmp_path)
    assert code == 2 and shown.decode().startswith("用法：canalyze ")


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_without_a_command_fits_a_screen(tmp_path: Path, lang: str) -> None:
    code, shown = on_terminal(tmp_path, "--lang", lang, COLUMNS="80")
    lines = shown.decode().splitlines()
    assert code == 2 and len(lines) < 24 and max(map(width, lines)) <= 80
    names = {name for line in lines for name in line.split()}
    assert set(COMMANDS) < names and "--help" in names
    assert not {"bash", "--config"} & names


def test_version(canalyze: Runner) -> None:
    import canalyze as package
    from canalyze import _core

    assert canalyze("--version").out == f"canalyze {package.__version__}\n"
    assert package.__version__ == _core.__version__


def test_completion(canalyze: Runner) -> None:
    done = canalyze(env={"_CANALYZE_COMPLETE": "bash_complete", "COMP_WORDS": "canalyze de", "COMP_CWORD": "1"})
    assert done.out == "plain,decode\n"
    done = canalyze(env={"_CANALYZE_COMPLETE": "zsh_complete", "COMP_WORDS": "canalyze decode --st", "COMP_CWORD": "2"})
    assert "--stamps" in done.lines


def test_completion_of_second_words(canalyze: Runner) -> None:
    for typed, completed in (("od a", ["plain,against", "file,a"]), ("od x.log d", ["file,d"])):
        words = f"canalyze {typed}"
        env = {"_CANALYZE_COMPLETE": "bash_complete", "COMP_WORDS": words, "COMP_CWORD": str(len(typed.split()))}
        assert canalyze(env=env).lines == completed
    env = {"_CANALYZE_COMPLETE": "bash_complete", "COMP_WORDS": "canalyze od write --sk", "COMP_CWORD": "3"}
    assert canalyze(env=env).out == "plain,--skeleton\n"


@pytest.mark.parametrize(
    "more", [[], ["--cob", "1A5=5.TPDO1", "--sync-period", "10ms"], ["--eds", f"5={EDS / 'drive.eds'}"]]
)
def test_decode_starts_light(notes: str, tmp_path: Path, more: list[str]) -> None:
    line = [sys.executable, "-X", "importtime", "-m", "canalyze", "decode", *more, notes]
    done = subprocess.run(line, capture_output=True, cwd=tmp_path, env=environment(), check=True)
    loaded = {line.rpartition("|")[2].strip().partition(".")[0] for line in done.stderr.decode().splitlines()}
    assert "click" in loaded
    assert not loaded & {"can", "canopen", "rich"}


@pytest.mark.parametrize("arguments", [["decode", "no.log"], ["no.log"], ["rules"]])
def test_a_core_that_is_missing_is_one_line(arguments: list[str]) -> None:
    """As in a checkout where nothing is installed."""
    program = "import sys; sys.modules['canalyze._core'] = None; from canalyze.cli import main; sys.exit(main())"
    done = subprocess.run([sys.executable, "-c", program, "--lang", "en", *arguments], capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.startswith("canalyze: the compiled core is missing (")
    assert done.stderr.count("\n") == 1
