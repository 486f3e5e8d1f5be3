"""Problems on a timeline: their lanes, the log of where they begin and end, the stories beside the summary.

Read back from the file with Rerun's own reader. What it must not do: test what is diagnosed, or how it looks.
"""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("rerun")

from captures import SAMPLES, SHARED
from diagnoses import diagnosed
from test_timeline_captures import Shown

PROBLEMS = SAMPLES / "problems.log"
CAPTURES = [PROBLEMS, *sorted((SHARED / "stories").glob("*.log"))]


@pytest.fixture(params=["zh", "en"])
def lang(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: path.stem)
def test_each_problem_is_a_span_from_its_begin_to_its_end(path: Path, lang: str, tmp_path: Path) -> None:
    shown = Shown(tmp_path, path.read_bytes(), None, lang)
    spans: dict[str, list[int | None]] = {}
    for entity in shown.under("/problems/"):
        before = ""
        rows = shown.recording.rows(entity, "StateChange:state")
        shown.on_time(rows)
        for row in rows:
            (state,) = row["value"]
            if before:
                spans[before][1] = row["frame"]
            if state:
                spans[state] = [row["frame"], None]
            before = state
    wanted = {
        str(one["id"]): [one["begin"]["frame"], one["end"] and one["end"]["frame"]]
        for one in diagnosed(path.read_bytes()).incidents
    }
    # One that is over where it begins has no length.
    assert {key: span for key, span in spans.items() if wanted[key][0] != wanted[key][1]} == {
        key: span for key, span in wanted.items() if span[0] != span[1]
    }


def test_stories_say_what_diagnose_says_with_their_causes(lang: str, tmp_path: Path) -> None:
    shown = Shown(tmp_path, PROBLEMS.read_bytes(), None, lang)
    text = str(shown.recording.static("/diagnosis", "TextDocument:text")[0])
    plain = text.replace("\\", "")
    for one in diagnosed(PROBLEMS.read_bytes(), lang=lang).incidents:
        assert one["message"] in plain
    assert ("caused by #1 +502.0 ms" if lang == "en" else "起因：#1 +502.0 ms") in plain
    heads = [line[3:] for line in plain.splitlines() if line.startswith("## ")]
    assert heads == (["OPEN", "ENDED", "HARMLESS"] if lang == "en" else ["仍存在", "已恢复", "无害"])
    assert shown.contents.diagnosis


def test_the_log_has_where_they_begin_and_end(lang: str, tmp_path: Path) -> None:
    shown = Shown(tmp_path, PROBLEMS.read_bytes(), None, lang)
    rows = shown.recording.rows("/log/problems", "TextLog:level")
    told = [(row["frame"], *row["value"]) for row in rows]
    assert told == [
        (47, "INFO"),
        (53, "INFO"),
        (77, "WARN"),
        (90, "INFO"),
        (126, "ERROR"),
        (134, "ERROR"),
        (138, "WARN"),
    ]


def test_nothing_wrong_leaves_nothing(tmp_path: Path) -> None:
    shown = Shown(tmp_path, (SAMPLES / "string-5-bytes.log").read_bytes(), None, "en")
    assert not shown.under("/problems") and not shown.under("/diagnosis") and not shown.contents.diagnosis
