"""A DBC file of PDOs, and the lines about it on standard error. What is in it, `canalyze/dictionary/dbc.py` decides."""

from canalyze.dictionary.dbc import Described, made
from canalyze.output import Output, complain
from canalyze.words import Words


def write(out: Output, words: Words, name: str, result: bytes, described: Described) -> None:
    """Writes the PDOs of one bus. CanalyzeError where that cannot be."""
    found = made(result, described)
    out.write(found.data)
    complain(f"canalyze: {words('dbc.written', name=name, messages=found.messages, signals=found.signals)}")
    for key, facts in found.said:
        complain(f"canalyze: {name}: {words(key, **facts)}")
