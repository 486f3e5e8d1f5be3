"""That the tests are as fast as they can be: what they run by the thousand is forked, not started."""

from __future__ import annotations

import os

import forked
import pytest
from conftest import environment


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks here")
def test_the_usual_command_lines_are_forked() -> None:
    assert forked.forks(os.environ)
    assert forked.forks(environment())
    assert forked.forks(environment(CANALYZE_LANG="en", NO_COLOR="1"))


@pytest.mark.parametrize("name", ["PYTHONUTF8", "PYTHONIOENCODING", "LC_ALL", "LD_PRELOAD"])
def test_what_has_a_say_in_the_start_is_started(name: str) -> None:
    assert not forked.forks(environment(**{name: "another"}))
