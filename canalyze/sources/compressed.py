"""Compressed files and text of another encoding, as the bytes that are in them.

A layer reads what the one below it gives and hands on pieces of bounded size, whatever they hold: memory does not grow
with what a file unpacks to. Damage ends it and is reported, never raised. Bytes go out before the check sum behind them
is seen: where that fails, or nothing can be unpacked up to it, all that came of its member may be wrong: reported
where the member begins. No format of captures is known here.
"""

import codecs
from typing import Final, NamedTuple, Protocol

from canalyze.sources.compression import COMPRESSIONS, HEAD, Decompressor, Gzip, errors

PIECE: Final = 1 << 20
"""Most bytes that one `read` gives."""
_TAKEN: Final = 1 << 12
"""Bytes that a decompressor gets at once: what it says of damage among them costs what else it has made of them."""
_KEPT: Final = 1 << 16
"""Bytes of a member that are kept, so that nothing that a small one holds before its damage is lost."""


class Damage(NamedTuple):
    """A file that cannot be unpacked any further."""

    kind: str
    """One of the core's kinds of damage."""
    offset: int
    """Where in the file as it is, in bytes."""
    lost: int | None
    """Bytes of the file from there on; None where nothing follows."""
    since: int | None = None
    """Where the member begins of which all that was given may be wrong; None: all that was given is sound."""


class Layer(Protocol):
    """Something that gives bytes."""

    @property
    def damage(self) -> Damage | None:
        """Why nothing comes any more, where it is the file's fault."""
        ...

    @property
    def begins(self) -> bool:
        """Whether the bytes given last are the first that a new check sum covers."""
        ...

    def read(self) -> bytes:
        """Give the next bytes, b"" at the end."""
        ...


