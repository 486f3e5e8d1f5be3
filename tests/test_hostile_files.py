"""Configuration, expectations, baselines and descriptions that somebody made to hurt, and what only looks like them.

What is hostile gets one line, with its file and its line, and exit code 2.

Time is not measured: a command that is not bounded runs into the limit of processor time or of memory that each gets.
"""

import random
import re
import resource
import subprocess
import tomllib
from pathlib import Path

import pytest
from conftest import NOTES, command, environment

from canalyze import _core
from canalyze.dictionary import read
from canalyze.output.files import MOST
from canalyze.sources.names import matching

MEMORY = 1 << 30
"""Bytes of address space; Python, the core and python-canopen take a third."""
LONGEST = 500
"""Characters of a glob that is taken."""
PROCESSOR_S = 60
"""What takes more is not bounded: without a bound each of these takes hours, or all memory."""


def bounded(directory: Path, *arguments: str) -> tuple[int, str, str]:
    """Runs a command within these bounds."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_S, PROCESSOR_S))

    line = command("--lang", "en", *arguments)
    done = subprocess.run(line, cwd=directory, env=environment(), capture_output=True, preexec_fn=limit, check=False)
    return done.returncode, done.stdout.decode(), done.stderr.decode()


HOSTILE_TOML = {
    "brackets": (b"x = 1\na = " + b"[" * 5000, ":2: nested more than 32 levels, not read"),
    "tables": (b"a = " + b"{a = " * 5000, ":1: nested more than 32 levels, not read"),
    "dotted": (b"# a\n" + b".".join([b"a"] * 50_000) + b" = 1\n", ":2: nested more than 32 levels, not read"),
    "dotted and quoted": (b" . ".join([b'"a"'] * 50_000) + b" = 1\n", ":1: nested more than 32 levels, not read"),
    "heading": (b"[" + b".".join([b"a"] * 50_000) + b"]\n", ":1: nested more than 32 levels, not read"),
    "digits": (b"\n\nx = " + b"9" * 5000 + b"\n", ":3: a number or key longer than 128 characters, not read"),
    "hexadecimal": (b"x = 0x" + b"f" * 5000, ":1: a number or key longer than 128 characters, not read"),
    "float": (b"x = " + b"9" * 400 + b".5", ":1: a number or key longer than 128 characters, not read"),
    "large": (b"#" * (MOST + 1), ": larger than 2 MiB, not read"),
    "open string": (b'x = """' + b'\\"""' * 300_000, "not valid TOML"),
    "quotes": (b'"' * MOST, "not valid TOML"),
    "returns": (b"\r" * MOST, "not valid TOML"),
    "binary": (bytes(range(256)) * 20, ":2: not UTF-8 text"),
    "key": (b'"' + b"k" * 100_000 + b'" = 1\n', "unknown key"),
}


@pytest.mark.parametrize("name", HOSTILE_TOML)
@pytest.mark.parametrize("kind", ["config", "expect"])
def test_hostile_toml_is_one_line(tmp_path: Path, kind: str, name: str) -> None:
    content, said = HOSTILE_TOML[name]
    (tmp_path / "notes.log").write_text(NOTES)
    (tmp_path / "hostile.toml").write_bytes(content)
    arguments = ["--config", "hostile.toml", "info"] if kind == "config" else ["check", "--expect", "hostile.toml"]
    code, out, err = bounded(tmp_path, *arguments, "notes.log")
    assert (code, err.count("\n")) == (2, 1), err[-500:]
    assert err.startswith("canalyze: hostile.toml:") and said in err and len(err) < 2000
    assert "10 frames" not in out


def test_a_device_without_end_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "notes.log").write_text(NOTES)
    for arguments in (["--config", "/dev/zero", "info"], ["check", "--expect", "/dev/zero"]):
        code, _, err = bounded(tmp_path, *arguments, "notes.log")
        assert (code, err) == (2, "canalyze: /dev/zero: larger than 2 MiB, not read\n")
    code, _, err = bounded(tmp_path, "check", "--baseline", "/dev/zero", "notes.log")
    assert (code, err) == (2, "canalyze: /dev/zero: larger than 2 MiB, not read\n")


def test_a_hostile_file_beside_one_capture_of_several_is_about_that_one(tmp_path: Path) -> None:
    for name in ("a", "b", "c"):
        (tmp_path / f"{name}.log").write_text(NOTES)
    (tmp_path / "b.expect.toml").write_bytes(b"a = " + b"[" * 5000)
    code, out, err = bounded(tmp_path, "check", "a.log", "b.log", "c.log")
    assert (code, err) == (2, "canalyze: b.expect.toml:1: nested more than 32 levels, not read\n")
    assert out.count(": not checked") == 1


READERS = (_core.settings, _core.Expectations)
FINE_TOML = [
    b'a = """[[[[ ' + b"[" * 100 + b' a.b.c """\n',
    b"a = '" + b"[" * 100 + b"." * 100 + b"'\n",
    b"# " + b"[" * 100 + b"." * 100 + b"\na = 1\n",
    b'a = "\\"' + b"[" * 100 + b'"\n',
    b'a = """x""""\nb = [[[[1.5, 2.5], [1.5]]]]\n',
    b"a = '''it's'' ''''\nb = {c = [1, 2]}\n",
    b"a = [" + b"1.5, " * 1000 + b"]\n",
    b"a = [" + b"[1], " * 1000 + b"]\n",
    b'a = "' + b"x" * 5000 + b'"\n',
    b"a.b.c.d.e = 1\n[x.y.z]\nk = 0xFFFF\n",
    b"".join(b"[[t]]\na = [[1]]\n" for _ in range(1000)),
    b'"a.b".c = 1\n"' + b"." * 200 + b'" = 2\n',
]


@pytest.mark.parametrize("content", FINE_TOML, ids=lambda content: repr(content[:20]))
def test_what_only_looks_deep_is_read(content: bytes) -> None:
    """As far as its keys, none of which there is."""
    for reader in READERS:
        with pytest.raises(_core.SettingsError) as caught:
            reader(content, "x.toml")
        key, facts = caught.value.args
        assert (key, facts["key"]) == ("config.unknown", next(iter(tomllib.loads(content.decode()))))


@pytest.mark.parametrize(("depth", "fine"), [(32, True), (33, False)])
def test_the_bounds_of_nesting(depth: int, fine: bool) -> None:
    for content in (b"a = " + b"[" * depth + b"]" * depth, b".".join([b"k"] * depth) + b" = 1"):
        for reader in READERS:
            with pytest.raises(_core.SettingsError) as caught:
                reader(content, "x")
            assert caught.value.args[0] == ("config.unknown" if fine else "config.deep")


def test_a_number_that_no_double_holds_is_refused_with_its_line(tmp_path: Path) -> None:
    (tmp_path / "notes.log").write_text(NOTES)
    for key in ("period_ms", "tolerance_percent"):
        text = f'[[signal]]\nselect = "x"\n{key} = {"9" * 120}\n'
        (tmp_path / "a.toml").write_text(text)
        code, _, err = bounded(tmp_path, "check", "--expect", "a.toml", "notes.log")
        assert (code, err.count("\n")) == (2, 1) and err.startswith(f"canalyze: a.toml:3: key signal.{key}: 999")


@pytest.mark.parametrize(
    ("text", "line", "key"),
    [
        ("jitter_us = 1\nlang = 5\n", 2, "lang"),
        ("[[cob]]\n'id' = '1'\n\"pdo\" = 5\n", 3, "cob.pdo"),
        ("[[cob]]\nid = '1'\nnode = 5\npdo = 'TPDO1'\n[[cob]]\n# id = 1\n  \"id\" = 3\n", 7, "cob.id"),
        ("[[cob]]\nid = '1'\nnode = 5\npdo = 'TPDO1'\n[[cob]]\nid = '2'\n", 5, "cob.node"),
        ("\n\n[lang]\nx.k = 4\n", 3, "lang"),
        ("[sync]\r\nperiod_us.k = 4\r\n", 2, "sync.period_us"),
        ("[check]\n\noverride = [{ codes = 'SDO' },\n{ codes = 5 }]\n", 3, "check.override.severity"),
        ("eds = [{ file = 'a' },\n{ file = 5 }]\n", 2, "eds.file"),
        ('text = """\nlang = 1\n"""\nlang = 5\n', 1, "text"),
    ],
)
def test_lines_of_keys_and_tables(text: str, line: int, key: str) -> None:
    with pytest.raises(_core.SettingsError) as caught:
        _core.settings(text.encode(), "f")
    facts = caught.value.args[1]
    assert (facts["file"], facts["key"]) == (f"f:{line}", key)


def test_many_expectations_are_read(tmp_path: Path) -> None:
    """Each has its line; looked for from the beginning each time, they would take hours."""
    (tmp_path / "notes.log").write_text(NOTES)
    (tmp_path / "a.toml").write_text('[[sdo]]\nnode = 10\nobject = "1008:00"\n' * 20_000)
    code, _, err = bounded(tmp_path, "check", "--expect", "a.toml", "notes.log")
    assert code in (0, 1) and "Traceback" not in err


KINDS = [b'{"code": "SDO%03d", "node": %d, "count": 1}' % (code, node) for code in range(150) for node in range(1, 128)]
HOSTILE_JSON = {
    "digits": (b'{"canalyze_baseline": 1, "findings": [\n{"code": "SDO001", "count": ' + b"9" * 5000 + b"}]}", ":2: "),
    "version": (b'{"canalyze_baseline": ' + b"9" * 5000 + b', "findings": []}', "baseline version "),
    "deep": (b'{"canalyze_baseline": 1, "findings": ' + b"[" * 500_000, ": not a baseline"),
    "objects": (b'{"a":' * 300_000, ": not a baseline"),
    "large": (b" " * (MOST + 1), ": larger than 2 MiB, not read"),
    "entries": (
        b'{"canalyze_baseline": 1, "findings": [' + b"{},\n" * 400_000 + b"{}]}",
        ":1: invalid code in a baseline entry",
    ),
    "last": (
        b'{"canalyze_baseline": 1, "findings": [' + b",\n".join(KINDS) + b',\n{"code": 1}]}',
        f":{len(KINDS) + 1}: invalid code in a baseline entry",
    ),
    "key": (b'{"canalyze_baseline": 1, "findings": [{"' + b"k" * 100_000 + b'": 1}]}', ":1: "),
}


@pytest.mark.parametrize("name", HOSTILE_JSON)
def test_a_hostile_baseline_is_one_line(tmp_path: Path, name: str) -> None:
    content, said = HOSTILE_JSON[name]
    (tmp_path / "notes.log").write_text(NOTES)
    (tmp_path / "b.json").write_bytes(content)
    code, _, err = bounded(tmp_path, "check", "--baseline", "b.json", "notes.log")
    assert (code, err.count("\n")) == (2, 1), err[-500:]
    assert err.startswith("canalyze: b.json:") and said in err and len(err) < 2000


# Globs.


def reference(glob: str) -> re.Pattern[str]:
    """The same globs as a regular expression, which may go back as often as it likes."""
    meaning = {"**/": "(?:.*/)?", "**": ".*", "*": "[^/]*", "?": "[^/]"}
    pattern = ""
    for place, piece in enumerate(re.split(r"((?:^|(?<=/))\*\*/|\*\*|\*|\?|\[!?\]?[^\]]*\])", glob)):
        if place % 2 == 0:
            pattern += re.escape(piece)
        elif piece in meaning:
            pattern += meaning[piece]
        else:
            inner = piece[1:-1]
            members = re.sub(r"([\\\[\]^&~|])", r"\\\1", inner.removeprefix("!"))
            pattern += f"(?!/)[^{members}]" if inner.startswith("!") else f"(?!/)[{members}]"
    try:
        return re.compile(pattern, re.DOTALL)
    except re.error:
        return re.compile(re.escape(glob))


def test_globs_match_as_one_that_goes_back() -> None:
    rng = random.Random(17)
    fits = 0
    for _ in range(30_000):
        parts = ["*", "**", "**/", "/**/", "?", "a", "b", "/", "[ab]", "[!a]", "[z-a]", "["]
        glob = "".join(rng.choices(parts, k=rng.randrange(8)))
        name = "".join(rng.choices("ab/", k=rng.randrange(8)))
        expected = reference(glob).fullmatch(name) is not None
        assert (matching(glob).fullmatch(name) is not None) == expected, (glob, name)
        fits += expected
    assert fits > 1500


@pytest.mark.parametrize(
    "glob", ["*a" * 12 + "b", "*" * 60 + "b", "**/a" * 100, "?" * LONGEST, "[a*" * 100, "**/*a*" * 50]
)
def test_no_glob_takes_long(tmp_path: Path, glob: str) -> None:
    name = "a" * 200 + ".log"
    (tmp_path / name).write_text(NOTES)
    text = f'[[check.override]]\ncodes = "SDO"\nseverity = "info"\nreason = "x"\nfiles = "{glob}"\n'
    (tmp_path / "canalyze.toml").write_text(text)
    code, out, err = bounded(tmp_path, "check", "--fail-on", "info", name)
    assert code in (0, 1) and err == "" and name in out


def test_a_glob_beyond_any_name_is_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.log").write_text(NOTES)
    text = f'[[check.override]]\ncodes = "SDO"\nseverity = "info"\nreason = "x"\nfiles = "{"*a" * LONGEST}"\n'
    (tmp_path / "canalyze.toml").write_text(text)
    code, _, err = bounded(tmp_path, "check", "notes.log")
    assert (code, err.count("\n")) == (2, 1) and err.startswith("canalyze: canalyze.toml:5: key check.override.files")


# Descriptions.


def object_of(*keys: str) -> str:
    return "\n".join(["[1000]", "ParameterName=Device type", "DataType=7", "AccessType=ro", *keys, ""])


HOSTILE_EDS = {
    "returns": "[FileInfo]" + "\r" * 2_000_000 + "x\n" + object_of(),
    "blanks behind a number": "[DeviceInfo]\nNrOfRXPDO=1" + " " * 2_000_000 + "x\n" + object_of(),
    "blanks behind a type": object_of().replace("=ro", "=ro" + " " * 2_000_000 + "x"),
    "blanks in a value": object_of("DefaultValue=$NODEID" + " " * 2_000_000 + "+1"),
    "summands": object_of("DefaultValue=$NODEID" + "+1" * 2_000_000),
    "digits": object_of("DefaultValue=" + "1" * 4_000_000).replace("=7", "=8"),
    "bytes": object_of("DefaultValue=" + "AB " * 1_000_000).replace("=7", "=10"),
    "comments": object_of("DefaultValue=1" + ";" * 4_000_000),
    "sections": object_of() + "[" * 4_000_000,
    "name": object_of().replace("Device type", "x" * 4_000_000),
    "lines": object_of() + "x\n" * 1_000_000,
    "zeros": object_of() + "[2000sub" + "0" * 4_000_000 + "1]\nParameterName=x\n",
}


HOSTILE_OBJECT = '<CANopenObject index="1000" objectType="7" dataType="0007" accessType="ro" name="x"/>'
HOSTILE_XDD = {
    "attributes": "<a " + " ".join(f'a{number}=""' for number in range(500_000)) + f">{HOSTILE_OBJECT}</a>",
    "depth": "<a>" * 1_000_000 + HOSTILE_OBJECT + "</a>" * 1_000_000,
    "references": f"<a>{HOSTILE_OBJECT}" + "&#65;" * 1_000_000 + "</a>",
    "objects": f"<a>{HOSTILE_OBJECT * 80_000}</a>",
}


@pytest.mark.parametrize("name", HOSTILE_XDD)
def test_a_hostile_document_is_read(tmp_path: Path, name: str) -> None:
    (tmp_path / "hostile.xdd").write_text(HOSTILE_XDD[name], newline="")
    code, out, err = bounded(tmp_path, "eds", "hostile.xdd", "--format", "jsonl")
    assert (code, err) == (0, ""), err[-500:]
    assert '"index": "1000"' in out


@pytest.mark.parametrize("name", HOSTILE_EDS)
def test_a_hostile_description_is_read_or_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "hostile.eds").write_text(HOSTILE_EDS[name], newline="")
    code, out, err = bounded(tmp_path, "eds", "hostile.eds", "--format", "jsonl")
    assert (code, err) == (0, ""), err[-500:]
    assert '"index": "1000"' in out


@pytest.mark.parametrize(
    "text",
    [
        "".join(object_of().replace("1000", f"{index:04X}") for index in range(0x1000, 0x9000)),
        "".join(
            object_of("CompactSubObj=254", "ObjectType=8").replace("1000", f"{index:04X}")
            for index in range(0x1000, 0x1400)
        ),
    ],
    ids=["objects", "compact"],
)
def test_more_entries_than_any_device_has_are_left_out_and_told(text: str) -> None:
    found = read(text.encode(), "x.eds")
    assert 29_000 < sum(len(one.entries) for one in found.objects) <= 30_000
    assert "too-many" in {defect.code for defect in found.defects}


def test_the_entries_of_a_large_device_are_all_read() -> None:
    text = "".join(object_of().replace("1000", f"{index:04X}") for index in range(0x1000, 0x3000))
    found = read(text.encode(), "x.eds")
    assert len(found.objects) == 0x2000 and "too-many" not in {defect.code for defect in found.defects}


@pytest.mark.parametrize("name", ["hostile.eds", "hostile.dcf", "hostile.xdd", "/dev/zero"])
def test_a_description_without_end_is_one_line(tmp_path: Path, name: str) -> None:
    if not name.startswith("/"):
        (tmp_path / name).write_bytes((b"<a>" if name.endswith("xdd") else object_of().encode()) + b"\n" * (9 << 20))
    code, _, err = bounded(tmp_path, "eds", name)
    assert (code, err.count("\n")) == (2, 1) and err.startswith(f"canalyze: {name}: ")


@pytest.mark.parametrize(
    "text", ["a\nb", "a\rb\r\nc", "a\r\r\nb\r\r", "\r", "\n", "", "a\n\r\nb\r", "a\r\r\r\n\r\rb"], ids=repr
)
def test_lines_end_as_any_system_ends_them(text: str) -> None:
    keyed = "[1000]\nParameterName=x\nDataType=7\nAccessType=ro\n" + text
    found = {defect.line: defect.facts["text"] for defect in read(keyed.encode(), "x.eds").defects if defect.line}
    lines = re.split(r"\r*\n|\r", keyed)
    assert found == {number: line for number, line in enumerate(lines[4:], 5) if line}


XDD = (
    '<?xml version="1.0" encoding="utf-8"?><ISO15745ProfileContainer><ISO15745Profile><ProfileBody><ApplicationLayers>'
    '<CANopenObjectList><CANopenObject index="1008" objectType="7" dataType="0009" accessType="const" name="{name}" '
    'defaultValue="{value}"/></CANopenObjectList></ApplicationLayers></ProfileBody></ISO15745Profile>'
    "</ISO15745ProfileContainer>"
)


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("a&#10;b", "a\nb"),
        ("a&#13;&#10;b", "a\r\nb"),
        ("a&#10;[2000]&#10;ParameterName=b", "a\n[2000]\nParameterName=b"),
        ("a&#10;[1008]&#10;", "a\n[1008]"),
        ("a;b", "a;b"),
        ("a&#x85;&#x9b;b&#x7f;", "a\x85\x9bb\x7f"),
        ("a&#x202e;&#x2028;b", "a\u202e\u2028b"),
        ("\ue03b\ue00a", "\ue03b\ue00a"),
        ("plain", "plain"),
    ],
)
def test_texts_of_an_xdd_are_kept_whatever_is_in_them(written: str, meant: str) -> None:
    found = read(XDD.format(name=written, value=written).encode(), "x.xdd")
    (one,) = found.objects
    assert (one.index, one.name, one.entries[0].default) == (0x1008, meant, meant)


def test_a_line_break_in_a_name_breaks_no_line(tmp_path: Path) -> None:
    (tmp_path / "x.xdd").write_text(XDD.format(name="a&#10;::error::x", value="b&#10;c"))
    (tmp_path / "notes.log").write_text(NOTES)
    for arguments in (
        ["eds", "x.xdd"],
        ["decode", "--eds", "10=x.xdd", "notes.log"],
        ["sdo", "--eds", "10=x.xdd", "notes.log"],
        ["check", "--eds", "10=x.xdd", "notes.log"],
    ):
        code, out, err = bounded(tmp_path, *arguments)
        assert code in (0, 1) and "Traceback" not in err
        assert not [line for line in (out + err).splitlines() if line.lstrip().startswith("::")]
