"""The core in WebAssembly says, byte for byte, what the installed one says.

Runs under node where `.ci/web` has built it. Every sample and damaged copies of them, in every form of a session, as
tables, in both languages; samples below a folder in one
of both, unless `CANALYZE_TESTS` is `thorough`. What it must not do: test
the page.
"""

from __future__ import annotations

import hashlib
import json
import lzma
import os
import random
import shutil
import struct
import subprocess
from collections import Counter
from itertools import cycle
from pathlib import Path
from typing import Any

import pytest
from captures import EDS, SAMPLES, TESTS

from canalyze import _core
from canalyze.configuration.network import (
    CanId,
    Cob,
    Description,
    Known,
    NodeProfile,
    PdoMapping,
    SdoChannel,
    network,
    network_rows,
)
from canalyze.dictionary import load
from canalyze.errors import SourceError
from canalyze.running.reading import SessionOptions

FOLDER = TESTS.parent / "canalyze" / "html"
WASM = FOLDER / "core.wasm.lzma"
NODE = shutil.which("node")
FORMS = (
    "text", "jsonl", "events", "transfers", "transfers-text", "transfers-csv", "signals", "signals-csv", "objects",
    "objects-text", "objects-csv", "pdos", "history", "history-text", "history-csv", "summary", "observed", "records",
    "lines", "convert", "info", "check", "diagnosis", "monitor",
)  # fmt: skip
THOROUGH = os.environ.get("CANALYZE_TESTS") == "thorough"
Case = dict[str, Any]

WEB = os.environ.get("CANALYZE_WEB", "")
"""later: these tests have a run of their own; required: nothing that they need may be missing."""

pytestmark = [
    pytest.mark.skipif(WEB == "later", reason="tested when the core is built for the web"),
    pytest.mark.skipif(WEB != "required" and NODE is None, reason="no node here"),
    pytest.mark.skipif(WEB != "required" and not WASM.exists(), reason="the core is not built for the web: .ci/web"),
]


def captures() -> list[Path]:
    """Every capture among the samples that the core reads by itself."""
    found = []
    for path in sorted(SAMPLES.rglob("*")):
        if path.suffix in {".log", ".candump", ".asc", ".mcap", ".blf", ".trc", ".pcapng", ".pcap"}:
            found.append(path)
    return found


def damaged(folder: Path, count: int) -> list[Path]:
    """Copies of samples with bytes that are missing or flipped, the same in every run."""
    chance = random.Random(38)
    found = []
    for number, path in enumerate(chance.sample([one for one in captures() if one.stat().st_size < 200_000], count)):
        data = bytearray(path.read_bytes())
        for _ in range(chance.choice((1, 3, 20))):
            at = chance.randrange(len(data))
            if chance.random() < 0.2:
                del data[at : at + chance.randrange(1, 40)]
            else:
                data[at] ^= 1 << chance.randrange(8)
        copy = folder / f"{number}-{path.name}"
        copy.write_bytes(data)
        found.append(copy)
    return found


def case(path: Path, **options: Any) -> Case:
    """One session over one file."""
    with path.open("rb") as file:
        form = _core.sniff(file.read(65536), True) or "candump"
    form = form if form in _core.FORMATS else "candump"
    return {"file": str(path), "name": path.name, "format": form, "options": options, "pieces": 3}


def cases_of(path: Path, lang: str) -> list[Case]:
    """Every form of a session over one file; tables beside one of them."""
    found = [case(path, lang=lang, format=form) for form in FORMS]
    found += [case(path, lang=lang, format="text", depth=depth, numbered=True) for depth in ("brief", "explain")]
    found += [case(path, lang=lang, format="convert", to=to) for to in _core.WRITERS]
    found += [case(path, lang=lang, format="jsonl", incidents=True, filter="severity=warning,error")]
    found += [case(path, lang=lang, format="columns", tables=list(_core.TABLES))]
    return found


def plain(value: Any, floats: bool) -> Any:
    """A value of a table as JSON has it."""
    if isinstance(value, bool) or value is None or isinstance(value, str):
        return value
    if isinstance(value, bytes):
        return value.hex()
    if isinstance(value, list):
        return [plain(one, floats) for one in value]
    return struct.pack(">d", value).hex() if floats else str(value)


