"""Rows of the core for tests that say only a part of one: the rest is as little as the record allows.

Must not: know what a row means.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from msgspec import Struct, inspect


def filled(kind: type[Struct], given: Mapping[str, Any]) -> dict[str, Any]:
    """A row as JSON has it, `given`, and whatever else the record needs."""
    described = inspect.type_info(kind)
    assert isinstance(described, inspect.StructType)
    return _row(described, given)


def _row(described: inspect.StructType, given: Mapping[str, Any]) -> dict[str, Any]:
    tag = {described.tag_field: described.tag} if described.tag_field else {}
    fields = {field.encode_name: field for field in described.fields}
    needed = {name: _least(field.type) for name, field in fields.items() if field.required}
    said = {name: _whole(fields[name].type, value) for name, value in given.items() if name in fields}
    return {**tag, **needed, **said}


def _whole(kind: inspect.Type, value: Any) -> Any:
    """The value, with rows in it filled."""
    kinds = kind.types if isinstance(kind, inspect.UnionType) else (kind,)
    if isinstance(value, Mapping):
        row = next((one for one in kinds if isinstance(one, inspect.StructType)), None)
        return value if row is None else _row(row, value)
    if isinstance(value, list | tuple):
        return [_whole(one.item_type, item) for one in kinds if isinstance(one, inspect.VarTupleType) for item in value]
    return value


def _least(kind: inspect.Type) -> Any:
    if isinstance(kind, inspect.UnionType):
        return None if any(isinstance(one, inspect.NoneType) for one in kind.types) else _least(kind.types[0])
    if isinstance(kind, inspect.StructType):
        return _row(kind, {})
    if isinstance(kind, inspect.LiteralType):
        return kind.values[0]
    empty: dict[type[inspect.Type], Any] = {
        inspect.BoolType: False,
        inspect.IntType: 0,
        inspect.FloatType: 0.0,
        inspect.VarTupleType: [],
        inspect.DictType: {},
    }
    return empty.get(type(kind), "")
