"""All manifests as the reports of `canalyze/reports/`: beside the results, and on the terminal.

Must not: read a capture, or judge.
"""

from collections.abc import Iterable, Sequence

from canalyze.fleet.manifest import Manifest
from canalyze.fleet.stores import Place
from canalyze.fleet.task import Action, problems_of, records_of, verdict_of
from canalyze.output import Output
from canalyze.output import jsonl as json_lines
from canalyze.records import of_rows
from canalyze.records.problems import KEYS
from canalyze.records.summary import KINDS
from canalyze.reports import check_jsonl, check_text, diagnosis_text, fleet_text, junit
from canalyze.words import Words


class _Kept(Output):
    """An output that keeps its data in memory."""

    def __init__(self) -> None:
        self.is_terminal = False
        self.is_quiet = True
        self.data = bytearray()

    def write(self, data: bytes) -> None:
        self.data += data


def show(action: Action, done: Sequence[Manifest], out: Output, words: Words, *, whole: bool) -> None:
    """Writes the text report. whole: for check with the findings of each capture, not only the totals."""
    if action == "check":
        check_text.show([verdict_of(action, one) for one in done], out, words, totals=not whole)
    elif action == "diagnose":
        rows = [row for one in done if (row := problems_of(one))]
        fleet_text.show_problems(rows, out, words)
        if whole:
            out.text("\n")
        diagnosis_text.show_each(
            rows, out, words, diagnosis_text.Chosen(None, None, None), unread=len(done) - len(rows), totals=not whole
        )
    elif action == "export":
        fleet_text.show_tables([(one.result or {}).get("rows", {}) for one in done], out, words)
    else:
        fleet_text.show([(one.capture, one.error, of_rows(records_of(one), *KINDS)) for one in done], out, words)
    fleet_text.show_failed([(one.capture, one.error or "", one.attempts) for one in done if one.failed], out, words)


def write(action: Action, done: Sequence[Manifest], place: Place, name: str, words: Words, *, html: bool) -> list[str]:
    """Writes all reports under a name; returns their names."""
    verdicts = [verdict_of(action, one) for one in done]
    text = _Kept()
    show(action, done, text, words, whole=True)
    lines = check_jsonl.lines(verdicts) if action == "check" else _records(action, done)
    reports = {
        "txt": bytes(text.data),
        "jsonl": "".join(f"{line}\n" for line in lines).encode("utf-8", "backslashreplace"),
        "xml": junit.document(verdicts, words),
    }
    if html:
        from canalyze.reports import fleet_html

        reports["html"] = fleet_html.page([(verdict_of(action, one), one.findings) for one in done], words)
    for form, data in reports.items():
        place.put(f"{name}.{form}", data)
    return [f"{name}.{form}" for form in reports]


def _records(action: Action, done: Iterable[Manifest]) -> Iterable[str]:
    """Yields the records of summaries, problems and exports, each with its capture, and the reasons of failures."""
    for one in done:
        if action == "export" and one.result:
            yield json_lines.text({"capture": one.capture, "kind": "export", **one.result}, compact=True)
        for problem in (one.result or {}).get("problems", ()) if action == "diagnose" else ():
            yield json_lines.text({"capture": one.capture, **{key: problem[key] for key in KEYS}}, compact=True)
        for record in records_of(one) if action == "summary" else ():
            yield json_lines.text({"capture": one.capture, **record}, compact=True)
        if one.failed:
            row = {"capture": one.capture, "kind": "failed", "reason": one.failed, "error": one.error}
            yield json_lines.text(row, compact=True)
