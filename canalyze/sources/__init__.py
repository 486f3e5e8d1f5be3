"""Where captures come from; one file a kind of source. No source knows what a frame is.

open_source(name)  a file, a pipe or standard input, unpacked, its format told
file.py            bytes of a file, a pipe or standard input
format.py          which format the bytes are, and what is done with one that the core does not read
pythoncan.py       formats that python-can reads, in records for the core (packed.py); blf.py and trace.py keep from it
                   what it would stumble over
"""
