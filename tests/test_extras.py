"""The extras in pyproject.toml: `all` holds the others, and both READMEs name each."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from page_examples import README, ROOT

from canalyze.pages import FOLDER

EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
CLUSTERS = {"dask", "ray"}
"""These have no wheels for each Python."""


def test_all_holds_every_extra_but_those_of_clusters() -> None:
    (requirement,) = EXTRAS["all"]
    named = re.fullmatch(r"canalyze\[([a-z0-9,]+)\]", requirement)
    assert named and named[1].split(",") == sorted(set(EXTRAS) - CLUSTERS - {"all", "dev"})


@pytest.mark.parametrize("readme", [README, FOLDER / "zh/README.md"], ids=str)
def test_each_extra_is_named(readme: Path) -> None:
    text = readme.read_text(encoding="utf-8")
    assert not [name for name in EXTRAS if name != "dev" and f"`{name}`" not in text]
