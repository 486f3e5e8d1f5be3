"""The reports of `check` by their names: the forms of --format, and documents in files."""

from collections.abc import Sequence
from typing import Final

from canalyze.check.verdict import Verdict
from canalyze.output import Output
from canalyze.words import Words

DOCUMENTS: Final = ("junit", "sarif", "code_quality", "markdown")
FORMS: Final = ("text", "jsonl", "github", "markdown")


def document(name: str, verdicts: Sequence[Verdict], words: Words) -> bytes:
    """Returns one of DOCUMENTS."""
    if name == "junit":
        from canalyze.reports import junit

        return junit.document(verdicts, words)
    if name == "sarif":
        from canalyze._core import rules
        from canalyze.reports import sarif

        return sarif.document(verdicts, rules(words.lang), words)
    if name == "code_quality":
        from canalyze.reports import code_quality

        return code_quality.document(verdicts, words)
    from canalyze.reports import markdown

    return b"".join(map(_encoded, markdown.lines(verdicts, words)))


def write(form: str, verdicts: Sequence[Verdict], out: Output, words: Words) -> None:
    """Writes one of FORMS."""
    if form == "text":
        from canalyze.reports import check_text

        check_text.show(verdicts, out, words)
        return
    if form == "jsonl":
        from canalyze.reports import check_jsonl

        lines = check_jsonl.lines(verdicts)
    elif form == "markdown":
        from canalyze.reports import markdown

        lines = markdown.lines(verdicts, words)
    else:
        from canalyze.reports import github

        lines = github.lines(verdicts, words)
    for line in lines:
        out.write(_encoded(line))


def _encoded(line: str) -> bytes:
    return f"{line}\n".encode("utf-8", "backslashreplace")
