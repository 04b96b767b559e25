"""A child process that never outlives the harness, and whose last words are kept in a file."""

import ctypes
import multiprocessing
import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

# exec after asking Linux to kill the child when the harness dies, however it dies.
_TIED = """\
import ctypes, os, signal, sys
if sys.platform == "linux":
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)
os.execv(sys.argv[1], sys.argv[1:])
"""


def end_with_parent() -> None:
    """Let Linux send this process of `multiprocessing` SIGTERM when its parent dies, and now if it
    is dead."""
    parent = multiprocessing.parent_process()
    if sys.platform == "linux" and parent is not None:
        ctypes.CDLL(None).prctl(1, signal.SIGTERM)
        if os.getppid() != parent.pid:
            os.kill(os.getpid(), signal.SIGTERM)


def spawn(arguments: Sequence[str], log: Path) -> subprocess.Popen[bytes]:
    """Start a program (by its absolute path) whose output goes to `log`."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("wb") as file:
        return subprocess.Popen(
            [sys.executable, "-c", _TIED, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=file,
            start_new_session=True,  # Ctrl-C is the harness's business
        )


def end(child: subprocess.Popen[bytes] | None) -> None:
    """Ask it to end, then make it."""
    if child is not None and child.poll() is None:
        child.terminate()
        try:
            child.wait(timeout=2.0)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()


def last_line(log: Path) -> str:
    """The last line that says something; "" when none does."""
    try:
        lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return ""
    return next((line.strip() for line in reversed(lines) if line.strip()), "")
