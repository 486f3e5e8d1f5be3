"""Pages above the views: the keys, the details of a node, the meaning of a frame or a rule.

A page is made once when it is opened, and can be scrolled. Any other key closes it. Must not: decode, or query
anything that was not passed to it.
"""

from collections.abc import Sequence
from typing import ClassVar, Final

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text
from textual import events
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import VerticalScroll
from textual.screen import ModalScreen
from textual.widgets import Static

from canalyze import _core
from canalyze.monitor.grid import STYLES
from canalyze.output import printable
from canalyze.records.live import MappedObject, Node, NodeDetails
from canalyze.words import Words

_CLASSIC: Final = 8
"""Maximum number of data bytes of a classic CAN frame."""


class Page(ModalScreen[bool]):
    """A page; its result is True if Enter closed it."""

    CSS = """
    Page { background: ansi_default; }
    Page VerticalScroll { background: ansi_default; scrollbar-size-vertical: 1; }
    """
    BINDINGS: ClassVar = [Binding("ctrl+c,ctrl+q", "app.end", show=False, priority=True)]

    def __init__(self, shown: RenderableType) -> None:
        """Creates a page with its content."""
        super().__init__()
        self._shown = shown

    def compose(self) -> ComposeResult:
        """Yields the content."""
        with VerticalScroll():
            yield Static(self._shown)

    def on_key(self, event: events.Key) -> None:
        """Closes the page."""
        event.stop()
        event.prevent_default()
        self.dismiss(event.key == "enter")


def listed(title: str, rows: Sequence[tuple[str, str]], below: str) -> RenderableType:
    """Returns a page of names with their descriptions."""
    table = _grid(2)
    for name, what in rows:
        table.add_row(_text(f" {name}", "key"), _text(what))
    return Group(_text(f" {title}", "strong"), table, _text(f" {below}", "dim"))


def of_node(node: Node, known: NodeDetails, words: Words) -> RenderableType:
    """Returns the page of a node: `node` is its row of a snapshot, `known` its page of the core."""
    head = words("monitor.of_node", node=words("monitor.node", node=node.node), name=node.name).strip()
    identity = _grid(3)
    for one in known.identity:
        identity.add_row(_text(f"  {one.object}", "strong"), _text(one.name or ""), _text(one.text))
    pdos = _grid(4)
    for pdo in known.pdos:
        kind = "" if pdo.type is None else words("monitor.transmission", type=pdo.type)
        off = "" if pdo.valid else words("monitor.pdo_off")
        pdos.add_row(
            _text(f"  {pdo.pdo}", "strong" if pdo.valid else "dim"),
            _text(f"{pdo.id}h"),
            _text("  ".join(filter(None, (off or kind, words.of("monitor_from", pdo.origin or "")))), "dim"),
            Text("\n").join(_mapped(one, words) for one in pdo.objects),
        )
    parts: list[RenderableType] = [_text(f" {head}", "strong")]
    for key, table in (("identity", identity), ("pdos", pdos)):
        title = "monitor_known" if table.row_count else "monitor_unknown"
        parts += ["", _text(f" {words.of(title, key)}", "" if table.row_count else "dim"), table]
    return Group(*parts, "", _text(f" {words('monitor.page_frames')}", "dim"))


def of_finding(words: Words, code: str, text: str) -> RenderableType:
    """Returns the explanation of the rule of a finding."""
    explained = _core.explain(code, words.lang) or ""
    end = words("monitor.page_frame")
    return Group(_text(f" {code}  {text}", "strong"), "", *_lines(explained), "", _text(f" {end}", "dim"))


def of_frame(words: Words, cob: str, data: str, text: str) -> RenderableType:
    """Returns a frame field by field, below its line."""
    octets = "".join(part for part in data.split() if len(part) == 2)
    remote = bool(data) and not octets
    separator = "##0" if len(octets) > 2 * _CLASSIC else "#"
    explained = _core.explain(f"{cob}{separator}{'R' if remote else octets}", words.lang) if cob else None
    lines = (explained or "").splitlines()[1:]
    head = [_text(f" {part}", "strong") for part in (f"{cob}  {data}".strip(), text)]
    return Group(*head, "", *_lines("\n".join(lines)), "", _text(f" {words('monitor.page_back')}", "dim"))


def _lines(text: str) -> list[Text]:
    return [_text(f" {line.removeprefix('#')}") for line in text.splitlines()]


def _mapped(one: MappedObject, words: Words) -> Text:
    return _text(words("monitor.mapped", object=one.object, name=one.name or "", bits=one.bits))


def _grid(columns: int) -> Table:
    table = Table.grid(padding=(0, 2))
    for _ in range(columns):
        table.add_column()
    return table


def _text(text: str, look: str = "") -> Text:
    """Returns a text without markup or characters that could control a terminal."""
    return Text(printable(text), STYLES[look])
