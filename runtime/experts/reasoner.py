"""A large local model behind a queue: one worker thread owns it, experts wait until their deadline.

It reasons in words (`expert`), or says of one frontier's picture after the other how likely the
goal is there (`look`), which is kept, as pictures and questions repeat. No picture is encoded while
somebody waits for a vote: what is not encoded yet (picture_encoder.py) is not shown.
"""

import hashlib
import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Protocol, Self

from runtime.clock import Clock, Deadline
from runtime.core.mapping.keyframes import Keyframe
from runtime.core.types import Absence, Brief, FrontierBrief, Missing, Vote
from runtime.core.voting import prompted_experts
from runtime.core.voting.likelihood_experts import ExpertConfig, recommend
from runtime.experts.panel import Expert
from runtime.experts.picture_encoder import Encoded, Encodes, PictureEncoder

LOOKS_KEPT = 10_000


class Replies(Protocol):
    """A model that replies; it raises when it is not done in so many seconds."""

    def reply(
        self, messages: list[dict[str, Any]], grammar: str, max_tokens: int, seconds: float
    ) -> str: ...


class Looks(Encodes, Protocol):
    """One that sees, too; it is handed what it made of the pictures that it is shown."""

    def reply(
        self,
        messages: list[dict[str, Any]],
        grammar: str,
        max_tokens: int,
        seconds: float,
        pictures: Sequence[Any],
    ) -> str: ...

    def likes(
        self, messages: list[dict[str, Any]], seconds: float, pictures: Sequence[Any]
    ) -> float:
        """Nats by which the answer is rather yes than no."""


class Late(Exception):
    """The deadline has passed."""

    def __str__(self) -> str:
        return "late"


class _Job:
    """One call of the model. Guarded by the reasoner's condition."""

    def __init__(self, work: Callable[[float], Any], by: Deadline) -> None:
        self.work, self.by = work, by
        self.done = False
        self.result: Any = None
        self.error: Exception | None = None


