"""One pass over a capture or a live bus: from what is read to what is shown, recorded or viewed, and its end.

Must not: know a frame's meaning, or what a command prints.
"""
