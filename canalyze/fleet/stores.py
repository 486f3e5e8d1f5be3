"""The captures of a fleet, and where they and its results are: folders and object stores behind one interface.

A place has named objects, which are written atomically. Object stores are accessed through obstore, which reads
addresses and keys from the environment as the tools of each store do, and retries if a store is busy. A local capture
is identified by its bytes, which are not read again while size, times and inode stay the same; one in a store by ETag
and size. Must not: know the content of an object.
"""

import errno
import hashlib
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from datetime import timedelta
from functools import cache
from pathlib import Path
from stat import S_ISREG
from typing import TYPE_CHECKING, Any, Final, Protocol

from canalyze import expectations
from canalyze.errors import CanalyzeError, ConfigError, OutputError, SourceError, as_error
from canalyze.output.files import Part, write_all
from canalyze.sources.names import below, expanded, matching, named_as_capture

if TYPE_CHECKING:
    from obstore.store import ObjectStore

_URL: Final = re.compile(r"(?!file:)[a-z][a-z0-9+.-]+://")
_RETRIES: Final[dict[str, Any]] = {
    "max_retries": 8,
    "backoff": {"init_backoff": timedelta(milliseconds=100), "max_backoff": timedelta(seconds=15), "base": 2},
    "retry_timeout": timedelta(minutes=3),
}
_SAID: Final = 200
"""Maximum length of a store's message that is passed on."""


def is_url(name: str) -> bool:
    """Returns true if a name is a URL of an object store and not a file."""
    return _URL.match(name) is not None


def local(name: str) -> str:
    """Returns the name of a file without its scheme."""
    return name.removeprefix("file://")


class Place(Protocol):
    """A place of objects whose names have parts separated by `/`."""

    def names(self, folder: str) -> list[str]:
        """Returns the names of the objects in a folder, without the folder, in no order."""

    def get(self, name: str) -> bytes | None:
        """Returns an object; None if there is none of that name."""

    def put(self, name: str, data: bytes) -> None:
        """Writes or replaces an object. Raises OutputError if that fails."""

    def beside(self, name: str, scratch: str | None) -> AbstractContextManager[Path]:
        """Provides an empty folder for files in progress, which is removed afterwards."""

    def bring(self, path: Path, name: str) -> None:
        """Makes a file of such a folder an object. Raises OutputError if that fails."""

    def remove(self, name: str) -> None:
        """Removes an object, if it exists."""


def place(name: str) -> Place:
    """Returns the place of that name, a folder or a URL, without accessing it."""
    return _Bucket(name) if is_url(name) else _Folder(Path(local(name)))


class _Folder:
    """A folder of this machine."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def names(self, folder: str) -> list[str]:
        path = self._path / folder
        with as_error(SourceError, "source.open", name=path), suppress(FileNotFoundError):
            return [one.name for one in path.iterdir()]
        return []

    def get(self, name: str) -> bytes | None:
        path = self._path / name
        with as_error(SourceError, "source.open", name=path), suppress(FileNotFoundError):
            return path.read_bytes()
        return None

    def put(self, name: str, data: bytes) -> None:
        path = self._path / name
        with as_error(OutputError, "output.write", name=path):
            path.parent.mkdir(parents=True, exist_ok=True)
            part = Part(path, replace=True)
            try:
                try:
                    write_all(part.fd, data)
                finally:
                    os.close(part.fd)
                part.complete()
            except BaseException:
                part.discard()
                raise

    @contextmanager
    def beside(self, name: str, scratch: str | None) -> Iterator[Path]:
        folder = self._path / "_parts" / name  # where renaming is enough, and the next attempt finds it
        with as_error(OutputError, "output.write", name=folder):
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)
            with suppress(OSError):  # others are at work there
                folder.parent.rmdir()

    def bring(self, path: Path, name: str) -> None:
        final = self._path / name
        with as_error(OutputError, "output.write", name=final):
            final.parent.mkdir(parents=True, exist_ok=True)
            path.replace(final)

    def remove(self, name: str) -> None:
        with suppress(OSError):
            (self._path / name).unlink()


class _Bucket:
    """A folder of an object store."""

    def __init__(self, url: str) -> None:
        self._url = url

    def names(self, folder: str) -> list[str]:
        with reported(self._url, SourceError):
            return [path.removeprefix(f"{folder}/") for path, *_ in listed(self._url, folder)]

    def get(self, name: str) -> bytes | None:
        import obstore

        with reported(f"{self._url}/{name}", SourceError):
            try:
                return bytes(obstore.get(opened(self._url), name).bytes())
            except FileNotFoundError:
                return None

    def put(self, name: str, data: bytes | Path) -> None:
        import obstore

        with reported(f"{self._url}/{name}", OutputError):
            obstore.put(opened(self._url), name, data)

    @contextmanager
    def beside(self, name: str, scratch: str | None) -> Iterator[Path]:
        with tempfile.TemporaryDirectory(prefix="canalyze-", dir=scratch) as folder:
            yield Path(folder)

    def bring(self, path: Path, name: str) -> None:
        self.put(name, path)

    def remove(self, name: str) -> None:
        import obstore

        with reported(f"{self._url}/{name}", OutputError), suppress(FileNotFoundError):
            obstore.delete(opened(self._url), name)


@cache
def opened(url: str) -> "ObjectStore":
    """Returns the store of a URL whose whole path is a prefix of its objects. Raises ConfigError without obstore."""
    with as_error(ConfigError, "fleet.needs", ImportError, name="obstore", extra="fleet"):
        from obstore.store import from_url
    plain: dict[str, Any] = {"client_options": {"allow_http": True}} if url.startswith("http:") else {}
    with reported(url, SourceError):
        return from_url(url, retry_config=_RETRIES, **plain)


def listed(url: str, folder: str = "") -> Iterator[tuple[str, int, str]]:
    """Yields name, size and tag of every object of a store below a folder. Raises the errors of obstore."""
    import obstore

    for page in obstore.list(opened(url), folder or None):
        yield from ((one["path"], one["size"], tag_of(one)) for one in page)


def tag_of(meta: Any) -> str:
    """Returns a tag that changes with the object: its ETag, or else its time, and its size."""
    return f"{meta['e_tag'] or meta['last_modified'].isoformat()} {meta['size']}"


@contextmanager
def reported(name: str, kind: Callable[..., CanalyzeError]) -> Iterator[None]:
    """Converts exceptions of a store to errors of kind `kind` with their first line."""
    try:
        yield
    except CanalyzeError:
        raise
    except Exception as error:  # its classes have no common root but this one
        said = (str(error).splitlines() or [type(error).__name__])[0][:_SAID]
        raise kind("fleet.store", name=name, problem=said) from error


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

    @property
    def size(self) -> int:
        """Size in bytes, 0 for a pipe."""
        return int((self.stamp.rpartition(" ")[2] if self.store else self.stamp.partition("-")[0]) or 0)

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
                if results is None or not Path(name).resolve().is_relative_to(results)
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
        with as_error(SourceError, "source.open", name=path), path.open("rb") as file:
            found.append(hashlib.file_digest(file, "sha256").hexdigest())
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
