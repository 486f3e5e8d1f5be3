"""What a file is when it is no text of candump, told by its first bytes.

Only to say so in one line: nothing is decompressed or read here. Every sign is one that no text of candump begins with.
"""

import re
import shlex
from typing import Final

from canalyze.errors import SourceError

_PACKED: Final = (
    (rb"\x1f\x8b", "gzip", "zcat"),
    (rb"\xfd7zXZ\x00", "xz", "xzcat"),
    (rb"\x28\xb5\x2f\xfd", "zstd", "zstdcat"),
    (rb"BZh[1-9](?:1AY&SY|\x17rE8P\x90)", "bzip2", "bzcat"),
)
"""(first bytes, name of the compression, program that undoes it)."""
_ENCODED: Final = (
    (rb"\xff\xfe|\xfe\xff", "UTF-16"),
    (rb"(?:[\t\n\r -~]\x00){2}", "UTF-16LE"),
    (rb"(?:\x00[\t\n\r -~]){2}", "UTF-16BE"),
)
_OTHER: Final = (
    (rb"\xa1\xb2(?:\xc3\xd4|\x3c\x4d)|(?:\xd4\xc3|\x4d\x3c)\xb2\xa1", "pcap"),
    (rb"\n\r\r\n....(?:\x1a\x2b\x3c\x4d|\x4d\x3c\x2b\x1a)", "pcapng"),
    (rb"\s*(?:date [^\r\n]*\r?\n\s*)?base +(?:hex|dec)\b", "Vector ASC"),
    (rb"LOGG..\x00\x00", "Vector BLF"),
    (rb"\x89MCAP0\r\n", "MCAP"),
)
"""(first bytes, name of the format): captures all, which are not read yet."""


def refuse(name: str, head: bytes, command: str) -> None:
    """Raise SourceError if `head`, the first bytes of the input called `name`, begins something else than text.

    command: what was typed, such as `canalyze decode`.
    """
    file = "" if name == "stdin" else f" {shlex.quote(name)}"
    for sign, kind, program in _PACKED:
        if re.match(sign, head, re.DOTALL):
            raise SourceError("source.packed", name=name, kind=kind, line=f"{program}{file} | {command} -")
    for sign, kind in _ENCODED:
        if re.match(sign, head, re.DOTALL):
            line = f"iconv -f {kind} -t UTF-8{file} | {command} -"
            raise SourceError("source.encoded", name=name, kind=kind, line=line)
    for sign, kind in _OTHER:
        if re.match(sign, head, re.DOTALL):
            raise SourceError("source.other", name=name, kind=kind)
