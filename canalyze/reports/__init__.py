"""The layout of results, for people and for other programs. No report makes sentences of its own."""
