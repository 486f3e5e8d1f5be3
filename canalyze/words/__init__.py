"""Python's own words: help, errors, headings.

Rows (key, zh, en), complete in both languages, one file a topic; a test keeps it. Words about frames stand in the core
(`text/`), never here, and nothing outside this folder prints a sentence of its own.
"""

from typing import Final

from canalyze.words import (
    check,
    commands,
    convert,
    defects,
    descriptions,
    diagnosis,
    diff,
    errors,
    expect,
    info,
    library,
    live,
    monitor,
    pages,
    reports,
    sniff,
    summary,
    tables,
    timeline,
    topics,
    view,
)

LANGUAGES: Final = ("zh", "en")

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    *pages.ROWS,
    *commands.ROWS,
    *check.ROWS,
    *convert.ROWS,
    *tables.ROWS,
    *summary.ROWS,
    *info.ROWS,
    *library.ROWS,
    *reports.ROWS,
    *diagnosis.ROWS,
    *diff.ROWS,
    *descriptions.ROWS,
    *defects.ROWS,
    *errors.ROWS,
    *expect.ROWS,
    *sniff.ROWS,
    *live.ROWS,
    *monitor.ROWS,
    *timeline.ROWS,
    *topics.ROWS,
    *view.ROWS,
)


class Words:
    """The words of one language: `words(key, **facts)` is the sentence."""

    def __init__(self, lang: str) -> None:
        """Take the column of `lang`, one of LANGUAGES."""
        self.lang = lang
        column = 1 + LANGUAGES.index(lang)
        self._table = {row[0]: row[column] for row in ROWS}

    def __call__(self, key: str, /, **facts: object) -> str:
        """Give the sentence of `key` with its facts filled in."""
        sentence = self._table[key]
        return sentence.format_map(facts) if facts else sentence

    def of(self, table: str, value: str) -> str:
        """Give the word for a value of the core, such as `block` of `mode`; the value itself if there is none."""
        return self._table.get(f"{table}.{value}", value)
