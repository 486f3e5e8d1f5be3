"""The third-party transcripts, where they lie beside the checkout."""

from __future__ import annotations

import pytest
from compare_transcripts import DEFAULT_DIRECTORY, compare


@pytest.mark.skipif(not DEFAULT_DIRECTORY.is_dir(), reason="the third-party transcripts are not beside this checkout")
def test_the_transcripts_say_what_their_authors_say() -> None:
    result = compare(DEFAULT_DIRECTORY)
    print(result.summary)
    assert result.answers > 0
    assert not result.wrong, result.summary
