"""canalyze.toml: what the core reads in it, as a Config.

Which tables and keys there are the core knows (`settings/`). Apart from `config`, because a run without such a file
needs nothing of it. It must not print: what is wrong is a ConfigError, worded by who shows it.
"""

from pathlib import Path

from canalyze import _core
from canalyze.check import policy
from canalyze.configuration import bounded, network
from canalyze.configuration.config import Config


def read(path: Path) -> Config:
    """Reads a canalyze.toml and checks every key."""
    said = bounded.checked(path, _core.settings, "config.unreadable")
    known = network.Known(
        tuple(
            network.Description(bus, tuple(nodes), str(path.parent / file)) for bus, nodes, file in said.descriptions
        ),
        tuple(
            network.Cob(bus, network.CanId(*can_id), node, direction, number)
            for bus, can_id, node, direction, number in said.cobs
        ),
        tuple(
            network.SdoChannel(bus, network.CanId(*client), network.CanId(*server), node)
            for bus, client, server, node in said.sdos
        ),
        said.sync_period_ns,
        said.sync_window_ns,
        said.jitter_ns,
        said.bitrate,
    )
    check = None if said.check is None else _policy(said.check, path.parent)
    return Config(lang=said.lang or "zh", chosen=said.lang is not None, known=known, check=check)


def _policy(said: _core.Check, directory: Path) -> policy.Policy:
    return policy.Policy(
        said.fail_on,
        tuple(said.select),
        tuple(said.ignore),
        str(directory / said.baseline) if said.baseline else None,
        tuple(
            policy.Override(tuple(codes), severity, reason, tuple(files), tuple(nodes), bus, at)
            for codes, severity, reason, files, nodes, bus, at in said.overrides
        ),
        str(directory),
        tuple(zip(("select", "ignore"), said.at, strict=True)),
        said.problems or (policy.FORMER[said.incidents] if said.incidents else None),
    )
