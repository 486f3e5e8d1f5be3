"""One file a command. A module offers `command(words)` and is imported only when its command is asked for."""
