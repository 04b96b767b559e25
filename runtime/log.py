"""Lines for the log, on standard error."""

import sys
from contextlib import suppress


def say(line: str) -> None:
    """Where standard error cannot be written, a full disk, nobody reads it: nothing ends by it."""
    with suppress(OSError, ValueError):
        print(f"rfnav: {line}", file=sys.stderr, flush=True)
