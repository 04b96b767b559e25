"""Decisions beside the drive: one at a time, in a worker, on a snapshot that nobody changes."""

import os
import threading
from contextlib import suppress
from dataclasses import dataclass

from runtime import navigate
from runtime.core.types import Decision
from runtime.core.world import Snapshot
from runtime.edge.clock import Deadline
from runtime.edge.panel import Panel
from runtime.navigate import NavigateConfig


@dataclass(frozen=True)
class Question:
    """What is to be decided; `asker` is whose it is, for an answer that comes too late."""

    asker: object
    snapshot: Snapshot
    panel: Panel
    by: Deadline
    cfg: NavigateConfig


class Decider:
    """A thread that decides. Only the thread that owns the world calls it."""

    def __init__(self, nice: int = 0) -> None:
        self._changed = threading.Condition()
        self._question: Question | None = None
        self._answer: tuple[Question, Decision] | None = None
        self._error: BaseException | None = None
        self._closed = False
        self._nice = nice
        self._thread = threading.Thread(target=self._work, name="decider", daemon=True)
        self._thread.start()

    @property
    def busy(self) -> bool:
        """Whether a question is open, or its answer was not taken yet."""
        with self._changed:
            return self._question is not None or self._answer is not None

    def ask(self, question: Question) -> None:
        """Begin to decide; must not be busy."""
        with self._changed:
            assert self._question is None
            self._question = question
            self._changed.notify_all()

    def take(self) -> tuple[Question, Decision] | None:
        """The decision that was made meanwhile; raises what went wrong in making it."""
        with self._changed:
            if self._error is not None:
                raise self._error
            answer, self._answer = self._answer, None
            return answer

    def close(self) -> None:
        """Let the thread end; one that still waits for its panel is left to its deadline."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._thread.join(timeout=0.5)

    def _work(self) -> None:
        lower_priority(self._nice)
        while True:
            with self._changed:
                while self._question is None and not self._closed:
                    self._changed.wait()
                if self._closed or self._question is None:
                    return
                question = self._question
            try:
                decision = navigate.decide(
                    question.snapshot, question.panel, question.by, question.cfg
                )
            except BaseException as error:  # noqa: BLE001 -- raised again by `take`
                with self._changed:
                    self._error = error
                return
            with self._changed:
                self._question, self._answer = None, (question, decision)


def lower_priority(nice: int) -> None:
    """Give the calling thread, and those it starts from now on, a higher nice value. Where a thread
    cannot have one of its own, nothing changes."""
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), nice)
