"""``python -m chaosdrill`` is the command line."""

import sys

from chaosdrill.cli import main

if __name__ == "__main__":
    sys.exit(main())
