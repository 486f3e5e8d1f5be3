"""canalyze.toml, CANALYZE_LANG, the user's own file and the global options -> one frozen Config.

The only place that decides the language. It must not print: what is wrong is a ConfigError, worded by who shows it.
"""

import os
import re
import sys
from typing import TYPE_CHECKING, Final, NamedTuple

from canalyze.configuration import network
from canalyze.errors import ConfigError
from canalyze.words import LANGUAGES

if TYPE_CHECKING:
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

    from canalyze.configuration import filed

    return filed.read(Path(FILE if file is None else file))
