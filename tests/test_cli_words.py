"""Python's words are complete in both languages, and written as `canalyze/words` says."""

import re
import string
from collections.abc import Iterator
from pathlib import Path

import pytest
from captures import TESTS

from canalyze.words import FOLDER, LANGUAGES, Words, sentences

PACKAGE = TESTS.parent / "canalyze"
CHINESE = re.compile("[\u4e00-\u9fff]")
TOPICS = sorted(path.stem for path in Path(FOLDER).glob("*.txt"))


def rows() -> Iterator[tuple[str, str, str]]:
    """Every key with its Chinese and its English; nothing where a language has none."""
    for topic in TOPICS:
        zh, en = (sentences(topic, lang) for lang in LANGUAGES)
        for key in zh | en:
            yield key, zh.get(key, ""), en.get(key, "")


ROWS = list(rows())


@pytest.mark.parametrize("topic", TOPICS)
def test_topic_is_well_formed(topic: str) -> None:
    """A line that means nothing, or a key a second time or in another topic's file, would be lost without a word."""
    text = (Path(FOLDER) / f"{topic}.txt").read_text(encoding="utf-8")
    assert not [line for line in text.splitlines() if not re.fullmatch(r"|# .+|\[.+\]|(zh|en|both):( .*\S)?", line)]
    keys = re.findall(r"^\[(.+)\]$", text, re.MULTILINE)
    assert len(set(keys)) == len(keys) and set(keys) == {key for key, _, _ in ROWS if key in keys}
    assert all(re.fullmatch(rf"{topic}(_\w+)?\..+", key) for key in keys)


def test_every_row_is_complete() -> None:
    """Both columns say something, with the same facts, and the English one holds no Chinese."""
    wrong = [key for key, zh, en in ROWS if not (zh.strip() and en.strip() and names(zh) == names(en))]
    assert not wrong
    assert not [key for key, _, en in ROWS if CHINESE.search(en)]


def names(sentence: str) -> set[str]:
    """The facts that it has."""
    return {name for _, name, _, _ in string.Formatter().parse(sentence) if name}


def test_only_the_topic_asked_for_is_read() -> None:
    sentences.cache_clear()
    assert Words("en")("usage.or") == " or "
    assert sentences.cache_info().currsize == 1


PAGES = {"short", "usage", "help", "format", "examples", "completion"}
"""What every command has; the keys are made of its name."""
SAID_BY_THE_CORE = {"bus_state", "check_nature", "damage", "example", "info", "merge", "mode", "severity", "status"}
"""Tables whose keys are made of what the core says."""
FILES = [*(PACKAGE / "core/src/settings").glob("*.rs"), PACKAGE / "core/src/python/description.rs"]
PROGRAM = "".join(
    path.read_text()
    for end in ("py", "html", "js")
    for path in PACKAGE.rglob(f"*.{end}")
    if path.parent != PACKAGE / "words"
) + "".join(path.read_text() for path in FILES if path.stem != "tests")
"""What names the sentences; of the core, what says what is wrong with files."""


def test_every_row_is_used() -> None:
    assert not [key for key, _, _ in ROWS if not is_used(key)]


def test_a_row_that_nothing_names_is_seen() -> None:
    assert is_used("check.clean") and not is_used("check.cleaner")


def is_used(key: str) -> bool:
    """Whether the program names the sentence, or makes its key of what the core says."""
    table, _, name = key.partition(".")
    if table in SAID_BY_THE_CORE or name in PAGES:
        return True
    spelled = re.escape(name).replace("_", "[-_]")
    return re.search(rf"""["'](?:{re.escape(table)}\.|--)?{spelled}["' ]""", PROGRAM) is not None


@pytest.mark.parametrize("lang", LANGUAGES)
def test_unknown_value_of_the_core_is_shown_as_it_is(lang: str) -> None:
    assert Words(lang).of("mode", "something-new") == "something-new"


def test_every_rule_of_cause_says_why() -> None:
    source = (PACKAGE / "core/src/problems/causes.rs").read_text(encoding="utf-8")
    numbers = {int(number) for number in re.findall(r"^    \((\d+), \w+\),$", source, re.MULTILINE)}
    assert len(numbers) > 30
    words = (PACKAGE / "core/words/causes.tsv").read_text(encoding="utf-8")
    assert numbers <= {int(number) for number in re.findall(r"^(\d+)\t", words, re.MULTILINE)}
