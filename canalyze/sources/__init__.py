"""Where captures come from; one file a kind of source. No source knows what a frame is.

file.py        bytes of a file, a pipe or standard input
compressed.py  what is in compressed bytes, and text of another encoding
format.py      from a name to bytes that the core reads: opened, unpacked, their format told
pythoncan.py   formats that python-can reads, in records for the core (packed.py)
pieces.py      those of them that are read line by line; lines.py keeps from it what it would stumble over
"""
