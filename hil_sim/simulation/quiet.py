"""Keeps what C libraries print (PyBullet and its EGL renderer are chatty) out of our output."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


def keep_stdout_for_python() -> None:
    """From here on only Python writes to standard output; file descriptor 1 goes nowhere."""
    sys.stdout.flush()
    ours = os.dup(1)
    _redirect(1)
    sys.stdout = open(ours, "w", buffering=1, encoding="utf-8", errors="replace")  # noqa: SIM115


@contextmanager
def hushed() -> Iterator[None]:
    """Within the block nothing reaches standard error, not even from C. Exceptions do leave it."""
    sys.stderr.flush()
    kept = os.dup(2)
    _redirect(2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def _redirect(descriptor: int) -> None:
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, descriptor)
    os.close(nowhere)
