"""Which captures there are, what each of them is by its content, and how it gets to where it is read.

A capture of this machine is what its bytes are. While size, times and inode are the same, they are not read again. One
in a store is what its ETag and its size say. Must not: read what is in a capture.
"""

import errno
import hashlib
import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from stat import S_ISREG
from typing import Final

from canalyze import expectations
from canalyze.check.globs import glob
from canalyze.errors import SourceError
from canalyze.fleet.stores import is_url, listed, local, opened, reported, tag_of
from canalyze.sources.names import below, expanded, named_as_capture

_MAGIC: Final = frozenset("*?[")
_CHUNK: Final = 1 << 20


@dataclass(frozen=True, slots=True)
class Capture:
    """A capture to work on."""

    name: str
    """For people: as the source was given, and the rest of its path."""
    path: str
    """The file, wherever this process stands; of a store the name of its object."""
    store: str | None = None
    """The URL of its store."""
    stamp: str = ""
    """Of a store: ETag and size. Of a file size, times and inode; "" where it is none."""

    @property
    def id(self) -> str:
        """Give 32 hexadecimal digits that stand for its place, not for its content."""
        where = self.path if self.store is None else f"{self.store}/{self.path}"
        return hashlib.sha256(os.fsencode(where)).hexdigest()[:32]

    def in_shard(self, number: int, of: int) -> bool:
        """Tell whether it belongs to a shard, counted from 1: each capture to one of them."""
        return int(self.id, 16) % of == number - 1


def captures(sources: Iterable[str], out: str, *, beside: bool) -> list[Capture]:
    """List the captures of all sources, each once; SourceError for a source that has none.

    out: where results are written; what is in there is no capture. beside: expectations beside a capture are part of
    what it is.
    """
    results = None if is_url(out) else Path(local(out)).resolve()
    found: dict[str, Capture] = {}
    for source in sources:
        if is_url(source):
            some = [one for one in _stored(source) if not one.name.startswith(f"{out.rstrip('/')}/")]
        else:
            some = [
                Capture(name, str(Path(name).absolute()), None, stamp(name, beside=beside))
                for name in _files(local(source))
                if results is None or results not in Path(name).resolve().parents
            ]
        if not some:
            raise SourceError("fleet.none", name=source)
        found |= {one.id: one for one in some if one.id not in found}
    return list(found.values())


def _files(source: str) -> Iterator[str]:
    """Give the files of a folder that are named as captures are, or those that a name or a pattern stands for."""
    if Path(source).is_dir():
        yield from below(source)
        return
    for one in expanded([source]):
        if one.error is not None:
            raise one.error
        if not os.path.lexists(one.name):
            raise SourceError("source.open", name=one.name, error=OSError(errno.ENOENT, os.strerror(errno.ENOENT)))
        yield one.name


def _stored(source: str) -> Iterator[Capture]:
    """Give the objects that a URL stands for: one, those that fit a pattern, or those of a folder."""
    import re

    place = next((at for at, char in enumerate(source) if char in _MAGIC), len(source))
    store, _, last = source[:place].rpartition("/")
    alone = place == len(source) and last != "" and not store.endswith("/")
    wanted = glob(source[len(store) + 1 :]) if place < len(source) else None
    if alone:
        import obstore

        opened(store)
        with reported(source, SourceError):
            try:
                yield Capture(source, last, store, tag_of(obstore.head(opened(store), last)))
                return
            except FileNotFoundError:
                store = source
    elif wanted is None:
        store = source.rstrip("/")
    opened(store)
    with reported(source, SourceError):
        for path, _, tag in sorted(listed(store)):
            hidden = re.search(r"(^|/)[._]", path) is not None
            if wanted.names(path) if wanted else named_as_capture(path) and not hidden:
                yield Capture(f"{store}/{path}", path, store, tag)


def stamp(name: str, *, beside: bool) -> str:
    """Give size, times and inode of a file and of the expectations beside it: while they stay, so does the content."""
    found = []
    for path in _parts(name, beside=beside):
        try:
            status = path.stat()
        except (OSError, ValueError):
            return ""
        if not S_ISREG(status.st_mode):
            return ""
        found.append(f"{status.st_size}-{status.st_mtime_ns}-{status.st_ctime_ns}-{status.st_ino}")
    return " ".join(found)


def content(name: str, *, beside: bool) -> str:
    """Give what a file is, with the expectations beside it: the hash of all bytes; "" for a pipe, read once only."""
    found = []
    for path in _parts(name, beside=beside):
        if path.exists() and not path.is_file():
            return ""
        try:
            with path.open("rb") as file:
                found.append(hashlib.file_digest(file, "sha256").hexdigest())
        except OSError as error:
            raise SourceError("source.open", name=path, error=error) from error
    return " ".join(found)


def _parts(name: str, *, beside: bool) -> list[Path]:
    also = expectations.beside(name) if beside else None
    return [Path(name)] if also is None else [Path(name), also]


@contextmanager
def fetched(capture: Capture, scratch: str | None) -> Iterator[tuple[str, str]]:
    """Give a file with the bytes of a capture in a store and the tag of what came; it is removed afterwards.

    SourceError where it does not come as a whole.
    """
    import obstore

    assert capture.store is not None
    store = opened(capture.store)
    with tempfile.TemporaryDirectory(prefix="canalyze-", dir=scratch) as folder:
        path = Path(folder, "capture").with_suffix(Path(capture.path).suffix)
        with reported(capture.name, SourceError), path.open("wb") as file:
            answer = obstore.get(store, capture.path)
            meta = answer.meta
            for chunk in answer.stream(min_chunk_size=_CHUNK):
                file.write(chunk)
            came = file.tell()
        etag, _, listed_size = capture.stamp.rpartition(" ")
        size = int(listed_size) if meta["e_tag"] == etag else meta["size"]  # another ETag: it was written meanwhile
        if came != size:
            raise SourceError("fleet.cut", name=capture.name, came=came, size=size)
        yield str(path), tag_of(meta)
