"""A file that is compressed as it is written, whatever its content.

The same bytes give the same file: it contains no name and no date.
"""

from types import TracebackType

from canalyze.output import FileOutput
from canalyze.sources.compression import COMPRESSIONS


class CompressedOutput(FileOutput):
    """A compressed file; complete when its block ends without an error."""

    def __init__(self, name: str, compression: str, *, force: bool) -> None:
        """Creates the file `name`; `compression` is one of COMPRESSIONS."""
        self._compressor = COMPRESSIONS[compression].compressor()
        super().__init__(name, force=force)

    def write(self, data: bytes) -> None:
        """Compresses and writes."""
        super().write(self._compressor.compress(data))

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Writes the remaining output of the compressor, then ends as every file."""
        if kind is None:
            try:
                super().write(self._compressor.flush())
            except BaseException as failure:
                super().__exit__(type(failure), failure, failure.__traceback__)
                raise
        super().__exit__(kind, error, at)