def compact(value: Any) -> bytes:
    """JSON as JavaScript writes it."""
    return json.dumps(value, ensure_ascii=False, separators=(",", ":")).encode()


def answer(one: Case) -> str:
    """The digest of all that the installed core gives for a case."""
    options: Case = {**one["options"], "network": one.get("known")}
    session = _core.Session(SessionOptions(**options))
    digest = hashlib.sha256()
    session.begin(one["name"], True, one["format"])
    data = Path(one["file"]).read_bytes()
    length = max(1, -(-len(data) // one["pieces"]))
    for at in range(0, len(data), length):
        digest.update(session.feed(data[at : at + length]))
    digest.update(session.end())
    digest.update(session.finish())
    for table, batch in session.batches(flush=True):
        columns = []
        for name in batch.column_names:
            values = batch.column(name)
            floats = any(isinstance(value, float) for value in values)
            columns.append([name, [plain(value, floats) for value in values]])
        digest.update(compact([table, batch.num_rows, columns]))
    digest.update(compact([session.complaints(), session.nature, session.frames]))
    for said in (session.tally(), session.nodes(), session.contents(), session.snapshot()):
        digest.update(said.encode())
    return digest.hexdigest()


def in_node(cases: list[Case], folder: Path) -> subprocess.Popen[str]:
    """Start the sessions of the core in WebAssembly."""
    assert NODE is not None
    plain_cases = [{name: value for name, value in one.items() if name != "known"} for one in cases]
    (folder / "cases.json").write_text(json.dumps(plain_cases))
    sources = [str(FOLDER / "worker" / f"{name}.js") for name in ("lzma", "core", "columns", "capture", "frames")]
    line = [NODE, str(TESTS / "web" / "answers.js"), str(WASM), str(folder / "cases.json"), *sources]
    return subprocess.Popen(line, stdout=subprocess.PIPE, text=True)


def differing(cases: list[Case], folder: Path, ours: list[Case] | None = None) -> list[Case]:
    """The cases whose answers differ; ours: what the installed core is given instead."""
    with in_node(cases, folder) as process:
        here = [answer(one) for one in ours or cases]
        said = process.communicate()[0].splitlines()
    assert process.returncode == 0 and len(said) == len(cases), "the core in WebAssembly has trapped"
    return [one for one, theirs, mine in zip(cases, said, here, strict=True) if theirs != mine]


PARTS = 8


@pytest.mark.parametrize("part", range(PARTS))
def test_every_sample_is_answered_alike(part: int, tmp_path: Path) -> None:
    found: list[Case] = []
    for path, lang in list(zip(captures(), cycle(("zh", "en")), strict=False))[part::PARTS]:
        for one in ("zh", "en") if THOROUGH or path.parent == SAMPLES else (lang,):
            found += cases_of(path, one)
    assert len(found) > 100
    assert differing(found, tmp_path) == []


def test_damaged_files_are_answered_alike(tmp_path: Path) -> None:
    found: list[Case] = []
    for path, lang in zip(damaged(tmp_path, 120 if THOROUGH else 30), cycle(("zh", "en")), strict=False):
        found += cases_of(path, lang)
    assert differing(found, tmp_path) == []


def described(capture: Path) -> Known:
    """What options would say of a session of a network: its nodes' descriptions, by the truth beside it."""
    nodes = json.loads(capture.with_suffix(".json").read_text())["nodes"]
    eds = tuple(Description(None, (row["node"],), str(EDS / row["eds"])) for row in nodes if row["eds"])
    return Known(
        eds,
        (Cob("can0", CanId(0x18A, False), 10, "tpdo", 1), Cob(None, CanId(0x1C0, False), 64, "tpdo", 1)),
        (SdoChannel(None, CanId(0x640, False), CanId(0x5C0, False), 64),),
        sync_period_ns=10_000_000,
        jitter_ns=1000,
        bitrate=500_000,
        pdos=(PdoMapping(None, 5, "tpdo", 1, ((0x1A00, 0, 1), (0x1A00, 1, 0x60410010))),),
        profiles=(NodeProfile(None, (5,), 402),),
    )


def test_a_known_network_is_known_alike(tmp_path: Path) -> None:
    found: list[Case] = []
    plainly: list[Case] = []
    for path in sorted((SAMPLES / "network").glob("*.log")):
        given = described(path)
        rows, known = network_rows(Known(), given), network(Known(), given, None)
        for one in cases_of(path, "en"):
            plainly.append(one)
            found.append({**one, "options": {**one["options"], "network": rows}, "known": known})
    assert differing(found, tmp_path) == []
    assert len(differing(plainly[:40], tmp_path, found[:40])) > 5, "what is known changes what is said"


def in_words(cases: list[Case], folder: Path) -> list[Any]:
    """What node prints for cases that answer in JSON."""
    with in_node(cases, folder) as process:
        said = process.communicate()[0].splitlines()
    assert process.returncode == 0 and len(said) == len(cases)
    return [json.loads(line) for line in said]


def test_descriptions_are_read_and_used_alike(tmp_path: Path) -> None:
    """Those that the page is given as files: sessions say what they say with `--eds`."""
    found: list[Case] = []
    for path in sorted((SAMPLES / "network").glob("*.log")):
        given = Known(described(path).descriptions)
        files = list(dict.fromkeys(one.file for one in given.descriptions))
        rows = [(one.bus, node, files.index(one.file)) for one in given.descriptions for node in one.nodes]
        for one in cases_of(path, "zh") if files else ():
            options = {**one["options"], "network": {"descriptions": rows}}
            found.append({**one, "options": options, "descriptions": files, "known": network(Known(), given, None)})
    assert len(found) > 100 and differing(found, tmp_path) == []
    plainly = [{**one, "options": {**one["options"], "network": {}}} for one in found[:40]]
    assert len(differing(plainly, tmp_path, found[:40])) > 5, "a description changes what is said"


def test_what_is_shown_of_a_description_is_what_python_reads(tmp_path: Path) -> None:
    texts = {
        "empty.eds": b" \n",
        "nothing.eds": b"[FileInfo]\nFileName=a\n",
        "doctype.xdd": b"<?xml version='1.0'?><!DOCTYPE a><a/>",
        "broken.xdd": b"<?xml version='1.0'?>\n<a>\n</b>",
        "many.eds": b"[1000]\nParameterName=a\nDataType=7\n" + b"".join(b"no equals %d\n" % n for n in range(1100)),
        "gbk.eds": "[DeviceInfo]\nProductName=驱动器\n[1000]\nParameterName=设备类型\nDataType=7\n".encode("gb18030"),
        "node.dcf": b"[DeviceComissioning]\nNodeID=9\n[1000]\nParameterName=a\nDataType=7\nParameterValue=1\n",
    }
    for name, data in texts.items():
        (tmp_path / name).write_bytes(data)
    files = [*sorted(EDS.iterdir()), *(tmp_path / name for name in texts)]
    said = in_words([{"describe": str(file), "name": file.name} for file in files], tmp_path)
    for file, about in zip(files, said, strict=True):
        try:
            read = load(str(file))
        except SourceError as error:
            facts = {name: str(fact) for name, fact in error.facts.items() if name != "name"}
            assert about == {"error": [error.key, facts]}
            continue
        defects: Counter[str] = Counter()
        for defect in read.defects:
            more = defect.code == "more"
            defects[str(defect.facts["code"]) if more else defect.code] += (
                int(str(defect.facts["count"])) if more else 1
            )
        assert about == {
            "form": read.form,
            "node": read.node,
            "product": read.device.product_name,
            "objects": len(read.objects),
            "pdos": len(read.pdos),
            "defects": dict(defects),
        }
    by_name = {file.name: about for file, about in zip(files, said, strict=True)}
    assert by_name["node.dcf"]["node"] == 9 and by_name["gbk.eds"]["product"] == "驱动器"
    assert by_name["many.eds"]["defects"]["no-equals"] == 1100
    assert {"source.empty", "eds.nothing", "eds.doctype", "eds.xml"} <= {
        about["error"][0] for about in said if "error" in about
    }


def test_lines_are_kept_as_they_are(tmp_path: Path) -> None:
    """More of them than are packed at once, and than the core hands over at once."""
    path = tmp_path / "long.log"
    path.write_text("".join(f"({n / 1000:.6f}) can0 {0x701 + n % 127:03X}#{n % 128:02X}\n" for n in range(70_000)))
    texts = ["heartbeat of node 5:", "节点", "Boot-up", "stopped", "[1]  6F", "no such text"]
    one = {**case(path, lang="en", format="columns", tables=["listing"]), "searched": texts}
    [(lines, found)] = in_words([one], tmp_path)
    session = _core.Session(SessionOptions("en", "columns", tables=("listing",)))
    session.begin(path.name, True)
    session.feed(path.read_bytes())
    session.finish()
    wanted = [line for _, batch in session.batches(flush=True) for line in batch.column("line")]
    assert len(wanted) == 70_000 and lines == wanted
    for text, places in zip(texts, found, strict=True):
        assert places == [n for n, line in enumerate(wanted) if text.lower() in line.lower()], text
    assert min(len(found[0]), len(found[4])) > 500 and found[-1] == []


def test_packed_data_are_unpacked(tmp_path: Path) -> None:
    chance = random.Random(5)
    texts = [b"", b"a", b"abc" * 100_000, chance.randbytes(100_000), WASM.read_bytes()[:300_000]]
    texts.append(b"".join(chance.choice((b"0", b"node", b"\n")) for _ in range(200_000)) + chance.randbytes(70_000))
    cases: list[Case] = []
    for number, text in enumerate(texts):
        for lc, lp, pb in ((3, 0, 0), (0, 2, 2), (4, 0, 4)):
            filters = [{"id": lzma.FILTER_LZMA1, "preset": 6, "lc": lc, "lp": lp, "pb": pb}]
            path = tmp_path / f"{number}-{lc}{lp}{pb}.lzma"
            path.write_bytes(lzma.compress(text, lzma.FORMAT_ALONE, filters=filters))
            cases.append({"unlzma": str(path), "digest": hashlib.sha256(text).hexdigest()})
    with in_node(cases, tmp_path) as process:
        said = process.communicate()[0].splitlines()
    assert said == [one["digest"] for one in cases]


@pytest.mark.parametrize("tables", [[], ["transfers"]])
def test_another_answer_is_seen(tables: list[str], tmp_path: Path) -> None:
    """The comparison itself: sessions whose words or values differ in one place."""
    path, other = tmp_path / "a.log", tmp_path / "b.log"
    path.write_bytes((SAMPLES / "sdo-abort.log").read_bytes())
    other.write_bytes(path.read_bytes().replace(b"60A#", b"60B#", 1))
    assert path.read_bytes() != other.read_bytes()
    form = "columns" if tables else "transfers"
    cases = [case(path, lang="en", format=form, tables=tables)]
    ours = [{**one, "file": str(other)} for one in cases]
    assert differing(cases, tmp_path) == []
    assert differing(cases, tmp_path, ours) == cases


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"filter": "nonsense=1"}, "nonsense"),
        ({"format": "nonsense"}, "diagnosis"),
        ({"nonsense": 1}, "unknown field"),
        ({"tables": ["nonsense"]}, "transfers"),
        ({"masks": ["can0,zzz"]}, "zzz"),
        ({"network": {"descriptions": [[None, 5, 0]]}}, "descriptions: 0"),
        ({"network": {"cobs": [[None, 0x185, False, 5, "nonsense", 1]]}}, "rpdo"),
    ],
)
def test_wrong_options_are_refused_in_words(options: dict[str, Any], said: str, tmp_path: Path) -> None:
    wrong = {**case(SAMPLES / "sdo-abort.log", lang="en"), "options": {"lang": "en", **options}}
    with in_node([wrong], tmp_path) as process:
        answered = process.communicate()[0]
    assert answered.startswith("Refused: ") and said in answered
    if "filter" in options or "masks" in options:
        with pytest.raises(ValueError) as raised:
            _core.Session(SessionOptions(lang="en", **options))
        assert answered == f"Refused: {raised.value}\n"
