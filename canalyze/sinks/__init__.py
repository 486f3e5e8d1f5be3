"""Outputs of frames in capture formats; one file per kind. No sink knows the meaning of a frame.

target.py     the format of an output by its name, and its writer; compressed files
pythoncan.py  the formats that python-can writes
"""
