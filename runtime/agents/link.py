"""The link to the running service: one session for all calls, opened when somebody asks."""

import threading
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from typing import Any, Protocol, TypeVar

import zenoh

from runtime.errors import BusError


class AskedRobot(Protocol):
    """A runtime that may be there; see `commands.running.Running`."""

    @property
    def session(self) -> Any: ...

    def ask(self, kind: str, body: Mapping[str, object], within_s: float) -> dict[str, Any]:
        """BusError, one line, when nobody answers."""
        ...


Got = TypeVar("Got")
Connect = Callable[[], AbstractContextManager[AskedRobot]]


class _Opened:
    """A session, and by how many calls it is used."""

    def __init__(self, connect: Connect) -> None:
        self.context = connect()
        self.robot = self.context.__enter__()
        self.users = 0

    def close(self) -> None:
        self.context.__exit__(None, None, None)


class RobotLink:
    """Asks from several threads. Over a session that failed nothing else is asked."""

    def __init__(self, connect: Connect) -> None:
        self._connect = connect
        self._lock = threading.Lock()
        self._opened: _Opened | None = None

    def ask(self, kind: str, body: Mapping[str, object], within_s: float) -> dict[str, Any]:
        """BusError, one line, when nobody answers."""
        return self.use(lambda robot: robot.ask(kind, body, within_s))

    def use(self, asks: Callable[[AskedRobot], Got]) -> Got:
        """What is asked over the session, which is open meanwhile."""
        opened = self._taken()
        failed = True
        try:
            got = asks(opened.robot)
            failed = False
            return got
        except zenoh.ZError as error:
            raise BusError(f"the link to the robot was lost: {error}") from error
        finally:
            self._given_back(opened, failed)

    def close(self) -> None:
        """Once nobody asks over it any more."""
        with self._lock:
            opened, self._opened = self._opened, None
            over = opened is not None and not opened.users
        if opened is not None and over:
            opened.close()

    def _taken(self) -> _Opened:
        with self._lock:
            if self._opened is None:
                self._opened = _Opened(self._connect)
            self._opened.users += 1
            return self._opened

    def _given_back(self, opened: _Opened, failed: bool) -> None:
        with self._lock:
            opened.users -= 1
            if failed and self._opened is opened:
                self._opened = None
            over = not opened.users and self._opened is not opened
        if over:
            opened.close()
