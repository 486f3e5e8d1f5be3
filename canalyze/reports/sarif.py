"""SARIF 2.1.0: the form of findings that code scanning and editors read.

One run; an artifact is a capture, a result a kind of finding (rule, bus, node, object, expectation) in it, at its first
frame. The file keeps what GitHub's code scanning asks for: the fields it needs, its largest number of results, and a
fingerprint that stays when a capture is recorded again. What a finding explains is a property of its result. Rules are
those that occur. Must not: judge, or look into a file.
"""

import hashlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path, PurePath, PurePosixPath, PureWindowsPath
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import quote

from canalyze import __version__
from canalyze.check.verdict import Counted, Verdict
from canalyze.output import json_text, printable
from canalyze.records import SEVERITIES
from canalyze.records.problems import Finding, Problem
from canalyze.reports import wording
from canalyze.sources import STDIN
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Rule

Json = dict[str, Any]

_SCHEMA: Final = "https://json.schemastore.org/sarif-2.1.0.json"
_LANGUAGES: Final = {"zh": "zh-CN", "en": "en-US"}
_LEVELS: Final = {"error": "error", "warning": "warning", "info": "note"}
_PROBLEMS: Final = {"error": "error", "warning": "warning", "info": "recommendation"}
"""The names in code scanning of severities that are not about security."""
_MOST: Final = 25_000
"""Results of a run that code scanning takes; a file with more is refused."""
_LONGEST: Final = 1024
"""Characters of a rule's description that it takes."""
_SHOWN: Final = 1
"""Identifies the location of the frame that shows a finding about an earlier one."""
_LINK: Final = "\0"
"""The place of the link to it in a sentence; no sentence has this character."""


def document(verdicts: Sequence[Verdict], rules: "Sequence[Rule]", words: Words) -> bytes:
    """Returns the whole file; `rules` is the catalogue in the language of `words`."""
    found = [
        (verdict.file, one)
        for verdict in verdicts
        for one in (*verdict.failures, *verdict.others, *verdict.consequences)
    ]
    kept = _worst(found)
    baseline = any(one.known for _, one in found) or any(verdict.known_problems for verdict in verdicts)
    known = {rule.code: rule for rule in rules}
    firsts: dict[str, Finding] = {}
    for _, one in kept:
        firsts.setdefault(one.finding.code, one.finding)
    places = {code: number for number, code in enumerate(sorted(firsts))}
    uris = {verdict.file: _uri(verdict.file) for verdict in verdicts}
    artifacts = {uri: number for number, uri in enumerate(dict.fromkeys(uris.values()))}
    results = []
    for file, one in kept:
        result = _result({"uri": uris[file], "index": artifacts[uris[file]]}, one, words)
        result["ruleIndex"] = places[one.finding.code]
        if baseline:
            result["baselineState"] = _state(one)
        results.append(result)
    problems = [(verdict, one) for verdict in verdicts for one in verdict.stories][: max(_MOST - len(results), 0)]
    kinds = list(dict.fromkeys(one.kind for _, one in problems))
    for verdict, problem in problems:
        artifact = {"uri": uris[verdict.file], "index": artifacts[uris[verdict.file]]}
        result = _story(artifact, problem, verdict, words)
        if baseline:
            result["baselineState"] = _state_of(problem, verdict)
        result["ruleIndex"] = len(places) + kinds.index(problem.kind)
        results.append(result)
    run = {
        "tool": {
            "driver": {
                "name": "canalyze",
                "version": __version__,
                "semanticVersion": __version__,
                "language": _LANGUAGES[words.lang],
                "rules": [_rule(firsts[code], known.get(code), words) for code in places]
                + [{"id": kind, "shortDescription": {"text": kind}} for kind in kinds],
            }
        },
        "language": _LANGUAGES[words.lang],
        "columnKind": "unicodeCodePoints",
        "invocations": [_invocation(verdicts, uris, len(found) - len(kept), words)],
        "artifacts": [{"location": {"uri": uri}, "roles": ["analysisTarget"]} for uri in artifacts],
        "results": results,
    }
    log = {"$schema": _SCHEMA, "version": "2.1.0", "runs": [run]}
    return (json_text(log, indent=2) + "\n").encode()


