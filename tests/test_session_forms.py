"""Forms of a session that are made of the same records agree on them, whatever the filter."""

from __future__ import annotations

import json

import pytest
from captures import SAMPLES, Row

from canalyze import _core
from canalyze.running.reading import SessionOptions

CAPTURES = ("network/sync-and-pdos.log", "rules/SDO001.log")
FILTERS = ("", "node=5", "service=sdo", "service=pdo", "frame=1-60", "id=585", "id=605", "t=0..1")


def rows(name: str, form: str, expression: str) -> list[Row]:
    session = _core.Session(SessionOptions(format=form, lang="en", filter=expression))
    session.begin(name, True)
    output = session.feed((SAMPLES / name).read_bytes()) + session.end() + session.finish()
    return [json.loads(line) for line in output.splitlines()]


def of(kind: str, found: list[Row]) -> list[Row]:
    return [row for row in found if row["kind"].startswith(kind)]


@pytest.mark.parametrize("name", CAPTURES)
@pytest.mark.parametrize("expression", FILTERS)
def test_forms_agree(name: str, expression: str) -> None:
    forms = {form: rows(name, form, expression) for form in ("transfers", "summary", "records", "observed", "check")}
    assert of("transfer", forms["transfers"]) == forms["transfers"]
    assert of("transfer", forms["records"]) == of("transfer", forms["observed"]) == forms["transfers"]
    assert of("summary", forms["observed"]) == forms["summary"] == of("summary", forms["summary"])
    assert of("finding", forms["records"]) == forms["check"]
    kinds = {kind.split("_")[0] for kind in (row["kind"] for row in forms["observed"])}
    assert kinds <= {"transfer", "summary", "observed"}


def test_there_is_something_to_agree_on() -> None:
    assert rows(CAPTURES[0], "transfers", "id=605") and rows(CAPTURES[0], "summary", "id=605")
    assert rows(CAPTURES[1], "check", "")
