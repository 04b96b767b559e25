"""Models are loaded in a thread of their own, so that the process hears what it is told meanwhile.

That thread may be within C code that nobody can interrupt: a process that ends meanwhile is left at
once, without waiting for it (`leave`).
"""

import os
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Final, Generic, NoReturn, TypeVar

from runtime.errors import RfNavError
from runtime.loops.worker_thread import lower_priority

LOAD_S: Final = 900.0  # a model that is missing is fetched, over a slow line, too
LISTEN_S: Final = 0.1  # between two looks at whether the process is to end

M = TypeVar("M")


class LoadingEndedError(RfNavError):
    """The process ends while a thread is at its models; `status` is what it ends with."""

    def __init__(self, message: str, status: int) -> None:
        super().__init__(message)
        self.status = status


class _Loader(threading.Thread, Generic[M]):
    """Of the priority that the threads of what it loads inherit."""

    def __init__(self, load: Callable[[], M], nice: int) -> None:
        super().__init__(name="models", daemon=True)
        self._load, self._nice = load, nice
        self.loaded: list[M] = []
        self.error: BaseException | None = None

    def run(self) -> None:
        lower_priority(self._nice)
        try:
            self.loaded.append(self._load())
        except BaseException as error:  # noqa: BLE001 -- raised again by `loaded`
            self.error = error


def loaded(load: Callable[[], M], nice: int, ending: Callable[[], bool]) -> M:
    """What `load` returns, or its error. LoadingEndedError when `ending` comes first, or when it
    takes longer than anything sensible."""
    loader = _Loader(load, nice)
    loader.start()
    for _ in range(round(LOAD_S / LISTEN_S)):
        loader.join(LISTEN_S)
        if not loader.is_alive():
            if loader.error is not None:
                raise loader.error
            return loader.loaded[0]
        if ending():
            raise LoadingEndedError("the models were still loading", 0)
    raise LoadingEndedError(
        f"models: not loaded within {LOAD_S:g} s; `rfnav models verify` says which is damaged", 2
    )


def leave(status: int) -> NoReturn:
    """End the process, whatever threads are at."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(status)