class Reasoner:
    """Queues what is asked of one model. `sees`: whether it is shown pictures."""

    def __init__(self, model: Looks | Replies, clock: Clock, reply_tokens: int, sees: bool) -> None:
        seeing: Any = model
        self._model = seeing
        self._clock, self._reply_tokens, self._sees = clock, reply_tokens, sees
        self._condition = threading.Condition()
        self._queue: deque[_Job] = deque()
        self._running: _Job | None = None
        self._closed = False
        self._looks: dict[bytes, float] = {}
        self._pictures = PictureEncoder(self._model, clock) if sees else None
        self._thread = threading.Thread(target=self._work, name="reasoner", daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the worker after the call under way; what is queued is abandoned."""
        with self._condition:
            self._closed = True
            self._condition.notify_all()
        if self._pictures is not None:
            self._pictures.stop()  # both end at once
        self._thread.join(timeout=5.0)
        if self._pictures is not None:
            self._pictures.close()

    def hold(self, frames: Sequence[Keyframe]) -> None:
        """Have the images of these keyframes encoded in the background, and forget all others."""
        if self._pictures is not None:
            self._pictures.hold(frames)

    @property
    def errors(self) -> list[str]:
        """Why pictures cannot be seen."""
        return self._pictures.errors if self._pictures is not None else []

    def told(self) -> dict[str, object]:
        """For people: how far the encoding of pictures is."""
        return self._pictures.told() if self._pictures is not None else {}

    def forget(self) -> None:
        """Ask about every picture anew from here on."""
        self._looks = {}  # whoever is asking goes on with those that it began with

    def ready(self, by: Deadline) -> bool:
        """Whether the model is free, or busy with what is still waited for; one that hangs is
        neither."""
        with self._condition:
            return self._running is None or not self._running.by.passed()

    def expert(self, name: str) -> Expert:
        """The expert of that name in words."""
        return partial(self._ask, name)

    def look(self, cfg: ExpertConfig) -> Expert:
        """SLE: each frontier's picture is asked about alone, yes or no."""
        return partial(self._look, cfg)

    def _ask(self, name: str, brief: Brief, by: Deadline) -> Vote | Missing:
        shown: dict[str, Any] = {}
        if name == "sle" and self._pictures is not None:
            encoded = self._pictures.of((f.image for f in brief.frontiers if f.image), by)
            told = [f if f.image in encoded else replace(f, image=b"") for f in brief.frontiers]
            if len(encoded) < 2 and any(f.image for f in brief.frontiers):
                return self._unseen(brief)
            brief, shown = replace(brief, frontiers=tuple(told)), {"pictures": [*encoded.values()]}
        prompt = prompted_experts.compose(name, brief, images=self._sees, marks=False)
        if isinstance(prompt, Missing):
            return prompt
        said = self._do(
            lambda seconds: self._model.reply(
                prompted_experts.chat(prompt.messages),
                prompted_experts.grammar(prompt.ids),
                self._reply_tokens,
                seconds,
                **shown,
            ),
            by,
        )
        return prompted_experts.read(str(said), name, prompt.ids)

    def _unseen(self, brief: Brief) -> Missing:
        """The abstention while too few pictures are encoded."""
        assert self._pictures is not None
        count = sum(bool(f.image) for f in brief.frontiers)
        told = f"of {count} views too few are encoded yet"
        return Missing("sle", Absence.NO_IMAGES, "; ".join([told, *self._pictures.errors[:1]]))

    def _look(self, cfg: ExpertConfig, brief: Brief, by: Deadline) -> Vote | Missing:
        shown = [(f, *_question(brief, f)) for f in brief.frontiers if f.image]
        if len(shown) < 2 or self._pictures is None:
            return Missing("sle", Absence.NO_IMAGES)
        looks = self._looks
        encoded = self._pictures.of((f.image for f, _, key in shown if key not in looks), by)
        nats = {
            f.id: self._nats(looks, messages, key, encoded.get(f.image), by)
            for f, messages, key in shown
            if key in looks or f.image in encoded
        }
        if len(nats) < 2:
            return self._unseen(brief)
        told = dict.fromkeys(nats, "the picture of it")
        return recommend("sle", brief, nats, told, cfg)

    def _nats(
        self,
        looks: dict[bytes, float],
        messages: list[dict[str, Any]],
        key: bytes,
        picture: Encoded | None,
        by: Deadline,
    ) -> float:
        if key not in looks:
            nats = self._do(lambda seconds: self._model.likes(messages, seconds, [picture]), by)
            looks[key] = float(nats)
            while len(looks) > LOOKS_KEPT:
                del looks[next(iter(looks))]
        return looks[key]

    def _do(self, work: Callable[[float], Any], by: Deadline) -> Any:
        """Queue a call and wait for it; raises Late, or what the model raised."""
        job = _Job(work, by)
        with self._condition:
            self._queue.append(job)
            self._condition.notify_all()
            while not job.done and not by.passed() and not self._closed:
                self._clock.wait(self._condition, by.at_s)
            if not job.done:
                if job in self._queue:
                    self._queue.remove(job)
                raise Late
        if job.error is not None:
            raise job.error
        return job.result

    # -- the worker thread: the only one that touches the model ----------------------------------

    def _work(self) -> None:
        while True:
            with self._condition:
                while not self._queue and not self._closed:
                    self._condition.wait()
                if self._closed:
                    return
                job = self._running = self._queue.popleft()
            try:
                if job.by.passed():
                    raise Late
                job.result = job.work(job.by.left_s())
            except Exception as error:  # noqa: BLE001 -- the asker's, not this thread's end
                job.error = error
            with self._condition:
                job.done = True
                self._running = None
                self._condition.notify_all()


def _question(brief: Brief, frontier: FrontierBrief) -> tuple[list[dict[str, Any]], bytes]:
    """What is asked about one frontier's picture, and what it goes by: its digest."""
    messages = prompted_experts.single(brief, frontier)
    text = "\0".join(p for m in messages for p in m.parts if isinstance(p, str))
    key = hashlib.sha256(frontier.image + b"\0" + text.encode()).digest()
    return prompted_experts.chat(messages), key
