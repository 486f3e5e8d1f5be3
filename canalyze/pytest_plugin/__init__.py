"""The pytest plugin: captures in tests, and annotated lines where an assertion fails.

`-p no:canalyze` turns it off. Until a fixture is used it imports nothing but pytest: every pytest run of an environment
loads it. Must not: make a test pass or fail by itself.
"""

import sys
from collections.abc import Generator, Iterator
from typing import TYPE_CHECKING, Any, Final, Protocol

import pytest

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Unpack

    from canalyze.library import Options, StrPath
    from canalyze.library.capture import Capture
    from canalyze.words import Words


class Opener(Protocol):
    """The fixture `canalyze_open`."""

    def __call__(self, path: "StrPath | Sequence[StrPath]", **options: "Unpack[Options]") -> "Capture":
        """Opens a capture as `canalyze.open` does, with names relative to the folder of the test's file."""


CAPTURES: "Final[pytest.StashKey[list[Capture]]]" = pytest.StashKey()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds the setting canalyze_lang."""
    from canalyze.words import Words

    parser.addini("canalyze_lang", Words("en")("test.lang"), default="en")


def language(config: pytest.Config) -> "Words":
    """Returns the words in the language of the configuration."""
    from canalyze.words import LANGUAGES, Words

    lang = str(config.getini("canalyze_lang"))
    if lang not in LANGUAGES:
        raise pytest.UsageError(f"canalyze_lang = {lang}: {' '.join(LANGUAGES)}")
    return Words(lang)


def pytest_configure(config: pytest.Config) -> None:
    """Checks the setting canalyze_lang."""
    language(config)


@pytest.fixture
def canalyze_open(request: pytest.FixtureRequest) -> Iterator[Opener]:
    """Opens captures as `canalyze.open` does, with names relative to the folder of the test's file."""
    import canalyze

    captures = request.node.stash.setdefault(CAPTURES, [])
    lang = language(request.config).lang

    def opened(path: "StrPath | Sequence[StrPath]", **options: "Unpack[Options]") -> "Capture":
        __tracebackhide__ = True
        given: Any = {"folder": request.path.parent, "lang": lang, **options}
        try:
            capture = canalyze.open(path, **given)
        except (canalyze.CanalyzeError, ValueError) as error:  # a mistake in the call, not in what it calls
            raise error.with_traceback(None) from None
        captures.append(capture)
        return capture

    yield opened
    for capture in captures:
        capture.close()


def pytest_assertrepr_compare(config: pytest.Config, op: str, left: object, right: object) -> list[str] | None:
    """Explains the differences of two transfers, findings or lists of them."""
    if "canalyze.library.rows" not in sys.modules:
        return None
    from canalyze.pytest_plugin.assertion import compared

    return compared(op, left, right, language(config))


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Generator[None, Any, None]:
    """Adds the annotated lines of the subject of a failed assertion."""
    outcome = yield
    report: pytest.TestReport = outcome.get_result()
    if not report.failed or call.excinfo is None or "canalyze.library.capture" not in sys.modules:
        return
    if call.excinfo.errisinstance(AssertionError):
        from canalyze.pytest_plugin.assertion import sections

        captures: list[Capture] = item.stash.setdefault(CAPTURES, [])
        report.sections += sections(call.excinfo, captures, language(item.config))
