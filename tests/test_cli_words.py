"""Python's words are complete in both languages."""

import re
import string

import pytest
from captures import TESTS

from canalyze.words import LANGUAGES, ROWS, Words

PACKAGE = TESTS.parent / "canalyze"
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


PAGES = {"short", "usage", "help", "format", "examples", "completion"}
"""What every command has; the keys are made of its name."""
SAID_BY_THE_CORE = {
    *("bus_state", "damage", "info", "merge", "mode", "severity", "status"),
    *(
        "example",
        "incident_many",
        "incident_one",
        "incident_grade",
        "incident_heading",
        "incident_impact",
        "incident_link",
        "incident_role",
        "incident_status",
    ),
}
"""Tables whose keys are made of what the core says."""
PROGRAM = "".join(
    path.read_text() for end in ("py", "html") for path in PACKAGE.rglob(f"*.{end}") if path.parent != PACKAGE / "words"
)


@pytest.mark.parametrize("key", [row[0] for row in ROWS])
def test_row_is_used(key: str) -> None:
    table, _, name = key.partition(".")
    if table in SAID_BY_THE_CORE or name in PAGES:
        return
    spelled = re.escape(name).replace("_", "[-_]")
    assert re.search(rf"""["'](?:{re.escape(table)}\.|--)?{spelled}["']""", PROGRAM)


@pytest.mark.parametrize("lang", LANGUAGES)
def test_unknown_value_of_the_core_is_shown_as_it_is(lang: str) -> None:
    assert Words(lang).of("mode", "something-new") == "something-new"
