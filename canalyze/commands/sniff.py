"""`canalyze sniff`: the annotated listing of a live bus. It only listens; every word of a line is the core's.

What is listened to, `listening` opens; it is read by the one loop that reads files. Exit codes: 0 done, also by
Ctrl-C; 1 an expectation does not hold; 2 something could not be opened, received or written, or nothing came that
expectations could be checked by; 143 SIGTERM, 129 SIGHUP.
"""

import json
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Final, Unpack

import click

from canalyze import expectations
from canalyze.config import Config
from canalyze.errors import CanalyzeError, OutputError
from canalyze.help import Command
from canalyze.listening import (
    ListeningOptions,
    channels_of,
    check_recordings,
    interface_of,
    listening_options,
    open_buses,
    open_recordings_of,
    positive,
    refuse_others,
    seconds,
)
from canalyze.options import (
    ANY_PATH,
    CaptureOptions,
    OneOf,
    Spelled,
    format_option,
    network_options,
    open_session,
)
from canalyze.output import Output, Progress, complain
from canalyze.recording import Recordings, Written
from canalyze.run import Run
from canalyze.sources.live import Live
from canalyze.words import Words

_REST_S: Final = 2.0
"""How long, after the first Ctrl-C, what was received may still take to be shown."""
_COUNTED: Final = {
    "sniff.findings": ("findings", ("sniff.error", "sniff.warning", "sniff.info")),
    "sniff.transfers": ("transfers", ("sniff.ok", "sniff.aborted", "sniff.incomplete", "sniff.failed")),
}
"""What the summary counts, in its order: in which words, and how the core calls it."""


class _Listening(CaptureOptions, ListeningOptions, total=False):
    """What the shared options of `sniff` give."""


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        channels: tuple[str, ...],
        brief: bool,
        explain: bool,
        form: str,
        expression: str | None,
        time: str | None,
        duration: float | None,
        count: int | None,
        expect: str | None,
        **given: Unpack[_Listening],
    ) -> int:
        context = click.get_current_context()
        if brief and explain:
            raise click.UsageError(words("usage.exclusive", one="--brief", other="--explain"), context)
        if form != "text" and (brief or explain):
            option = "--brief" if brief else "--explain"
            raise click.UsageError(words("usage.text_only", option=option), context)
        named = channels_of(channels, words)
        refuse_others(named, given, words)
        interface_of(given, words)
        check_recordings(given, words)
        settings: dict[str, Any] = {"depth": "brief" if brief else "explain" if explain else "default"}
        settings |= {"format": form, "time": time, "filter": expression, "count": count}
        settings["masks"] = [channel.mask for channel in named if channel.filters] or None
        if expect is not None:
            settings["expectations"] = expectations.read(Path(expect))
        session = open_session(words, given, **settings)
        with ExitStack() as stack:
            filed = (context.find_object(Config) or Config()).known.bitrate
            buses = open_buses(named, given, words, bitrate=given.get("bitrate") or filed, tell=complain)
            for bus in buses:
                stack.callback(bus.close)
            recordings = open_recordings_of(given, words)
            if recordings:
                stack.callback(recordings.close)
            live = Live(buses, recording=recordings, reconnect=given.get("reconnect", False), duration_s=duration)
            stack.callback(live.close)
            return _listen(live, session, recordings, words, given)

    return Command(
        "sniff",
        words,
        run,
        [
            click.Argument(["channels"], nargs=-1, metavar="CHANNEL"),
            *listening_options(words),
            click.Option(["--filter", "expression"], metavar="EXPR", help=words("opt.filter")),
            click.Option(
                ["--duration"], type=Spelled(seconds, "duration", words), metavar="TIME", help=words("sniff.duration")
            ),
            click.Option(
                ["--count"], type=Spelled(positive, "positive", words), metavar="N", help=words("sniff.count")
            ),
            click.Option(["--brief"], is_flag=True, help=words("decode.brief")),
            click.Option(["--explain"], is_flag=True, help=words("decode.explain")),
            format_option(words, "decode"),
            click.Option(["-t", "time"], type=OneOf(("a", "d", "z", "A", "n"), words), help=words("decode.time")),
            click.Option(["--expect"], type=ANY_PATH, metavar="FILE", help=words("sniff.expect")),
            *network_options(words),
        ],
    )


