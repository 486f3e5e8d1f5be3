"""`canalyze.open`: what is asked for in Python, as the settings by which a capture is read.

It checks what it is given at once and reads descriptions, not captures. It must not print, and it looks for no
canalyze.toml: what a program means does not depend on the folder in which it is started.
"""

import os
from collections.abc import Iterable, Sequence
from typing import IO, TYPE_CHECKING, Any, Literal, Protocol, TypeAlias, TypedDict

if TYPE_CHECKING:
    from can import Message
    from canopen import ObjectDictionary

    from canalyze.library.capture import Capture

StrPath: TypeAlias = str | os.PathLike[str]
Described: TypeAlias = "StrPath | ObjectDictionary"
"""A description of a device: its file, or what python-canopen has of it."""


class McapReader(Protocol):
    """A reader of `mcap.reader`."""

    def iter_messages(self, *, log_time_order: bool = True) -> Iterable[tuple[Any, ...]]:
        """Yields schema, channel and message of each."""


Source: TypeAlias = (
    "StrPath | bytes | bytearray | memoryview | IO[bytes] | McapReader | Iterable[StrPath | Message | tuple[Any, ...]]"
)
"""The sources of a capture; `open` lists them."""


class ByNode(Protocol):
    """Descriptions by node-ID, or by bus and node-ID: a dictionary whose keys may be of one kind, or of both."""

    def items(self) -> Iterable[tuple[int | tuple[str, int], Described]]:
        """Returns nodes and descriptions."""


Descriptions: TypeAlias = ByNode | Sequence[str]


class Known(TypedDict, total=False):
    """The options of `Listener` and `live`, and of `open`, which says what they mean."""

    eds: Descriptions
    cob: Iterable[str]
    pdo: Iterable[str]
    profile: Iterable[str]
    sdo: Iterable[str]
    sync_period: str | int | None
    sync_window: str | int | None
    jitter: str | int | None
    bitrate: str | int | None
    filter: str | None
    lang: Literal["en", "zh"]
    config: StrPath | None
    folder: StrPath | None


class Options(Known, total=False):
    """The options of `open`, which says what they mean."""

    stamps: Literal["auto", "absolute", "zero", "delta"]
    input_format: str | None
    merge: bool
    topic: Iterable[str]
    time_source: Literal["stamp", "publish", "log"] | None
    mcap_map: Iterable[str]


def open(  # noqa: A001  canalyze.open, as tarfile.open
    source: Source,
    *,
    eds: Descriptions = (),
    cob: Iterable[str] = (),
    pdo: Iterable[str] = (),
    profile: Iterable[str] = (),
    sdo: Iterable[str] = (),
    sync_period: str | int | None = None,
    sync_window: str | int | None = None,
    jitter: str | int | None = None,
    bitrate: str | int | None = None,
    filter: str | None = None,  # noqa: A002  the command line's word
    lang: Literal["en", "zh"] = "en",
    config: StrPath | None = None,
    folder: StrPath | None = None,
    stamps: Literal["auto", "absolute", "zero", "delta"] = "auto",
    input_format: str | None = None,
    merge: bool = False,
    topic: Iterable[str] = (),
    time_source: Literal["stamp", "publish", "log"] | None = None,
    mcap_map: Iterable[str] = (),
) -> "Capture":
    """Opens a capture; it is read when it is asked for something.

    source: a file in any format that canalyze reads, compressed or not; several, which are one capture, read in the
    given order; the content of such a file as bytes, or a file that is open for reading bytes, which is read at once
    and stays open; messages of python-can (a list, a generator, one of its readers), which are taken at once, where
    stamps of 0 count as none if no message has another; a reader of `mcap.reader`, or the messages it iterates over
    (extra `mcap`). A bus is listened to with `live` or `Listener`.
    eds: which device is which, `{5: "drive.eds", ("can1", 6): "io.dcf"}`, or as --eds: `["5=drive.eds", "1-4=io.eds"]`.
    A `canopen.ObjectDictionary` may stand for a file.
    cob: which CAN-ID carries which PDO, as --cob: `["1A5=5.TPDO1"]`.
    pdo: what a PDO carries, as --pdo: `["185=6041:16,6064:32"]`. profile: nodes with the default mappings of a profile,
    as --profile: `["5=402"]`.
    sdo: further SDO channels, as --sdo: `["640,5C0=5"]`.
    sync_period, sync_window, jitter: in microseconds, or with a unit (`"10ms"`): 1006h, 1007h, and the error of the
    stamps to allow for. What the capture shows overrules the first two.
    bitrate: in bit/s, or `"500k"`.
    filter: which frames are told of, as --filter: `"service=sdo node=5 t=1.0..2.5"`. State comes from every frame.
    lang: the language of `text` and `message`, and of names in tables of columns; other names are the same in each.
    English whatever the environment says.
    config: a canalyze.toml whose network counts too; none is looked for.
    folder: where relative names, also those of descriptions, are looked for; the current directory by default.
    stamps: what small stamps mean. input_format: what the files are, where their content does not tell.
    merge: files are joined by time, not read one after the other.
    topic, time_source, mcap_map: how MCAP is read, as the options of these names.

    SourceError for a capture or description that is missing or cannot be read (of a capture's content only once it is
    read), ConfigError for a configuration that cannot be, TypeError and ValueError, which name the argument, for one
    of a kind or a value that cannot be. Damage and lines that cannot be read are no error but `Capture.complaints`.
    """
    given: Any = dict(locals())  # what comes before is the parameters alone
    del given["source"]
    from canalyze.library.capture import Capture
    from canalyze.library.plan import inputs, plan

    made = plan("open", given)
    return Capture(made, inputs(source, made))
