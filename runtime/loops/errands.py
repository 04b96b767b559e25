"""Slow work beside the loop, in a thread of low priority: done one after the other, the result
taken when it is there."""

from collections.abc import Callable

from runtime.loops.worker_thread import WorkerThread

LAST_S = 15.0  # what is under way at the end has so long


class Errands:
    """Of one owner. Work of a name replaces what waits under it."""

    def __init__(self, nice: int) -> None:
        self._thread = WorkerThread("errands", self._work, nice)
        self._changed = self._thread.changed
        self._waiting: dict[str, Callable[[], object]] = {}
        self._done: dict[str, object] = {}
        self._at = ""  # the name of what is done now
        self._thread.start()

    def ask(self, name: str, work: Callable[[], object]) -> None:
        with self._changed:
            self._waiting[name] = work
            self._done.pop(name, None)
            self._changed.notify_all()

    def take(self, name: str) -> object | None:
        """The result, once; raises what went wrong in any."""
        with self._changed:
            self._thread.check()
            return self._done.pop(name, None)

    def busy(self, name: str) -> bool:
        """Whether it waits, is under way, or was not taken."""
        with self._changed:
            return self._at == name or name in self._waiting or name in self._done

    def close(self) -> None:
        """Let all that waits be done, and the thread end."""
        self._thread.close(LAST_S)

    def _work(self) -> None:
        while (next_one := self._next()) is not None:
            name, work = next_one
            result = work()
            with self._changed:
                self._at = ""
                if name not in self._waiting:
                    self._done[name] = result
                self._changed.notify_all()

    def _next(self) -> tuple[str, Callable[[], object]] | None:
        with self._changed:
            self._changed.wait_for(lambda: self._waiting or self._thread.closed)
            if not self._waiting:
                return None
            name = next(iter(self._waiting))
            self._at = name
            return name, self._waiting.pop(name)
