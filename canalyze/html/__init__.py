"""The program as one HTML file: its parts put together, with the core in WebAssembly and, if wanted, captures inside.

`page/` is what runs in the page, `worker/` what runs beside it and feeds the core, a file a part; nothing is loaded and
nothing but these scripts may run: the policy of the page names their hashes. Must not: read a capture.
"""

import base64
import gzip
import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

from canalyze.errors import OutputError
from canalyze.words import LANGUAGES, sentences

FOLDER: Final = Path(__file__).parent
WASM: Final = FOLDER / "core.wasm"
"""Built by `.ci/web`; not there in every installation."""
MOST: Final = 256 << 20
"""Characters of packed captures in a page; browsers keep no text of twice the length."""
PAGE: Final = ("say", "link", "list", "axis", "problems", "tables", "lanes", "plots", "recordings", "main")
WORKER: Final = ("core", "columns", "capture", "frames", "tables", "requests", "main")
_TOPICS: Final = ("html", "problem")
_DIAGNOSE: Final = ("diagnose.html_apart", "diagnose.html_check")
"""What the page has in common with the report."""


class Part(NamedTuple):
    """A file of a capture, as the core reads it."""

    name: str
    """For people."""
    format: str
    data: bytes
    """Unpacked, as the session is fed."""
    damage: Mapping[str, Any] | None = None
    """Why it goes on no further: kind, offset, bytes."""


def page(
    lang: str, options: Mapping[str, Any], captures: Iterable[Sequence[Part]] = (), *, merge: bool = False
) -> bytes:
    """Return the page. lang: shown first; options: of each session, by their names; captures: each with its files.

    merge: the files of a capture are joined by time. OutputError where the core for the page was not built, or where
    the captures are too large for a page.
    """
    try:
        core = WASM.read_bytes()
    except FileNotFoundError:
        raise OutputError("page.not_built") from None
    style = (FOLDER / "page" / "page.css").read_text(encoding="utf-8")
    script = _scripts("page", PAGE)
    parts = {
        "policy": _policy(style, script),
        "style": style,
        "words": _json({one: _words(one) for one in LANGUAGES}),
        "settings": _json({"lang": lang, "merge": merge, "options": dict(options)}),
        "captures": _captures(captures),
        "worker": _scripts("worker", WORKER),
        "wasm": _packed(core),
        "script": script,
    }
    pieces = (FOLDER / "page" / "page.html").read_text(encoding="utf-8").split("{{")
    text = [pieces[0]]
    for piece in pieces[1:]:
        name, _, rest = piece.partition("}}")
        text += [parts[name], rest]
    return "".join(text).encode()


def _scripts(folder: str, names: Iterable[str]) -> str:
    """Put the files of a script together, as one that shares nothing with what is outside."""
    files = [(FOLDER / folder / f"{name}.js").read_text(encoding="utf-8") for name in names]
    text = "\n".join(('"use strict";', "{", *files, "}\n"))
    assert "</script" not in text and "<!--" not in text
    return text


def _policy(style: str, script: str) -> str:
    return "; ".join(
        (
            "default-src 'none'",
            f"script-src {_hash(script)} 'wasm-unsafe-eval'",
            "worker-src blob:",
            f"style-src {_hash(style)}",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def _words(lang: str) -> dict[str, str]:
    found = {key: text for topic in _TOPICS for key, text in sentences(topic, lang).items()}
    return found | {key: sentences("diagnose", lang)[key] for key in _DIAGNOSE}


def _json(value: object) -> str:
    """Return JSON that cannot end the element that it is in."""
    return json.dumps(value, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")


def _captures(captures: Iterable[Sequence[Part]]) -> str:
    found: list[str] = []
    size = 0
    for recording, parts in enumerate(captures):
        for part in parts:
            about = {"recording": recording, "name": part.name, "format": part.format, "damage": part.damage}
            said = _json(about).replace("&", "&amp;").replace('"', "&quot;")
            packed = _packed(part.data)
            found.append(f'<script type="text/plain" class="capture" data-about="{said}">{packed}</script>\n')
            size += len(packed)
            if size > MOST:
                raise OutputError("page.too_large", most=MOST >> 20)
    return "".join(found)


def _packed(data: bytes) -> str:
    return base64.b64encode(gzip.compress(data, 9, mtime=0)).decode()
