"""`canalyze rules`: the catalogue of rules, or one of them at length. The rules and their words are the core's."""

from typing import TYPE_CHECKING, Final

import click

from canalyze.configuration.options import argument, form
from canalyze.output import Output, complain, fields, json_line
from canalyze.output.help import simple_command
from canalyze.output.layout import definitions, wrap
from canalyze.words import Words

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

    from canalyze._core import Rule

_FIELDS: Final = "code name severity clause message meaning cause"
_NEAR: Final = 0.6
"""Likeness from which on a code may be the one that was meant; 1 is the same."""


def run(words: Words, *, codes: tuple[str, ...], form: str) -> int:
    """Shows the rules that are asked for."""
    from canalyze._core import rules

    catalogue = {rule.code: rule for rule in rules(words.lang)}
    chosen: list[Rule] = []
    code = 0
    listed = not codes
    for wanted in codes:
        if rule := catalogue.get(wanted.upper()):
            chosen.append(rule)
        elif family := [rule for rule in catalogue.values() if wanted and rule.code.startswith(wanted.upper())]:
            chosen += family
            listed = True
        else:
            complain(f"canalyze: {_unknown(wanted, list(catalogue), words)}")
            code = 2
    if not codes:
        chosen = list(catalogue.values())
    out = Output()
    if form == "jsonl":
        for rule in chosen:
            out.write(json_line({"kind": "rule", **fields(rule, _FIELDS)}))
    elif listed:
        _list(chosen, out, words)
    else:
        out.text("\n".join(_page(rule, words) for rule in chosen))
    return code


def _completed(_: click.Context, __: click.Parameter, begun: str) -> "list[CompletionItem]":
    """Returns the codes that begin so, for a shell."""
    from click.shell_completion import CompletionItem

    from canalyze._core import rules

    return [CompletionItem(rule.code, help=rule.name) for rule in rules() if rule.code.startswith(begun.upper())]


def _unknown(wanted: str, codes: list[str], words: Words) -> str:
    from difflib import SequenceMatcher

    alike = ((SequenceMatcher(None, code, wanted.upper()).ratio(), code) for code in codes)
    near = [code for likeness, code in sorted(alike, key=lambda pair: (-pair[0], pair[1])) if likeness >= _NEAR][:3]
    shown = wanted or '""'
    return words("rules.near", code=shown, near=", ".join(near)) if near else words("rules.unknown", code=shown)


def _list(catalogue: "list[Rule]", out: Output, words: Words) -> None:
    from canalyze.reports.table import columns, write

    rows = ([rule.code, words.of("severity", rule.severity), rule.name, rule.message] for rule in catalogue)
    write(columns(words, ["code", "severity", "rule", "message"], folds=["message"]), rows, out)


def _page(rule: "Rule", words: Words) -> str:
    lines = [f"{rule.code} {rule.name} ({words.of('severity', rule.severity)})", *wrap(rule.message, 98), ""]
    facts = [
        (words("rules.meaning"), rule.meaning),
        (words("rules.cause"), rule.cause),
        (words("rules.clause"), _clause(rule.clause, words)),
    ]
    return "\n".join([*lines, *definitions(facts, columns=98, margin=0)]) + "\n"


def _clause(clause: str, words: Words) -> str:
    """Returns a clause in no language: "to" between two of them becomes a sign."""
    return words("rules.no_clause") if clause in ("", "-") else clause.replace(" to ", " ~ ")


command = simple_command(
    "rules", run, form("text", "jsonl"), argument("codes", "CODE", nargs=-1, shell_complete=_completed), paged=True
)
