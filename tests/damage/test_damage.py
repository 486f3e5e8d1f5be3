"""Damaged captures: nothing is lost, changed or invented in silence, and all commands say alike.

`python tests/damage/test_damage.py 1000 [FORM...]` runs that many cases of each format and counts what is wrong.
"""

from __future__ import annotations

import os
import sys
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1])]

from damage_kinds import damaged
from damage_law import falsehoods
from damage_seeds import FORMS, sound

CASES = 120 if os.environ.get("CANALYZE_TESTS") == "thorough" else 60
STEP = 30


@pytest.mark.parametrize("first", range(0, CASES, STEP))
@pytest.mark.parametrize("form", FORMS)
def test_damage_is_told(form: str, first: int, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp(form)
    wrong = []
    for number in range(first, first + STEP):
        kind, case = damaged(form, sound(form), number)
        wrong += [f"{number} {kind}: {falsehood}" for falsehood in falsehoods(form, kind, case, folder)]
    assert not wrong, "\n".join(wrong)


def main() -> None:
    """Counts what is wrong in as many cases as are asked for."""
    cases, forms = int(sys.argv[1]), sys.argv[2:] or list(FORMS)
    for form in forms:
        kinds: Counter[str] = Counter()
        with TemporaryDirectory() as folder:
            for number in range(cases):
                kind, case = damaged(form, sound(form), number)
                for falsehood in falsehoods(form, kind, case, Path(folder)):
                    kinds[f"{kind}: {falsehood.partition(':')[0]}"] += 1
                    print(f"{form} {number} {kind}: {falsehood}", flush=True)
        print(f"{form}: {cases} cases, {dict(kinds) or 'nothing'}", flush=True)


if __name__ == "__main__":
    main()
