"""canalyze.toml, CANALYZE_LANG and the global options -> one frozen Config.

The only place that decides the language and that knows the tables of the file. It must not print: what is wrong is a
ConfigError, worded by who shows it.
"""

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from canalyze import bounded, network
from canalyze.check import globs, policy
from canalyze.errors import ConfigError
from canalyze.toml import File, Key, as_text, as_toml, bit_rate, choice, node, text
from canalyze.words import LANGUAGES

FILE: Final = "canalyze.toml"
_NOTHING: Final = network.Known()
_LENIENT: Final = policy.Policy()


@dataclass(frozen=True, slots=True)
class Config:
    """What holds for the whole run."""

    lang: str = "zh"
    """zh or en."""
    chosen: bool = False
    """Whether anybody chose the language: then it stands, whatever the terminal can show."""
    known: network.Known = _NOTHING
    """What canalyze.toml says of the network; options may overrule it."""
    check: policy.Policy = _LENIENT
    """What canalyze.toml says of findings; options may overrule it."""


def _nodes(value: object) -> tuple[int, ...] | None:
    if isinstance(value, str):
        return network.nodes(value)
    found = [node(one) for one in (value if isinstance(value, list) else [value])]
    nodes = tuple(dict.fromkeys(node for node in found if node is not None))
    return nodes if nodes and None not in found else None


def _several(value: object) -> tuple[int, ...] | None:
    """Read node-IDs, each a number or a text as `_nodes` takes it."""
    found = [_nodes(one) for one in value] if isinstance(value, list) else [_nodes(value)]
    nodes = tuple(dict.fromkeys(node for some in found for node in some or ()))
    return nodes if nodes and None not in found else None


def _codes(value: object) -> tuple[str, ...] | None:
    texts = value if isinstance(value, list) else [value]
    joined = ",".join(one if isinstance(one, str) else "" for one in texts)
    return policy.codes(joined) if texts else None


def _globs(value: object) -> tuple[str, ...] | None:
    found = [text(one) for one in value] if isinstance(value, list) else [text(value)]
    texts = tuple(one for one in found if one is not None and len(one) <= globs.LONGEST)
    return texts if texts and len(texts) == len(found) else None


def _tolerance(value: object) -> int | None:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return network.nanoseconds(value)


_BUS: Final = Key(text, "text")
_ID: Final = Key(as_text(network.can_id), "can_id", needed=True)
ENTRIES: Final[Mapping[str, Mapping[str, Key]]] = {
    "eds": {"file": Key(text, "text", needed=True), "node": Key(_nodes, "nodes"), "bus": _BUS},
    "cob": {
        "id": _ID,
        "node": Key(node, "node", needed=True),
        "pdo": Key(as_text(network.pdo), "pdo", needed=True),
        "bus": _BUS,
    },
    "sdo": {"client": _ID, "server": _ID, "node": Key(node, "node", needed=True), "bus": _BUS},
}
"""Tables that may come several times, [[eds]], and their keys."""
SYNC: Final[Mapping[str, Key]] = {
    "period_us": Key(lambda value: _tolerance(value) or None, "period"),
    "window_us": Key(lambda value: _tolerance(value) or None, "period"),
}
"""Keys of [sync]."""
CHECK: Final[Mapping[str, Key]] = {
    "fail_on": Key(lambda value: value if value in policy.THRESHOLDS else None, "threshold"),
    "incidents": choice(*policy.STANDINGS),
    "select": Key(_codes, "codes"),
    "ignore": Key(_codes, "codes"),
    "baseline": Key(text, "text"),
}
"""Keys of [check]."""
OVERRIDE: Final[Mapping[str, Key]] = {
    "codes": Key(_codes, "codes", needed=True),
    "severity": Key(lambda value: value if value in policy.RULINGS else None, "ruling", needed=True),
    "reason": Key(text, "text", needed=True),
    "files": Key(_globs, "globs"),
    "nodes": Key(_several, "several_nodes"),
    "bus": _BUS,
}
"""Keys of [[check.override]]."""
KEYS: Final[Mapping[str, Key]] = {
    "lang": choice(*LANGUAGES),
    "jitter_us": Key(_tolerance, "tolerance"),
    "bitrate": Key(bit_rate, "bit_rate"),
}
"""Keys of canalyze.toml outside of tables."""
TABLES: Final = ("sync", "check")
"""Tables that come once."""


