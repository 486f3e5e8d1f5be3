"""`canalyze.records` against the core: its schema, and for records that this does not have, what a session gives."""

from __future__ import annotations

import json
from typing import Any

import msgspec
import pytest
from captures import SAMPLES
from msgspec import inspect

from canalyze import _core, records
from canalyze.records import findings, frames, info, inventory, problems, summary, transfers
from canalyze.running.options import SessionOptions

KINDS: list[tuple[str, type[msgspec.Struct]]] = [
    (str(kind.__struct_config__.tag), kind)
    for module in (findings, frames, info, inventory, problems, summary, transfers)
    for kind in vars(module).values()
    if isinstance(kind, type)
    and issubclass(kind, msgspec.Struct)
    and kind.__module__ == module.__name__
    and kind.__struct_config__.tag
]
SCHEMA = {record["kind"]: record["columns"] for record in json.loads(_core.schema()) if record["kind"]}
FORMS: dict[str, Any] = {
    "events": {"incidents": True},
    "diagnosis": {},
    "summary": {},
    "info": {},
    "objects": {},
    "objects-text": {},
}
TYPES: list[tuple[type, str]] = [
    (inspect.BoolType, "boolean"),
    (inspect.IntType, "integer"),
    (inspect.FloatType, "number"),
    (inspect.StrType, "string"),
    (inspect.LiteralType, "string"),
    (inspect.CustomType, "string"),
    (inspect.NoneType, "null"),
    (inspect.VarTupleType, "array"),
    (inspect.TupleType, "array"),
    (inspect.DictType, "object"),
    (inspect.StructType, "object"),
]


def taken(kind: inspect.Type) -> set[str]:
    """The types of JSON that a field is decoded from."""
    if isinstance(kind, inspect.UnionType):
        return set.union(*map(taken, kind.types))
    return {next(name for form, name in TYPES if isinstance(kind, form))}


def fields(kind: type[msgspec.Struct]) -> list[inspect.Field]:
    """The fields that come from JSON."""
    described = inspect.type_info(kind)
    assert isinstance(described, inspect.StructType)
    return [one for one in described.fields if not one.encode_name.startswith("_")]


@pytest.mark.parametrize(("name", "kind"), [one for one in KINDS if one[0] in SCHEMA])
def test_a_record_is_as_the_schema_says(name: str, kind: type[msgspec.Struct]) -> None:
    columns = {one["key"]: one for one in SCHEMA[name] if one["key"]}
    for field in fields(kind):
        column = columns[field.encode_name]
        types = taken(field.type)
        assert not (field.required and column["optional"]), field.name
        if column["json"] != "any":
            assert types - {"null"} == {column["json"]}, field.name
            assert ("null" in types) == column["nullable"], field.name


def test_records_of_the_schema_are_known() -> None:
    assert {name for name, _ in KINDS if name in SCHEMA} >= {"frame", "note", "finding", "transfer", "signal"}


@pytest.fixture(scope="module")
def lines() -> list[bytes]:
    """Everything that a session gives of captures that have much."""
    found: list[bytes] = []
    for path in (
        *sorted((SAMPLES / "network").glob("*.log")),
        SAMPLES / "rules/HBT002.log",
        SAMPLES / "roboteq.log",
        SAMPLES / "rules/BUS009-extended.log",
    ):
        for form, more in FORMS.items():
            session = _core.Session(SessionOptions("en", format=form, **more))
            session.begin(path.name, True)
            found += (session.feed(path.read_bytes()) + session.end() + session.finish()).splitlines()
    return found


@pytest.mark.parametrize(("name", "kind"), [one for one in KINDS if one[0] not in SCHEMA])
def test_a_record_is_as_a_session_gives_it(name: str, kind: type[msgspec.Struct], lines: list[bytes]) -> None:
    change = kind is problems.ProblemChange
    mine = [line for line in lines if line.startswith(f'{{"kind":"{name}"'.encode())]
    mine = [line for line in mine if name != "problem" or change == (b'"phase":"final"' not in line)]
    made = list(records.records(b"\n".join(mine), kind))
    assert len(made) == len(mine) > 0
    given = set[str]().union(*map(json.loads, mine))
    assert {field.encode_name for field in fields(kind)} <= given


def test_what_is_no_record_is_refused() -> None:
    with pytest.raises(msgspec.ValidationError):
        list(records.records(b'{"kind":"note","note":1}', frames.Note))
