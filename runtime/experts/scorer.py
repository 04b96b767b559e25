"""The language model behind a score cache: one worker thread owns it, questions queue on it.

Equal questions have equal answers, so every score is kept under (model, context, continuation); a
room type or an object is asked about once, when it first appears, and decisions only look it up.
"""

import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Protocol, Self

import numpy as np

from runtime.clock import Clock, Deadline
from runtime.core.types import F32
from runtime.core.voting.likelihood_experts import LikelihoodQuestion
from runtime.experts.score_cache import ScoreFile

# Contexts of one home number in the hundreds; the bound only keeps a service of many days small.
CACHE_SIZE = 100_000
STUCK_S = 5.0  # at one prompt
UNSAVED = 500  # scores that are kept back from the file at most, while somebody waits
SHARED = 60  # characters in common from which on it pays to ask of two contexts in a row


class Likelihood(Protocol):
    """log P(continuation | context), up to a constant per continuation. One that can be shown
    something takes it as `seen`, (n, width), too."""

    def score(self, context: str, continuations: Sequence[str]) -> Sequence[float]: ...


Shown = Mapping[str, F32]
"""By the digest that questions carry, what stands before their context."""
NOTHING_SHOWN: Shown = {}


class Embedder(Protocol):
    def embed(self, texts: list[str]) -> F32:
        """N sentences -> (N, D) unit rows."""
        ...


class Similarity:
    """The rung below a language model: cosine of the two sentences' embeddings.

    Divided by a temperature, so that it spreads over about as many nats as a likelihood does.
    """

    def __init__(self, embedder: Embedder, temperature: float = 0.1) -> None:
        self._embedder = embedder
        self._temperature = temperature

    def score(self, context: str, continuations: Sequence[str]) -> tuple[float, ...]:
        rows = np.asarray(
            self._embedder.embed([context.strip(), *(c.strip() for c in continuations)])
        )
        return tuple(float(x) for x in rows[1:] @ rows[0] / self._temperature)


class _Job:
    """What one caller waits for. Guarded by the scorer's condition."""

    def __init__(self, questions: Sequence[LikelihoodQuestion], by: Deadline, shown: Shown) -> None:
        self.questions, self.shown = questions, shown
        self.waiting = deque(questions)  # those without a score yet, and perhaps some with
        self.by = by
        self.error: Exception | None = None
        self.done = False


