"""What recordings may hold, made by hand: networks of any size, for tests of their layout.

What it must not do: say what a layout makes of it.
"""

from __future__ import annotations

from collections.abc import Iterable

from canalyze.timeline.stream import Contents, Lane, Plot, Series

UNITS = ("rpm", "°C", "V")


def series(name: str, unit: str = "", *, least: float = 0, greatest: float = 1000, described: bool = True) -> Series:
    return Series(f"{name} [{unit}]" if unit else name, unit, described, least, greatest)


def plot(contents: Contents, node: int, pdo: str, lines: Iterable[Series], bus: str = "") -> None:
    entity = "/".join(["/pdo", *([bus] if bus else []), f"node{node}", pdo])
    contents.plots[entity] = Plot(entity, bus, node, pdo, list(lines), 100)


def lanes(contents: Contents, *entities: str) -> None:
    contents.lanes.update({entity: Lane(entity, 5) for entity in entities})


def stamped() -> Contents:
    return Contents(frames=1000, timed=True, last_ns=10**10, last_frame=1000, summary=True)


def drive(*, timed: bool = True) -> Contents:
    """One drive with all there is."""
    contents = stamped()
    contents.timed = timed
    contents.logged = {"WARN": 3}
    lanes(contents, *(f"/{kind}/node5" for kind in ("sdo", "nmt", "emcy", "drive")))
    lanes(contents, "/value/node5/TPDO1/Statusword.3", "/value/node5/TPDO1/Statusword")
    plot(contents, 5, "TPDO1", [series("Velocity", "rpm"), series("Torque", "%")])
    plot(contents, 5, "RPDO1", [series("Target velocity", "rpm"), series("2101h:03", described=False, greatest=0)])
    plot(contents, 5, "TPDO2", [series("Position", greatest=2e6), series("Gear")])
    contents.sync.add("")
    contents.windows.add("")
    contents.delays["/sync/delay/node5/TPDO1"] = None
    contents.durations["/sdo_duration/node5"] = None
    contents.transfers, contents.transferring_ns, contents.findings = 10, 10 * 1e6, 3
    contents.load[""] = False
    return contents


def network(nodes: int, buses: tuple[str, ...] = ("can0",)) -> Contents:
    """Drives that all have the same signals."""
    contents = stamped()
    contents.logged = {"WARN": 3}
    for bus in buses:
        for node in range(1, nodes + 1):
            where = f"{bus}/node{node}" if bus else f"node{node}"
            lanes(contents, f"/nmt/{where}", f"/sdo/{where}", f"/drive/{where}")
            plot(contents, node, "TPDO1", [series("Velocity", "rpm"), series("Torque", "%")], bus)
            plot(contents, node, "TPDO2", [series("Position", greatest=2e6), series("Temperature", "°C")], bus)
            contents.delays["/".join(["/sync", *([bus] if bus else []), "delay", f"node{node}", "TPDO1"])] = None
            contents.durations["/".join(["/sdo_duration", *([bus] if bus else []), f"node{node}"])] = None
        contents.sync.add(bus)
        contents.load[bus] = True
    lanes(contents, f"/emcy/{where}")
    return contents


def hundreds() -> Contents:
    """Nodes that have nothing in common, and far more signals than there is room for; most are not described."""
    contents = stamped()
    for node in range(1, 9):
        lanes(contents, f"/nmt/node{node}")
        for pdo in range(1, 9):
            lines = [series(f"{0x2100 + pdo:04X}h:{sub:02X}", described=False, greatest=sub % 3) for sub in range(5)]
            unit = UNITS[(node + pdo) % 3]
            lines.append(series(f"Signal {node}.{pdo}", unit, greatest=pdo % 4))
            plot(contents, node, f"TPDO{pdo}", lines)
    return contents


def transfers() -> Contents:
    """Nothing but SDO."""
    contents = stamped()
    lanes(contents, "/sdo/node5")
    return contents


EVERY = {
    "nothing": Contents(),
    "frames": Contents(frames=10, timed=True),
    "transfers": transfers(),
    "drive": drive(),
    "unstamped": drive(timed=False),
    "thirty": network(30),
    "two buses": network(3, ("can0", "can1")),
    "no bus": network(12, ("",)),
    "hundreds": hundreds(),
}
