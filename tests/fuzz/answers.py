"""What an entry point is, and what it may answer."""

import atexit
import shutil
import tempfile
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path


@dataclass(frozen=True)
class EntryPoint:
    """`seeds` are good inputs; `run` takes any bytes. `slow`: it opens files, a hundred times as
    long as the others."""

    seeds: Sequence[bytes]
    run: Callable[[bytes], None]
    slow: bool = False


@cache
def scratch() -> Path:
    """A folder in memory, of this process."""
    memory = Path("/dev/shm")
    folder = Path(tempfile.mkdtemp(prefix="rfnav-fuzz-", dir=memory if memory.is_dir() else None))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def filed(data: bytes, name: str) -> Path:
    path = scratch() / name
    path.write_bytes(data)
    return path


REFUSALS: deque[str] = deque(maxlen=1)
"""The newest answer that was one: good input leaves none."""


def refused(told: str) -> None:
    assert "\n" not in told, told
    REFUSALS.append(told)


@contextmanager
def refused_in_a_line(*errors: type[Exception]) -> Iterator[None]:
    """These errors are answers, of one line."""
    try:
        yield
    except errors as error:
        refused(str(error))
