"""The command line: the group of commands, global options, language, exit codes.

`main` is the only place where errors become a line and a code:

    0    done; also if the reader of a pipe went away
    1    check: there are findings; sniff: an expectation is not met
    2    wrong usage, or something could not be read or written
    3    fleet: finished, but some captures failed
    130  Ctrl-C (143: SIGTERM); results so far are written. For sniff Ctrl-C is the normal end: 0

A command's module is imported only when that command is run.
"""

import os
import sys
from collections.abc import Sequence
from typing import Final

import click

from canalyze import __version__
from canalyze.configuration.config import Config, settle, spoken
from canalyze.configuration.options import COMMON, built, option
from canalyze.errors import CanalyzeError, ConfigError, CoreError, ReaderGone
from canalyze.output import Output, complain, shows_chinese
from canalyze.output.help import Located, page, screen, usage_line
from canalyze.words import Words

TOPICS: Final = {
    "look": ("diagnose", "decode", "summary", "sdo", "signals", "od", "view", "page", "explain"),
    "live": ("sniff", "monitor"),
    "judge": ("check", "expect", "diff", "fleet", "rules"),
    "files": ("info", "convert", "export", "eds", "mcp", "examples", "help"),
}
"""The commands as grouped in the help; the module of each is in `commands/`."""
COMMANDS: Final = tuple(name for names in TOPICS.values() for name in names)
PARTS: Final = {"od": ("diff", "against", "write")}
"""Commands of two words, by the first of them, which is a command as well."""
_MACHINE: Final = ("signals", "convert", "export")
"""Commands whose default output is no text for people."""

_FORMER: Final = {
    ("--incidents", None): ("--problems", None),
    ("--incidents", "stands"): ("--problems", "open"),
    ("--incidents", "over"): ("--problems", "ended"),
    ("--incidents", "never"): ("--problems", "never"),
    ("--fail-on", "stands"): ("--fail-on", "open"),
    ("--fail-on", "over"): ("--fail-on", "ended"),
    ("--table", "incidents"): ("--table", "problems"),
}
"""Former spellings of options and their values, which are still accepted."""
_FORMER_PARTS: Final = {"--diff": "diff", "--against": "against"} | dict.fromkeys(
    ("--dcf", "--concise-dcf", "--skeleton", "--dbc"), "write"
)
"""Options of `od` that are commands now; they are still accepted."""
_SETTLED_FIRST: Final = ("--lang", "--config")


