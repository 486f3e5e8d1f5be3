"""`diagnose --html`: one page that loads nothing, with everything escaped, in both languages, in a real browser.

What it must not do: test what is diagnosed.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from copy import deepcopy
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from captures import Row
from conftest import Runner, command, environment
from diagnoses import diagnosed
from test_diagnosis import lost

from canalyze.reports.diagnosis_axis import axis_of, shortened
from canalyze.reports.diagnosis_html import MOST, Told, page
from canalyze.reports.diagnosis_lanes import PLOTS, Beside, Lane, Plot
from canalyze.values import nanoseconds

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
        whole: dict[str, Any] = {**one.whole, "nature": "canopen", "order": list(range(1, count + 1))}
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
    assert canalyze("-", "--html", "-", stdin=lost(20)).code == 2
    assert canalyze("--html", "other.html", "--lang", "en", stdin=lost(20)).code == 0
    assert "node 5" in (tmp_path / "other.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("form", ["text", "jsonl"])
def test_the_page_is_written_though_nobody_reads_the_text(form: str, tmp_path: Path) -> None:
    (tmp_path / "lost.log").write_bytes(lost(20))
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "wb") as gone:
        line = command("lost.log", "--html", "page.html", "--format", form, "--fail-on", "open")
        done = subprocess.run(line, cwd=tmp_path, env=environment(), stdout=gone, stderr=subprocess.PIPE, check=False)
    assert (done.returncode, done.stderr) == (1, b"")
    assert not Parsed((tmp_path / "page.html").read_text()).open


def beside(lang: str, begin: int, text: str = "") -> Beside:
    """States and values as the core has them; begin: of the capture, in ns."""
    node = (text or None, 5)
    state = {"zh": "操作", "en": "Operational"}[lang] + text
    lanes = [Lane("nmt", node, 0, [(begin, state, "operational"), (begin + 2_000_000_000, None, None)])]
    points = [(begin + one * 100_000_000, float(one % 7)) for one in range(20)]
    return Beside(lanes, {1: [Plot(f"5.TPDO1 {lang}{text}", node, "mm", points)]}, [])


def with_beside(text: str = "") -> dict[str, Told]:
    return {
        lang: replace(one, beside=beside(lang, nanoseconds(one.whole["begin"]) or 0, text))
        for lang, one in told(text=text).items()
    }


def test_states_and_values_are_drawn_in_both_languages() -> None:
    one = with_beside()
    text = page(one, "a.log", "zh").decode()
    assert not Parsed(text).open
    assert text.count("<svg ") == 3
    assert 'class="state s-operational"' in text and ">操作</text>" in text and ">Operational</text>" in text
    assert "5.TPDO1 zh mm" in text and "5.TPDO1 en mm" in text


def test_names_of_states_and_values_are_escaped() -> None:
    text = page(with_beside(HOSTILE), "a.log", "en").decode()
    assert not any(tag == "img" for tag, _ in Parsed(text).seen)


def test_all_frames_may_be_in_it_beyond_the_limit() -> None:
    lines = dict.fromkeys(range(1, 40001), f"can0 {HOSTILE}\n#   note")
    one = {lang: replace(each, every=lines) for lang, each in told().items()}
    text = page(one, "a.log", "en").decode()
    assert len(text) > MOST and "#   note" in text
    assert [tag for tag, _ in Parsed(text).seen].count("script") == 1
    assert 'id="frame-39"' in text, "what is printed stays"


def test_the_axis_shows_where_something_happened() -> None:
    one = told()["en"]
    start = int(float(one.incidents[0]["begin"]["t"]))
    far = {"begin": f"{start - 5000}", "end": f"{start + 5000}"}
    over = [{**each, "end": each["noticed"], "status": "ended"} for each in one.incidents]
    axis = axis_of(over, far)
    assert axis is not None and axis.end_ns - axis.begin_ns < 60_000_000_000
    assert 2 <= len(list(axis.ticks())) <= 12
    assert axis_of([], far) is None
    assert axis_of(one.incidents, {"begin": None, "end": None}) is None


@pytest.mark.parametrize(("room", "said"), [(200, "Operational"), (40, "Oper…"), (5, "")])
def test_a_line_is_cut_to_its_room(room: int, said: str) -> None:
    found = shortened("Operational", room)
    assert found == said or (said.endswith("…") and found.endswith("…"))


def test_a_recorded_story(canalyze: Runner, tmp_path: Path) -> None:
    """Drives, their states, the limit of a heartbeat consumer: of sessions that the network makes."""
    for name in ("drive-fault.log", "node-lost.log", "node-restarted.log"):
        assert canalyze("examples", ".").code in (0, 2)
        assert canalyze(name, "--html", f"{name}.html").code == 0
        text = (tmp_path / f"{name}.html").read_text()
        assert not Parsed(text).open
        assert len(text) < MOST
        assert "s-operational" in text
    assert 's-fault"' in (tmp_path / "drive-fault.log.html").read_text()
    assert re.search(r"\+\d+ ms \(1016h \d+ ms\)", (tmp_path / "node-lost.log.html").read_text())


def test_frames_need_a_page(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "lost.log").write_bytes(lost(20))
    assert canalyze("lost.log", "--frames", "all").code == 2
    assert canalyze("lost.log", "--frames", "all", "--html", "page.html").code == 0
    assert 'id="every-en"' in (tmp_path / "page.html").read_text()


def test_what_stands_is_told_in_full_where_there_is_no_room_for_all() -> None:
    text = page(told(1000), "a.log", "en").decode()
    first, last = (text.split(f'<article id="problem-{number}"')[1].split("</article>")[0] for number in (1, 1000))
    assert 'class="steps"' in first and 'class="checks"' in first
    assert 'class="steps"' not in last and "<h3>" in last


def test_a_lane_that_flaps_is_short() -> None:
    begin = nanoseconds(told()["en"].whole["begin"]) or 0
    changes = [(begin + one * 10_000, str(one % 2), "operational") for one in range(50_000)]
    changes[30_000] = (changes[30_000][0], "gone", "lost")
    one = {
        lang: replace(each, beside=Beside([Lane("nmt", (None, 5), 0, list(changes))], {}, []))
        for lang, each in told().items()
    }
    assert len(page(one, "a.log", "en")) < 120_000


def test_few_values_are_drawn() -> None:
    plots = [Plot(f"5.TPDO1 {number}", (None, 5), None, [(0, 0.0), (10**9, 1.0)]) for number in range(40)]
    one = {lang: replace(each, beside=Beside([], {1: plots}, [])) for lang, each in told().items()}
    assert page(one, "a.log", "en").decode().count('class="line" d=') == PLOTS


def test_a_plot_keeps_what_stands_out() -> None:
    plot = Plot("5.TPDO1 x", (None, 5), None)
    for number in range(100_000):
        plot.add(number, 9.0 if number == 77_777 else float(number % 2))
    assert len(plot.points) < 1000
    assert max(value for _, value in plot.points) == 9.0
    assert plot.points == sorted(plot.points) and plot.points[-1][0] == 99_999


@pytest.mark.skipif(BROWSER is None, reason="there is no Chromium here")
def test_all_frames_in_a_browser(tmp_path: Path) -> None:
    api = pytest.importorskip("playwright.sync_api")
    lines = {number: f"can0 705 [1] 05 # line {number}\n#   note {number}" for number in range(1, 5001)}
    one = {lang: replace(each, every=lines) for lang, each in told().items()}
    (tmp_path / "page.html").write_bytes(page(one, "a.log", "en"))
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        try:
            view = browser.new_page()
            wrong: list[str] = []
            view.on("console", lambda message: wrong.append(message.text))
            view.on("pageerror", lambda error: wrong.append(str(error)))
            view.goto(f"file://{tmp_path}/page.html")
            rows = view.locator("#rows div")
            assert 5 < rows.count() < 100, "only what can be seen is in the page"
            assert "line 1" in rows.first.inner_text()
            view.fill("#search", "note 4321")
            assert view.locator("#found").inner_text() == "1"
            assert "line 4321" in rows.first.inner_text()
            view.locator('.story.open a[href="#frame-39"]').first.click()
            assert "line 39" in view.locator("#rows .goal").first.inner_text()
            view.click("#language")
            assert rows.count() > 5
            view.evaluate("document.getElementById('every').scrollTop = 1e9")
            view.wait_for_function("document.getElementById('rows').textContent.includes('note 5000')")
            assert not wrong
        finally:
            browser.close()


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
                assert view.locator(f"#problem-{place + 1}").is_visible()
            assert view.locator(".story.open h3 [lang=zh]").first.is_visible()
            view.click("#language")
            assert view.locator(".story.open h3 [lang=en]").first.is_visible()
            if count == 2:
                view.fill("#search", "#40")
                assert view.locator("#frames tr:visible").count() == 1
            view.click("#theme")
            if count == 2:
                assert len(re.findall(rb"/Type /Page\b", view.pdf(prefer_css_page_size=True))) <= 2
                shown = view.evaluate("getComputedStyle(document.body).backgroundColor")
                view.emulate_media(media="print")
                assert view.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)", shown
            assert not wrong
            assert asked == [f"file://{tmp_path}/page.html"]
        finally:
            browser.close()
