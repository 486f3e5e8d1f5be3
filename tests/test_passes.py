"""Commands ask a `Pass` for nothing that it does not have: its parameters are looked up by name."""

import ast
from pathlib import Path

import click
import pytest
from captures import TESTS

from canalyze.cli import COMMANDS, PARTS, build
from canalyze.running.passes import Pass

PACKAGE = TESTS.parent / "canalyze"
NAMES = (*COMMANDS, *(f"{first} {part}" for first, parts in PARTS.items() for part in parts))
OWN = {*dir(Pass), *Pass.__annotations__, "words", "given"}


def parameters(name: str) -> set[str]:
    command = build("en").get_command(click.Context(click.Command("canalyze")), name)
    assert command is not None
    return {param.name or "" for param in command.params}


def asked(path: Path) -> set[str]:
    """The attributes of a `Pass` that the functions of a file use."""
    found = set()
    for function in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(function, ast.FunctionDef):
            continue
        kinds = {arg.arg: ast.unparse(arg.annotation).strip("'") for arg in function.args.args if arg.annotation}
        passes = {name for name, kind in kinds.items() if kind == "Pass"}
        for node in ast.walk(function):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in passes:
                found.add(node.attr)
    return found


@pytest.mark.parametrize("name", NAMES)
def test_a_command_has_the_parameters_that_it_uses(name: str) -> None:
    path = PACKAGE / "commands" / f"{name.replace(' ', '_')}.py"
    assert not asked(path) - OWN - parameters(name)


def test_what_a_pass_is_handed_to_uses_parameters_that_there_are() -> None:
    every = set().union(*map(parameters, NAMES))
    paths = [path for path in PACKAGE.rglob("*.py") if "commands" not in path.parts and "core" not in path.parts]
    used = {path.stem: asked(path) for path in paths}
    assert used["diagnosing"] and not {name: rest for name, names in used.items() if (rest := names - OWN - every)}


def test_a_parameter_that_is_not_there_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="other"):
        _ = Pass(None, {"form": "text"}).other  # type: ignore[arg-type]
    assert Pass(None, {"form": "text"}).form == "text"  # type: ignore[arg-type]
