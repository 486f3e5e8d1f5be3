"""Docstrings of the package are in the third person or name a thing, as in the standard library.

Must not: judge a sentence beyond its first word.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from captures import TESTS

PACKAGE = TESTS.parent / "canalyze"
OPENERS = {"Give", "Take", "Tell", "Say", "Put", "Let", "What", "Whether", "Return", "How"}
"""First words that no docstring has."""
LATER: set[str] = set()
"""Rooms whose docstrings are not rewritten yet."""
FILES = [
    path
    for path in sorted([*PACKAGE.rglob("*.py"), *PACKAGE.glob("*.pyi")])
    if not {"core", *LATER} & set(path.relative_to(PACKAGE).parts)
]


def openers(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yields line and first word of every docstring, also of attributes."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            yield node.lineno, (node.value.value.split() or [""])[0].strip('.,:;"')


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_docstrings_are_in_the_third_person(path: Path) -> None:
    wrong = [line for line, word in openers(ast.parse(path.read_text(encoding="utf-8"))) if word in OPENERS]
    assert wrong == []


def test_openers_are_found() -> None:
    source = 'def a():\n    """Give it."""\n\nb = 1\n"""What it is."""\n\nclass C:\n    """Gives it."""\n'
    assert sorted(openers(ast.parse(source))) == [(2, "Give"), (5, "What"), (8, "Gives")]
