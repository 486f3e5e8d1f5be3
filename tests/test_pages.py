"""The pages for users are true: they show what the program prints, and name what exists, in both languages alike.

`page_examples.py` runs what is in them. Must not: hold a sentence of a page, or need a bus or a window.
"""

from __future__ import annotations

import ast
import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import click
import generated_pages
import page_examples
import pytest
from captures import run_canalyze
from page_examples import PAGES, README, ROOT, Block, blocks, invocations

from canalyze import _core, expectations, pages
from canalyze.cli import COMMANDS, PARTS, build
from canalyze.configuration import config
from canalyze.words import LANGUAGES

OTHERS = {"--no-deps", "--canalyze-update"}
"""Options of other programs that pages name."""
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")


def shown(page: Path) -> str:
    return str(page.relative_to(ROOT))


def text(page: Path) -> str:
    return page.read_text(encoding="utf-8")


WRITTEN = [page for page in PAGES if page.stem not in generated_pages.PAGES]


@pytest.mark.parametrize("page", WRITTEN, ids=shown)
def test_examples_run_and_show_what_the_program_prints(page: Path) -> None:
    if page.stem == "timeline":
        pytest.importorskip("rerun")
    assert page_examples.rewritten(page) == text(page), "run: python tests/regenerate.py pages"


@pytest.mark.parametrize("lang", LANGUAGES)
@pytest.mark.parametrize("topic", generated_pages.PAGES)
def test_generated_pages_are_current(topic: str, lang: str) -> None:
    assert generated_pages.PAGES[topic](lang) == text(pages.FOLDER / lang / f"{topic}.md"), (
        "run: python tests/regenerate.py pages"
    )


@pytest.mark.parametrize(
    "example", ["sh\ncanalyze decode --no-such all-well.log", "sh\ncanalyze decode missing.log", "python\nassert False"]
)
def test_an_example_that_fails_is_noticed(example: str, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"```{example}\n```\n")
    with pytest.raises(page_examples.Failed):
        page_examples.rewritten(page)


def test_what_a_listing_may_need_runs_in_both_languages(tmp_path: Path) -> None:
    (tmp_path / "zh").mkdir()
    page = tmp_path / "zh/page.md"
    failing, listing = "```sh\ncanalyze decode missing.log\n```\n", "```console\n$ canalyze --version\n```\n"
    page.write_text(listing + failing)
    assert page_examples.rewritten(page).endswith(failing)
    page.write_text(failing + listing)
    with pytest.raises(page_examples.Failed):
        page_examples.rewritten(page)


