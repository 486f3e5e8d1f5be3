"""The baseline and the examined captures: it is rewritten, and its entries that no longer occur are reported.

Must not: judge.
"""

from collections.abc import Sequence
from typing import Final

from canalyze.check import baseline, policy
from canalyze.check.verdict import Examined
from canalyze.output import FileOutput, complain
from canalyze.words import Words

_STALE: Final = 5
"""Entries of the baseline that no longer occur and are named."""


def updated(held: policy.Policy, examined: Sequence[Examined], words: Words, *, whole: bool) -> baseline.Baseline:
    """Writes the baseline anew, of what would fail; not where something was not read, since that would be forgotten."""
    name = held.baseline or ""
    if not whole:
        complain(f"canalyze: {words('baseline.kept', name=name)}")
        return baseline.read(name) if baseline.exists(name) else {}
    verdicts = [policy.judge(one, held, {}) for one in examined]
    known = baseline.most(
        policy.counted(verdict.failures) + policy.problems(policy.failing(held, verdict.incidents))
        for verdict in verdicts
    )
    with FileOutput(name, force=True) as out:
        out.write(baseline.text(known).encode())
    complain(f"canalyze: {words('baseline.written', name=name, count=len(known))}")
    return known


def report_stale(held: policy.Policy, known: baseline.Baseline, examined: Sequence[Examined], words: Words) -> None:
    """Reports which entries of the baseline no longer occur, or not as often."""
    most = baseline.most(
        policy.counted(capture.found) + policy.problems(policy.failing(held, capture.incidents)) for capture in examined
    )
    judged = [kind for kind in known if isinstance(kind, baseline.Kind) or held.incidents not in (None, "never")]
    gone = sorted((kind for kind in judged if most.get(kind, 0) < known[kind]), key=lambda kind: kind.order)
    for kind in gone[:_STALE]:
        whose = (
            kind.subject
            if isinstance(kind, baseline.ProblemKind)
            else kind.node and words("check.node", node=kind.node)
        )
        where = [kind.bus, whose, kind.object]
        shown = " ".join([kind[0], words("check.then").join(str(part) for part in where if part)]).rstrip()
        key = "baseline.fewer" if kind in most else "baseline.gone"
        said = words(key, name=held.baseline, entry=shown, count=most.get(kind, 0), known=known[kind])
        complain(f"canalyze: {said}")
    if len(gone) > _STALE:
        complain(f"canalyze: {words('baseline.more_gone', name=held.baseline, count=len(gone) - _STALE)}")