def settle(lang: str | None, file: str | None) -> Config:
    """Decide by option, CANALYZE_LANG and file, in that order; raise ConfigError for what cannot be."""
    given = language(lang)
    if lang is not None and given is None:
        raise ConfigError("config.lang_option", value=lang or '""')
    wanted = os.environ.get("CANALYZE_LANG") or None
    if lang is None and wanted is not None and language(wanted) is None:
        raise ConfigError("config.lang_env", value=wanted)
    filed = read(file)  # always: a broken file is said even where another choice wins
    choice = given or language(wanted) or (filed.lang if filed.chosen else None)
    return Config(lang=choice or "zh", chosen=choice is not None, known=filed.known, check=filed.check)


def spoken(lang: str | None) -> Config:
    """Give what holds where the file does not count (a ConfigError, help): the first valid choice that needs none."""
    choice = language(lang) or language(os.environ.get("CANALYZE_LANG"))
    return Config(lang=choice or "zh", chosen=choice is not None)


def language(value: str | None) -> str | None:
    """Give the language that is meant by one of LANGUAGES in any case, or by a locale such as zh_CN.UTF-8."""
    name = re.split("[_.@-]", value or "", maxsplit=1)[0].lower()
    return name if name in LANGUAGES else None


def read(file: str | None) -> Config:
    """Read the named file, or canalyze.toml of the current directory if there is one, and check every key."""
    path = Path(FILE if file is None else file)
    try:
        content = bounded.content(path)
    except FileNotFoundError as error:
        if file is None:
            return Config()
        raise ConfigError("config.unreadable", file=path, error=error) from error
    except OSError as error:
        raise ConfigError("config.unreadable", file=path, error=error) from error
    filed, values = File.parsed(path, content)
    filed.allow(values, KEYS, tables=TABLES, lists=tuple(ENTRIES))
    top = filed.read("", 0, {key: value for key, value in values.items() if key in KEYS}, KEYS)
    sync = filed.read("sync", 0, _table(filed, values, "sync"), SYNC)
    known = network.Known(
        tuple(
            network.Description(entry.get("bus"), entry.get("node") or (), str(path.parent / entry["file"]))
            for entry in filed.entries("eds", values, ENTRIES["eds"])
        ),
        tuple(
            network.Cob(entry.get("bus"), entry["id"], entry["node"], *entry["pdo"])
            for entry in filed.entries("cob", values, ENTRIES["cob"])
        ),
        tuple(
            network.SdoChannel(entry.get("bus"), entry["client"], entry["server"], entry["node"])
            for entry in _channels(filed, values)
        ),
        sync.get("period_us"),
        sync.get("window_us"),
        top.get("jitter_us"),
        top.get("bitrate"),
    )
    lang = top.get("lang")
    return Config(lang=lang or "zh", chosen=lang is not None, known=known, check=_check(filed, values, path.parent))


def _table(filed: File, values: Mapping[str, object], name: str) -> dict[str, Any]:
    given = values.get(name, {})
    if not isinstance(given, dict):
        raise ConfigError("config.table", file=filed.at("", 0, name), key=name, table=f"[{name}]")
    return given


def _check(filed: File, values: Mapping[str, object], directory: Path) -> policy.Policy:
    if "check" not in values:
        return _LENIENT
    given = _table(filed, values, "check")
    own = filed.read("check", 0, {key: value for key, value in given.items() if key != "override"}, CHECK)
    entries = filed.entries("check.override", {"check.override": given.get("override", [])}, OVERRIDE)
    overrides = [
        policy.Override(**entry, at=filed.at("check.override", place, "codes")) for place, entry in enumerate(entries)
    ]
    baseline = own.get("baseline")
    return policy.Policy(
        own.get("fail_on"),
        own.get("select", ()),
        own.get("ignore", ()),
        str(directory / baseline) if baseline else None,
        tuple(overrides),
        str(directory),
        tuple((key, filed.at("check", 0, key)) for key in ("select", "ignore")),
        own.get("incidents"),
    )


def _channels(filed: File, values: Mapping[str, Any]) -> list[dict[str, Any]]:
    channels = filed.entries("sdo", values, ENTRIES["sdo"])
    for place, channel in enumerate(channels):
        if channel["client"] == channel["server"]:
            file, server = filed.at("sdo", place, "server"), as_toml(values["sdo"][place]["server"])
            raise ConfigError("config.one_id", file=file, key="sdo.server", value=server)
    return channels
