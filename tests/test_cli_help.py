"""Help, version, language and usage errors."""

import re
import subprocess
from pathlib import Path

import pytest
from conftest import Runner, command, environment
from test_cli_terminal import on_terminal

from canalyze.output.layout import width

COMMANDS = (
    "decode",
    "sniff",
    "view",
    "explain",
    "sdo",
    "od",
    "signals",
    "summary",
    "check",
    "expect",
    "diff",
    "convert",
    "info",
    "eds",
    "rules",
    "diagnose",
    "export",
    "fleet",
    "monitor",
    "examples",
)
CHINESE = re.compile("[\u4e00-\u9fff]")
UNFILLED = re.compile(r"\{[a-z_]+\}")


@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("place", ["before", "after"])
def test_help_in_english(canalyze: Runner, name: str, place: str) -> None:
    args = ("--lang", "en", name, "--help") if place == "before" else (name, "--help", "--lang=en")
    done = canalyze(*args)
    assert (done.code, done.err) == (0, "")
    assert done.out.startswith(f"Usage: canalyze {name} ")
    assert "Examples" in done.lines
    assert ("Options" in done.lines) != ("Usual options" in done.lines)
    assert not CHINESE.search(done.out)
    assert not UNFILLED.search(done.out)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_in_chinese(canalyze: Runner, name: str) -> None:
    done = canalyze(name, "--help")
    assert (done.code, done.err) == (0, "")
    assert done.out.startswith(f"用法：canalyze {name} ")
    assert "例子" in done.lines
    assert not UNFILLED.search(done.out)
    for english in ("Usage", "Options", "Commands", "Show this", "Examples"):
        assert english not in done.out


def test_help_lists_every_command(canalyze: Runner) -> None:
    done = canalyze("--help", "--lang", "en")
    assert done.code == 0
    for name in COMMANDS:
        assert re.search(rf"^  {name} +\S", done.out, re.MULTILINE)
    assert "_CANALYZE_COMPLETE=bash_source" in done.out


def sections(text: str) -> dict[str, list[str]]:
    """Give what stands under each heading of a page, by the first word of each line that has one."""
    found: dict[str, list[str]] = {}
    for line in text.splitlines():
        if line and not line.startswith(" "):
            found[line] = rows = []
        elif match := re.match(r"  (-\w, --[\w-]+|\S+)", line):
            rows.append(match[1])
    return found


FIRST = {
    "decode": ["--explain", "--eds", "--filter", "-t", "-o, --output"],
    "diagnose": ["-n", "--all", "--html", "--fail-on", "--eds"],
    "sniff": ["--record", "--explain", "--eds", "--filter", "--bitrate"],
    "monitor": ["--record", "--speed", "--eds", "--filter", "--bitrate"],
    "view": ["--eds", "--filter", "--bitrate", "--save", "--merge"],
    "sdo": ["--extract", "--eds", "--filter", "-t", "-o, --output"],
    "od": ["--history", "--at", "--eds", "--filter", "-t"],
    "od diff": ["--node", "--all", "--at", "--eds", "--filter"],
    "od against": ["--node", "--unseen", "--at", "--eds", "--filter"],
    "od write": ["--dcf", "--concise-dcf", "--skeleton", "--dbc", "--node"],
    "check": ["--fail-on", "--baseline", "--junit", "--eds", "--filter"],
    "convert": ["--to", "--eds", "--filter", "--merge", "--force"],
}


@pytest.mark.parametrize(("name", "usual"), FIRST.items())
def test_usual_options_stand_first(canalyze: Runner, name: str, usual: list[str]) -> None:
    found = sections(canalyze(*name.split(), "--help", "--lang", "en").out)
    headings = [heading for heading in found if heading != "Examples" and not heading.startswith("Usage")]
    assert headings[0] == "Usual options" and headings[-1] == "General"
    assert found["Usual options"] == usual
    assert {"--lang", "--config", "-h, --help"} <= set(found["General"])
    options = [option for heading in headings for option in found[heading]]
    assert len(options) == len(set(options)) and all(found[heading] for heading in headings)
    chinese = sections(canalyze(*name.split(), "--help").out)
    assert [rows for heading, rows in chinese.items() if heading in ("常用选项", "通用")] == [usual, found["General"]]


def test_options_stand_under_their_topic(canalyze: Runner) -> None:
    found = sections(canalyze("decode", "--help", "--lang", "en").out)
    assert found["Network description"] == ["--cob", "--pdo", "--profile", "--sdo", "--eds-from-traffic"]
    assert found["Time"] == ["--stamps", "--sync-period", "--sync-window", "--jitter"]
    assert found["Output"] == ["--format", "-n, --number", "--color", "--force"]
    assert found["More options"] == ["--brief", "--problems"]


