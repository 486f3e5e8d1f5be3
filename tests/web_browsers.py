"""Browsers that tests drive: Chromium by its driver, Firefox by Marionette, both without a window.

Both speak the same commands (W3C WebDriver), one over HTTP, the other over a socket of its own. What it must not do:
know the page.
"""

from __future__ import annotations

import base64
import json
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, ClassVar
from urllib.request import ProxyHandler, Request, build_opener

CHROMIUM = shutil.which("chromium")
CHROMEDRIVER = shutil.which("chromedriver")
FIREFOX = shutil.which("firefox-esr")
ELEMENT = "element-6066-11e4-a52e-4f735466cecf"
START_S = 60.0


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port: int = one.getsockname()[1]
        return port


def until(found: Callable[[], Any], seconds: float, what: str) -> Any:
    """Ask until there is an answer."""
    end = time.monotonic() + seconds
    while not (answer := found()):
        assert time.monotonic() < end, f"{what}: not within {seconds} s"
        time.sleep(0.02)
    return answer


class Browser:
    """A page in a browser."""

    name = ""

    def command(self, method: str, path: str, **given: Any) -> Any:
        """Run a command of WebDriver: of HTTP, its path below the session."""
        raise NotImplementedError

    def open(self, page: Path) -> None:
        """Load a page from the disk."""
        self.command("POST", "url", url=page.as_uri())

    def run(self, script: str, *given: Any) -> Any:
        """Run a script in the page; give what it returns."""
        return self.command("POST", "execute/sync", script=script, args=list(given))

    def wait(self, condition: str, seconds: float = 60.0) -> Any:
        """Wait until an expression of the page is true; give it."""
        return until(lambda: self.run(f"return {condition}"), seconds, condition)

    def element(self, selector: str) -> str:
        found: dict[str, str] = self.command("POST", "element", using="css selector", value=selector)
        return found[ELEMENT]

    def choose(self, selector: str, *files: Path) -> None:
        """Choose files in a field for files."""
        self.type(self.element(selector), "\n".join(map(str, files)))

    def type(self, element: str, text: str) -> None:
        self.command("POST", f"element/{element}/value", text=text)

    def click(self, selector: str) -> None:
        self.command("POST", f"element/{self.element(selector)}/click")

    def key(self, key: str) -> None:
        """Press a key where the page has its focus."""
        strokes = [{"type": "keyDown", "value": key}, {"type": "keyUp", "value": key}]
        self.command("POST", "actions", actions=[{"type": "key", "id": "keys", "actions": strokes}])

    def size(self, width: int, height: int) -> None:
        self.command("POST", "window/rect", width=width, height=height)

    def picture(self, path: Path) -> None:
        path.write_bytes(base64.b64decode(self.command("GET", "screenshot")))


class Chromium(Browser):
    """Chromium by chromedriver."""

    name = "chromium"

    def __init__(self, address: str, folder: Path) -> None:
        """Open a session. folder: of the profile and downloads."""
        self._opener = build_opener(ProxyHandler({}))
        self._address = f"{address}/session"
        switches = [
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            f"--user-data-dir={folder}",
            "--window-size=1300,850",
        ]
        options = {
            "binary": CHROMIUM,
            "args": [*switches, "--disable-dev-shm-usage", "--no-first-run"],
            "prefs": {"download.default_directory": str(folder)},
        }
        capabilities = {"goog:chromeOptions": options, "goog:loggingPrefs": {"performance": "ALL", "browser": "ALL"}}
        made = self._ask("POST", self._address, {"capabilities": {"alwaysMatch": capabilities}})
        self._address += f"/{made['sessionId']}"
        self.command("POST", "timeouts", script=120000)

    def _ask(self, method: str, address: str, given: dict[str, Any] | None) -> Any:
        data = None if given is None else json.dumps(given).encode()
        request = Request(address, data, {"Content-Type": "application/json"}, method=method)
        with self._opener.open(request, timeout=180) as answer:
            return json.load(answer)["value"]

    def command(self, method: str, path: str, **given: Any) -> Any:
        return self._ask(method, f"{self._address}/{path}".rstrip("/"), given if method == "POST" else None)

    def cdp(self, name: str, **given: Any) -> Any:
        """Run a command of the DevTools protocol."""
        return self.command("POST", "goog/cdp/execute", cmd=name, params=given)

    def log(self, kind: str) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = self.command("POST", "se/log", type=kind)
        return found

    def requested(self) -> set[str]:
        """The addresses that were asked for since the last call."""
        messages = (json.loads(one["message"])["message"] for one in self.log("performance"))
        return {one["params"]["request"]["url"] for one in messages if one["method"] == "Network.requestWillBeSent"}


