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
"""Number of bytes passed to a decompressor at once; damage among them costs all of their output."""
_KEPT: Final = 1 << 16
"""Bytes of a member that are kept, so that the sound part of a small damaged member is not lost."""


class Damage(NamedTuple):
    """The point from which a file cannot be unpacked."""

    kind: str
    """One of the core's kinds of damage."""
    offset: int
    """The offset in the compressed file, in bytes."""
    lost: int | None
    """Bytes of the file from there on; None if it ends there."""
    since: int | None = None
    """Where the member begins whose output may be wrong; None if all output is sound."""


class Layer(Protocol):
    """A source of bytes."""

    @property
    def damage(self) -> Damage | None:
        """The damage of the file that ended the data, if any."""
        ...

    @property
    def begins(self) -> bool:
        """True if the bytes returned last are the first that a new checksum covers."""
        ...

    def read(self) -> bytes:
        """Returns the next bytes, b"" at the end."""
        ...


class Unpacked:
    """The content of a compressed file, with all its members joined."""

    def __init__(self, below: Layer, form: str) -> None:
        """`form` is one of COMPRESSIONS."""
        self.damage: Damage | None = None
        self.begins = False
        self.checked = True
        """True if every member so far has a checksum."""
        self._below = below
        compression = COMPRESSIONS[form]
        self._new, self._signs = compression.decompressor, compression.signs
        self._has_sum = compression.checked
        self._member: Decompressor | None = None
        self._kept = b""
        """The input of the current member, while it is small."""
        self._given = 0
        """Number of bytes that the member has produced."""
        self._head = b""
        """Its first bytes."""
        self._start = 0
        """Its offset in the file."""
        self._held = b""
        """Output of the member that is returned by the next `read`, after that of the members before it."""
        self._first = True
        self._raw = b""
        self._at = 0
        """The position in `_raw`."""
        self._offset = 0
        """Bytes of the file before `_raw`."""
        self._over = False

    def read(self) -> bytes:
        """Returns up to PIECE bytes of the content; b"" at the end, or where damage ends it.

        They are all of finished members, or all of the current one, so that `Damage.since` can name what may be wrong.
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
        """Begins the next member, skipping zero padding; returns false if there is none, or not yet."""
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
        """Reads from the first bytes of a member if it has a checksum."""
        if len(self._head) < HEAD:
            self._head += data[: HEAD - len(self._head)]
            self.checked = self.checked and self._has_sum(self._head)

    def _again(self, member: Decompressor, data: bytes) -> tuple[tuple[Decompressor | None, bytes, int], int]:
        """Returns the state from which `data` can be unpacked again if it is damaged, and how far back it begins."""
        if isinstance(member, Gzip):
            return (Gzip(member), data, 0), len(data)
        if len(self._kept) > _KEPT:
            return (None, b"", 0), len(data)
        self._kept += data
        return (self._new(), self._kept, self._given), len(self._kept)

    def _damaged(self, kind: str, at: int, since: int | None = None) -> None:
        """Records the damage and counts the bytes that are left."""
        lost = len(self._raw) - at
        while kind != "cut" and (more := self._below.read()):
            lost += len(more)
        self.damage = Damage(kind, self._offset + at, None if kind == "cut" else lost, since)


def _bytewise(member: Decompressor | None, data: bytes, skipped: int) -> tuple[bytes, int]:
    """Unpacks damaged bytes one by one; returns the output after `skipped` bytes, and the number of sound bytes."""
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
    """Text of another encoding as UTF-8; undecodable bytes become U+FFFD."""

    def __init__(self, below: Layer, encoding: str) -> None:
        """`encoding` is a name that Python knows."""
        self._below = below
        self._decoder = codecs.getincrementaldecoder(encoding)("replace")
        self._over = False

    @property
    def damage(self) -> Damage | None:
        """The damage of the layer below."""
        return self._below.damage

    @property
    def begins(self) -> bool:
        """The state of the layer below; a character that a member boundary splits belongs to the next member."""
        return self._below.begins

    def read(self) -> bytes:
        """Returns the next bytes, b"" at the end."""
        text = ""
        while not text and not self._over:
            raw = self._below.read()
            self._over = not raw
            text = self._decoder.decode(raw, final=self._over)
        return text.encode("utf-8")