def _worst(found: list[tuple[str, Counted]]) -> list[tuple[str, Counted]]:
    """Keeps what a reader takes, the worst of it, in the order in which it is."""
    if len(found) <= _MOST:
        return found
    by_severity = sorted(range(len(found)), key=lambda place: -SEVERITIES.index(found[place][1].finding.severity))
    return [found[place] for place in sorted(by_severity[:_MOST])]


def _state(one: Counted) -> str:
    if not one.known:
        return "new"
    return "unchanged" if one.count <= one.known else "updated"


def _state_of(one: Problem, verdict: Verdict) -> str:
    if one.id not in verdict.known_problems:
        return "new"
    return "unchanged" if one.id in verdict.excused else "updated"


def _rule(finding: Finding, rule: "Rule | None", words: Words) -> Json:
    """Describes the rule of a finding; what no catalogue has, by the finding."""
    severity = finding.severity if rule is None else rule.severity
    facts = []
    if rule is not None:
        facts = [(words("rules.meaning"), rule.meaning), (words("rules.cause"), rule.cause)]
        if rule.clause not in ("", "-"):
            facts.append((words("rules.clause"), rule.clause.replace(" to ", " ~ ")))
    short = wording.title(finding) if rule is None else rule.message
    return {
        "id": printable(finding.code),
        "name": "".join(part.capitalize() for part in printable(finding.name).split("-")),
        "shortDescription": {"text": short[:_LONGEST]},
        "fullDescription": {"text": (short if rule is None else rule.meaning)[:_LONGEST]},
        "help": {
            "text": "\n".join(f"{term}: {text}" for term, text in facts) or short,
            "markdown": "\n\n".join(f"**{term}**: {text}" for term, text in facts) or short,
        },
        "defaultConfiguration": {"level": _LEVELS[severity]},
        "properties": {
            "tags": ["CANopen", printable(finding.code)[:3]],
            "precision": "high",
            "problem.severity": _PROBLEMS[severity],
        },
    }


def _result(artifact: Json, one: Counted, words: Words) -> Json:
    finding = one.finding
    location = _location(artifact, finding.about_line, _line_of(finding, finding.about_frame))
    if names := list(_logical(finding)):
        location["logicalLocations"] = names
    text = wording.sentence(one, words, shown=_LINK).replace("](", "] (")  # else a link to where the capture says
    result: Json = {
        "ruleId": printable(finding.code),
        "level": _LEVELS[finding.severity],
        "message": {},
        "locations": [location],
        "partialFingerprints": _fingerprints(finding),
        "occurrenceCount": one.count,
    }
    if finding.about_frame != finding.frame and finding.frame is not None:
        text = text.replace(_LINK, f"[{words('reports.frame', frame=finding.frame)}]({_SHOWN})")
        shown = _location(artifact, finding.line, _line_of(finding, finding.frame))
        shown |= {"id": _SHOWN, "message": {"text": words("reports.shown_here")}}
        result["relatedLocations"] = [shown]
    result["message"]["text"] = text
    if one.known >= one.count:
        result["suppressions"] = [{"kind": "external", "justification": words("reports.known", known=one.known)}]
    properties = {
        "frame": finding.frame,
        "t": finding.t and printable(finding.t),
        "bus": finding.bus and printable(finding.bus),
        "node": finding.node,
        "object": finding.object and printable(finding.object),
        "expectation": finding.expectation and printable(finding.expectation),
        "becauseOf": finding.because_of,
        "consequences": [wording.sentence(other, words) for other in one.consequences],
        "lines": list(wording.annotated(finding)),
    }
    result["properties"] = {name: value for name, value in properties.items() if value not in (None, [])}
    return result


def _story(artifact: Json, one: Problem, verdict: Verdict, words: Words) -> Json:
    """Returns a root: its steps as a flow, and what it has caused as related places."""
    steps = [
        {"location": {**_location(artifact, None, None), "message": {"text": printable(f"#{step.frame}: {step.text}")}}}
        for step in one.steps
    ]
    caused = [other for other in verdict.incidents if other.id in one.effects]
    result: Json = {
        "ruleId": one.kind,
        "level": "error" if one.id in verdict.problems else "note",
        "message": {"text": printable(one.message)},
        "locations": [_location(artifact, None, None)],
        # The former name too, for a release: results are matched with those of former runs by it.
        "partialFingerprints": dict.fromkeys(
            ("problem/v1", "incident/v1"), hashlib.sha256(repr((one.kind, one.bus, one.nodes)).encode()).hexdigest()
        ),
        "properties": {"status": one.status, "impact": one.impact, "frame": one.begin.frame, "nodes": list(one.nodes)},
    }
    if one.id in verdict.excused:
        said = words("reports.known", known=verdict.known_problems[one.id])
        result["suppressions"] = [{"kind": "external", "justification": said}]
    if steps:
        result["codeFlows"] = [{"threadFlows": [{"locations": steps}]}]
    if caused:
        result["relatedLocations"] = [
            {**_location(artifact, None, None), "id": other.id, "message": {"text": printable(other.message)}}
            for other in caused
        ]
    return result