def test_a_listing_that_is_old_is_noticed(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("```console\n$ canalyze --version\nold\n```\n")
    assert "old" not in page_examples.rewritten(page)


def test_an_option_that_is_none_is_noticed() -> None:
    (arguments,) = invocations("canalyze decode --no-such capture.log | head")
    with pytest.raises(AssertionError):
        parsed(arguments)


def test_both_languages_have_the_same_pages() -> None:
    there = {lang: {path.stem for path in (pages.FOLDER / lang).glob("*.md")} - {"README"} for lang in LANGUAGES}
    assert there["zh"] == there["en"] == set(pages.TOPICS)
    assert (pages.FOLDER / "zh/README.md").is_file()


PAIRS = [(README, pages.FOLDER / "zh/README.md")] + [
    (pages.FOLDER / f"en/{topic}.md", pages.FOLDER / f"zh/{topic}.md") for topic in pages.TOPICS
]


@pytest.mark.parametrize("pair", PAIRS, ids=lambda pair: pair[0].stem)
def test_both_languages_have_the_same_headings_and_examples(pair: tuple[Path, Path]) -> None:
    english, chinese = map(text, pair)
    if pair[0].stem != "glossary":  # sorted by its own language
        assert [*headings(english)] == [*headings(chinese)]
        assert english.count("\n|") == chinese.count("\n|")
    assert [*map(sense, blocks(english))] == [*map(sense, blocks(chinese))]


def headings(page: str) -> Iterator[int]:
    """The levels of its headings, in order."""
    bare = re.sub(r"^```.*?^```$", "", page, flags=re.DOTALL | re.MULTILINE)
    for match in re.finditer(r"^(#+) ", bare, re.MULTILINE):
        yield len(match[1])


def sense(block: Block) -> object:
    """What a block says to the program, whatever its comments and results."""
    head = (block.kind, block.words.replace(".zh.", ".en."))
    if block.kind == "toml":
        return head, re.sub(
            r'"[^"]*[^\x00-\x7f"][^"]*"|(?<=reason = )"[^"]*"', '""', repr(tomllib.loads(without_reason(block.text)))
        )
    if block.kind == "python":
        return head, ast.dump(ast.parse(block.text))
    if block.kind in ("console", "sh", "yaml"):
        return head, [neutral(line) for line in block.commands()]
    return head


def without_reason(toml: str) -> str:
    return re.sub(r"^reason = .*$", 'reason = "x"', toml, flags=re.MULTILINE)


def neutral(line: str) -> str:
    """A command line without its comment and its language."""
    line = re.sub(r"\s+# .*", "", line)
    return re.sub(r"--lang (zh|en)", "--lang L", line).strip()


@pytest.mark.parametrize("page", PAGES, ids=shown)
def test_links_lead_somewhere(page: Path) -> None:
    bare = re.sub(r"^```.*?^```$", "", text(page), flags=re.DOTALL | re.MULTILINE)
    for target in LINK.findall(bare):
        if not target.startswith(("http:", "https:")):
            assert (page.parent / target).exists(), target


@pytest.mark.parametrize("page", PAGES, ids=shown)
def test_commands_and_options_that_are_named_exist(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page_examples.workspace(tmp_path)
    monkeypatch.chdir(tmp_path)
    content = text(page)
    lines = [line for block in blocks(content) for line in block.commands()]
    bare = re.sub(r"^```.*?^```$", "", content, flags=re.DOTALL | re.MULTILINE)
    spans = re.findall(r"`([^`\n]+)`", bare)
    for line in [*lines, *(span for span in spans if "canalyze " in span)]:
        for arguments in invocations(line):
            parsed(arguments)
    two = (f"{first} {part}" for first, parts in PARTS.items() for part in parts)
    every = {name for command in (*COMMANDS, *two) for name in options(command)}
    for name in re.findall(r"(?<![\w-])--[a-z][a-z-]*", " ".join(spans)):
        assert name in every | OTHERS | {"--help"}, name


def options(command: str) -> set[str]:
    """The options of a command."""
    found = build("en").get_command(click.Context(click.Command("canalyze")), command)
    assert found is not None
    return {name for param in found.params for name in (*param.opts, *param.secondary_opts)}


def parsed(arguments: list[str]) -> None:
    """Parse a command line as the program does, without running it; click's error where it cannot be."""
    group = build("en")
    names = [one for one in arguments if not one.startswith("-")]
    if not names or names[0] in ("COMMAND", "命令"):
        return
    if names[0] not in COMMANDS:
        # A file, or options alone, before a pipe.
        assert "." in names[0] or "/" in names[0] or arguments[0].startswith("-"), f"no command {names[0]}"
        arguments = ["diagnose", *arguments]
    name = names[0] if names[0] in COMMANDS else "diagnose"
    if len(names) > 1 and names[1] in PARTS.get(name, ()):
        name = f"{name} {names[1]}"
    command = group.get_command(click.Context(group), name)
    assert command is not None
    rest = arguments[arguments.index(names[0]) + 1 :] if names[0] in COMMANDS else arguments[1:]
    for option in (one.partition("=")[0] for one in rest if re.match(r"-[-a-zA-Z]", one)):
        known = {name for param in command.params for name in (*param.opts, *param.secondary_opts)} | {"--help"}
        assert option in known, f"{name} has no {option}"


@pytest.mark.parametrize("page", PAGES, ids=shown)
def test_files_in_toml_load(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page_examples.workspace(tmp_path)
    monkeypatch.chdir(tmp_path)
    for block in blocks(text(page)):
        if block.kind == "toml":
            assert block.file, "an example in TOML names its file"
            path = tmp_path / block.file
            path.write_text(block.text, encoding="utf-8")
            if block.file.endswith(expectations.SUFFIX):
                assert expectations.read(path)
            else:
                assert config.read(str(path))


@pytest.mark.parametrize("lang", LANGUAGES)
def test_every_key_of_the_configuration_is_on_its_page(lang: str) -> None:
    (block,) = (one for one in blocks(pages.page("configuration", lang)) if one.kind == "toml")
    given = tomllib.loads(block.text)
    schema = dict(_core.SETTINGS["config"])
    top, override = schema.pop(""), schema.pop("check.override")
    assert {*top, *schema} == set(given)
    assert set(schema.pop("sync")) == set(given["sync"])
    former = {"incidents"}
    assert {*schema.pop("check"), "override"} - former == set(given["check"])
    assert set(override) == set(given["check"]["override"][0])
    for name, keys in schema.items():
        assert set(keys) - {"bus"} <= set(given[name][0])
    assert set(schema) == {"eds", "cob", "sdo"}


@pytest.mark.parametrize("lang", LANGUAGES)
def test_every_key_of_expectations_is_on_their_page(lang: str) -> None:
    (block,) = (one for one in blocks(pages.page("expectations", lang)) if one.kind == "toml")
    schema = _core.SETTINGS["expect"]
    assert set(schema) == set(tomllib.loads(block.text))
    for name, keys in schema.items():
        for key in keys:
            assert re.search(rf"\b{key}\b", block.text), f"{name}.{key}"


def test_every_table_of_columns_is_on_their_page() -> None:
    assert {*(record["table"] for record in generated_pages.tables()), "wide"} == set(_core.TABLES)


def test_every_column_has_a_meaning_in_both_languages() -> None:
    for record in json.loads(_core.schema()):
        for column in record["columns"]:
            assert column["column"] or column["key"] or column["json"] == "object", (record, column)
            assert all(column[lang] for lang in LANGUAGES), (record["kind"] or record["table"], column)


def test_the_readme_is_short_and_begins_with_the_chinese_one() -> None:
    lines = text(README).splitlines()
    assert len(lines) <= 160
    assert LINK.findall(lines[0]) == ["canalyze/pages/zh/README.md"]
    for command in COMMANDS:
        assert any(f"`{command} " in line or f"`[{command}] " in line for line in lines), command


def test_the_readme_shows_both_languages() -> None:
    for page in (README, pages.FOLDER / "zh/README.md"):
        assert text(page).count("canalyze decode --lang zh samples/zephyr-sdo.log") == 1
        assert text(page).count("canalyze decode --lang en samples/zephyr-sdo.log") == 1


@pytest.mark.parametrize("developers", ["canalyze/README.md", "canalyze/core/README.md", "tests/README.md"])
def test_files_that_developers_are_led_to_exist(developers: str) -> None:
    content = (ROOT / developers).read_text(encoding="utf-8")
    named = set(re.findall(r"`(\w+/[\w/.]*)`", content))
    if developers.startswith("tests"):
        named |= set(re.findall(r"`((?:\w+)\.py)`", content))
    places = [ROOT / place for place in ("", "canalyze", "canalyze/core", "canalyze/core/src", "tests")]
    assert not [name for name in named if not any((place / name).exists() for place in places)]
    assert len(named) > 3


@pytest.mark.parametrize("topic", ["sdo", "check", "SDO"])
def test_help_gives_the_page_as_it_is_to_a_pipe(topic: str) -> None:
    found = pages.topic_of(topic)
    assert found is not None
    said = run_canalyze(["help", topic, "--lang", "en"]).decode().splitlines()
    page = pages.page(found, "en").splitlines()
    assert [line for line in said if not line.startswith("```")] == [line for line in page if line[:3] != "```"]
    assert {line for line in said if line.startswith("```")} <= {"```", "```sh", "```python", "```toml", "```yaml"}


@pytest.mark.parametrize("lang", LANGUAGES)
def test_help_gives_the_readme(lang: str) -> None:
    said = run_canalyze(["help", "readme", "--lang", lang]).decode()
    assert "# canalyze\n" in said and "```sh live" not in said


def test_help_lists_every_topic() -> None:
    said = run_canalyze(["help", "--lang", "zh"]).decode()
    for topic in pages.TOPICS:
        assert f"  {topic} " in said
        assert pages.title(topic, "zh") in said
    assert "canalyze examples --pages" in said.splitlines()[-1]


def test_every_command_leads_to_a_page() -> None:
    assert {name for name in COMMANDS if pages.topic_of(name) is None} == {"help"}


def test_an_unknown_topic_is_one_line_with_the_nearest(capfd: pytest.CaptureFixture[str]) -> None:
    from canalyze.cli import main

    assert main(["help", "--lang", "en", "timelin"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert "timeline" in err
    assert main(["help", "--lang", "en", "qqqq"]) == 2
    assert "qqqq" in capfd.readouterr().err


def test_a_terminal_gets_the_page_rendered(monkeypatch: pytest.MonkeyPatch) -> None:
    from canalyze.commands.help import _rendered

    monkeypatch.setenv("COLUMNS", "60")
    monkeypatch.setenv("NO_COLOR", "1")
    said = re.sub(r"\x1b\[[0-9;]*m", "", _rendered(pages.page("sdo", "en")))
    assert "```" not in said
    assert "canalyze help diagnosis" in " ".join(said.split())
    assert "diagnosis.md" not in said
    assert max(map(len, said.splitlines())) <= 60


def test_rich_is_loaded_only_to_render() -> None:
    import subprocess
    import sys

    code = "import sys, canalyze.commands.help, canalyze.cli; print('rich' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
