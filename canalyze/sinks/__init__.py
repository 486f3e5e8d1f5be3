"""Where frames go beside standard output; one file a kind of sink. No sink knows what a frame means.

pythoncan.py  the formats that python-can writes
"""
