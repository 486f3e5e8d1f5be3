"""`canalyze mcp` as an agent has it: the SDK's own client over real pipes, hostile names among its requests.

Must not: know what a capture means; the library's tests do.
"""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import signal
import subprocess
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from captures import SAMPLES
from conftest import command, environment, ran, started

import canalyze
from canalyze import agents
from canalyze.words import LANGUAGES, Words

mcp = pytest.importorskip("mcp")

ROOT = SAMPLES.parent
NAMES = {
    "problems.log": SAMPLES / "problems.log",
    "deep/services.log": SAMPLES / "services.log",
    "network.log": SAMPLES / "network/sync-and-pdos.log",
    "drive.eds": ROOT / "eds/drive.eds",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with captures, a secret beside it, and ways that lead there."""
    beside = tmp_path_factory.mktemp("beside")
    made = beside / "captures"
    (made / "deep").mkdir(parents=True)
    for name, source in NAMES.items():
        shutil.copy(source, made / name)
    shutil.copy(SAMPLES / "problems.log", beside / "secret.log")
    (made / "link.log").symlink_to(beside / "secret.log")
    (made / "links").symlink_to(beside)
    (made / "inside.log").symlink_to(made / "problems.log")
    (made / "loop.log").symlink_to(made / "loop.log")
    (made / "notes.md").write_text("nothing to be read\n")
    os.mkfifo(made / "pipe.log")
    return made


Talk = Callable[[Any], Awaitable[Any]]


def talk(folder: Path, with_client: Talk, lang: str = "en") -> Any:
    """Start the server as an agent's program does, and talk to it."""
    from mcp.client.client import Client
    from mcp.client.stdio import StdioServerParameters, stdio_client

    program, *arguments = command("mcp", "--lang", lang, str(folder))
    server = StdioServerParameters(command=program, args=arguments, env={"PYTHONPATH": str(ROOT)}, cwd=str(folder))

    async def run() -> Any:
        async with Client(stdio_client(server), read_timeout_seconds=60) as client:
            return await with_client(client)

    return asyncio.run(run())


def answers(folder: Path, *asked: tuple[str, dict[str, Any]], lang: str = "en") -> list[tuple[str, bool]]:
    """The texts of answers; true if one is an error."""

    async def ask(client: Any) -> list[tuple[str, bool]]:
        results = [await client.call_tool(name, arguments) for name, arguments in asked]
        assert all(len(result.content) == 1 for result in results)
        return [(result.content[0].text, bool(result.is_error)) for result in results]

    found: list[tuple[str, bool]] = talk(folder, ask, lang)
    return found


@pytest.mark.parametrize("lang", LANGUAGES)
def test_the_tools_are_listed_as_they_are(folder: Path, lang: str) -> None:
    async def listed(client: Any) -> Any:
        return (await client.list_tools()).tools, client.instructions

    tools, instructions = talk(folder, listed, lang)
    words = Words(lang)
    assert {tool.name: tuple(tool.input_schema["properties"]) for tool in tools} == agents.TOOLS
    for tool in tools:
        assert tool.description == words(f"mcp_tool.{tool.name}") and tool.annotations.read_only_hint is True
        assert tool.input_schema["required"] == [
            name for name in agents.TOOLS[tool.name] if name in ("capture", "what")
        ]
        for name, parameter in tool.input_schema["properties"].items():
            assert parameter["description"] == words(f"mcp.{name}")
    assert instructions == words("mcp.instructions")


@pytest.mark.parametrize("lang", LANGUAGES)
def test_answers_are_those_of_the_library(folder: Path, lang: Any) -> None:
    eds = ["5=drive.eds"]
    found = answers(
        folder,
        ("captures", {}),
        ("diagnose", {"capture": "problems.log"}),
        ("decode", {"capture": "deep/services.log", "first": 3, "last": 5}),
        ("decode", {"capture": "network.log", "filter": "service=nmt", "eds": eds}),
        ("explain", {"what": "SDO001"}),
        ("sdo", {"capture": "network.log", "filter": "node=5"}),
        ("od", {"capture": "network.log", "filter": "node=5", "at": 0.5, "eds": eds}),
        ("signals", {"capture": "network.log", "eds": eds}),
        ("signals", {"capture": "network.log", "select": "5.TPDO4.velocity actual value", "eds": eds}),
        ("diagnose", {"capture": "inside.log"}),
        lang=lang,
    )
    assert [failed for _, failed in found] == [False] * len(found)
    texts = iter(text for text, _ in found)
    listed = [line.split("  ") for line in next(texts).splitlines()]
    assert sorted(listed) == sorted(
        [name, str(path.stat().st_size)] for name, path in {**NAMES, "inside.log": SAMPLES / "problems.log"}.items()
    )

    def opened(name: str, **options: Any) -> canalyze.Capture:
        return canalyze.open(name, folder=folder, lang=lang, **options)

    diagnosis = next(texts)
    assert diagnosis.splitlines()[:-1] == str(canalyze.diagnose(opened("problems.log"))).splitlines()[:-1]
    lines = opened("deep/services.log").lines(3, 5)
    assert [line.split(":", 1)[0].strip() for line in next(texts).splitlines()] == [str(line.frame) for line in lines]
    nmt = [line.split(":", 1)[1].strip() for line in next(texts).splitlines() if line.strip()]
    every = [
        one.text for one in opened("network.log", eds=eds, filter="service=nmt") if isinstance(one, canalyze.Frame)
    ]
    assert len(nmt) == len(every) > 1 and all(text in line for text, line in zip(every, nmt, strict=True))
    assert next(texts) == canalyze.explain("SDO001", lang=lang)
    transfers = [json.loads(line) for line in next(texts).splitlines()]
    assert [one["transfer"] for one in transfers] == [one.number for one in opened("network.log").transfers.of(node=5)]
    assert transfers[0]["value"] == 100 and not {"data", "kind", "abort"} & {*transfers[0]}
    assert next(texts) == str(canalyze.od(opened("network.log", eds=eds, filter="node=5"), at=0.5)).rstrip("\n")
    signals = opened("network.log", eds=eds).signals
    assert [line.partition(":")[0] for line in next(texts).splitlines()] == [
        name.partition(":")[0] for name in signals.names
    ]
    values = [line.split("  ") for line in next(texts).splitlines()]
    series = signals["5.TPDO4.velocity actual value"]
    assert [(int(frame), t, text) for frame, t, text in values] == [(row.frame, row.t, row.text) for row in series]
    assert next(texts).splitlines()[0] == diagnosis.splitlines()[0]


OUTSIDE = [
    *("../secret.log", "deep/../../secret.log", "deep/../problems.log", "/etc/passwd", "link.log", "links/secret.log"),
    *("..", "/"),
]
NO_FILE = [
    ".",
    "missing.log",
    "deep",
    "pipe.log",
    "loop.log",
    "",
    "x" * 5000,
    "a\0b.log",
    "-",
    "~/a.log",
    "*.log",
    "\ud800",
]


def test_names_lead_nowhere_but_into_the_folder(folder: Path) -> None:
    secret = str(folder.parent / "secret.log")
    names = [*OUTSIDE, *NO_FILE[:-1], secret]
    asked: list[tuple[str, dict[str, Any]]] = [("decode", {"capture": name}) for name in names]
    asked += [("diagnose", {"capture": "problems.log", "eds": [f"5={name}"]}) for name in ("../x.eds", "/etc/passwd")]
    asked += [("explain", {"what": "705#00", "eds": ["5=../secret.log"]})]
    for (name, arguments), (text, failed) in zip(asked, answers(folder, *asked), strict=True):
        assert failed and "\n" not in text and len(text) <= 1000, (name, arguments)
        assert "can0" not in text and "root:" not in text


@pytest.mark.parametrize("name", [*OUTSIDE, *NO_FILE])
def test_each_name_is_refused_for_its_reason(folder: Path, name: str) -> None:
    text, failed = agents.Folder(str(folder), Words("en")).answer("diagnose", {"capture": name})
    reasons = ("not in the folder", "no such file in the folder")
    assert failed and text.isprintable() and any(reason in text or len(name) > 1000 for reason in reasons)
    if ".." in name or name.startswith("/") or "link" in name:
        assert "not in the folder" in text


@pytest.mark.parametrize(
    ("tool", "arguments", "said"),
    [
        ("nothing", {}, "no tool nothing; there are captures, diagnose"),
        ("decode", {}, "'capture' is a required property"),
        ("decode", {"capture": 5}, "capture: 5 is not of type 'string'"),
        ("decode", {"capture": "problems.log", "first": 0}, "first: 0 is less than the minimum of 1"),
        ("decode", {"capture": "problems.log", "shell": "ls"}, "'shell' was unexpected"),
        ("decode", {"capture": "problems.log", "filter": "colour=red"}, "colour"),
        ("diagnose", {"capture": "notes.md"}, "notes.md"),
        ("diagnose", {"capture": "problems.log", "eds": ["drive"]}, "drive"),
        ("signals", {"capture": "network.log", "select": "speed"}, "no signal 'speed'; there are"),
        ("explain", {"what": "nothing of this\nkind"}, "nothing of this"),
        ("od", {"capture": "problems.log", "at": float("nan")}, "at=nan"),
    ],
)
def test_what_is_wrong_is_an_error_in_one_line(folder: Path, tool: str, arguments: dict[str, Any], said: str) -> None:
    text, failed = agents.Folder(str(folder), Words("en")).answer(tool, arguments)
    assert failed and said in text and "\n" not in text


def test_a_server_goes_on_after_an_error(folder: Path) -> None:
    found = answers(folder, ("nothing", {}), ("decode", {"capture": "../x"}), ("explain", {"what": "8130h"}))
    assert [failed for _, failed in found] == [True, True, False]


def test_an_answer_is_bounded_and_says_so(folder: Path) -> None:
    (text, failed), (short, _) = answers(
        folder, ("decode", {"capture": "network.log"}), ("decode", {"capture": "network.log", "last": 100})
    )
    *lines, last = text.splitlines()
    assert not failed and last.startswith(f"(cut after {len(lines)} lines") and 50 < len(lines) <= agents.LINES
    assert sum(len(line.encode()) + 1 for line in lines) <= agents.BYTES
    assert len(short.splitlines()) == 100 and "cut" not in short
    assert lines[:100] == short.splitlines()


def test_one_long_line_is_cut_too(tmp_path: Path) -> None:
    tools = agents.Folder(str(tmp_path), Words("en"))
    bounded: Any = tools._bounded
    text = bounded(["x" * 100_000])
    assert len(text) < agents.BYTES and text.splitlines()[-1].startswith("(cut after 0 lines")
    assert bounded([]) == "(nothing)"
    assert bounded(["a\x1b[2J\ud800"]) == "a\\x1b[2J\\ud800"
    assert len(bounded(["y"] * agents.LINES).splitlines()) == agents.LINES


def test_nothing_but_the_protocol_comes_to_standard_output(folder: Path) -> None:
    hello = {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": {"name": "t", "version": "0"}}
    requests: list[Any] = [
        {"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": hello},
        {"jsonrpc": "2.0", "method": "notifications/initialized"},
        *(
            {"jsonrpc": "2.0", "id": number, "method": "tools/call", "params": {"name": name, "arguments": arguments}}
            for number, (name, arguments) in enumerate(
                [("diagnose", {"capture": "notes.md"}), ("diagnose", {"capture": "problems.log"})], 2
            )
        ),
    ]
    with started(
        None,
        "mcp",
        "--lang",
        "en",
        str(folder),
        stdin=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=environment(PYTHONPATH=str(ROOT)),
    ) as server:
        assert server.stdin is not None and server.stdout is not None
        server.stdin.write("".join(json.dumps(request) + "\n" for request in requests).encode())
        server.stdin.flush()
        found = [json.loads(server.stdout.readline()) for _ in (1, 2, 3)]
        server.stdin.close()
        assert server.stdout.read() == b""
        assert server.wait(30) == 0
    assert sorted(row["id"] for row in found) == [1, 2, 3]
    assert all(row["jsonrpc"] == "2.0" and "result" in row for row in found)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_signal_ends_it_quietly(folder: Path, number: int, code: int) -> None:
    with started(
        None, "mcp", "--lang", "en", str(folder), stdin=subprocess.PIPE, env=environment(PYTHONPATH=str(ROOT))
    ) as server:
        assert server.stdin is not None and server.stdout is not None and server.stderr is not None
        hello = {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": {"name": "t", "version": "0"}}
        request = {"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": hello}
        server.stdin.write(json.dumps(request).encode() + b"\n")
        server.stdin.flush()
        assert server.stdout.readline()
        server.send_signal(number)
        assert (server.wait(30), server.stderr.read()) == (code, b"")


def test_a_folder_that_is_none_is_one_line(folder: Path) -> None:
    for name in ("missing", "problems.log"):
        done = ran(folder, "mcp", "--lang", "en", name)
        assert (done.returncode, done.stdout) == (2, b"")
        assert done.stderr.decode() == f"canalyze: {name}: no such folder\n"


def test_nothing_is_written(folder: Path) -> None:
    def state() -> dict[str, Any]:
        return {str(path): path.lstat().st_mtime_ns for path in sorted(folder.rglob("*"))}

    before = state()
    asked: list[tuple[str, dict[str, Any]]] = [
        (tool, {name: {"capture": "network.log", "what": "705#00"}[name] for name in parameters[:1]})
        for tool, parameters in agents.TOOLS.items()
    ]
    assert not any(failed for _, failed in answers(folder, *asked))
    assert state() == before
