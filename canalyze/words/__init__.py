"""Python's own words: help, errors, headings; data in the text files beside this one, read a topic at a time.

A row is a key and its text in both languages, in the file named as the key's first word: `usage.node` in `usage.txt`,
`opt_help.lang` in `opt.txt`.

    # A comment.

    [usage.node]
    zh: 选项 {option} 不能是 {value}
    en: option {option}: {value} is not a node-ID

`both:` is the same text in both. Several lines of a language are several lines of the text. A text that begins or
ends with a blank is put in quotes. `{fact}` is filled in, and is the same in both languages; `{{` is a brace;
`{count:frame|frames}` is "1 frame", "2 frames".

Words about frames are in the core (`words/`), never here, and nothing outside this folder prints a sentence.
"""

from functools import cache
from typing import Final

LANGUAGES: Final = ("zh", "en")
FOLDER: Final = __file__.rpartition("__init__")[0]


class Words:
    """The words of one language: `words(key, **facts)` is the sentence."""

    def __init__(self, lang: str) -> None:
        """Creates the words of a language, one of LANGUAGES."""
        assert lang in LANGUAGES
        self.lang = lang

    def __call__(self, key: str, /, **facts: object) -> str:
        """Returns the sentence of `key` with its facts filled in."""
        sentence = sentences(_topic(key), self.lang)[key]
        if "|" in sentence:
            facts = {name: _Counted(fact) for name, fact in facts.items()}
        return sentence.format_map(facts) if facts else sentence

    def of(self, table: str, value: str) -> str:
        """Returns the word for a value of the core, such as `block` of `mode`, or the value itself if there is none."""
        return sentences(_topic(table), self.lang).get(f"{table}.{value}", value)


class _Counted(str):
    """A fact that may be a count, and appends the noun: `{count:frame|frames}`."""

    def __format__(self, spec: str) -> str:
        one, bar, many = spec.partition("|")
        return f"{self} {one if self == '1' else many}" if bar else format(str(self), spec)


def _topic(key: str) -> str:
    return key.partition(".")[0].partition("_")[0]


@cache
def sentences(topic: str, lang: str) -> dict[str, str]:
    """Reads the file of a topic; returns its sentences in one language, by their keys."""
    if topic == "problem":
        return _of_the_core(lang)
    found: dict[str, str] = {}
    key = ""
    with open(f"{FOLDER}{topic}.txt", encoding="utf-8") as file:
        lines = file.read().split("\n")
    for line in lines:
        tag, _, text = line.partition(":")
        if line.startswith("["):
            key = line[1:-1]
        elif tag in (lang, "both"):
            text = text[1:]
            text = text[1:-1] if text[:1] == text[-1:] == '"' else text
            found[key] = f"{found[key]}\n{text}" if key in found else text
    return found


def _of_the_core(lang: str) -> dict[str, str]:
    """Returns the words of a diagnosis, which the core has."""
    from canalyze._core import diagnosis_words

    return {f"problem_{key}": text for key, text in diagnosis_words(lang)}
