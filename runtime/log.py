"""Lines for the log: on standard error, and where systemd reads that, in its journal with fields
(its native protocol, systemd.io/JOURNAL_NATIVE_PROTOCOL)."""

import os
import socket
import sys
from contextlib import suppress
from pathlib import Path
from typing import Final

ERROR, WARNING, NOTICE, INFO, DEBUG = 3, 4, 5, 6, 7  # of syslog
JOURNAL: Final = Path("/run/systemd/journal/socket")
MESSAGE_BYTES: Final = 32_768  # what a datagram takes for sure; the rest is cut off
FIELD_BYTES: Final = 1024


def say(line: str, priority: int = INFO, **fields: str) -> None:
    """`fields`: of the journal's entry, RFNAV_NAME each. What is DEBUG goes nowhere else. Where
    standard error cannot be written, a full disk, nobody reads it: nothing ends by it."""
    if _is_journaled() and _sent(line, priority, fields):
        return
    if priority < DEBUG:
        with suppress(OSError, ValueError):
            print(f"rfnav: {line}", file=sys.stderr, flush=True)


def _is_journaled() -> bool:
    """Whether standard error is the journal's: of a process that systemd started, and that nobody
    led elsewhere since."""
    device, _, inode = os.environ.get("JOURNAL_STREAM", "").partition(":")
    if not inode:
        return False
    try:
        there = os.fstat(sys.stderr.fileno())
    except (OSError, ValueError, AttributeError):
        return False
    return (device, inode) == (str(there.st_dev), str(there.st_ino))


def _sent(line: str, priority: int, fields: dict[str, str]) -> bool:
    """Whether the journal took it. It never waits: a journal that is full gets it as a line."""
    known = {f"RFNAV_{name}": value[:FIELD_BYTES] for name, value in fields.items()}
    told = {
        "MESSAGE": line[:MESSAGE_BYTES],
        "PRIORITY": str(priority),
        "SYSLOG_IDENTIFIER": "rfnav",
        **known,
    }
    entry = b"".join(_field(name, value) for name, value in told.items())
    try:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as out:
            out.setblocking(False)
            out.sendto(entry, str(JOURNAL))
        return True
    except OSError:
        return False


def _field(name: str, value: str) -> bytes:
    """One whose value has a line break in it goes with its length before it."""
    raw = value.encode("utf-8", "replace")
    if b"\n" not in raw:
        return f"{name}=".encode() + raw + b"\n"
    return f"{name}\n".encode() + len(raw).to_bytes(8, "little") + raw + b"\n"