class Unpacked:
    """What is in a compressed file: all its members one after the other, as if they were one."""

    def __init__(self, below: Layer, form: str) -> None:
        """`form` is one of COMPRESSIONS."""
        self.damage: Damage | None = None
        self.begins = False
        self.checked = True
        """Whether every member so far has a check sum."""
        self._below = below
        compression = COMPRESSIONS[form]
        self._new, self._signs = compression.decompressor, compression.signs
        self._has_sum = compression.checked
        self._member: Decompressor | None = None
        self._kept = b""
        """What the member has got, while it is little."""
        self._given = 0
        """What it has given, in bytes."""
        self._head = b""
        """Its first bytes."""
        self._start = 0
        """Where it begins in the file."""
        self._held = b""
        """What it has given from its beginning on, where that did not go out with what is of the members before it."""
        self._first = True
        self._raw = b""
        self._at = 0
        """Where `_raw` goes on."""
        self._offset = 0
        """Bytes of the file before `_raw`."""
        self._over = False

    def read(self) -> bytes:
        """Give what the next bytes of the file hold, at most PIECE; b"" at the end, or where damage ends it.

        All of it is of members that are over, or all of the one that is not: what may be wrong is counted from there.
        """
        self.begins = bool(self._held) or self._member is None or not self._given
        over: list[bytes] = []
        pieces, self._held = [self._held] if self._held else [], b""
        room = PIECE - sum(map(len, pieces))
        while room and not self.damage:
            member = self._member
            # Bytes are waited for only while there is nothing to give: lines of a pipe are answered when they come.
            if (member is None or member.needs_input) and self._at == len(self._raw) and not self._over:
                if over or pieces:
                    break
                self._offset += len(self._raw)
                self._raw, self._at = self._below.read(), 0
                self._over = not self._raw
            if member is None and not self._begin():
                if self._over:
                    break
                continue
            piece = self._step(room)
            if piece:
                pieces.append(piece)
                room -= len(piece)
            if self._member is None and not self.damage:
                over += pieces
                pieces = []
                self.begins = self.begins or not over
        if over:
            self._held, pieces = b"".join(pieces), over
        return b"".join(pieces)

    def _begin(self) -> bool:
        """Begin the next member; zeros before it are filling. False: there is none, or not yet."""
        if not self._first:
            rest = self._raw[self._at :].lstrip(b"\0")
            self._at = len(self._raw) - len(rest)
        longest = max(map(len, self._signs))
        while len(self._raw) - self._at < longest and self._at < len(self._raw) and not self._over:
            more = self._below.read()
            self._over = not more
            self._raw += more
        head = self._raw[self._at : self._at + longest]
        if not head:
            return False
        if not head.startswith(self._signs):
            begun = len(head) < longest and any(sign.startswith(head) for sign in self._signs)
            self._damaged("cut" if begun else "rest", self._at)
            return False
        self._first = False
        self._member, self._kept, self._given = self._new(), b"", 0
        self._head, self._start = b"", self._offset + self._at
        return True

    def _step(self, room: int) -> bytes:
        member = self._member
        assert member is not None
        data = self._raw[self._at : self._at + _TAKEN] if member.needs_input else b""
        if not data and member.needs_input:
            if self._over:
                self._damaged("cut", self._at)
            return b""
        self._at += len(data)
        self._look(data)
        again, behind = self._again(member, data)
        try:
            piece = member.decompress(data, room)
        except errors():
            piece, used = _bytewise(*again)
            self._given += len(piece)
            self._damaged("compression", self._at - behind + used, self._start if self._given else None)
            return piece
        self._given += len(piece)
        if member.eof:
            self._at -= len(member.unused_data)
            self._member = None
        return piece

    def _look(self, data: bytes) -> None:
        """Look at the first bytes of a member: whether it has a check sum."""
        if len(self._head) < HEAD:
            self._head += data[: HEAD - len(self._head)]
            self.checked = self.checked and self._has_sum(self._head)

    def _again(self, member: Decompressor, data: bytes) -> tuple[tuple[Decompressor | None, bytes, int], int]:
        """Give what is needed to unpack `data` again, should they be damaged, and how far back it begins."""
        if isinstance(member, Gzip):
            return (Gzip(member), data, 0), len(data)
        if len(self._kept) > _KEPT:
            return (None, b"", 0), len(data)
        self._kept += data
        return (self._new(), self._kept, self._given), len(self._kept)

    def _damaged(self, kind: str, at: int, since: int | None = None) -> None:
        """Nothing more can be unpacked: count what is left."""
        lost = len(self._raw) - at
        while kind != "cut" and (more := self._below.read()):
            lost += len(more)
        self.damage = Damage(kind, self._offset + at, None if kind == "cut" else lost, since)


def _bytewise(member: Decompressor | None, data: bytes, skipped: int) -> tuple[bytes, int]:
    """Unpack damaged bytes one by one; give what they hold behind what is skipped, and how many are sound."""
    pieces, used = b"", 0
    try:
        while member and len(pieces) < PIECE and not member.eof and (used < len(data) or not member.needs_input):
            byte = data[used : used + 1] if member.needs_input else b""
            piece = member.decompress(byte, PIECE)
            used += len(byte)
            pieces += piece[skipped:]
            skipped = max(0, skipped - len(piece))
    except errors():
        pass
    return pieces, used


class Transcoded:
    """Text of another encoding, as UTF-8. What cannot be read becomes U+FFFD."""

    def __init__(self, below: Layer, encoding: str) -> None:
        """`encoding` is a name that Python knows."""
        self._below = below
        self._decoder = codecs.getincrementaldecoder(encoding)("replace")
        self._over = False

    @property
    def damage(self) -> Damage | None:
        """What the layer below says."""
        return self._below.damage

    @property
    def begins(self) -> bool:
        """What the layer below says: a character that a member's end cuts belongs to the next one."""
        return self._below.begins

    def read(self) -> bytes:
        """Give the next bytes, b"" at the end."""
        text = ""
        while not text and not self._over:
            raw = self._below.read()
            self._over = not raw
            text = self._decoder.decode(raw, final=self._over)
        return text.encode("utf-8")
