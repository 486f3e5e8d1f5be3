"""The layout of results for people; one file a form. No report makes sentences of its own."""
