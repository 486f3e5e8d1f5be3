"""Python's words are complete in both languages."""

import re
import string

import pytest

from canalyze.words import LANGUAGES, ROWS, Words

CHINESE = re.compile("[\u4e00-\u9fff]")


def test_keys_are_unique() -> None:
    keys = [key for key, _, _ in ROWS]
    assert sorted(keys) == sorted(set(keys))


@pytest.mark.parametrize(("key", "zh", "en"), ROWS, ids=[row[0] for row in ROWS])
def test_row_is_complete(key: str, zh: str, en: str) -> None:
    assert zh.strip() and en.strip()
    facts = [{name for _, name, _, _ in string.Formatter().parse(text) if name} for text in (zh, en)]
    assert facts[0] == facts[1]
    assert not CHINESE.search(en), "the English column holds Chinese"


@pytest.mark.parametrize("lang", LANGUAGES)
def test_unknown_value_of_the_core_is_shown_as_it_is(lang: str) -> None:
    assert Words(lang).of("mode", "something-new") == "something-new"
