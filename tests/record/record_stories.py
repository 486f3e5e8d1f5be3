"""Records stories: networks in which something really goes wrong, with the truth beside each.

    python tests/record/record_stories.py [--into DIRECTORY] [NAME]...

Needs Linux with an interface vcan0 that is up, candump of can-utils in PATH, and the packages canopen and python-can.
DIRECTORY (default: samples/stories) gets NAME.log (`candump -L`) and NAME.json, the truth: its words are those of
samples/stories/NAME.json, which a new story needs first, its lines are those of the new recording. A recording during
which the machine stood still, or that lacks a frame which its story tells of, is made again.

What it must not do: ask canalyze anything.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable
from pathlib import Path

import stories_of_commands
import stories_of_configuration
import stories_of_drives
import stories_of_loss
import stories_of_monitoring
import stories_of_services
from story_log import MissingFrame
from story_plant import Plant, Tale

TARGET = Path(__file__).resolve().parents[2] / "samples" / "stories"
ATTEMPTS = 5
SETTINGS: dict[str, dict[str, int]] = {
    "t20-recorder-stall": {"buffer_bytes": 12_000},
    "t28-overload": {"bit_rate": 20_000},
}
"""Of plants that are not the usual one."""

SCENARIOS: dict[str, Callable[[Plant], Tale]] = {
    **stories_of_loss.SCENARIOS,
    **stories_of_commands.SCENARIOS,
    **stories_of_configuration.SCENARIOS,
    **stories_of_drives.SCENARIOS,
    **stories_of_monitoring.SCENARIOS,
    **stories_of_services.SCENARIOS,
}


def record(name: str, target: Path) -> None:
    """Records one story, again where the machine did not keep up."""
    for attempt in range(ATTEMPTS):
        with tempfile.TemporaryDirectory() as scratch:
            path = Path(scratch) / f"{name}.log"
            plant = Plant(path, **SETTINGS.get(name, {}))
            try:
                tale = SCENARIOS[name](plant)
            except MissingFrame as reason:
                print(f"{name}: attempt {attempt + 1}: {reason}", flush=True)
                continue
            plant.write_truth(tale, json.loads((TARGET / f"{name}.json").read_text()))
            for made in (path, path.with_suffix(".json")):
                (target / made.name).write_bytes(made.read_bytes())
            print(f"{name}: {len(tale.log.lines)} frames in {tale.log.seconds} s", flush=True)
            return
    raise SystemExit(f"{name}: not recorded in {ATTEMPTS} attempts")


def main() -> None:
    """Records what the command line names, or everything."""
    options = argparse.ArgumentParser(description="record stories of networks in which something goes wrong")
    options.add_argument("--into", type=Path, default=TARGET)
    options.add_argument("names", nargs="*", metavar="NAME", help="without one: all")
    given = options.parse_args()
    given.into.mkdir(parents=True, exist_ok=True)
    for name in given.names or SCENARIOS:
        record(name, given.into)


if __name__ == "__main__":
    main()
