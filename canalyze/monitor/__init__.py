"""The screen of `canalyze monitor`; the only part that knows textual. One file a room.

watch.py      the thread that reads, and what it has to tell
app.py        the application: where the rooms stand, keys and what they do, the beat of the screen
grid.py       a table whose cells are updated in place: what all rooms draw with
figures.py    figures and bars in few columns
nodes.py, objects.py, transfers.py, findings.py, incidents.py   from a snapshot of the core to rows, one room each
trace.py      the room of annotated frames: following, scrolled back, filtered, searched
status.py     the lines above and below the rooms
keys.py       every key: what it does, the foot line, the page of help
prompt.py     the line in which a filter or a search is typed

Nothing here decodes or judges: what a frame means, and every figure, comes from `Session.snapshot` and `.trace`. What
devices and files call themselves is drawn as text, never as markup, and escaped where it could drive a terminal.
"""