class Scorer:
    """Cached likelihoods. `rungs` are tried from the first: (name, model), best first.

    A rung whose model raises is left for good, and the next one answers: scores of different
    models are never mixed in one answer, for their scales differ. The first rung's scores are kept
    in `file` too, unless they are of what was seen. `book` is told how long each prompt took, s, by
    the thread that owns the models.
    """

    def __init__(
        self,
        rungs: Sequence[tuple[str, Likelihood]],
        clock: Clock,
        file: ScoreFile | None = None,
        book: Callable[[float], None] = lambda took_s: None,
    ) -> None:
        if not rungs:
            raise ValueError("a scorer needs at least one model")
        self._rungs = list(rungs)
        self._first = self._rungs[0][0]
        self._clock, self._book = clock, book
        self._condition = threading.Condition()
        self._file = file
        self._cache: dict[tuple[str, LikelihoodQuestion], float] = {}
        if file is not None:
            name = self._rungs[0][0]
            self._cache = {(name, q): value for q, value in file.load().items()}
        self._urgent: deque[_Job] = deque()
        self._background: deque[LikelihoodQuestion] = deque()
        self._busy = False
        self._began_s = 0.0  # the prompt under way
        self._unsaved: list[tuple[LikelihoodQuestion, float]] = []
        self._last = ""  # the context asked about last
        self._closed = False
        self.errors: list[str] = []  # why rungs were left
        self._thread = threading.Thread(target=self._work, name="scorer", daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def rung(self) -> str:
        """Name of the model that answers now."""
        with self._condition:
            return self._rungs[0][0]

    @property
    def stuck(self) -> bool:
        """Whether the model has been at one prompt for so long that it may never end."""
        with self._condition:
            return self._busy and self._clock.now_s() - self._began_s > STUCK_S

    def __len__(self) -> int:
        """How many scores are kept."""
        with self._condition:
            return len(self._cache)

    def answer(
        self,
        questions: Iterable[LikelihoodQuestion],
        by: Deadline,
        shown: Shown = NOTHING_SHOWN,
    ) -> dict[LikelihoodQuestion, float]:
        """Scores by question; those the model did not reach by the deadline are left out. `shown`
        must have all that the questions say was seen.

        Raises what the last rung's model raised.
        """
        wanted = list(dict.fromkeys(questions))
        with self._condition:
            name = self._rungs[0][0]
            job = _Job(wanted, by, shown)
            if all((name, q) in self._cache for q in wanted):
                job.done = True
            else:
                self._urgent.append(job)
                self._condition.notify_all()
            while not job.done and not by.passed() and not self._closed:
                self._clock.wait(self._condition, by.at_s)
            if job.error is not None:
                raise job.error
            name = self._rungs[0][0]
            return {q: self._cache[name, q] for q in wanted if (name, q) in self._cache}

    def warm(self, questions: Iterable[LikelihoodQuestion]) -> None:
        """Score in the background, after everything that somebody waits for. Returns at once."""
        with self._condition:
            name = self._rungs[0][0]
            known = set(self._background)
            fresh = dict.fromkeys(q for q in questions if (name, q) not in self._cache)
            self._background.extend(q for q in fresh if q not in known)
            self._condition.notify_all()

    def forget(self) -> None:
        """Begin anew: nothing is known, and nothing is to be scored in the background."""
        with self._condition:
            self._cache.clear()
            self._background.clear()

    def settle(self, by: Deadline) -> bool:
        """Wait until nothing is queued any more; False when the deadline came first."""
        with self._condition:
            while self._urgent or self._background or self._busy:
                if by.passed() or self._closed:
                    return False
                self._clock.wait(self._condition, by.at_s)
            return True

    def close(self) -> None:
        """End the worker after the prompt under way; what is queued is abandoned."""
        with self._condition:
            self._closed = True
            self._background.clear()
            self._urgent.clear()
            self._condition.notify_all()
        self._thread.join(timeout=5.0)

    # -- the worker thread: the only one that touches a model ------------------------------------

    def _work(self) -> None:
        while True:
            with self._condition:
                while not self._urgent and not self._background and not self._closed:
                    self._condition.wait()
                if self._closed:
                    break
                job, prompt = self._next_prompt()
                name, model = self._rungs[0]
                self._busy, self._began_s = bool(prompt), self._clock.now_s()
                self._condition.notify_all()  # some may have found their answers in the cache
            if not prompt:
                continue
            outcome = _score(model, prompt, job.shown if job is not None else NOTHING_SHOWN)
            self._book(self._clock.now_s() - self._began_s)
            with self._condition:
                self._last = prompt[0].context
                self._keep(name, job, prompt, outcome)
                self._condition.notify_all()
            self._save(name, prompt, outcome)
            with self._condition:
                self._busy = False
                self._condition.notify_all()
        self._write()

    def _next_prompt(self) -> tuple[_Job | None, list[LikelihoodQuestion]]:
        """Questions that share one context, and what was seen before it: of the caller who can be
        answered soonest, else of the background."""
        while self._urgent:
            job = min(self._urgent, key=lambda j: len(j.waiting))  # the first of equals
            # Abandoned: its caller has gone. Nothing to take: answered in another's prompt.
            prompt = [] if job.by.passed() else self._take(job.waiting)
            if prompt:
                return job, prompt
            self._urgent.remove(job)
            job.done = True
        return None, self._take(self._background)

    def _take(self, waiting: deque[LikelihoodQuestion]) -> list[LikelihoodQuestion]:
        """Remove and return the unanswered questions of one context: one that begins as the last
        one did, if there is such, since what models have read of it they need not read again;
        else the first."""
        name = self._rungs[0][0]
        open_ = [q for q in waiting if (name, q) not in self._cache]
        if not open_:
            waiting.clear()
            return []
        begun = self._last[:SHARED]
        first = next((q for q in open_ if not q.seen and q.context[:SHARED] == begun), open_[0])
        context = first.seen, first.context
        taken = [q for q in open_ if (q.seen, q.context) == context]
        rest = [q for q in open_ if (q.seen, q.context) != context]
        waiting.clear()
        waiting.extend(rest)
        return taken

    def _keep(
        self,
        name: str,
        job: _Job | None,
        prompt: list[LikelihoodQuestion],
        outcome: list[float] | Exception,
    ) -> None:
        if isinstance(outcome, Exception):
            self._step_down(name, job, outcome)
            return
        for question, value in zip(prompt, outcome, strict=True):
            self._cache[name, question] = value
        while len(self._cache) > CACHE_SIZE:
            self._cache.pop(next(iter(self._cache)))
        if job is not None and not job.waiting:
            self._leave(job)

    def _save(
        self, name: str, prompt: list[LikelihoodQuestion], outcome: list[float] | Exception
    ) -> None:
        """Write what is new to the file once nobody waits, or when it is much; of what was seen
        nothing is."""
        kept = self._file is not None and name == self._first and not prompt[0].seen
        if kept and not isinstance(outcome, Exception):
            self._unsaved += zip(prompt, outcome, strict=True)
        with self._condition:
            waiting = bool(self._urgent or self._background)
        if not waiting or len(self._unsaved) >= UNSAVED:
            self._write()

    def _write(self) -> None:
        if self._file is not None and self._unsaved:
            self._file.keep(self._unsaved)
            self._unsaved = []

    def _step_down(self, name: str, job: _Job | None, error: Exception) -> None:
        """Leave the rung; on the last one the caller hears of it and the rung stays."""
        self.errors = [*self.errors[-9:], f"{name}: {error}"]
        if len(self._rungs) > 1:
            self._rungs.pop(0)
            for other in self._urgent:  # from the start: no mixture of scales
                other.waiting = deque(other.questions)
        elif job is not None:
            job.error = error
            self._leave(job)

    def _leave(self, job: _Job) -> None:
        job.done = True
        if job in self._urgent:  # else the scorer was closed meanwhile
            self._urgent.remove(job)


def _score(
    model: Likelihood, prompt: list[LikelihoodQuestion], shown: Shown
) -> list[float] | Exception:
    digest = prompt[0].seen
    try:
        seen: Any = {"seen": shown[digest]} if digest else {}
        values: Any = model.score(prompt[0].context, [q.continuation for q in prompt], **seen)
        scores = [float(v) for v in values]
        if len(scores) != len(prompt):
            raise ValueError(f"{len(scores)} scores for {len(prompt)} continuations")
    except Exception as error:  # noqa: BLE001 -- the callers' answer, not this thread's end
        return error
    return scores
