"""canalyze.toml, CANALYZE_LANG, the user's own file and the global options -> one frozen Config.

The only place that decides the language. Which tables and keys there are in canalyze.toml, the core knows
(`settings/`); what reads one is loaded only where there is one. It must not print: what is wrong is a ConfigError,
worded by who shows it.
"""

import os
import re
import sys
from typing import TYPE_CHECKING, Final, NamedTuple

from canalyze.configuration import network
from canalyze.errors import ConfigError
from canalyze.words import LANGUAGES

if TYPE_CHECKING:
    from pathlib import Path

    from canalyze import _core
    from canalyze.check.policy import Policy

FILE: Final = "canalyze.toml"


class Config(NamedTuple):
    """The settings of the whole run."""

    lang: str = "zh"
    """zh or en."""
    chosen: bool = False
    """True if the language was chosen: it is used whatever the terminal can show."""
    known: network.Known = network.Known()
    """The network of canalyze.toml; options may overrule it."""
    check: "Policy | None" = None
    """The [check] of canalyze.toml; options may overrule it."""
    pager: bool = True
    """False with --no-pager."""


def settle(lang: str | None, file: str | None) -> Config:
    """Decides by option, CANALYZE_LANG, file and the user's file, in that order; ConfigError for what cannot be."""
    given = language(lang)
    if lang is not None and given is None:
        raise ConfigError("config.lang_option", value=lang or '""')
    wanted = os.environ.get("CANALYZE_LANG") or None
    if lang is None and wanted is not None and language(wanted) is None:
        raise ConfigError("config.lang_env", value=wanted)
    filed = read(file)  # always: a broken file is said even where another choice wins
    choice = given or language(wanted) or (filed.lang if filed.chosen else own_language())
    return Config(lang=choice or "zh", chosen=choice is not None, known=filed.known, check=filed.check)


def spoken(lang: str | None) -> Config:
    """Returns the settings without a file (after a ConfigError, for help): the first valid choice that needs none."""
    choice = language(lang) or language(os.environ.get("CANALYZE_LANG"))
    return Config(lang=choice or "zh", chosen=choice is not None)


def language(value: str | None) -> str | None:
    """Returns the language that is meant by one of LANGUAGES in any case, or by a locale such as zh_CN.UTF-8."""
    name = re.split("[_.@-]", value or "", maxsplit=1)[0].lower()
    return name if name in LANGUAGES else None


def own_file() -> str | None:
    """Returns where the user's own file would be; None where the system has no place for it."""
    if sys.platform == "win32":
        folder = os.environ.get("APPDATA", "")
    else:
        folder = os.environ.get("XDG_CONFIG_HOME") or os.path.expanduser("~/.config")  # noqa: PTH111 - as in `sources.file`
    return f"{folder}/canalyze/config.toml" if os.path.isabs(folder) else None  # noqa: PTH117


def own_language() -> str | None:
    """Returns the language in the user's own file; None without one. ConfigError if there is anything else in it."""
    file = own_file()
    if file is None or not os.path.lexists(file):
        return None
    found = read(file)
    if found != Config(lang=found.lang, chosen=found.chosen):
        raise ConfigError("config.only_lang", file=file)
    return found.lang if found.chosen else None


def read(file: str | None) -> Config:
    """Reads the named file, or canalyze.toml of the current directory if there is one."""
    if file is None and not os.path.lexists(FILE):
        return Config()
    from pathlib import Path

    return _filed(Path(FILE if file is None else file))


def _filed(path: "Path") -> Config:
    """Reads a canalyze.toml and checks every key."""
    from canalyze import _core
    from canalyze.output import files

    said = files.checked(path, _core.settings, "config.unreadable")
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


def _policy(said: "_core.Check", directory: "Path") -> "Policy":
    from canalyze.check import policy

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