class Group(Located, click.Group):
    """The commands, imported on demand, with help in the language of the run."""

    def __init__(self, words: Words) -> None:
        """Builds the group in one language."""
        super().__init__("canalyze", params=built((*COMMON, _VERSION), "canalyze", words), add_help_option=False)
        self._words = words

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Returns the names, without importing anything."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Imports and builds one command."""
        first, _, second = cmd_name.partition(" ")
        if first not in COMMANDS or (second and second not in PARTS.get(first, ())):
            return None
        from importlib import import_module

        command = import_module(f"canalyze.commands.{cmd_name.replace(' ', '_')}").command(self._words)
        assert isinstance(command, click.Command)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Finds the command; a usage error names those that are spelt alike."""
        if args[1:] and args[1] in PARTS.get(args[0], ()):
            args = [f"{args[0]} {args[1]}", *args[2:]]
            return super().resolve_command(ctx, args)
        if args[0] in COMMANDS or ctx.resilient_parsing:
            return super().resolve_command(ctx, args)
        near = _near(args[0])
        key = "usage.no_command_near" if near else "usage.no_command"
        raise click.UsageError(self._words(key, name=args[0] or '""', near=self._words("usage.or").join(near)), ctx)

    def get_help(self, ctx: click.Context) -> str:
        """Returns the page."""
        return page(self, ctx, self._words, TOPICS)


def _show_version(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        Output().text(f"canalyze {__version__}\n")
        ctx.exit()


_VERSION: Final = option(
    "--version", key="opt.version", topic="general", is_eager=True, expose_value=False, callback=_show_version
)


def build(lang: str) -> click.Group:
    """Returns the whole command line in one language."""
    return Group(Words(lang))


def main(argv: Sequence[str] | None = None) -> int:
    """Runs one command line; returns the exit code."""
    try:
        return _run(list(sys.argv[1:] if argv is None else argv))
    except KeyboardInterrupt:
        return 130


def _run(args: list[str]) -> int:
    options: dict[str, str] = {}
    args, missing = _take_global(args, options)
    lang = options.get("--lang")
    try:
        if missing:
            words = _words(spoken(lang), notice=False)
            problem = words("usage.needs_value", option=missing)
            complain(words("usage.line", command=_command(args), problem=problem))
            return 2
        config = settle(lang, options.get("--config"))._replace(pager="--no-pager" not in options)
        words = _words(config)
        if not config.chosen and _needs_hint(args):
            complain(words("output.hint"))
    except ConfigError as error:
        if not _completes() and not (_explains(args) and error.key != "config.lang_option"):
            complain(f"canalyze: {error.in_words(_words(spoken(lang), notice=False))}")
            return error.exit_code
        config = spoken(lang)
        words = _words(config, notice=not _completes())
    group = Group(words)
    try:
        if not args and not _completes() and not _of_a_pipe(args):
            complain(*screen(group, words, TOPICS).splitlines())
            return 2
        return int(group.main(_renamed(_commanded(args)), prog_name="canalyze", standalone_mode=False, obj=config) or 0)
    except click.UsageError as error:
        complain(usage_line(error, words))
        return 2
    except click.Abort:  # Ctrl-C where no reading was under way
        return 130
    except ReaderGone as error:
        return error.exit_code
    except CanalyzeError as error:
        complain(f"canalyze: {error.in_words(words)}")
        return error.exit_code
    except ImportError as error:
        if error.name != "canalyze._core":
            raise
        complain(f"canalyze: {CoreError('core.missing', problem=error).in_words(words)}")
        return CoreError.exit_code


def _completes() -> bool:
    return "_CANALYZE_COMPLETE" in os.environ


def _commanded(args: list[str]) -> list[str]:
    """Returns the arguments with `diagnose` before files that come without a command, or a pipe."""
    first = next((arg for arg in args if not arg.startswith("-") or arg == "-"), None)
    if first in COMMANDS or _completes():
        return args
    if _of_a_pipe(args):
        return ["diagnose", *args]
    if first is None:
        return args
    files = [arg for arg in args if arg == "-" or os.path.lexists(arg)]
    looks = os.sep in first or "." in first or any(sign in first for sign in "*?[")
    if first == args[0] and not looks and first not in files and _near(first):
        return args  # a command that is spelt wrong, before a file or not
    return ["diagnose", *args] if files or looks else args


def _of_a_pipe(args: list[str]) -> bool:
    """Returns true if a capture comes through a pipe or from a file, and nothing but options is said of it."""
    import stat

    if (args and not args[0].startswith("-")) or _explains(args) or not {*args}.isdisjoint(COMMANDS):
        return False
    if any(os.path.lexists(arg) for arg in args):
        return False
    try:
        mode = os.fstat(0).st_mode
    except OSError:
        return False
    return stat.S_ISFIFO(mode) or stat.S_ISREG(mode) or stat.S_ISSOCK(mode)


def _renamed(args: list[str]) -> list[str]:
    """Returns the arguments with former spellings replaced by those of today."""
    found: list[str] = []
    rest = _parted(args)
    while rest:
        option, equals, value = rest.pop(0).partition("=")
        if option == "--":
            return [*found, option, *rest]
        following = value if equals else rest[0] if rest else None
        if (now := _FORMER.get((option, following))) and now[1] is not None:
            found += [f"{now[0]}={now[1]}"]
            rest = rest if equals else rest[1:]
            continue
        option = _FORMER.get((option, None), (option, None))[0]
        found.append(f"{option}{equals}{value}")
    return found


def _parted(args: list[str]) -> list[str]:
    """Returns the arguments of `od` with an option that is a command now as that; a file behind it is an argument."""
    if args[:1] != ["od"] or args[1:2] in [[part] for part in PARTS["od"]]:
        return list(args)
    end = args.index("--") if "--" in args else len(args)
    for place in range(1, end):
        option, equals, value = args[place].partition("=")
        part = _FORMER_PARTS.get(option)
        if part == "write":
            return ["od", part, *args[1:]]
        if part is not None:
            behind = place + 1 if equals else place + 2
            file = [value] if equals else args[place + 1 : behind]
            others = [*args[1:place], *args[behind:]]
            if not file or behind > end:
                break
            return ["od", part, *others, *file] if part == "diff" else ["od", part, *file, *others]
    return list(args)


def _near(name: str) -> list[str]:
    """Returns the commands that may have been meant."""
    from difflib import get_close_matches

    return get_close_matches(name, COMMANDS)


def _command(args: list[str]) -> str:
    """Returns what was typed up to the command, if there is one."""
    name = next((arg for arg in args if not arg.startswith("-")), "")
    return f"canalyze {name}" if name in COMMANDS else "canalyze"


def _explains(args: list[str]) -> bool:
    """Returns true if help or the version is asked for; an error in the configuration does not prevent it."""
    return not {"-h", "--help", "--version"}.isdisjoint(args[: args.index("--")] if "--" in args else args)


def _needs_hint(args: list[str]) -> bool:
    """Returns true if a text in Chinese comes on the terminal of a user who may not read it."""
    out, err = (stream is not None and stream.isatty() for stream in (sys.stdout, sys.stderr))
    if not out or not err or not shows_chinese() or _completes() or "--version" in args:
        return False
    spoken = (os.environ.get(name) for name in ("LC_ALL", "LC_MESSAGES", "LANG"))
    if next(filter(None, spoken), "").lower().startswith("zh"):
        return False
    if _explains(args):
        return True
    args = args[: args.index("--")] if "--" in args else args
    if (_commanded(args) or [""])[0] in _MACHINE:
        return False
    forms = [after for arg, after in zip(args, [*args[1:], ""], strict=True) if arg == "--format"]
    forms += [arg.partition("=")[2] for arg in args if arg.startswith("--format=")]
    return set(forms) <= {"text"}


def _words(config: Config, *, notice: bool = True) -> Words:
    if config.lang == "zh" and not config.chosen and not shows_chinese():
        words = Words("en")
        if notice:
            complain(words("output.english"))
        return words
    return Words(config.lang)


def _take_global(args: list[str], found: dict[str, str]) -> tuple[list[str], str]:
    """Removes --lang, --config and --no-pager from the arguments, wherever they are before "--"; the last one counts.

    Returns the rest, and the option whose value is missing, if any.
    """
    rest: list[str] = []
    waiting = iter(args)
    for arg in waiting:
        option, equals, value = arg.partition("=")
        if arg == "--":
            rest += [arg, *waiting]
        elif arg == "--no-pager":
            found[arg] = ""
        elif option not in _SETTLED_FIRST:
            rest.append(arg)
        elif equals:
            found[option] = value
        else:
            following = next(waiting, None)
            if following is None:
                return rest, option
            found[option] = following
    return rest, ""
