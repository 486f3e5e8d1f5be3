"""`python -m canalyze`: the same as the command `canalyze`."""

import sys

from canalyze.cli import main

if __name__ == "__main__":
    sys.exit(main())
