"""What the runtime leaves on disk is its owner's alone, for it shows a home: files 0600, folders
0700, whatever umask it was started with."""

import os
from pathlib import Path

OTHERS = 0o077


def keep_to_owner() -> None:
    """For all that this process, and those that it starts, will create."""
    os.umask(OTHERS)


def tighten(path: Path) -> None:
    """A file that is kept over runs, if it is there, may be of a time before that. OSError when it
    is another's."""
    mode = path.stat().st_mode & 0o777 if path.exists() else 0
    if mode & OTHERS:
        path.chmod(mode & ~OTHERS)


def state_directory() -> Path:
    """Where all is kept that outlives the process, whether it is there yet or not: what systemd
    gives the service, else the user's own."""
    given = os.environ.get("STATE_DIRECTORY", "").split(":")[0]
    if given:
        return Path(given)
    return Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "rf-nav"
