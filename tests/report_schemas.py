"""The schemas that other programs hold reports against: Jenkins' of JUnit XML, the standard's of SARIF.

Neither is ours to copy into this repository, and no wheel holds them: they lie in the source archives of pytest, whose
own tests use Jenkins' schema, and of sarif-om, whose classes are made from SARIF's. pip fetches those, by their hash,
into `.cache`. Of the standard's final schema that one differs in a name of `suppression` that we do not write.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tarfile
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import xmlschema
from captures import TESTS

CACHE = TESTS.parent / ".cache" / "schemas"
JUNIT = (
    "pytest==8.4.2",
    "86c0d0b93306b961d58d62a4db4879f27fe25513d4b969df351abdddb3c30e01",
    "pytest-8.4.2/testing/example_scripts/junit-10.xsd",
)
SARIF = (
    "sarif-om==1.0.4",
    "cd5f416b3083e00d402a92e449a7ff67af46f11241073eea0461802a3b5aef98",
    "sarif_om-1.0.4/sarif-2.1.0-rtm.4.json",
)
"""Requirement, hash of its source archive, name of the schema in it."""


def fetched(source: tuple[str, str, str]) -> Path:
    """The schema; the test is skipped where it cannot be fetched, unless nothing may be missing."""
    schema = _fetched(source)
    if isinstance(schema, Path):
        return schema
    if os.environ.get("CANALYZE_TOOLS") == "required":
        pytest.fail(f"{schema}, and CANALYZE_TOOLS=required")
    pytest.skip(schema)


@cache
def _fetched(source: tuple[str, str, str]) -> Path | str:
    """The schema, or why there is none: a run without a network waits for it once."""
    requirement, digest, member = source
    schema = CACHE / Path(member).name
    if schema.is_file():
        return schema
    CACHE.mkdir(parents=True, exist_ok=True)
    # Others may fetch it at the same time: each has files of its own until the schema is there.
    wanted = CACHE / f"{schema.name}.{os.getpid()}.requirement"
    wanted.write_text(f"{requirement} --hash=sha256:{digest}\n")
    folder = CACHE / f"{schema.name}.{os.getpid()}.source"
    options = ["--no-deps", "--no-binary", requirement.split("==")[0], "--retries", "1", "--timeout", "20"]
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", *options]
    try:
        done = subprocess.run(
            [*command, "--require-hashes", "--dest", str(folder), "-r", str(wanted)],
            capture_output=True,
            text=True,
            check=False,
            timeout=180,
        )
    except subprocess.TimeoutExpired:
        return f"{requirement} cannot be fetched within three minutes"
    if done.returncode:
        return f"{requirement} cannot be fetched: {(done.stderr.strip().splitlines() or ['?'])[-1]}"
    (archive,) = folder.glob("*.tar.gz")
    with tarfile.open(archive) as packed:
        content = packed.extractfile(member)
        assert content is not None
        part = schema.with_suffix(f".{os.getpid()}.part")
        part.write_bytes(content.read())
    part.replace(schema)
    wanted.unlink()
    shutil.rmtree(folder)
    return schema


@cache
def junit_schema() -> xmlschema.XMLSchema:
    return xmlschema.XMLSchema(fetched(JUNIT))


@cache
def sarif_schema() -> Any:
    schema = json.loads(fetched(SARIF).read_text())
    kind = jsonschema.validators.validator_for(schema)
    kind.check_schema(schema)
    checker = jsonschema.FormatChecker()
    assert {"uri", "uri-reference"} <= set(checker.checkers), "the formats of URIs would pass unseen"
    return kind(schema, format_checker=checker)


def junit_faults(document: bytes) -> list[str]:
    """What Jenkins' schema finds wrong."""
    return [str(fault.reason) for fault in junit_schema().iter_errors(BytesIO(document))]


def sarif_faults(log: Any) -> list[str]:
    """What the schema of SARIF finds wrong."""
    return [f"{fault.json_path}: {fault.message}" for fault in sarif_schema().iter_errors(log)]
