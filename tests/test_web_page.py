"""The page in real browsers, opened from the disk: what is dropped on it, chosen, filtered, explained and saved.

What it must not do: test what the core says; that is `test_web.py`.
"""

from __future__ import annotations

import base64
import bz2
import gzip
import json
import lzma
import os
import random
import re
import shutil
import sqlite3
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any

import pytest
import zstandard
from bench_captures import capture_lines
from captures import EDS, SAMPLES, TESTS, held, log_text, read_log, session_output
from conftest import Runner
from diagnoses import diagnosed
from test_web import WASM, WEB, described
from web_browsers import CHROMEDRIVER, CHROMIUM, FIREFOX, Browser, Chromium, chromium, firefox

from canalyze import _core, html
from canalyze.configuration.network import Description, Known, network, network_rows
from canalyze.running.reading import SessionOptions

PROBLEMS = SAMPLES / "problems.log"
TSC = shutil.which("tsc")
HOSTILE = '</script><script>window.hacked=1</script><img src=x onerror="window.hacked=2">'
STEPS = (TESTS / "web" / "steps.js").read_text(encoding="utf-8")
LOADED: set[str] = set()
"""The pages that tests have opened."""
CHECKED = 'document.body.dataset.state === "opened"'

pytestmark = [
    pytest.mark.skipif(WEB == "later", reason="tested when the core is built for the web"),
    pytest.mark.skipif(WEB != "required" and not WASM.exists(), reason="the core is not built for the web: .ci/web"),
]
NO_CHROMIUM = pytest.mark.skipif(not (CHROMIUM and CHROMEDRIVER) and WEB != "required", reason="no chromium here")
NO_FIREFOX = pytest.mark.skipif(not FIREFOX and WEB != "required", reason="no firefox here")