def _line_of(finding: Finding, frame: int | None) -> str | None:
    return next((line.text for line in finding.lines if line.frame == frame), None)


def _location(artifact: Json, line: int | None, text: str | None) -> Json:
    """Returns a location; with a line only where the format has lines."""
    physical: Json = {"artifactLocation": artifact}
    if line is not None:
        physical["region"] = {"startLine": line, "startColumn": 1, "endLine": line}
        if text is not None:
            physical["region"]["snippet"] = {"text": printable(text)}
    return {"physicalLocation": physical}


def _logical(finding: Finding) -> Iterator[Json]:
    """Returns bus, node and object, each within the one before."""
    path: list[str] = []
    for kind, name in (("bus", finding.bus), ("node", finding.node), ("object", finding.object)):
        if name is not None:
            text = printable(str(name))
            path.append(text.replace("/", "%2F"))
            yield {"name": text, "fullyQualifiedName": "/".join(path), "kind": kind}


def _fingerprints(finding: Finding) -> Mapping[str, str]:
    """Returns a key of a kind of finding, the same in the next run whatever its frame is; the reader adds the file."""
    parts = [finding.code, finding.bus, finding.node, finding.object]
    if label := wording.expectation(finding):
        parts.append(label)
    key = json.dumps(parts).encode()
    digest = hashlib.sha256(key).hexdigest()[:16]
    return {"primaryLocationLineHash": f"{digest}:1", "findingKind/v1": digest}


def _invocation(verdicts: Sequence[Verdict], uris: Mapping[str, str], left: int, words: Words) -> Json:
    """Returns the notes about captures that could not be read, complaints, and results that are not in the file."""
    said: list[Json] = []
    for verdict in verdicts:
        lines = [("error", verdict.error)] if verdict.error is not None else []
        lines += [] if verdict.judged or verdict.error else [("warning", wording.unjudged(verdict, words))]
        lines += [("note", line) for line in verdict.complaints]
        for level, text in lines:
            location = _location({"uri": uris[verdict.file]}, None, None)
            said.append({"level": level, "message": {"text": printable(text) or "-"}, "locations": [location]})
    if left:
        said.append({"level": "warning", "message": {"text": words("reports.results", count=left, most=_MOST)}})
    whole = all(verdict.error is None for verdict in verdicts)
    return {"executionSuccessful": whole, **({"toolExecutionNotifications": said} if said else {})}


def _uri(file: str) -> str:
    if file == STDIN:
        return "stdin"
    try:
        here = str(Path.cwd())
    except OSError:  # it is gone
        here = None
    return file_uri(file, here=here)


def file_uri(file: str, *, windows: bool = os.name == "nt", here: str | None = None) -> str:
    """Returns the URI of a name as it was given; `here` is the working directory, an absolute path.

    A relative name stays relative. Bytes of a POSIX name that are no UTF-8 are encoded as they are.
    """
    path: PurePath = PureWindowsPath(file) if windows else PurePosixPath(file)
    root = here and (PureWindowsPath(here) if windows else PurePosixPath(here))
    if root and path.is_absolute() and path.is_relative_to(root) and path != root:
        path = path.relative_to(root)
    text = path.as_posix()
    if not path.is_absolute():
        if path.drive:  # C:part of a directory of its own on that drive
            return f"file:///{_encoded(text)}"
        return _encoded(text)
    if path.drive.startswith("\\\\"):
        return f"file:{_encoded(text)}"
    if path.drive:
        return f"file:///{text[0]}:{_encoded(text[2:])}"
    return f"file://{_encoded('/' + text.lstrip('/'))}"


def _encoded(text: str) -> str:
    try:
        return quote(text.encode("utf-8", "surrogateescape"))
    except UnicodeEncodeError:  # half a character, which only Windows lets into a name
        return quote(text.encode("utf-8", "surrogatepass"))
