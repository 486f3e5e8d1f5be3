"""`canalyze.records` against the core: its schema, and for records that this does not have, what a session gives."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import msgspec
import pytest
from captures import SAMPLES
from msgspec import inspect

from canalyze import _core, records
from canalyze.expectations import draft
from canalyze.records import frames, live, objects, problems, summary
from canalyze.running.reading import SessionOptions

KINDS: list[tuple[str, type[msgspec.Struct]]] = [
    (str(kind.__struct_config__.tag), kind)
    for module in (draft, frames, objects, problems, summary)
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
    "observed": {},
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


def test_a_row_of_a_table_is_as_the_schema_says() -> None:
    (table,) = (record["columns"] for record in json.loads(_core.schema()) if record["table"] == "problems")
    columns = {one["column"]: one for one in table if one["arrow"]}
    for field in fields(problems.ProblemRow):
        types, column = taken(field.type), columns[field.encode_name]
        assert ("null" in types) == column["nullable"], field.name
        assert types - {"null"} == {"integer" if "int" in column["arrow"] else "string"}, field.name


def test_records_of_the_schema_are_known() -> None:
    assert {name for name, _ in KINDS if name in SCHEMA} >= {"frame", "note", "finding", "transfer", "signal"}


CAPTURES = (
    *sorted((SAMPLES / "network").glob("*.log")),
    SAMPLES / "rules/HBT002.log",
    SAMPLES / "roboteq.log",
    SAMPLES / "rules/BUS009-extended.log",
    SAMPLES / "services.log",
)


@pytest.fixture(scope="module")
def lines() -> list[bytes]:
    """Everything that a session gives of captures that have much."""
    found: list[bytes] = []
    for path in CAPTURES:
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


def test_the_state_of_a_session_is_as_it_gives_it() -> None:
    seen: set[str] = set()
    for path in CAPTURES:
        session = _core.Session(SessionOptions("en", format="monitor"))
        session.begin(path.name, False, "candump")
        data = path.read_bytes()
        session.feed(data[: len(data) * 9 // 10])
        session.rest()
        now: live.Snapshot = records.decoder(live.Snapshot)(session.snapshot())
        parts: list[tuple[str, Sequence[Any]]] = [(name, getattr(now, name)) for name in ("buses", "nodes", "objects")]
        parts += [(name, getattr(now, name)) for name in ("findings", "problems")]
        parts += [("running", now.transfers.running), ("done", now.transfers.done)]
        parts += [("emcy", [one.emcy for one in now.nodes if one.emcy])]
        parts += [("problem", [one.problem for one in now.nodes if one.problem])]
        parts += [("counted", msgspec.json.decode(session.nodes(), type=list[live.CountedNode]))]
        for node in now.nodes:
            page: live.NodeDetails = records.decoder(live.NodeDetails)(session.page(node.bus, node.node))
            parts += [("identity", page.identity), ("pdos", page.pdos)]
            parts += [("mapped", pdo.objects) for pdo in page.pdos]
        seen |= {name for name, rows in parts if rows}
        counted: live.Tally = records.decoder(live.Tally)(session.tally())
        assert counted == now.tally and counted.frames == session.frames > 0
    assert seen == {name for name, _ in parts}


def test_what_is_no_record_is_refused() -> None:
    with pytest.raises(msgspec.ValidationError):
        list(records.records(b'{"kind":"note","note":1}', frames.Note))
