"""`canalyze od against`: what a device and its description differ in."""

from canalyze.configuration import network
from canalyze.configuration.network import described
from canalyze.configuration.options import ANY_PATH, COLOR, SHORT, argument, form, inputs, option
from canalyze.running.passes import AT, FORMS, Pass, capture_command, read_objects


def run(one: Pass) -> int:
    """Reads the device, then compares."""
    from canalyze.dictionary.against import INFO, compared, device
    from canalyze.reports import od

    one.names = inputs(one.files, one.words)
    found = described(one.description, one.node, one.words)
    with one.opened() as out:
        seen = read_objects(one, "objects" + FORMS[one.form])
        code = seen.code
        if seen.frames:
            one.progress.clear()
            held = compared(found, seen.result, *device(seen.result, found), unseen=one.unseen)
            if one.form == "text":
                od.show_against(held, found.file, out, one.words)
            else:
                out.write(od.against_lines(held, found.file, one.words))
            code = max(code, int(any(difference.severity != INFO for difference in held.differences)))
        one.end(code, seen.frames)
    if seen.frames and not seen.some:
        one.note("od.none", frames=seen.frames)
    return code


command = capture_command(
    "od against",
    run,
    argument("description", "DESCRIPTION", type=ANY_PATH),
    option("--node", "N", network.node, "node", topic="chosen", usual=0),
    option("--unseen", usual=0),
    AT,
    form("text", "jsonl"),
    COLOR,
    without=SHORT[:1],
)
