"""Everything that is set before a capture is read: canalyze.toml, options, the known network.

Must not: read a capture.
"""