class Firefox(Browser):
    """Firefox by Marionette: messages of JSON behind their length."""

    name = "firefox"
    NAMES: ClassVar = {
        "url": "WebDriver:Navigate",
        "execute/sync": "WebDriver:ExecuteScript",
        "element": "WebDriver:FindElement",
        "actions": "WebDriver:PerformActions",
        "window/rect": "WebDriver:SetWindowRect",
        "screenshot": "WebDriver:TakeScreenshot",
    }

    def __init__(self, connection: socket.socket) -> None:
        """Open a session over a connection."""
        self._file = connection.makefile("rwb")
        self._number = 0
        self._message()  # who it is
        self._send("WebDriver:NewSession", {})

    def _message(self) -> Any:
        length = b""
        while (one := self._file.read(1)) != b":":
            assert one, "Firefox has ended"
            length += one
        return json.loads(self._file.read(int(length)))

    def _send(self, name: str, given: dict[str, Any]) -> Any:
        self._number += 1
        message = json.dumps([0, self._number, name, given]).encode()
        self._file.write(b"%d:%b" % (len(message), message))
        self._file.flush()
        _, _, error, value = self._message()
        assert error is None, error
        return value["value"] if isinstance(value, dict) and set(value) == {"value"} else value

    def command(self, method: str, path: str, **given: Any) -> Any:
        if path.startswith("element/"):
            _, element, act = path.split("/")
            name = {"value": "WebDriver:ElementSendKeys", "click": "WebDriver:ElementClick"}[act]
            return self._send(name, {"id": element, **given})
        return self._send(self.NAMES[path], given)


def started(line: list[str], home: str) -> subprocess.Popen[bytes]:
    """Start a program that starts others, silent, in a group of their own, with a home of its own."""
    own = {name: value for name, value in os.environ.items() if not name.startswith("XDG_")} | {"HOME": home}
    silent = subprocess.DEVNULL
    return subprocess.Popen(line, stdout=silent, stderr=silent, start_new_session=True, env=own)


def ended(process: subprocess.Popen[bytes]) -> None:
    """End a program and all that it has started."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


@contextmanager
def chromium() -> Iterator[Chromium]:
    """Start Chromium; it ends with the block."""
    assert CHROMEDRIVER is not None
    port = free_port()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        line = [CHROMEDRIVER, f"--port={port}", "--log-level=OFF"]
        process = started(line, folder)
        try:
            address = f"http://127.0.0.1:{port}"
            opener = build_opener(ProxyHandler({}))

            def ready() -> bool:
                with suppress(OSError), opener.open(f"{address}/status", timeout=5) as answer:
                    return bool(json.load(answer)["value"]["ready"])
                return False

            until(ready, START_S, "chromedriver")
            browser = Chromium(address, Path(folder))
            try:
                yield browser
            finally:
                browser.command("DELETE", "")
        finally:
            ended(process)


@contextmanager
def firefox() -> Iterator[Firefox]:
    """Start Firefox; it ends with the block."""
    assert FIREFOX is not None
    port = free_port()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        settings = {
            "marionette.port": port,
            "datareporting.policy.dataSubmissionEnabled": False,
            "app.update.enabled": False,
        }
        lines = [f"user_pref({json.dumps(name)}, {json.dumps(value)});\n" for name, value in settings.items()]
        (Path(folder) / "user.js").write_text("".join(lines))
        line = [FIREFOX, "--headless", "--marionette", "--no-remote", "--profile", folder]
        process = started(line, folder)
        try:

            def connected() -> socket.socket | None:
                with suppress(OSError):
                    return socket.create_connection(("127.0.0.1", port), timeout=120)
                return None

            with until(connected, START_S, "firefox") as connection:
                yield Firefox(connection)
        finally:
            ended(process)
