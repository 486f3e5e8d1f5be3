"""Sources of captures; one file per kind. No source knows the meaning of a frame.

file.py        bytes of a file, a pipe, standard input or a memory; names.py names of captures
compressed.py  the content of compressed bytes, and text of another encoding; the compressions
format.py      opens an input by name: unpacks it, detects its format, and yields bytes that the core reads
bridge/        formats and adapters of python-can, and its messages
live.py        live buses as an input: socketcan.py (with netdevices.py), bridge/buses.py, replay.py of captures
recordings.py  captures that are parts of one recording
"""
