"""Where frames go beside standard output; one file a kind of sink. No sink knows what a frame means.

target.py      what a file is converted to, by its name, and what writes it
compressed.py  files that are compressed on their way
pythoncan.py   the formats that python-can writes
"""