@pytest.fixture(scope="module")
def empty(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page without a capture, in English."""
    path = tmp_path_factory.mktemp("page") / "canalyze.html"
    path.write_bytes(html.page("en", {}))
    return path


@pytest.fixture(scope="module")
def chromium_browser() -> Iterator[Chromium]:
    with chromium() as one:
        yield one


@pytest.fixture(
    scope="module", params=[pytest.param("chromium", marks=NO_CHROMIUM), pytest.param("firefox", marks=NO_FIREFOX)]
)
def browser(request: pytest.FixtureRequest) -> Iterator[Browser]:
    if request.param == "chromium":
        yield request.getfixturevalue("chromium_browser")
    else:
        with firefox() as one:
            one.size(1300, 900)
            yield one


def step(browser: Browser, name: str, *given: Any) -> Any:
    """Call a function of `web/steps.js` in the page; give what it returns."""
    return browser.run(f"{STEPS}\nreturn {name}(...arguments);", *given)


def opened(browser: Browser, page: Path, *captures: Path) -> None:
    """Open the page and a capture in it."""
    browser.open(page)
    LOADED.add(page.as_uri())
    if captures:
        browser.choose("#file", *captures)
    browser.wait('["opened", "failed", "index"].includes(document.body.dataset.state)', 60)


def again(browser: Browser, *files: Path) -> None:
    """Choose further files in the page that is open."""
    browser.run('document.body.dataset.state = ""')
    browser.choose("#file", *files)
    browser.wait('["opened", "failed", "index"].includes(document.body.dataset.state)', 60)


def described_for(browser: Browser, name: str, nodes: str) -> None:
    """Type the nodes of a description."""
    step(browser, "describe", name, nodes)


def saved(browser: Browser, form: str) -> tuple[str, str]:
    """Save what is shown; give the file's name and its text."""
    return saved_by(browser, lambda: step(browser, "save", form))


def saved_by(browser: Browser, act: Callable[[], object]) -> tuple[str, str]:
    """Do something that saves a file; give its name and its text."""
    step(browser, "keepSaved")
    act()
    browser.wait("window.saved !== null")
    return browser.run("return window.named"), browser.run("return window.saved")


def text(browser: Browser, selector: str) -> str:
    found: str = browser.run("return document.querySelector(arguments[0]).innerText", selector)
    return found


def rows(browser: Browser) -> list[int]:
    """The numbers of the frames that are drawn."""
    found: list[int] = browser.wait(
        '[...document.querySelectorAll(".row[data-frame]")].map((row) => Number(row.dataset.frame))'
    )
    return found


def filtered(browser: Browser, expression: str) -> str:
    """Type a filter; give what is said of it."""
    step(browser, "filter", expression)
    said = 'document.querySelector("#filter output").textContent'
    browser.wait(f'{said} && !{said}.startsWith("reading")', 30)
    found: str = browser.run(f"return {said}")
    return found


def test_a_page_is_one_file_that_loads_nothing(empty: Path) -> None:
    said = empty.read_text()
    assert len(said.encode()) < 2_200_000
    policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', said)
    assert policy and policy[1].startswith("default-src 'none'; script-src 'sha256-")
    assert "'unsafe-" not in policy[1] and "http" not in policy[1]
    assert not re.search(r'\s(src|href|on\w+)="', said)
    assert not re.search(r"\b(fetch|XMLHttpRequest|WebSocket|EventSource|importScripts|innerHTML)\b|\beval\(", said)


CONFIGURATIONS = {"page": html.PAGE, "worker": html.WORKER}


@pytest.mark.parametrize("part", CONFIGURATIONS)
def test_types_are_checked_of_every_file(part: str) -> None:
    """As the configuration for TypeScript's compiler says; run where there is one."""
    path = TESTS / "web" / f"tsconfig.{part}.json"
    files = [Path(name) for name in json.loads(path.read_text())["files"]]
    assert [one.stem for one in files] == list(CONFIGURATIONS[part])
    assert {one.name for one in files} == {one.name for one in (html.FOLDER / part).glob("*.js")}
    if TSC is not None:
        done = subprocess.run([TSC, "-p", path], capture_output=True, text=True, check=False)
        assert (done.returncode, done.stdout) == (0, "")


def test_what_is_dropped_is_diagnosed(browser: Browser, empty: Path) -> None:
    browser.open(empty)
    step(browser, "drop", "problems.log", base64.b64encode(PROBLEMS.read_bytes()).decode())
    browser.wait(CHECKED)
    found = diagnosed(PROBLEMS.read_bytes())
    shown = step(browser, "texts", ".problem .words")
    assert shown == [one["message"] for one in found.incidents]
    assert text(browser, "#verdict") == found.whole["verdict"]["text"] == "✖ 1 open problem, 1 ended, 1 harmless"
    assert text(browser, "#extent").startswith(found.whole["extent"])
    browser.wait('document.querySelectorAll(".problem .steps").length === document.querySelectorAll(".problem").length')
    for one in found.incidents:
        said = browser.run("return document.querySelector(arguments[0]).textContent", f"#problem-{one['id']}")
        wanted = [*one["checks_left"], *(one["texts"][key] for key in ("because", "why", "delay", "repeats"))]
        assert all(line in said for line in wanted), one["id"]
    browser.click('[data-panel="nodes"]')
    shown = browser.run('return [...document.querySelectorAll("#nodes tr")].map((row) => row.innerText.split("\\t"))')
    assert [[cell.strip() for cell in row] for row in shown] == [one["cells"] for one in found.whole["nodes"]]


def test_a_healthy_capture_says_what_was_looked_at(browser: Browser, empty: Path) -> None:
    capture = SAMPLES / "rules" / "HBT002.clean.log"
    opened(browser, empty, capture)
    whole = diagnosed(capture.read_bytes()).whole
    assert text(browser, "#verdict") == whole["verdict"]["text"]
    shown = f"{text(browser, '#notice')}\n{text(browser, '#problems')}"
    said = [line for line in (whole["notice"] or whole["looked"], whole["loose_text"]) if line]
    assert said and all(line in shown for line in said)


def test_a_problem_leads_to_its_frame_and_its_explanation(browser: Browser, empty: Path) -> None:
    opened(browser, empty, PROBLEMS)
    browser.click("#problem-2 .frame")
    browser.wait('document.querySelector(".row.chosen")?.dataset.frame === "134"')
    explained = session_output([PROBLEMS.read_bytes()], lang="en", depth="explain").decode()
    browser.wait('document.querySelector("#detail pre")?.textContent.includes("COB-ID")')
    lines = text(browser, "#detail pre").splitlines()
    assert len(lines) > 2 and all(line.rstrip() in explained for line in lines)
    assert browser.run('return document.querySelector("#problem-2").open')
    assert "caused by 1" in text(browser, "#problem-2") and "1029h" in text(browser, "#problem-2")
    assert browser.run('return document.querySelectorAll(".row.marked").length') > 1


def test_frames_are_filtered_as_on_the_command_line(browser: Browser, empty: Path, canalyze: Runner) -> None:
    opened(browser, empty, PROBLEMS)
    for expression in ("node=4", "service=sdo node=5", "severity=error", 'text="boot-up" node=3'):
        done = canalyze("decode", str(PROBLEMS), "--format", "jsonl", "--filter", expression, "--lang", "en")
        records = [json.loads(line) for line in done.lines]
        numbers = [one["frame"] for one in records if one["kind"] == "frame"]
        assert filtered(browser, expression) == f"{len(numbers)} {'frame' if len(numbers) == 1 else 'frames'}"
        drawn = rows(browser)
        first = numbers.index(drawn[0])
        assert len(drawn) > 1 and drawn == numbers[first : first + len(drawn)]
    assert filtered(browser, "LIFE GUARD error") == "1 frame" and rows(browser) == [134]
    assert "nonsense" in filtered(browser, "nonsense=1")
    assert browser.run('return document.querySelector("#filter output").className') == "wrong"
    browser.click("#all")
    browser.wait('document.querySelector("#filter output").textContent === "175 frames"')
    assert browser.run('return document.querySelector("#filter input").value') == ""
    assert browser.run('return document.querySelector("#all").hidden')
    assert filtered(browser, "node=5") != filtered(browser, "") == "175 frames"
    step(browser, "ask", "#150")
    browser.wait('document.querySelector(".row.chosen")?.dataset.frame === "150"')


def test_both_languages_are_a_switch_away(browser: Browser, empty: Path) -> None:
    opened(browser, empty, PROBLEMS)
    browser.wait('document.querySelector(".row.chosen")?.dataset.frame === "126"')
    browser.run('document.body.dataset.state = ""')
    browser.click("#language")
    browser.wait(CHECKED)
    found = diagnosed(PROBLEMS.read_bytes(), lang="zh")
    shown = step(browser, "texts", ".problem .words")
    assert shown == [one["message"] for one in found.incidents]
    browser.wait('document.querySelector(".row.chosen")?.dataset.frame === "126"')
    browser.wait('document.querySelector("#detail pre")?.textContent.includes("节点9的心跳")')
    assert browser.run("return document.documentElement.lang") == "zh"
    shown = browser.run("return document.body.innerText")
    assert not re.search(r"\b(html|diagnose|problem)(_\w+)?\.\w+", shown), "a word that is missing"


ABBREVIATIONS = re.compile(
    r"(?<![A-Za-z])(ASC|BLF|Boot|CAN|COB|CSV|DCF|EDS|EMCY|English|FEh|FFh|Fh|ID|INTEGER|JSON|MCAP|NMT|PDO|RPDO|RTR|SDO"
    r"|STRING|Shutdown|TPDO|TRC|UNSIGNED|VISIBLE|XDD|candump|canalyze|gzip|ms|pcap|pcapng|rpm|rw|ro|wo|up|zstd)(?![A-Za-z])"
)
"""What is Latin in Chinese sentences, too."""
FILTERS = re.compile(r"--filter .*|node=5 service=sdo")


def test_a_chinese_page_has_no_english_word(browser: Browser, tmp_path: Path) -> None:
    """In any panel, lane or button; names of files, buses and devices are those of the capture."""
    page = tmp_path / "zh.html"
    page.write_bytes(html.page("zh", {}))
    browser.open(page)
    LOADED.add(page.as_uri())
    step(browser, "keepDrawn")
    shown = [browser.run("return document.body.innerText")]
    capture = SAMPLES / "network" / "sync-and-pdos.log"
    again(browser, capture)
    for panel in ("problems", "nodes", "transfers", "objects", "findings", "plots"):
        browser.click(f'[data-panel="{panel}"]')
        if panel in ("transfers", "objects", "plots"):
            browser.wait(f'document.querySelectorAll("#{panel} td, #{panel} label").length')
        shown.append(browser.run("return document.body.innerText"))
    browser.wait('window.drawn.some((text) => text.startsWith("NMT"))')
    lanes = browser.run("return window.drawn")
    assert any(text.startswith("驱动器 节点5") for text in lanes)
    assert not any(re.match(r"(nmt|drive|sdo|emcy|value)\b", text) for text in lanes)
    for tag in ("title", "placeholder", "aria-label"):
        shown += step(browser, "attributes", tag)
    said = "\n".join([*shown, *lanes]).replace(capture.name, "").replace("vcan0", "")
    assert set(re.findall(r"[A-Za-z]{2,}", ABBREVIATIONS.sub("", FILTERS.sub("", said)))) == set()


def test_keys_move_through_frames_and_problems(browser: Browser, empty: Path) -> None:
    opened(browser, empty, PROBLEMS)
    browser.run("document.activeElement.blur()")
    browser.wait('document.querySelector(".row.chosen")?.dataset.frame === "126"')
    for key, frame in (("n", 134), ("n", 138), ("p", 134), ("p", 126), ("j", 127), ("j", 128), ("k", 127)):
        browser.key(key)
        browser.wait(f'document.querySelector(".row.chosen")?.dataset.frame === "{frame}"')
    browser.key("/")
    assert browser.run('return document.activeElement.closest("form").id') == "filter"


def test_tables_are_searched_and_lead_to_frames(browser: Browser, empty: Path) -> None:
    capture = SAMPLES / "services.log"
    opened(browser, empty, capture)
    rows_of = [
        json.loads(one) for one in session_output([capture.read_bytes()], output_format="transfers").splitlines()
    ]
    browser.click('[data-panel="transfers"]')
    browser.wait('document.querySelectorAll("#transfers tbody tr").length')
    assert browser.run('return document.querySelectorAll("#transfers tbody tr").length') == min(len(rows_of), 100)
    browser.run('document.querySelector("#transfers tbody tr").click()')
    # The frame that the page opens on has its buttons there until then.
    browser.wait('document.querySelector("#detail").textContent.includes("only this transfer")')
    browser.run('document.querySelector("#detail .actions button").click()')
    browser.wait('/^[0-9]+ frame/.test(document.querySelector("#filter output").textContent)')
    first = rows_of[0]
    assert browser.run('return document.querySelector("#filter input").value').startswith(
        f"service=sdo node={first['node']} frame="
    )
    browser.click('[data-panel="objects"]')
    browser.wait('document.querySelectorAll("#objects tbody tr").length')
    session = _core.Session(SessionOptions(format="columns", tables=("od",)))
    session.begin(capture.name, True)
    session.feed(capture.read_bytes())
    session.finish()
    count = sum(batch.num_rows for _, batch in session.batches(flush=True))
    assert text(browser, "#objects .quiet") == f"{count} of {count} rows"
    step(browser, "searchObjects", "no such object")
    browser.wait('document.querySelectorAll("#objects tbody tr").length === 0')
    browser.click('[data-panel="nodes"]')
    assert browser.run('return document.querySelectorAll("#nodes tr").length') == len(
        diagnosed(capture.read_bytes()).whole["nodes"]
    )


def test_signals_are_drawn(browser: Browser, empty: Path) -> None:
    capture = SAMPLES / "stories" / "c01-boot-and-run.log"
    signals = [json.loads(one) for one in session_output([capture.read_bytes()], output_format="signals").splitlines()]
    assert signals, "a capture with mappings in it"
    opened(browser, empty, capture)
    browser.click('[data-panel="plots"]')
    browser.wait('document.querySelector("#plots input[type=checkbox]")', 60)
    browser.run('document.querySelector("#plots input[type=checkbox]").click()')
    browser.wait('document.querySelector("#plots canvas")?.width > 0')
    end = time.monotonic() + 20
    while step(browser, "plotted") < 50:
        assert time.monotonic() < end, "nothing is drawn"
        time.sleep(0.05)


def test_lanes_lead_to_frames_and_zoom(browser: Browser, empty: Path) -> None:
    opened(browser, empty, PROBLEMS)
    browser.wait('document.querySelector(".row.chosen")')
    step(browser, "pressLanes", 600, 90)
    browser.wait('document.querySelector(".row.chosen")?.dataset.frame !== "126"')
    middle = int(browser.run('return document.querySelector(".row.chosen").dataset.frame'))
    assert 20 < middle < 160
    step(browser, "pressLanes", 600, 44)
    browser.wait('document.querySelector("#problem-2.chosen")')


@pytest.mark.parametrize("packed", ["gzip", "zstd", "utf-16"])
def test_packed_and_recoded_captures_are_read(packed: str, browser: Browser, empty: Path, tmp_path: Path) -> None:
    data = PROBLEMS.read_bytes()
    path = tmp_path / "capture.bin"
    forms = {"gzip": gzip.compress(data), "zstd": zstandard.compress(data), "utf-16": data.decode().encode("utf-16")}
    path.write_bytes(forms[packed])
    opened(browser, empty, path)
    assert text(browser, "#verdict") == "✖ 1 open problem, 1 ended, 1 harmless"


def test_damage_is_reported(browser: Browser, empty: Path, tmp_path: Path) -> None:
    whole = gzip.compress(
        b"".join(f"(1.{n:06}) can0 7{n % 100 + 1:02X}#{n % 256:02X}\n".encode() for n in range(200_000))
    )
    (tmp_path / "cut.log.gz").write_bytes(whole[: len(whole) // 2])
    opened(browser, empty, tmp_path / "cut.log.gz")
    assert "packed data are damaged" in text(browser, "#notice")
    (tmp_path / "flipped.log.zst").write_bytes(
        b"".join((zstandard.compress(PROBLEMS.read_bytes()), b"\x28\xb5\x2f\xfd nonsense"))
    )
    opened(browser, empty, tmp_path / "flipped.log.zst")
    assert "packed data are damaged" in text(browser, "#notice") and "175 frames" in text(browser, "#extent")
    (tmp_path / "lines.log").write_bytes(PROBLEMS.read_bytes() + b"(1.0) can0 nothing#\n")
    opened(browser, empty, tmp_path / "lines.log")
    assert "lines.log" in text(browser, "#notice")


def test_a_file_that_it_cannot_read_is_named(browser: Browser, empty: Path, tmp_path: Path) -> None:
    with sqlite3.connect(tmp_path / "a.db") as base:
        base.execute("create table a (b)")
    base.close()
    opened(browser, empty, tmp_path / "a.db")
    assert browser.run("return document.body.dataset.state") == "failed"
    wanted = (
        "a.db: this page cannot read SQLite; convert it first with the command line: canalyze convert a.db capture.log"
    )
    assert text(browser, "#notice") == wanted
    data = PROBLEMS.read_bytes()
    (tmp_path / "it's.log.xz").write_bytes(lzma.compress(data))
    (tmp_path / "a.log.bz2").write_bytes(bz2.compress(data))
    (tmp_path / "a.mf4").write_bytes(b"MDF     4.11" + bytes(100))
    for name, said in (
        ("it's.log.xz", "cannot unpack xz; unpack it first, with 7-Zip or xz -dk 'it'\\''s.log.xz'"),
        ("a.log.bz2", "cannot unpack bzip2; unpack it first, with 7-Zip or bzip2 -dk a.log.bz2"),
        ("a.mf4", "cannot read MF4; convert it first with the command line: canalyze convert a.mf4 capture.log"),
    ):
        again(browser, tmp_path / name)
        assert text(browser, "#notice") == f"{name}: this page {said}"
        assert not browser.run('return document.querySelector("#drop").hidden')
    browser.run('document.body.dataset.state = ""')
    browser.choose("#file", PROBLEMS)
    browser.wait(CHECKED)


def test_a_hostile_capture_executes_nothing(browser: Browser, tmp_path: Path) -> None:
    """In names of files and buses, in texts of transfers, with the capture inside the page."""
    value = HOSTILE.encode()
    frames = [b"(1.000000) %b 605#4008100000000000" % b"can0<img/src=x/onerror=alert(1)>"]
    frames.append(
        b"(1.000100) can0 605#4008100000000000\n(1.000200) can0 585#41081000%b"
        % len(value).to_bytes(4, "little").hex().encode()
    )
    for number, at in enumerate(range(0, len(value), 7)):
        part = value[at : at + 7]
        last = at + 7 >= len(value)
        head = (number % 2) << 4 | (7 - len(part)) << 1 | last
        frames.append(b"(1.%06d) can0 605#%02X00000000000000" % (1000 + 2 * number, 0x60 | (number % 2) << 4))
        frames.append(
            b"(1.%06d) can0 585#%b" % (1001 + 2 * number, (bytes([head]) + part.ljust(7, b"\0")).hex().encode())
        )
    page = tmp_path / "hostile.html"
    page.write_bytes(html.page("en", {}, [[held(f"{HOSTILE}\u202e.log", b"\n".join(frames) + b"\n")]]))
    opened(browser, page)
    assert browser.run("return document.body.dataset.state") == "opened"
    browser.click('[data-panel="transfers"]')
    browser.wait('document.querySelector("#transfers tbody tr")')
    assert "onerror" in text(browser, "#transfers") and "onerror" in text(browser, "#name")
    assert "\\u202e" in text(browser, "#name")
    browser.run('document.querySelector("#transfers tbody tr").click()')
    browser.wait('document.querySelector("#detail pre")?.textContent.includes("COB-ID")')
    assert browser.run("return window.hacked ?? null") is None
    assert browser.run('return document.querySelectorAll("img").length') == 0
    assert page.read_text().count("<script") == 7


def test_several_captures_are_listed(browser: Browser, empty: Path) -> None:
    opened(browser, empty, SAMPLES / "rules" / "HBT002.clean.log", PROBLEMS, SAMPLES / "sdo-abort.log")
    browser.wait('document.querySelectorAll("#index tr").length === 3')
    browser.wait('document.body.dataset.state === "index"')
    assert browser.run('return document.querySelector("#index .frame").textContent') == "problems.log"
    browser.click("#index .frame")
    browser.wait(CHECKED)
    assert text(browser, "#verdict").startswith("✖ 1 open problem")
    browser.click("#back")
    assert step(browser, "texts", "#index .frame") == [
        "problems.log",
        "sdo-abort.log",
        "HBT002.clean.log",
    ]
    assert browser.run('return document.querySelector("#main").hidden && document.querySelector("#back").hidden')
    browser.run('document.querySelectorAll("#index .frame")[2].click()')
    browser.wait(f'{CHECKED} && document.querySelector("#name").textContent === "HBT002.clean.log"')
    browser.click("#language")
    browser.wait('document.documentElement.lang === "zh"')
    browser.click("#back")
    browser.wait('document.body.dataset.state === "index"')
    assert "仍存在" in text(browser, "#index td")


def test_files_that_follow_one_another_are_one_capture(browser: Browser, empty: Path, tmp_path: Path) -> None:
    """As on the command line: by stamps of a calendar within 5 s, on the same bus."""
    lines = PROBLEMS.read_bytes().splitlines(keepends=True)
    middle = len(lines) // 2
    (tmp_path / "a.log").write_bytes(b"".join(lines[middle:]))
    (tmp_path / "b.log").write_bytes(b"".join(lines[:middle]))
    opened(browser, empty, tmp_path / "a.log", tmp_path / "b.log")
    assert browser.run("return document.body.dataset.state") == "opened"
    assert text(browser, "#name") == "b.log, a.log"
    assert text(browser, "#verdict") == "✖ 1 open problem, 1 ended, 1 harmless"
    late = b"".join(lines[middle:]).replace(b"(17000000", b"(17000900")
    (tmp_path / "a.log").write_bytes(late)
    browser.run('document.body.dataset.state = ""')
    browser.choose("#file", tmp_path / "a.log", tmp_path / "b.log")
    browser.wait('document.body.dataset.state === "index"')


def test_files_are_joined_by_time(browser: Browser, tmp_path: Path) -> None:
    lines = [line for line in PROBLEMS.read_bytes().splitlines(keepends=True) if line.startswith(b"(")]
    parts = [held(name, b"".join(lines[at::2])) for at, name in enumerate(("a.log", "b.log"))]
    page = tmp_path / "merged.html"
    page.write_bytes(html.page("en", {}, [parts], merge=True))
    opened(browser, page)
    assert text(browser, "#verdict") == "✖ 1 open problem, 1 ended, 1 harmless"
    assert "175 frames" in text(browser, "#extent")


def test_a_capture_inside_is_read_piece_by_piece(browser: Browser, tmp_path: Path) -> None:
    """Packed it is larger than what is read at once."""
    chance = random.Random(9)
    lines = [f"({n / 1000:.6f}) can0 181#{chance.randbytes(8).hex().upper()}\n" for n in range(120_001)]
    page = tmp_path / "large.html"
    page.write_bytes(html.page("en", {}, [[held("large.log", "".join(lines).encode())]]))
    assert page.stat().st_size > html.WASM.stat().st_size * 4 / 3 + 1_500_000
    opened(browser, page)
    assert "120001 frames" in text(browser, "#extent") and "damaged" not in text(browser, "#notice")
    browser.run('document.querySelector("#frames").scrollTop = 1e9')
    last = " ".join(re.findall("..", lines[-1].split("#")[1].strip()))
    browser.wait(f'[...document.querySelectorAll(".row .raw")].some((one) => one.textContent.includes("{last}"))')


def test_what_is_known_of_the_network_counts(browser: Browser, tmp_path: Path) -> None:
    """Names of a description, in a page with the capture inside."""
    capture = next(path for path in sorted((SAMPLES / "network").glob("*.log")) if described(path).descriptions)
    known = described(capture)
    page = tmp_path / "known.html"
    part = held(capture.name, capture.read_bytes())
    page.write_bytes(html.page("en", {"network": network_rows(Known(), known)}, [[part]]))
    opened(browser, page)
    session = _core.Session(SessionOptions("en", "columns", tables=("signals",), network=network(Known(), known, None)))
    session.begin(capture.name, True)
    session.feed(capture.read_bytes())
    session.finish()
    names = {name for _, batch in session.batches(flush=True) for name in batch.column("signal")}
    browser.click('[data-panel="plots"]')
    browser.wait('document.querySelector("#plots label, #plots .signals p")', 30)
    browser.wait('document.querySelector("#progress").hidden')
    shown = text(browser, "#plots .signals")
    assert names and any(name in shown for name in names)


def test_descriptions_are_dropped_before_and_behind_the_capture(
    browser: Browser, empty: Path, canalyze: Runner
) -> None:
    """Several of them, for nodes that are typed: what is saved is what the command line writes with `--eds`."""
    capture = SAMPLES / "network" / "sync-and-pdos.log"
    drive, io = EDS / "drive.eds", EDS / "io.eds"

    def written(*options: str) -> str:
        done = canalyze("decode", str(capture), "--lang", "en", *options)
        assert done.code == 0
        return done.out

    browser.open(empty)
    browser.choose("#file", drive, io)
    browser.wait('document.querySelectorAll("#descriptions .chip").length === 2')
    assert text(browser, "#descriptions p") == "drive.eds: no node-ID; give it in the field, as 5 or 1-4,7"
    described_for(browser, "drive.eds", "5")
    browser.wait('document.querySelectorAll("#descriptions p.warning").length === 1')
    again(browser, capture)
    with_drive = written("--eds", f"5={drive}")
    assert with_drive != written()
    assert saved(browser, "text") == ("sync-and-pdos.log.txt", with_drive)

    browser.run('document.body.dataset.state = ""')
    described_for(browser, "io.eds", "vcan0:6")
    browser.wait(CHECKED)
    with_both = written("--eds", f"5={drive}", "--eds", f"vcan0:6={io}")
    assert with_both != with_drive
    assert saved(browser, "text")[1] == with_both
    again(browser, EDS / "encoder.eds", capture)
    browser.run('document.body.dataset.state = ""')
    described_for(browser, "encoder.eds", "7")
    browser.wait(CHECKED)
    browser.click('[data-panel="plots"]')
    browser.wait(
        '[...document.querySelectorAll("#plots label")].some((one) => one.textContent.includes("Position value"))'
    )

    browser.run('document.body.dataset.state = ""')
    browser.click("#descriptions .chip button")
    browser.wait(CHECKED)
    wanted = written("--eds", f"vcan0:6={io}", "--eds", f"7={EDS / 'encoder.eds'}")
    assert saved(browser, "text")[1] == wanted
    assert step(browser, "texts", "#descriptions b") == [
        "io.eds",
        "encoder.eds",
    ]


def test_a_description_that_cannot_be_used_is_one_line(browser: Browser, empty: Path, tmp_path: Path) -> None:
    """In the words of the command line; what is open stays open."""
    opened(browser, empty, PROBLEMS)
    texts = {
        "none.eds": (b"[FileInfo]\n", "none.eds: no CANopen objects; in EDS and DCF they are sections such as [1000]"),
        "empty.dcf": (b"", "empty.dcf: file is empty"),
        "broken.xml": (b"<?xml version='1.0'?>\n<a>\n</b>", "broken.xml:3: not well-formed XML: mismatched tag"),
        "large.eds": (b" " * ((8 << 20) + 1), "large.eds: larger than 8 MiB, not a device description"),
    }
    for name, (data, said) in texts.items():
        (tmp_path / name).write_bytes(data)
        browser.choose("#file", tmp_path / name)
        browser.wait(f'document.querySelector("#descriptions").innerText === {json.dumps(said)}')
    assert text(browser, "#verdict") == "✖ 1 open problem, 1 ended, 1 harmless"
    sound = b"[1000]\nParameterName=a\nDataType=7\nAccessType=ro\n"
    (tmp_path / "a.eds").write_bytes(sound + b"no equals\n")
    (tmp_path / "b.dcf").write_bytes(b"[DeviceComissioning]\nNodeID=9\n" + sound)
    again(browser, tmp_path / "a.eds", tmp_path / "b.dcf")
    described_for(browser, "a.eds", "4-6,0")
    browser.wait('document.querySelector("#descriptions").innerText.includes("is no node-ID")')
    described_for(browser, "a.eds", "4,9")
    browser.wait('document.querySelector("#descriptions").innerText.includes("node 9 has two")')
    lines = step(browser, "texts", "#descriptions p")
    assert lines == [
        "node 9 has two device descriptions, a.eds and b.dcf; give only one",
        "a.eds: 1 entry not used; see canalyze eds a.eds",
    ]
    described_for(browser, "a.eds", "4")
    described_for(browser, "b.dcf", "3")
    said = "b.dcf: DCF of node 9, used for 3; values without $NODEID stay those of node 9"
    browser.wait(f'document.querySelector("#descriptions").innerText.includes({json.dumps(said)})')


def test_a_dropped_description_is_taken_before_one_inside_the_page(browser: Browser, tmp_path: Path) -> None:
    capture = SAMPLES / "network" / "sync-and-pdos.log"
    known = Known((Description(None, (5, 6), str(EDS / "io.eds")),))
    page = tmp_path / "known.html"
    part = held(capture.name, capture.read_bytes())
    page.write_bytes(html.page("en", {"network": network_rows(Known(), known)}, [[part]]))
    opened(browser, page)
    browser.choose("#file", EDS / "drive.eds")
    browser.wait('document.querySelector("#descriptions .chip")')
    browser.run('document.body.dataset.state = ""')
    described_for(browser, "drive.eds", "5")
    browser.wait(CHECKED)
    given = Known((Description(None, (5,), str(EDS / "drive.eds")),))
    wanted = session_output([capture.read_bytes()], name=capture.name, lang="en", network=network(known, given, None))
    assert saved(browser, "text")[1] == wanted.decode()
    assert wanted != session_output([capture.read_bytes()], lang="en", network=network(known, Known(), None))


def test_the_configuration_of_a_node_is_saved_as_dcf(
    browser: Browser, empty: Path, canalyze: Runner, tmp_path: Path
) -> None:
    capture, eds = SAMPLES / "network" / "sync-and-pdos.log", EDS / "drive.eds"
    opened(browser, empty, eds, capture)
    browser.run('document.body.dataset.state = ""')
    described_for(browser, "drive.eds", "5")
    browser.wait(CHECKED)
    browser.click('[data-panel="objects"]')
    button = '[...document.querySelectorAll("#objects button")].find((one) => one.textContent === "DCF node 5")'
    browser.wait(f"{button} !== undefined")
    name, content = saved_by(browser, lambda: browser.run(f"{button}.click()"))
    made = tmp_path / "node5.dcf"
    done = canalyze("od", str(capture), "--node", "5", "--dcf", str(made), "--eds", f"5={eds}", "--lang", "en")
    assert (name, content) == (made.name, made.read_bytes().decode())
    said = [line.removeprefix("canalyze: ").replace(str(made), made.name) for line in done.err.splitlines()]
    assert text(browser, "#notice").splitlines() == said and said


def test_a_trap_is_said_and_the_page_goes_on(browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A core whose first call ends in `unreachable`."""
    types, functions, memory = "0106 01 60017f017f", "0302 0100", "0503 010001"
    exports = "0712 02 05 696e707574 0000 06 6d656d6f7279 0200"  # input, memory
    module = bytes.fromhex(f"0061736d 01000000 {types} {functions} {memory} {exports} 0a05 01 03 00 00 0b")
    (tmp_path / "core.wasm.lzma").write_bytes(lzma.compress(module, lzma.FORMAT_ALONE))
    monkeypatch.setattr(html, "WASM", tmp_path / "core.wasm.lzma")
    page = tmp_path / "trap.html"
    page.write_bytes(html.page("en", {}))
    opened(browser, page, PROBLEMS)
    assert "the program has failed and was started again" in text(browser, "#notice")
    browser.run('document.body.dataset.state = ""')
    browser.choose("#file", PROBLEMS)
    browser.wait('document.body.dataset.state === "failed"')


class _Server(HTTPServer):
    """Counts what it is asked."""

    asked = 0


class _Handler(BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        assert isinstance(self.server, _Server)
        self.server.asked += 1
        self.send_response(204)
        self.end_headers()

    def log_message(self, *_: Any) -> None:
        pass


def test_no_request_leaves(browser: Browser, empty: Path) -> None:
    """What the page itself asks for, and what a script in it may: nothing."""
    opened(browser, empty, PROBLEMS)
    browser.click("#problem-1 .frame")
    browser.wait('document.querySelector("#detail pre")?.textContent.includes("COB-ID")')
    if isinstance(browser, Chromium):
        asked = {one for one in browser.requested() if not one.startswith(("chrome://", "data:", "devtools:"))}
        assert {one.partition(":")[0] for one in asked} == {"file", "blob"}
        assert {one for one in asked if one.startswith("file:")} <= {empty.as_uri()} | LOADED
    with _Server(("127.0.0.1", 0), _Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f"http://127.0.0.1:{server.server_port}/"
        step(browser, "request", address)
        browser.wait("window.refused >= 3")
        time.sleep(0.2)
        assert server.asked == 0
        assert browser.run("return window.hacked ?? null") is None
        server.shutdown()


@NO_CHROMIUM
def test_a_narrow_screen_shows_everything_in_its_width(chromium_browser: Chromium, empty: Path) -> None:
    browser = chromium_browser
    browser.cdp("Emulation.setDeviceMetricsOverride", width=390, height=800, deviceScaleFactor=1, mobile=True)
    try:
        opened(browser, empty, PROBLEMS)
        assert browser.run("return document.documentElement.scrollWidth") <= 390
        assert browser.run("return window.scrollY") == 0
        # The list comes to the top although the detail below it is still empty.
        browser.run(
            'document.querySelector("#detail").replaceChildren(); document.querySelector("#problem-1 .frame").click()'
        )
        browser.wait('document.querySelector(".row.chosen")')
        frames = 'document.querySelector("#frames").getBoundingClientRect()'
        browser.wait(f"{frames}.top >= 0 && {frames}.top < 200")
        browser.click('[data-panel="transfers"]')
        browser.wait('document.querySelector("#transfers tbody tr") !== null')
        assert browser.run("return document.documentElement.scrollWidth") <= 390
    finally:
        browser.cdp("Emulation.clearDeviceMetricsOverride")


@NO_CHROMIUM
def test_it_is_printed_with_all_problems(chromium_browser: Chromium, empty: Path) -> None:
    browser = chromium_browser
    opened(browser, empty, PROBLEMS)
    made = base64.b64decode(browser.cdp("Page.printToPDF")["data"])
    assert made.startswith(b"%PDF") and len(made) > 10_000
    assert browser.run('return [...document.querySelectorAll("details.problem")].every((one) => one.open)')
    near = text(browser, "#problem-2 .near").splitlines()
    assert len(near) > 5 and any(line.startswith("#134 084") for line in near)
    browser.cdp("Emulation.setEmulatedMedia", media="print")
    try:
        assert browser.run('return getComputedStyle(document.querySelector("#frames")).display') == "none"
    finally:
        browser.cdp("Emulation.setEmulatedMedia", media="")


@NO_CHROMIUM
def test_dark_and_light(chromium_browser: Chromium, empty: Path) -> None:
    browser = chromium_browser
    browser.open(empty)
    ground = "return getComputedStyle(document.body).backgroundColor"
    before = browser.run(ground)
    browser.click("#theme")
    assert browser.run(ground) != before


@NO_CHROMIUM
def test_it_saves_what_convert_writes(chromium_browser: Chromium, empty: Path) -> None:
    """The bytes that a download would have."""
    browser = chromium_browser
    opened(browser, empty, PROBLEMS)
    filtered(browser, "node=5")
    label = 'return document.querySelector("#save option").textContent'
    assert browser.run(label) == "Save filtered…"
    name, content = saved(browser, "candump")
    wanted = [one for one in read_log(PROBLEMS.read_bytes()) if one.can_id & 0x7F == 5]
    assert log_text(read_log(content.encode())) == log_text(wanted)
    assert name == "problems.log.log"
    filtered(browser, "heartbeat")
    assert browser.run(label) == "Save all…"
    assert log_text(read_log(saved(browser, "candump")[1].encode())) == log_text(read_log(PROBLEMS.read_bytes()))


def resident_mb() -> int:
    """Memory of the largest process of a page among all that this one has started."""
    parents, sizes = {}, {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            lines = (folder / "status").read_text().splitlines()
            told = dict(line.split(":", 1) for line in lines)
            parents[int(folder.name)] = int(told["PPid"])
            if b"--type=renderer" in (folder / "cmdline").read_bytes():
                sizes[int(folder.name)] = int(told["VmRSS"].split()[0]) >> 10
        except (OSError, KeyError):  # it has ended
            continue

    def is_own(process: int) -> bool:
        return process == os.getpid() or (process in parents and is_own(parents[process]))

    return max(size for process, size in sizes.items() if is_own(process))


@NO_CHROMIUM
def test_a_million_frames(empty: Path, tmp_path: Path) -> None:
    capture = tmp_path / "million.log"
    capture.write_text("".join(f"{line.rstrip()}\n" for line in capture_lines(1_000_000)))
    with chromium() as browser:
        browser.open(empty)
        step(browser, "keepTasks")
        again(browser, capture)
        assert browser.run("return document.body.dataset.state") == "opened"
        assert "1000000 frames" in text(browser, "#extent")
        # About 60 ms where nothing else runs: at most 100 are wanted.
        assert browser.run("return Math.max(...window.tasks)") < 300
        step(browser, "keepLongest")
        assert re.fullmatch(r"\d+ frames", filtered(browser, "service=sdo node=5"))
        shown = filtered(browser, "service=heartbeat")
        step(browser, "askAndCancel", "service=pdo")
        browser.wait('!document.querySelector("#filter output").textContent.startsWith("reading")')
        assert browser.run('return document.querySelector("#filter output").textContent') == shown
        assert browser.run('return document.querySelector("#filter input").value') == "service=heartbeat"
        assert rows(browser)
        assert re.fullmatch(r"\d+ frames", filtered(browser, "heartbeat of node 5"))
        assert filtered(browser, "") == "1000000 frames"
        for end, frame in (("1e9", 1_000_000), ("0", 1)):
            browser.run(f'document.querySelector("#frames").scrollTop = {end}')
            browser.wait(f'[...document.querySelectorAll(".row")].some((row) => row.dataset.frame === "{frame}")')
        wanted = random.Random(1).sample(range(1, 1_000_000), 5)
        for frame in wanted:
            step(browser, "ask", f"#{frame}")
            browser.wait(f'document.querySelector(".row.chosen")?.dataset.frame === "{frame}"')
        assert browser.run("return window.longest") < 500, "the page is blocked"
        assert resident_mb() < 420
