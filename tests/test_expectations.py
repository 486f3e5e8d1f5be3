"""Files of expectations: every key comes through, every mistake is named with its line and with what is allowed."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from captures import DATA, TESTS

from canalyze import _core
from canalyze.errors import ConfigError
from canalyze.expectations import beside, read
from canalyze.sinks import suffixes
from canalyze.words import LANGUAGES, Words

SCHEMA = _core.SETTINGS["expect"]
"""Of every table each key: the sentence about it, and what it allows."""


def normal(tmp_path: Path, content: str) -> dict[str, Any]:
    path = tmp_path / "boot.expect.toml"
    path.write_text(content, encoding="utf-8")
    found = json.loads(read(path).normal)
    assert isinstance(found, dict)
    return found


def only(tmp_path: Path, table: str, content: str) -> dict[str, Any]:
    """The one entry of this table."""
    (entry,) = normal(tmp_path, f"[[{table}]]\n{content}\n")[table]
    assert entry.pop("line") == 1
    assert isinstance(entry, dict)
    return entry


CASES = tomllib.loads((DATA / "expectations.toml").read_text("utf-8"))
MEANT: list[tuple[str, str, dict[str, Any]]] = []
"""Tables and what is written in them, with what the core gets of it."""
for case in CASES["meant"]:
    first = next((wanted for table, _, wanted in MEANT if table == case["table"]), {})
    MEANT.append((case["table"], case["content"], first | json.loads(case["wanted"])))


@pytest.mark.parametrize(("table", "content", "wanted"), MEANT, ids=[f"{row[0]}-{row[1]}" for row in MEANT])
def test_what_is_written_is_what_the_core_gets(
    tmp_path: Path, table: str, content: str, wanted: dict[str, Any]
) -> None:
    given = only(tmp_path, table, content)
    assert given == wanted
    assert [type(value) for value in given.values()] == [type(wanted[key]) for key in given]


def test_every_key_is_tried() -> None:
    tried = {(table, line.split(" = ")[0]) for table, content, _ in MEANT for line in content.splitlines()}
    allowed = {(name, key) for name, keys in SCHEMA.items() for key in keys if key != "bus"}
    untried = {("sync", "period_ms"), ("sync", "tolerance_ms"), ("sync", "tolerance_percent")}
    untried |= {("heartbeat", key) for key in ("period_us", "tolerance_us", "tolerance_percent")}
    untried |= {("signal", key) for key in ("tolerance_ms", "tolerance_us")}
    assert allowed - tried == untried, "the same readers, tried in other tables"


def test_every_state_has_its_name(tmp_path: Path) -> None:
    for key, count in (("state", 4), ("drive", 8)):
        states = re.findall('"(.*?)"', SCHEMA["state"][key][1])
        assert len(states) == count
        for state in states:
            assert only(tmp_path, "state", f'node = 5\n{key} = "{state}"')[key] == state


def test_entries_know_their_lines(tmp_path: Path) -> None:
    content = (
        '# of a drive\n\n[[load]]\nmax_percent = 50\n[[emcy]]  # none\noccurs = "never"\n[[load]]\nmax_percent = 1\n'
    )
    found = normal(tmp_path, content)
    assert [entry["line"] for entry in found["load"]] == [3, 7]
    assert [entry["line"] for entry in found["emcy"]] == [5]
    assert found["file"] == str(tmp_path / "boot.expect.toml")
    assert set(found) == {"file", *SCHEMA}


MISTAKES = [(case["content"], case["said"]) for case in CASES["mistake"]]


@pytest.mark.parametrize(("content", "said"), MISTAKES, ids=[row[0] for row in MISTAKES])
def test_a_mistake_is_named_with_its_line(tmp_path: Path, content: str, said: str) -> None:
    path = tmp_path / "boot.expect.toml"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        read(path)
    assert str(caught.value) == f"{path}{said}"
    for lang in LANGUAGES:
        sentence = caught.value.in_words(Words(lang))
        assert "\n" not in sentence and "{" not in sentence


def test_every_kind_of_mistake_is_tried(tmp_path: Path) -> None:
    said = set()
    for content, *_ in MISTAKES:
        (tmp_path / "boot.expect.toml").write_text(content, encoding="utf-8")
        with pytest.raises(ConfigError) as caught:
            read(tmp_path / "boot.expect.toml")
        said.add(caught.value.key)
    assert said >= {f"config.{sentence}" for keys in SCHEMA.values() for sentence, _ in keys.values()}
    assert said >= {
        f"expect.{name}"
        for name in ("exclusive", "lacks_one", "goes_with", "only_true", "below_min", "no_problem", "no_problem_near")
    }


def test_a_file_that_cannot_be_read_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot read the expectations: no such file"):
        read(tmp_path / "none.expect.toml")
    (tmp_path / "latin.expect.toml").write_bytes(b"# ok\n# \xe9\n")
    with pytest.raises(ConfigError, match=r"latin.expect.toml:2: not UTF-8 text"):
        read(tmp_path / "latin.expect.toml")


@pytest.mark.parametrize(
    ("capture", "found"),
    [
        ("boot.log", True),
        ("boot.log.gz", True),
        ("boot.LOG.ZST", True),
        ("boot.asc", True),
        ("boot.mcap", True),
        ("boot", True),
        ("boot.v2.log", False),
        ("boot.v2", False),
        ("other.log", False),
        (".log", False),
        ("-", False),
    ],
)
def test_the_file_beside_a_capture(tmp_path: Path, capture: str, found: bool) -> None:
    (tmp_path / "boot.expect.toml").write_text("")
    name = capture if capture == "-" else str(tmp_path / capture)
    assert beside(name) == (tmp_path / "boot.expect.toml" if found else None)


def test_every_format_has_its_file_beside(tmp_path: Path) -> None:
    (tmp_path / "boot.expect.toml").write_text("")
    for suffix in suffixes():
        assert beside(str(tmp_path / f"boot{suffix}"))


def test_the_name_of_a_capture_may_have_dots(tmp_path: Path) -> None:
    (tmp_path / "boot.v2.expect.toml").write_text("")
    assert beside(str(tmp_path / "boot.v2.log.xz")) == tmp_path / "boot.v2.expect.toml"
    assert beside(str(tmp_path / "boot.v2")) == tmp_path / "boot.v2.expect.toml"


def written_examples() -> list[Any]:
    """The files of expectations that help and README show."""
    shown = [pytest.param(Words(lang)("expect.examples").partition("\n\n")[2], id=f"help-{lang}") for lang in LANGUAGES]
    readme = (TESTS.parent / "README.md").read_text(encoding="utf-8")
    fenced = re.findall(r"^```toml\n(.*?)^```$", readme, flags=re.DOTALL | re.MULTILINE)
    return shown + [pytest.param(part, id=f"readme-{place}") for place, part in enumerate(fenced) if "[[emcy]]" in part]


@pytest.mark.parametrize("content", written_examples())
def test_what_is_shown_is_valid(tmp_path: Path, content: str) -> None:
    assert all(normal(tmp_path, content)[table] for table in ("sdo", "state", "emcy"))


@pytest.mark.parametrize("lang", LANGUAGES)
def test_help_shows_every_key(lang: str) -> None:
    shown = Words(lang)("expect.examples")
    assert not {key for keys in SCHEMA.values() for key in keys if not re.search(rf"\b{key}\b", shown)}
