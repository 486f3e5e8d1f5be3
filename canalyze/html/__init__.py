"""The program as one HTML file: its parts put together, with the core in WebAssembly and, if wanted, captures inside.

`page/` is what runs in the page, `worker/` what runs beside it and feeds the core, a file a part; nothing is loaded and
nothing but these scripts may run: the policy of the page names their hashes. Must not: open a capture.
"""

import base64
import hashlib
import json
import zlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from canalyze.dictionary import EFFECTS
from canalyze.errors import OutputError, SourceError
from canalyze.words import LANGUAGES, sentences

if TYPE_CHECKING:
    from canalyze.running.reading import Counted
    from canalyze.sources import Capture
    from canalyze.sources.compressed import Damage

    Part = Capture | Counted

FOLDER: Final = Path(__file__).parent
WASM: Final = FOLDER / "core.wasm.lzma"
"""Built and packed by `.ci/web`; not there in every installation."""
MOST: Final = 256 << 20
"""Characters of packed captures in a page; browsers keep no text of twice the length."""
PAGE: Final = (
    "say",
    "link",
    "list",
    "axis",
    "problems",
    "tables",
    "lanes",
    "plots",
    "recordings",
    "descriptions",
    "main",
)
WORKER: Final = ("lzma", "core", "columns", "capture", "frames", "tables", "requests", "main")
LEVEL: Final = 6
"""Of zlib: the next ones take twice the time for 1 % less."""
_GZIP: Final = 31
"""Bits of the window, with gzip's head around."""
_TOPICS: Final = ("html", "problem", "network", "direction", "status", "severity")
_SENTENCES: Final = (
    "diagnose.html_apart",
    "diagnose.html_check",
    "source.empty",
    "eds.concise",
    "eds.doctype",
    "eds.large",
    "eds.nothing",
    "eds.xml",
    "od.buses",
    "od.dcf_none",
    "od.left_out",
    "od.no_node",
    "od.written",
)
"""Those of the command line and of the report that the page has, too."""


def page(
    lang: str, options: Mapping[str, Any], captures: Iterable[Iterable["Part"]] = (), *, merge: bool = False
) -> bytes:
    """Returns the page whole, as `pieces` makes it."""
    return b"".join(pieces(lang, options, captures, merge=merge))


def pieces(
    lang: str,
    options: Mapping[str, Any],
    captures: Iterable[Iterable["Part"]] = (),
    *,
    merge: bool = False,
    some: bool = False,
    problem: int | None = None,
) -> Iterator[bytes]:
    """Returns the page piece by piece: an open capture is read while its pieces are taken, and nothing of it is kept.

    lang: shown first; options: of each session, by their names; captures: each with its files. merge: the files of a
    capture are joined by time; some: a file that cannot be read to its end ends there; problem: the number of the one
    that the page opens on, None for the most important. OutputError where the core for the page was not built, and,
    after some pieces, where the captures are too large for a page.
    """
    parts = {
        "wasm": base64.b64encode(core()).decode(),
        "worker": _scripts("worker", WORKER),
        "script": _scripts("page", PAGE),
    }
    parts["style"] = _style()
    parts["policy"] = _policy(parts["style"], parts["script"])
    parts["words"] = _json({one: _words(one) for one in LANGUAGES})
    parts["settings"] = _json({"lang": lang, "merge": merge, "options": dict(options), "effects": EFFECTS})
    return _filled(parts, _captures(captures, some=some, problem=problem))


def static(lang: str, title: str, body: str) -> bytes:
    """Returns a page in the style of the page, without scripts. title, body: as HTML."""
    style = _style()
    head = f'<meta charset="utf-8">\n<meta http-equiv="Content-Security-Policy" content="{_policy(style)}">'
    head += f'\n<meta name="color-scheme" content="light dark">\n<title>{title}</title>\n<style>{style}</style>'
    text = f'<!DOCTYPE html>\n<html lang="{lang}">\n<head>\n{head}\n</head>\n<body>\n{body}\n</body>\n</html>\n'
    return text.encode("utf-8", "backslashreplace")


def _style() -> str:
    return (FOLDER / "page" / "page.css").read_text(encoding="utf-8")


def core() -> bytes:
    """Returns the core for the page; OutputError where it was not built."""
    try:
        return WASM.read_bytes()
    except FileNotFoundError:
        raise OutputError("page.not_built") from None


def _filled(parts: Mapping[str, str], captures: Iterable[bytes]) -> Iterator[bytes]:
    """Fills the template."""
    first, *others = (FOLDER / "page" / "page.html").read_text(encoding="utf-8").split("{{")
    yield first.encode()
    for piece in others:
        name, _, rest = piece.partition("}}")
        if name == "captures":
            yield from captures
        else:
            yield parts[name].encode("utf-8", "backslashreplace")
        yield rest.encode()


def _scripts(folder: str, names: Iterable[str]) -> str:
    """Joins the files of a script, which shares no names with other scripts."""
    files = [(FOLDER / folder / f"{name}.js").read_text(encoding="utf-8") for name in names]
    text = "\n".join(('"use strict";', "{", *files, "}\n"))
    assert "</script" not in text and "<!--" not in text
    return text


def _policy(style: str, script: str | None = None) -> str:
    scripts = (f"script-src {_hash(script)} 'wasm-unsafe-eval'", "worker-src blob:") if script else ()
    rest = (f"style-src {_hash(style)}", "base-uri 'none'", "form-action 'none'")
    return "; ".join(("default-src 'none'", *scripts, *rest))


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def _words(lang: str) -> dict[str, str]:
    found = {key: text for topic in _TOPICS for key, text in sentences(topic, lang).items()}
    return found | {key: sentences(key.partition(".")[0], lang)[key] for key in _SENTENCES}


def _json(value: object) -> str:
    """Returns JSON that cannot end the element that it is in."""
    return json.dumps(value, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")


def _captures(captures: Iterable[Iterable["Part"]], *, some: bool, problem: int | None) -> Iterator[bytes]:
    """Returns each file as two elements: its bytes, packed, and what they are."""
    size = 0
    for recording, parts in enumerate(captures):
        for part in parts:
            yield b'<script type="text/plain" class="capture">'
            for packed in _packed_in_pieces(_read(part, some=some)):
                size += len(packed)
                if size > MOST:
                    raise OutputError("page.too_large", most=MOST >> 20)
                yield packed
            about = {"recording": recording, "name": Path(part.name).name, "format": part.format}
            said = _json(about | {"damage": _damage(part.damage), "problem": problem})
            yield f'</script><script type="application/json">{said}</script>\n'.encode("utf-8", "backslashreplace")


def _damage(damage: "Damage | None") -> Mapping[str, Any] | None:
    if damage is None:
        return None
    kind, offset, lost, since = damage
    kind, offset = (kind, offset) if since is None else ("doubtful", since)
    return {"kind": kind, "offset": offset, "bytes": lost}


def _read(part: "Part", *, some: bool) -> Iterator[bytes]:
    try:
        yield from iter(part.read, b"")
    except SourceError:
        if not some:
            raise


def _packed_in_pieces(pieces: Iterable[bytes]) -> Iterator[bytes]:
    """Returns bytes as gzip in base64; only the last piece is padded."""
    packer = zlib.compressobj(LEVEL, wbits=_GZIP)
    rest = b""
    for data in pieces:
        rest += packer.compress(data)
        whole = len(rest) - len(rest) % 3
        yield base64.b64encode(rest[:whole])
        rest = rest[whole:]
    yield base64.b64encode(rest + packer.flush())
