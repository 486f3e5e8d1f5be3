"""Folders and object stores behind one interface: a place of named objects.

Objects are written atomically. Object stores are accessed through obstore, which reads addresses and keys from the
environment as the tools of each store do, and retries if a store is busy. Must not: know the content of an object.
"""

import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from datetime import timedelta
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol

from canalyze.errors import CanalyzeError, ConfigError, OutputError, SourceError
from canalyze.output.writing import Part, write_all

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
        try:
            return [one.name for one in (self._path / folder).iterdir()]
        except FileNotFoundError:
            return []
        except OSError as error:
            raise SourceError("source.open", name=self._path / folder, error=error) from error

    def get(self, name: str) -> bytes | None:
        try:
            return (self._path / name).read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise SourceError("source.open", name=self._path / name, error=error) from error

    def put(self, name: str, data: bytes) -> None:
        import os

        path = self._path / name
        try:
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
        except OSError as error:
            raise OutputError("output.write", name=path, error=error) from error

    @contextmanager
    def beside(self, name: str, scratch: str | None) -> Iterator[Path]:
        folder = self._path / "_parts" / name  # where renaming is enough, and the next attempt finds it
        try:
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
        except OSError as error:
            raise OutputError("output.write", name=folder, error=error) from error
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)
            with suppress(OSError):  # others are at work there
                folder.parent.rmdir()

    def bring(self, path: Path, name: str) -> None:
        final = self._path / name
        try:
            final.parent.mkdir(parents=True, exist_ok=True)
            path.replace(final)
        except OSError as error:
            raise OutputError("output.write", name=final, error=error) from error

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

    def put(self, name: str, data: bytes) -> None:
        import obstore

        with reported(f"{self._url}/{name}", OutputError):
            obstore.put(opened(self._url), name, data)

    @contextmanager
    def beside(self, name: str, scratch: str | None) -> Iterator[Path]:
        with tempfile.TemporaryDirectory(prefix="canalyze-", dir=scratch) as folder:
            yield Path(folder)

    def bring(self, path: Path, name: str) -> None:
        import obstore

        with reported(f"{self._url}/{name}", OutputError):
            obstore.put(opened(self._url), name, path)

    def remove(self, name: str) -> None:
        import obstore

        with reported(f"{self._url}/{name}", OutputError), suppress(FileNotFoundError):
            obstore.delete(opened(self._url), name)


@cache
def opened(url: str) -> "ObjectStore":
    """Returns the store of a URL whose whole path is a prefix of its objects. Raises ConfigError without obstore."""
    try:
        from obstore.store import from_url
    except ImportError as error:
        raise ConfigError("fleet.needs", error=error, name="obstore", extra="fleet") from error
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