def test_few_options_have_one_heading(canalyze: Runner) -> None:
    found = sections(canalyze("rules", "--help", "--lang", "en").out)
    assert found["Options"] == ["--format", "--lang", "--config", "--no-pager", "-h, --help"] and "General" not in found


def test_commands_are_grouped(canalyze: Runner) -> None:
    found = sections(canalyze("--help", "--lang", "en").out)
    assert list(found)[1:5] == ["Look at a capture", "Live", "Judge", "Files"]
    assert found["Live"] == ["sniff", "monitor"]
    assert {"查看记录", "实时监听", "检查和比较", "文件"} <= set(sections(canalyze("--help").out))


def test_no_command_is_wrong_usage(tmp_path: Path) -> None:
    done = subprocess.run(
        command(), stdin=subprocess.DEVNULL, cwd=tmp_path, env=environment(), capture_output=True, check=False
    )
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


@pytest.mark.parametrize(
    ("args", "zh", "en"),
    [
        (["deocde"], "没有命令 deocde（是否要用 decode？）", "no such command: deocde (did you mean decode?)"),
        (["xyzzy"], "没有命令 xyzzy", "no such command: xyzzy"),
        (
            ["decode", "--breif"],
            "没有选项 --breif（是否要用 --brief？）",
            "no such option: --breif (did you mean --brief?)",
        ),
        (["decode", "--quux"], "没有选项 --quux；", "no such option: --quux; see"),
        (["decode", "--stamp"], "没有选项 --stamp（是否要用 --stamps？）", "--stamp (did you mean --stamps?);"),
        (["decode", "--Explain"], "没有选项 --Explain（是否要用 --explain？）", "(did you mean --explain?);"),
        (["rules", "--filter"], "没有选项 --filter；", "no such option: --filter; see"),
        (["decode", "-Z"], "没有选项 -Z", "no such option: -Z"),
        (["decode", "-o"], "选项 -o 需要一个值", "option -o needs a value"),
        (["decode", "--brief=1"], "选项 --brief 不带值", "option --brief takes no value"),
        (["decode", "--format", "xml"], "--format xml：应为", "--format xml: expected one of text, jsonl"),
        (["decode", "-t", "q", "f"], "-t q：应为", "-t q: expected one of a, d, z, A, n"),
        (["decode", "--brief", "--explain", "f"], "不能同时使用", "cannot be used together"),
        (["decode", "--brief", "--format", "jsonl", "f"], "只能用于", "only with --format text"),
        (["decode", "f", "--config"], "用法见 canalyze decode --help", "see canalyze decode --help"),
        (["decode", "--config"], "--config 需要一个值", "--config needs a value; see canalyze decode --help"),
        (["--config"], "用法见 canalyze --help", "see canalyze --help"),
    ],
)
def test_usage_error_is_one_line(canalyze: Runner, args: list[str], zh: str, en: str) -> None:
    for lang, said in (("zh", zh), ("en", en)):
        done = canalyze("--lang", lang, *args)
        assert (done.code, done.out) == (2, "")
        assert len(done.complaints) == 1
        assert said in done.err
        assert "--help" in done.err


def test_language_of_environment_and_option(canalyze: Runner) -> None:
    assert canalyze("--help", env={"CANALYZE_LANG": "en"}).out.startswith("Usage:")
    assert canalyze("--help", "--lang", "zh", env={"CANALYZE_LANG": "en"}).out.startswith("用法：")
    assert canalyze("--help", env={"CANALYZE_LANG": ""}).out.startswith("用法：")


@pytest.mark.parametrize("args", [["--lang", "fr"], ["--lang="], ["decode", "x", "--lang", "english"]])
def test_unknown_language(canalyze: Runner, args: list[str]) -> None:
    done = canalyze(*args)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert "zh" in done.err and "en" in done.err


@pytest.mark.parametrize("value", ["EN", "en_US.UTF-8", "en-GB", "En"])
def test_language_in_any_case_or_as_a_locale(canalyze: Runner, value: str) -> None:
    assert canalyze("--help", env={"CANALYZE_LANG": value}).out.startswith("Usage:")
    assert canalyze("--help", "--lang", value).out.startswith("Usage:")


@pytest.mark.parametrize("value", ["zh_CN", "ZH", "zh_CN.UTF-8", "zh-Hans"])
def test_chinese_as_a_locale(canalyze: Runner, value: str) -> None:
    assert canalyze("--help", env={"CANALYZE_LANG": value}).out.startswith("用法：")


