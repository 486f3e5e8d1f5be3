"""The page of `diagnose --html` in real browsers: it opens on the problems, with all that the command has found.

And the examples on pages for users that write such a page. What it must not do: test the page itself; that is
`test_web_page.py`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import can
import page_examples
import pytest
from bench_captures import capture_lines
from captures import EDS, SAMPLES, eds_options
from conftest import Runner
from diagnoses import diagnosed
from page_examples import PAGES, blocks
from test_diagnosis import lost
from test_web import WASM, WEB
from test_web_page import CHECKED, NO_CHROMIUM, NO_FIREFOX, opened, text
from web_browsers import Browser, chromium, firefox

from canalyze import open as open_capture

PROBLEMS = SAMPLES / "problems.log"
HOSTILE = "</script><script>window.hacked=1</script><img src=x onerror='window.hacked=2'>"
SHOWN = 'return [...document.querySelectorAll(".problem .words")].map((one) => one.textContent)'

pytestmark = [
    pytest.mark.skipif(WEB == "later", reason="tested when the core is built for the web"),
    pytest.mark.skipif(WEB != "required" and not WASM.exists(), reason="the core is not built for the web: .ci/web"),
]


@pytest.fixture(
    scope="module", params=[pytest.param("chromium", marks=NO_CHROMIUM), pytest.param("firefox", marks=NO_FIREFOX)]
)
def browser(request: pytest.FixtureRequest) -> Iterator[Browser]:
    with (chromium if request.param == "chromium" else firefox)() as one:
        one.size(1300, 900)
        yield one


@pytest.mark.parametrize("page", [page for page in PAGES if any(one.writes_page for one in blocks(page.read_text()))])
def test_examples_that_write_a_page_run(page: Path) -> None:
    assert page_examples.rewritten(page) == page.read_text(encoding="utf-8"), "run: python tests/regenerate.py pages"


def test_it_opens_on_the_problem_in_both_languages(browser: Browser, canalyze: Runner, tmp_path: Path) -> None:
    assert canalyze("diagnose", str(PROBLEMS), "--html", "page.html", "--lang", "zh").code == 0
    opened(browser, tmp_path / "page.html")
    for lang in ("zh", "en"):
        found = diagnosed(PROBLEMS.read_bytes(), lang=lang)
        assert browser.run("return document.documentElement.lang") == lang
        assert text(browser, "#verdict") == found.whole["verdict"]["text"]
        assert browser.run(SHOWN) == [one["message"] for one in found.incidents]
        first = next(one for one in found.incidents if one["id"] == found.whole["order"][0])
        browser.wait(f'document.querySelector(".row.chosen")?.dataset.frame === "{first["begin"]["frame"]}"')
        assert browser.run("return document.querySelector(arguments[0]).open", f"#problem-{first['id']}")
        assert all(line in text(browser, f"#problem-{first['id']}") for line in first["checks_left"])
        if lang == "zh":
            browser.run('document.body.dataset.state = ""')
            browser.click("#language")
            browser.wait(CHECKED)


def test_it_opens_on_the_problem_that_is_asked_for(browser: Browser, canalyze: Runner, tmp_path: Path) -> None:
    found = diagnosed(PROBLEMS.read_bytes())
    first, *others = found.whole["order"]
    other = next(one for one in found.incidents if one["id"] == others[0])
    assert canalyze("diagnose", str(PROBLEMS), "-n", str(other["id"]), "--html", "page.html", "--lang", "en").code == 0
    opened(browser, tmp_path / "page.html")
    browser.wait(f'document.querySelector(".row.chosen")?.dataset.frame === "{other["begin"]["frame"]}"')
    assert browser.run("return document.querySelector(arguments[0]).open", f"#problem-{other['id']}")
    browser.run('document.body.dataset.state = ""')
    browser.choose("#file", PROBLEMS)
    browser.wait(CHECKED)
    begin = next(one for one in found.incidents if one["id"] == first)["begin"]["frame"]
    browser.wait(f'document.querySelector(".row.chosen")?.dataset.frame === "{begin}"')


def test_all_problems_are_there_in_their_order(browser: Browser, canalyze: Runner, tmp_path: Path) -> None:
    """Of many buses, on half of which the node comes back: by the status, then by what the core holds for important."""
    one = lost(20).splitlines(keepends=True)
    back = [line for line in lost(40).splitlines(keepends=True) if b" 705#" in line][30:]
    lines = ((line, bus) for bus in range(60) for line in (one if bus % 2 else sorted({*one, *back})))
    capture = b"".join(sorted(line.replace(b" can0 ", b" can%d " % bus) for line, bus in lines))
    (tmp_path / "many.log").write_bytes(capture)
    assert canalyze("diagnose", "many.log", "--html", "page.html", "--lang", "en").code == 0
    found = diagnosed(capture)
    states = {one["id"]: one["status"] for one in found.incidents}
    assert len(states) == 60 and set(states.values()) == {"open", "ended"}
    opened(browser, tmp_path / "page.html")
    shown = browser.run('return [...document.querySelectorAll(".problem")].map((one) => Number(one.id.slice(8)))')
    assert shown == sorted(found.whole["order"], key=lambda number: states[number] != "open")
    last = shown[-1]
    browser.click(f"#problem-{last} summary")
    browser.wait(f'document.querySelector("#problem-{last} .steps")')


def test_descriptions_are_inside(browser: Browser, canalyze: Runner, tmp_path: Path) -> None:
    capture = SAMPLES / "network" / "sync-and-pdos.log"
    options = eds_options(capture)
    assert options and canalyze("diagnose", str(capture), *options, "--html", "page.html").code == 0
    with_names, without = (
        {json.loads(line)["signal"] for line in canalyze("signals", str(capture), "--format", "jsonl", *given).lines}
        for given in (options, ())
    )
    names = with_names - without
    assert names
    opened(browser, tmp_path / "page.html")
    browser.click('[data-panel="plots"]')
    browser.wait('document.querySelector("#plots label, #plots .signals p")', 30)
    shown = text(browser, "#plots .signals")
    assert any(name in shown for name in names)


def test_recordings_are_listed(browser: Browser, canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "lost.log").write_bytes(lost(20))
    well = SAMPLES / "rules" / "HBT002.clean.log"
    assert canalyze("diagnose", str(well), "lost.log", "--html", "page.html", "--lang", "en").code == 0
    opened(browser, tmp_path / "page.html")
    browser.wait('document.body.dataset.state === "index"')
    listed = browser.run('return [...document.querySelectorAll("#index .frame")].map((one) => one.textContent)')
    assert listed == ["lost.log", "HBT002.clean.log"], "the worst first"


def test_hostile_names_execute_nothing(browser: Browser, canalyze: Runner, tmp_path: Path) -> None:
    """Of the file and of objects in a description."""
    name = "<img src=x onerror=window.hacked=4>.log"
    (tmp_path / name).write_bytes(lost(20))
    eds = (EDS / "drive.eds").read_text().replace("ParameterName=", f"ParameterName={HOSTILE}")
    (tmp_path / "hostile.eds").write_text(eds)
    assert canalyze("diagnose", name, "--eds", "5=hostile.eds", "--html", "page.html", "--lang", "en").code == 0
    assert "window.hacked" in (tmp_path / "page.html").read_text()
    opened(browser, tmp_path / "page.html")
    assert "onerror" in text(browser, "#name")
    executes_nothing(browser)


def test_hostile_buses_execute_nothing(browser: Browser, tmp_path: Path) -> None:
    buses = ("can0", HOSTILE)
    messages = [
        can.Message(timestamp=beat / 10, arbitration_id=0x705, data=[5], is_extended_id=False, channel=bus)
        for beat in range(1, 60)
        for bus in buses
        if bus == "can0" or beat < 20
    ]
    (tmp_path / "page.html").write_text(open_capture(messages).html())
    opened(browser, tmp_path / "page.html")
    assert "onerror" in text(browser, "#problems")
    executes_nothing(browser)


def executes_nothing(browser: Browser) -> None:
    """Look at all that the page shows."""
    assert browser.run("return document.body.dataset.state") == "opened"
    for panel in ("nodes", "objects", "findings", "plots"):
        browser.click(f'[data-panel="{panel}"]')
        browser.wait(f'document.querySelector("#{panel}").childElementCount')
    assert browser.run("return window.hacked ?? null") is None
    assert browser.run('return document.querySelectorAll("img").length') == 0


@NO_CHROMIUM
def test_a_million_frames_are_inside(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "million.log").write_text("".join(f"{line.rstrip()}\n" for line in capture_lines(1_000_000)))
    assert canalyze("diagnose", "million.log", "--html", "page.html", "--lang", "en").code == 0
    assert (tmp_path / "page.html").stat().st_size < 45_000_000
    with chromium() as browser:
        opened(browser, tmp_path / "page.html")
        assert browser.run("return document.body.dataset.state") == "opened"
        assert "1000000 frames" in text(browser, "#extent")
