"""`diagnose --html`: one page that loads nothing, with everything escaped, in both languages, in a real browser.

What it must not do: test what is diagnosed.
"""

from __future__ import annotations

import re
import shutil
from copy import deepcopy
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from captures import Row
from conftest import Runner
from diagnoses import diagnosed
from test_diagnosis import lost

from canalyze.reports.diagnosis_html import MOST, Told, page

HOSTILE = '</script><script>alert(1)</script>"><img src=x onerror=alert(1)>'
BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


def told(count: int = 1, text: str = "") -> dict[str, Told]:
    """The diagnosis of a lost node, so many times; with a text that a capture has put there."""
    found = {}
    for lang in ("zh", "en"):
        one = diagnosed(lost(20), lang=lang)
        incidents: list[Row] = []
        for number in range(1, count + 1):
            incident = deepcopy(one.incidents[0])
            incident["id"] = number
            if text:
                incident["message"] = incident["steps"][0]["text"] = incident["subject"]["bus"] = text
            incidents.append(incident)
        whole: dict[str, Any] = {**one.whole, "order": list(range(1, count + 1))}
        if text:
            whole["buses"], whole["nodes"] = [text, "can1"], [{**whole["nodes"][0], "bus": text}]
        found[lang] = Told(incidents, whole, {39: f"{text} frame 39", 40: "frame 40"})
    return found


class Parsed(HTMLParser):
    """Which elements a page has, and whether they are closed in order."""

    VOID = frozenset({"meta", "input", "br", "line", "rect", "path"})

    def __init__(self, text: str) -> None:
        """Read it."""
        super().__init__()
        self.open: list[str] = []
        self.seen: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in self.VOID:
            assert self.open and self.open.pop() == tag


def test_a_page_is_whole_and_loads_nothing() -> None:
    text = page(told(), "a.log", "zh").decode()
    parsed = Parsed(text)
    assert not parsed.open
    assert [tag for tag, _ in parsed.seen].count("script") == 1
    policy = next(attrs["content"] for tag, attrs in parsed.seen if "http-equiv" in attrs)
    assert policy is not None and policy.startswith("default-src 'none'; style-src 'sha256-")
    assert "unsafe" not in policy
    for _, attrs in parsed.seen:
        assert not {"src", "style"} & set(attrs)
        assert (attrs.get("href") or "#").startswith("#")
        assert not any(name.startswith("on") for name in attrs)
    assert not re.search(r"https?://(?!www\.w3\.org/2000/svg)", text)
    assert "节点5" in text and "node 5" in text


def test_what_a_capture_says_is_escaped() -> None:
    text = page(told(text=HOSTILE), HOSTILE, "en").decode()
    parsed = Parsed(text)
    assert [tag for tag, _ in parsed.seen].count("script") == 1
    assert not any(tag == "img" for tag, _ in parsed.seen)
    assert "&lt;img" in text


@pytest.mark.parametrize("count", [0, 1, 1000])
def test_a_page_has_a_limit(count: int) -> None:
    assert len(page(told(count), "a.log", "en")) < MOST


def test_the_option(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "lost.log").write_bytes(lost(20))
    done = canalyze("lost.log", "--html", "page.html", "--lang", "en")
    assert done.code == 0 and "node 5" in done.out
    text = (tmp_path / "page.html").read_text()
    assert "heartbeat of node 5" in text and "节点5的心跳" in text
    assert canalyze("lost.log", "--html", "page.html").code == 2
    assert canalyze("lost.log", "--html", "page.html", "--force").code == 0
    assert canalyze("-", "--html", "other.html", stdin=lost(20)).code == 2
    assert not (tmp_path / "other.html").exists()


@pytest.mark.skipif(BROWSER is None, reason="there is no Chromium here")
@pytest.mark.parametrize("count", [2, 1000])
def test_in_a_browser(tmp_path: Path, count: int) -> None:
    api = pytest.importorskip("playwright.sync_api")
    (tmp_path / "page.html").write_bytes(page(told(count), "a.log", "zh"))
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        try:
            view = browser.new_page()
            wrong: list[str] = []
            asked: list[str] = []
            view.on("console", lambda message: wrong.append(message.text))
            view.on("pageerror", lambda error: wrong.append(str(error)))
            view.on("request", lambda request: asked.append(request.url))
            view.goto(f"file://{tmp_path}/page.html")
            links = view.locator("nav a")
            assert links.count() == count
            for place in {0, 1, count - 1}:
                links.nth(place).click()
                assert view.locator(".story.open").count() == 1
                assert view.locator(f"#story-{place + 1}").is_visible()
            assert view.locator(".story.open h3 [lang=zh]").first.is_visible()
            view.click("#language")
            assert view.locator(".story.open h3 [lang=en]").first.is_visible()
            if count == 2:
                view.fill("#search", "#40")
                assert view.locator("#frames tr:visible").count() == 1
            view.click("#theme")
            assert not wrong
            assert asked == [f"file://{tmp_path}/page.html"]
        finally:
            browser.close()