def test_unknown_language_of_environment(canalyze: Runner) -> None:
    done = canalyze("rules", env={"CANALYZE_LANG": "de"})
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert "CANALYZE_LANG" in done.err
    assert canalyze("rules", "--lang", "en", env={"CANALYZE_LANG": "de"}).code == 0


def test_language_of_the_configuration(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "canalyze.toml").write_text('lang = "en"\n')
    assert canalyze("--help").out.startswith("Usage:")
    assert canalyze("--help", env={"CANALYZE_LANG": "zh"}).out.startswith("用法：")
    (tmp_path / "other.toml").write_text('lang = "zh"\n')
    assert canalyze("decode", "--help", "--config", "other.toml").out.startswith("用法：")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b'language = "en"\n', ["canalyze.toml", "language", "lang"]),
        (b"lang = 1\n", ["canalyze.toml", "lang", "1", '"zh", "en"']),
        (b"lang = true\n", ["canalyze.toml", "lang", "true"]),
        (b'lang = ["en"]\n', ["canalyze.toml", "lang", '"zh", "en"']),
        (b'lang = "fr"\n', ["canalyze.toml", "lang", '"fr"', '"zh", "en"']),
        (b'# one\n\nlang = "en\n', ["canalyze.toml:3:"]),
        (b"lang = [\n", ["canalyze.toml:"]),
        (b'# one\n# \xff\nlang = "en"\n', ["canalyze.toml:2"]),
    ],
)
def test_broken_configuration_is_one_line(canalyze: Runner, tmp_path: Path, text: bytes, said: list[str]) -> None:
    (tmp_path / "canalyze.toml").write_bytes(text)
    for lang in ("zh", "en"):
        done = canalyze("rules", "--lang", lang)
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
        for part in said:
            assert part in done.err


@pytest.mark.parametrize("text", [b"lang = [\n", b"lang = 'en\n", b"\xff\n", b"lang = 1\n", b"other = 1\n"])
def test_broken_configuration_is_said_in_one_language(canalyze: Runner, tmp_path: Path, text: bytes) -> None:
    (tmp_path / "canalyze.toml").write_bytes(text)
    for env in ({}, {"CANALYZE_LANG": "zh_CN.UTF-8"}):
        done = canalyze("rules", env=env)
        quoted = re.sub("“.*”", "", done.err)
        assert not re.search("[a-z]{3,} [a-z]{3,}", quoted)
        assert CHINESE.search(quoted)
    assert not CHINESE.search(canalyze("rules", env={"CANALYZE_LANG": "EN"}).err)


def test_place_in_a_broken_configuration(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "canalyze.toml").write_text("# one\nlang = en\n")
    assert canalyze("rules").err.startswith("canalyze: canalyze.toml:2:8：不是有效的TOML（")
    (tmp_path / "canalyze.toml").write_text("lang = [")
    assert "canalyze.toml:1:9" in canalyze("rules").err


@pytest.mark.parametrize(
    "args", [["--help"], ["decode", "-h"], ["--version"], ["rules", "--help", "--config", "no.toml"]]
)
def test_help_comes_whatever_the_configuration(canalyze: Runner, tmp_path: Path, args: list[str]) -> None:
    (tmp_path / "canalyze.toml").write_text("lang = [")
    for lang, env, said in (("zh", {}, "用法："), ("en", {"CANALYZE_LANG": "en"}, "Usage:"), ("en", None, "Usage:")):
        done = canalyze(*args, *(["--lang", lang] if env is None else []), env=env)
        assert (done.code, done.err) == (0, "")
        assert done.out.startswith("canalyze " if args == ["--version"] else said)


def test_help_comes_whatever_the_environment(canalyze: Runner) -> None:
    done = canalyze("--help", env={"CANALYZE_LANG": "fr"})
    assert (done.code, done.err) == (0, "")


def test_named_configuration_must_exist(canalyze: Runner) -> None:
    done = canalyze("rules", "--config", "nowhere.toml")
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert "nowhere.toml" in done.err


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


def test_decode_starts_light(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    import subprocess
    import sys

    from conftest import environment

    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "canalyze", "decode", notes],
        capture_output=True,
        cwd=tmp_path,
        env=environment(),
        check=True,
    )
    loaded = {line.rpartition("|")[2].strip().partition(".")[0] for line in done.stderr.decode().splitlines()}
    assert "click" in loaded
    assert not loaded & {"can", "canopen", "rich"}
