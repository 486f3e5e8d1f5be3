"""The captures of a fleet, their content hashes, and their download.

A local capture is identified by its bytes, which are not read again while size, times and inode stay the same; one
in a store by ETag and size. Must not: read the content of a capture.
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
from canalyze.errors import SourceError
from canalyze.fleet.stores import is_url, listed, local, opened, reported, tag_of
from canalyze.sources.names import below, expanded, matching, named_as_capture

_MAGIC: Final = frozenset("*?[")
_CHUNK: Final = 1 << 20


@dataclass(frozen=True, slots=True)
class Capture:
    """A capture to process."""

    name: str
    """The name in messages: the source as it was given, and the rest of the path."""
    path: str
    """The absolute path of the file; in a store the name of the object."""
    store: str | None = None
    """The URL of its store."""
    stamp: str = ""
    """In a store ETag and size; of a file size, times and inode, or "" for a pipe."""

    @property
    def id(self) -> str:
        """32 hexadecimal digits for its location, not for its content."""
        where = self.path if self.store is None else f"{self.store}/{self.path}"
        return hashlib.sha256(os.fsencode(where)).hexdigest()[:32]

    def in_shard(self, number: int, of: int) -> bool:
        """Returns true if it belongs to a shard, counted from 1. Each capture belongs to one shard."""
        return int(self.id, 16) % of == number - 1


def captures(sources: Iterable[str], out: str, *, beside: bool) -> list[Capture]:
    """Returns the captures of all sources without duplicates. Raises SourceError for a source without captures.

    out: the place of the results, which is excluded. beside: expectations beside a capture are part of its identity.
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
    """Yields the captures of a folder, or the files that match a name or a pattern."""
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
    """Yields the objects of a URL: a single one, those that match a pattern, or those of a folder."""
    import re

    place = next((at for at, char in enumerate(source) if char in _MAGIC), len(source))
    store, _, last = source[:place].rpartition("/")
    alone = place == len(source) and last != "" and not store.endswith("/")
    wanted = matching(source[len(store) + 1 :]) if place < len(source) else None
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
            if wanted.fullmatch(path) if wanted else named_as_capture(path) and not hidden:
                yield Capture(f"{store}/{path}", path, store, tag)


def stamp(name: str, *, beside: bool) -> str:
    """Returns size, times and inode of a file and of the expectations beside it, which change with the content."""
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
    """Returns the hash of a file and of the expectations beside it; "" for a pipe, which can be read only once."""
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
    """Downloads a capture from a store to a temporary file; the context is its path, and the tag of its content.

    Raises SourceError if the download is incomplete.
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
