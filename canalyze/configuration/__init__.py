"""What the user has said before a capture is read: canalyze.toml, options, what is known of the network.

Must not: read a capture.
"""