def _listen(live: Live, session: Any, recordings: Recordings | None, words: Words, given: CaptureOptions) -> int:
    """Show what is received until the end; give the exit code."""
    out = Output()
    began = time.monotonic()
    stopped = 0.0

    def take(result: bytes) -> None:
        nonlocal stopped
        if result:
            out.write(result)
        if run.signal:  # the rest is shown, but not for long
            stopped = stopped or time.monotonic()
            if time.monotonic() - stopped > _REST_S:
                live.stop(now=True)

    run = Run(session, words, Progress(words, out, None), take, given, frameless=True, live=live)
    broken: CanalyzeError | None = None
    try:
        code = run.over((live.name,))
    except SystemExit as ended:  # the second Ctrl-C: what is not shown yet will not be
        code = ended.code if isinstance(ended.code, int) else 2
    except OutputError as error:
        broken, code = error, error.exit_code
    took = time.monotonic() - began
    live.close()
    if recordings:
        recordings.close()
        for remark in recordings.remarks():
            complain(remark.in_words(words))
        for line in recordings.losses():
            complain(line)
    tally = json.loads(session.tally())
    written = recordings.written if recordings else []
    lines = [recorded(one, words) for one in written]
    if broken is None:
        lines = [*_seen(tally, took, live.unshown, bool(written), words), *_held(tally, words), *lines]
    for line in lines:
        complain(f"canalyze: {line}")
    if recordings and recordings.failed:
        code = code or 2
    if broken is not None and code == broken.exit_code:
        raise broken
    if tally["expectations"]:
        code = code or (2 if not tally["frames"] else 1 if tally["expectations"]["missed"] else 0)
    return code


def _held(tally: Mapping[str, Any], words: Words) -> Iterator[str]:
    """Say how the expectations came out, if there are any: nothing is known of a bus that was silent."""
    if expected := tally["expectations"]:
        key = "sniff.unchecked" if not tally["frames"] else "sniff.missed" if expected["missed"] else "sniff.met"
        yield words(key, count=expected["missed"])


def _seen(tally: Mapping[str, Any], seconds: float, unshown: int, recorded: bool, words: Words) -> Iterator[str]:
    """Give what was seen, a line each: the buses, findings, SDO transfers, what was not shown."""
    comma = words("listen.comma")
    # The core counts what it was not given as dropped, too; it is told apart below.
    unshown_here = unshown if len(tally["buses"]) == 1 else 0
    for bus in tally["buses"]:
        frames = bus["frames"]
        facts = {"bus": bus["name"], "frames": frames, "seconds": f"{seconds:.1f}"}
        rate = _rounded(frames / max(seconds, 0.001))
        parts = [words("sniff.bus" if frames else "sniff.nothing", rate=rate, **facts)]
        lost = {"error_frames": bus["error_frames"], "dropped": bus["dropped"] - unshown_here}
        parts += [words(f"sniff.{key}", count=count) for key, count in lost.items() if count > 0]
        yield comma.join(parts)
    lines = []
    for title, (kind, keys) in _COUNTED.items():
        counts = {key: tally[kind][key.removeprefix("sniff.")] for key in keys}
        if listed := comma.join(words(key, count=count) for key, count in counts.items() if count):
            lines.append(words(title, listed=listed))
    if lines:
        yield words("sniff.then").join(lines)
    if tally["shown"] not in (0, tally["frames"]):  # that nothing passes a filter, the core says
        yield words("sniff.shown", shown=tally["shown"])
    if unshown:
        yield words("sniff.unshown_recorded" if recorded else "sniff.unshown", count=unshown)


def recorded(one: Written, words: Words) -> str:
    """Give what became of a recording."""
    facts = {"name": one.name, "frames": one.frames, "size": _bytes(one.bytes), "reason": one.failure}
    if len(one.files) + one.deleted > 1:
        facts |= {"first": one.files[0], "last": one.files[-1], "files": len(one.files)}
        parts = [words("record.files", **facts)]
        parts += [words("record.deleted", count=one.deleted, frames=one.frames_deleted)] if one.deleted else []
    else:
        parts = [words("record.file", **{**facts, "name": one.files[0]})]
    if one.failure:
        parts.append(words("record.broken_off"))
    return words("listen.comma").join(parts)


def _rounded(rate: float) -> str:
    return f"{rate:.1f}" if rate < 100 else f"{rate:.0f}"


def _bytes(size: int) -> str:
    for unit, least in (("GB", 10**9), ("MB", 10**6), ("kB", 10**3)):
        if size >= least:
            return f"{size / least:.1f} {unit}"
    return f"{size} B"
