"""canalyze.toml: its tables and keys, and what they say as a Config.

Apart from `config`, because a run without such a file needs nothing of it. It must not print: what is wrong is a
ConfigError, worded by who shows it.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from canalyze.check import globs, policy
from canalyze.configuration import bounded, network
from canalyze.configuration.config import Config
from canalyze.configuration.toml import File, Key, as_text, as_toml, bit_rate, choice, node, text
from canalyze.errors import ConfigError
from canalyze.words import LANGUAGES


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


def read(path: Path) -> Config:
    """Read a canalyze.toml and check every key."""
    try:
        content = bounded.content(path)
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


def _check(filed: File, values: Mapping[str, object], directory: Path) -> policy.Policy | None:
    if "check" not in values:
        return None
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
