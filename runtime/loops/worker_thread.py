"""A thread beside the loop: what goes wrong in it is raised where its results are taken."""

import os
import threading
from collections.abc import Callable
from contextlib import suppress


class WorkerThread:
    """Runs `work` once, at a lower priority. `changed` guards what it shares with its owner, who
    calls the rest."""

    def __init__(self, name: str, work: Callable[[], None], nice: int) -> None:
        self.changed = threading.Condition()
        self.closed = False  # `work` is to return, when it reads this under `changed`
        self._work, self._nice = work, nice
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """When all is there that `work` uses."""
        self._thread.start()

    def check(self) -> None:
        """Raises what ended the work."""
        if self._error is not None:
            raise self._error

    def close(self, wait_s: float) -> None:
        """Let the thread end; one that is at something longer is left to it."""
        with self.changed:
            self.closed = True
            self.changed.notify_all()
        self._thread.join(timeout=wait_s)

    def _run(self) -> None:
        lower_priority(self._nice)
        try:
            self._work()
        except BaseException as error:  # noqa: BLE001 -- raised again by `check`
            with self.changed:
                self._error = error
                self.changed.notify_all()


def lower_priority(nice: int) -> None:
    """Give the calling thread, and those it starts from now on, a higher nice value. Where a thread
    cannot have one of its own, nothing changes."""
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), nice)
