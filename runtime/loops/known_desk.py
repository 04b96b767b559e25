"""`rfnav/things`, `rfnav/where`, `rfnav/map`: what is known of the home, for whoever asks. The
thread that owns the world copies it; one of its own, of low priority, answers. Where nobody asks
there is neither copy nor work."""

from collections import deque
from collections.abc import Callable
from typing import Final, NamedTuple

from runtime.clock import Clock
from runtime.core.world import World
from runtime.loops.search import Search
from runtime.loops.worker_thread import WorkerThread
from runtime.robot.requests import ENDS, Request
from runtime.service.atlas import ASK, Atlas, asked_name, atlas_of, nothing_told

WAITING: Final = 8  # requests; more are told that it is busy
FRESH_S: Final = 0.2  # a copy that is no older is used again, and one since which nothing was seen
REST: Final = 4.0  # in lengths of the last answer's work: a fifth of a core at most


class _Question(NamedTuple):
    request: Request
    atlas: Atlas | None
    name: str


class KnownDesk:
    """`search`: the newest that has seen anything, to be set before the first question. `frame`,
    `origin_xy`: odometry's, and where in it the map begins."""

    def __init__(
        self,
        frame: Callable[[], str],
        origin_xy: Callable[[], tuple[float, float]],
        clock: Clock,
        nice: int,
    ) -> None:
        self.search: Callable[[], Search | None] = lambda: None
        self._frame, self._origin_xy, self._clock = frame, origin_xy, clock
        self._copy: tuple[World, float, Atlas] | None = None  # of which world, and when
        self._waiting: deque[_Question] = deque()
        self._thread = WorkerThread("known", self._work, nice)
        self._changed, self._started = self._thread.changed, False

    def answer(self, request: Request) -> dict[str, object] | None:
        """A refusal, or None: it is answered later. In the thread that owns the world."""
        self._thread.check()
        kind, name = request.kind, ""
        try:
            if kind == "where":
                name = asked_name(request.body)
            elif request.body:
                raise ValueError(f"ask {ASK[kind]}")
        except ValueError as error:
            return {"accepted": False, "error": f"rfnav/{kind}: {error}"}
        with self._changed:
            if len(self._waiting) >= WAITING:
                return {"accepted": False, "error": f"busy: {WAITING} such requests wait already"}
        atlas = self._atlas()
        with self._changed:
            self._waiting.append(_Question(request, atlas, name))
            self._changed.notify_all()
        if not self._started:
            self._started = True
            self._thread.start()
        return None

    def close(self) -> None:
        """Refuse what waits, and let the thread end. Idempotent."""
        with self._changed:
            left = list(self._waiting)
            self._waiting.clear()
        for question in left:
            question.request.refuse(ENDS)
        if self._started:
            self._thread.close(2.0)

    def _atlas(self) -> Atlas | None:
        search = self.search()
        if search is None or search.world is None:
            return None
        world, now_s = search.world, self._clock.now_s()
        if self._copy is not None and self._copy[0] is world:
            _, at_s, atlas = self._copy
            if now_s - at_s < FRESH_S or atlas.stamp_ns == world.stamp_ns:
                return atlas
        atlas = atlas_of(world, search.goal.classes, self._frame(), self._origin_xy())
        self._copy = world, now_s, atlas
        return atlas

    # -- in its own thread -----------------------------------------------------------------------

    def _work(self) -> None:
        while (question := self._next()) is not None:
            began_s = self._clock.now_s()
            request, atlas, name = question
            try:
                told = atlas.told(request.kind, name) if atlas is not None else None
                request.reply(told or nothing_told(request.kind, name, self._frame()))
            finally:
                request.refuse(
                    "internal error"
                )  # where it was not answered: the first reply counts
            now_s = self._clock.now_s()
            rested_s = now_s + REST * (now_s - began_s)
            with self._changed:
                while not self._thread.closed and self._clock.now_s() < rested_s:
                    self._clock.wait(self._changed, rested_s)

    def _next(self) -> _Question | None:
        with self._changed:
            self._changed.wait_for(lambda: self._waiting or self._thread.closed)
            return self._waiting.popleft() if self._waiting and not self._thread.closed else None
