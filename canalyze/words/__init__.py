"""Python's own words: help, errors, headings.

Rows (key, zh, en), complete in both languages, one file a topic; a test keeps it. Words about frames stand in the core
(`text/`), never here, and nothing outside this folder prints a sentence of its own.
"""

from importlib import import_module
from typing import Final

LANGUAGES: Final = ("zh", "en")

_TOPICS: Final = (
    "pages",
    "commands",
    "check",
    "errors",
    "diagnosis",
    "tables",
    "summary",
    "convert",
    "info",
    "library",
    "reports",
    "diff",
    "descriptions",
    "defects",
    "expect",
    "sniff",
    "live",
    "monitor",
    "timeline",
    "topics",
    "view",
)
"""The files of this folder: each is read when a key is in none of those before it."""


def _rows(topic: str) -> tuple[tuple[str, str, str], ...]:
    found: tuple[tuple[str, str, str], ...] = import_module(f"canalyze.words.{topic}").ROWS
    return found


def rows() -> list[tuple[str, str, str]]:
    """Give all rows."""
    return [row for topic in _TOPICS for row in _rows(topic)]


class Words:
    """The words of one language: `words(key, **facts)` is the sentence."""

    def __init__(self, lang: str) -> None:
        """Take the column of `lang`, one of LANGUAGES."""
        self.lang = lang
        self._column = 1 + LANGUAGES.index(lang)
        self._table: dict[str, str] = {}
        self._unread = iter(_TOPICS)

    def __call__(self, key: str, /, **facts: object) -> str:
        """Give the sentence of `key` with its facts filled in."""
        sentence = self._found(key)
        if sentence is None:
            raise KeyError(key)
        return sentence.format_map(facts) if facts else sentence

    def of(self, table: str, value: str) -> str:
        """Give the word for a value of the core, such as `block` of `mode`; the value itself if there is none."""
        return self._found(f"{table}.{value}") or value

    def _found(self, key: str) -> str | None:
        """Find a sentence, reading topics until one has it."""
        while key not in self._table:
            topic = next(self._unread, None)
            if topic is None:
                return None
            self._table |= {row[0]: row[self._column] for row in _rows(topic)}
        return self._table[key]
