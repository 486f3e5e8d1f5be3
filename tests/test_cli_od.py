"""`canalyze od`: the objects of each node as a table, JSON lines and CSV, at a time, and all of their values."""

import json

from captures import EDS, SAMPLES, run_canalyze

import canalyze as library

NETWORK = SAMPLES / "network/sync-and-pdos.log"


def test_the_table_of_columns_is_the_same() -> None:
    given = {5: EDS / "drive.eds", 6: EDS / "io.eds", 7: EDS / "encoder.eds"}
    options = [f"--eds={node}={path}" for node, path in given.items()]
    said = run_canalyze(["od", NETWORK, "--format", "jsonl", "--lang", "en", *options]).splitlines()
    records = [one for one in map(json.loads, said) if one["kind"] == "od_object"]
    with library.open(NETWORK, eds=given) as capture:
        table = capture.tables("od")["od"].to_pandas().to_dict("records")
    assert len(table) == len(records) > 40
    for row, record in zip(table, records, strict=True):
        assert f"{row['index']:04X}" == record["index"]
        alike = (
            *("bus", "node", "sub", "name", "type", "type_from", "access", "exists", "text", "source", "frame", "bits"),
            *("values", "read", "written", "tpdo", "rpdo", "emcy", "refused", "unconfirmed", "first_frame"),
        )
        assert {key: row[key] for key in alike} == {key: record[key] for key in alike}
        assert row["data"].hex().upper() == record["data"]
        held = record["in_force"]
        assert (row["in_force_from"] if held else None) == (held and held["from"])
    scaled = next(row for row in table if (row["node"], row["index"]) == (5, 0x6077))
    assert (scaled["value"], scaled["text"]) == (-3.1, "-3.1 %")
