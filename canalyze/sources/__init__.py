"""Sources of captures; one file per kind. No source knows the meaning of a frame.

file.py        bytes of a file, a pipe or standard input; memory.py the same in memory, names.py names of captures
compressed.py  the content of compressed bytes, and text of another encoding; the compressions
format.py      opens an input by name: unpacks it, detects its format, and yields bytes that the core reads
pythoncan.py   formats that python-can reads, in records for the core (packed.py); pieces.py those read line by line
database.py    private copies of SQLite databases
live.py        live buses as an input: socketcan.py (with netdevices.py), buses.py of python-can, replay.py of captures
recordings.py  captures that are parts of one recording
"""
