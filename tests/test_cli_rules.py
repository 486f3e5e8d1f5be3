"""`canalyze explain` and `canalyze rules`."""

import json

import pytest
from conftest import Runner

from canalyze import _core


def test_rules_lists_the_catalogue(canalyze: Runner) -> None:
    done = canalyze("--lang", "en", "rules")
    assert (done.code, done.err) == (0, "")
    heading, *rows = done.lines
    assert heading.split() == ["code", "severity", "name", "message"]
    assert any(row.startswith("SDO001 ") for row in rows)
    objects = [json.loads(line) for line in canalyze("--lang", "en", "rules", "--format", "jsonl").lines]
    assert [row.split()[0] for row in rows] == [rule["code"] for rule in objects]
    assert all(rule["message"] in done.out for rule in objects)
    assert all(rule["severity"] in {"error", "warning", "info"} for rule in objects)


def test_every_rule_is_explained() -> None:
    for rule in _core.rules("en"):
        for name in (rule.code, rule.code.lower()):
            said = _core.explain(name, "en")
            assert said is not None and rule.meaning in said and rule.cause in said


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_rules_are_told_apart_by_their_titles(lang: str) -> None:
    titles = [rule.message for rule in _core.rules(lang)]
    assert len(titles) > 100 and len(set(titles)) == len(titles)
