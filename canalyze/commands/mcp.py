"""`canalyze mcp`: the tools of `agents` by the Model Context Protocol, on standard input and output.

client --(lines of JSON)--> the SDK's server --> a tool, in another thread --> an answer
"""

import os
import signal
from functools import partial
from typing import Any

from canalyze import __version__
from canalyze.configuration.options import ANY_PATH, argument
from canalyze.errors import CanalyzeError, as_error
from canalyze.output.help import simple_command
from canalyze.words import Words


def run(words: Words, *, folder: str) -> int:
    """Serves a folder."""
    with as_error(CanalyzeError, "mcp.missing", ImportError):
        _serve(folder, words)
    return 0


def _serve(folder: str, words: Words) -> None:
    """Serves until standard input ends; nothing but the protocol comes to standard output."""
    import anyio
    from mcp import types
    from mcp.server.lowlevel import Server
    from mcp.server.stdio import stdio_server

    from canalyze import agents

    tools = agents.Folder(folder, words)
    one_by_one = anyio.CapacityLimiter(1)  # of captures, one at a time is in memory
    hints = types.ToolAnnotations(read_only_hint=True, open_world_hint=False)
    listed = [
        types.Tool(
            name=name, description=words(f"mcp_tool.{name}"), input_schema=agents.schema(name, words), annotations=hints
        )
        for name in agents.TOOLS
    ]

    async def list_tools(_: Any, __: Any) -> Any:
        return types.ListToolsResult(tools=listed)

    async def call_tool(_: Any, asked: Any) -> Any:
        work = partial(tools.answer, asked.name, asked.arguments or {})
        text, failed = await anyio.to_thread.run_sync(work, limiter=one_by_one)
        return types.CallToolResult(content=[types.TextContent(type="text", text=text)], is_error=failed)

    async def serve() -> None:
        server = Server(
            "canalyze",
            version=__version__,
            instructions=words("mcp.instructions"),
            on_list_tools=list_tools,
            on_call_tool=call_tool,
        )
        async with stdio_server() as (incoming, outgoing):
            await server.run(incoming, outgoing, server.create_initialization_options())

    # The thread that waits for standard input ends with the process only; nothing is at stake.
    for number in (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", None)):
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, lambda got, _: os._exit(128 + got))
    anyio.run(serve)


command = simple_command("mcp", run, argument("folder", "DIR", type=ANY_PATH))
