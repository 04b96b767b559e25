"""The models: whether they are there, and how fast they are on this machine."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from runtime.clock import Clock, Deadline
from runtime.config import Config
from runtime.core.types import U8, Absence, Ballot, Detections
from runtime.doctor.diagnosis import Diagnosis, bad, ok, unknown, warning
from runtime.errors import RfNavError
from runtime.experts.panel import Panel
from runtime.experts.trial_question import TRIAL
from runtime.loops.shedding import RESTS
from runtime.perception.goal_words import Goal
from runtime.tracing.budgets import Budgets, StageBudget
from runtime.tracing.stages import Stage

LOOKS: Final = 8  # of the detectors: some look at every other image
PATIENCE: Final = 5.0  # times what a vote may take, that a first one, and prompts, are waited for
SIZE: Final = (480, 640)  # of an image, where none came
MS: Final = 1e3


class TriedModels(Protocol):
    """The models, as far as they are tried."""

    def accept(self, goal: str, config: Config) -> tuple[Goal, Panel]: ...

    def detect(self, rgb: U8) -> Detections: ...

    def settle(self, by: Deadline) -> bool: ...


Load = Callable[[Config, Callable[[float], None]], AbstractContextManager[TriedModels]]
"""The configuration, and who is told how long each prompt took, s -> the models, loaded."""


@dataclass(frozen=True)
class ModelsTried:
    """`error`: why they cannot be used; `looks_s`: of the detectors, once they were warm;
    `prompts_s`: to the language model that scores words; `ballot`: of all experts, None where
    nobody was asked; `within_s`: so soon a vote counts; `seen`: whether an
    image was the camera's."""

    error: str = ""
    load_s: float = 0.0
    looks_s: Sequence[float] = ()
    prompts_s: Sequence[float] = ()
    ballot: Ballot | None = None
    within_s: float = 0.0
    seen: bool = False


def try_models(load: Load, config: Config, clock: Clock, rgb: U8 | None) -> ModelsTried:
    """Load them, show the detectors an image, and have the experts vote once, by the evidence that
    is configured. The language model that scores words is timed at what a goal has it score in the
    background, whether or not that vote asks it: what was never counted does."""
    image, prompts_s, began_s = rgb if rgb is not None else _grain(), list[float](), clock.now_s()
    try:
        with load(config, prompts_s.append) as models:
            load_s = clock.now_s() - began_s
            _, panel = models.accept(TRIAL.goal, config)
            looks_s = []
            for _ in range(LOOKS + 1):
                look_s = clock.now_s()
                models.detect(image)
                looks_s.append(clock.now_s() - look_s)
            ballot = None
            if config.panel.experts:
                patience_s = PATIENCE * config.panel.votes_s
                ballot = panel.ask(TRIAL, Deadline.after(patience_s, clock))
                models.settle(Deadline.after(patience_s, clock))
    except RfNavError as error:
        return ModelsTried(str(error))
    seen, within_s = rgb is not None, config.panel.votes_s
    return ModelsTried("", load_s, looks_s[1:], tuple(prompts_s), ballot, within_s, seen)


def _grain() -> U8:
    """(H, W, 3) of noise: it costs what any image costs."""
    return np.random.default_rng(0).integers(256, size=(*SIZE, 3), dtype=np.uint8)


def judge_models(tried: ModelsTried, budgets: Budgets) -> Iterator[Diagnosis]:
    """Against what each stage may take."""
    if tried.error:
        yield bad("models", tried.error, "rfnav models pull fetches what is missing")
        return
    loop = budgets.loop
    told = f"loaded in {tried.load_s:.1f} s"
    if tried.load_s > loop.ready_s:
        few = f"{told}, {loop.ready_s:g} are their budget"
        yield warning("models", few, "the first start embeds all words; look again at the next")
    else:
        yield ok("models", told)
    yield _detector(tried, budgets)
    yield from _experts(tried, budgets)


def _detector(tried: ModelsTried, budgets: Budgets) -> Diagnosis:
    budget = budgets.stages.get(Stage.DETECT)
    if not tried.looks_s or budget is None:
        return unknown("detector", "nobody looked, or it has no budget")
    median_ms = MS * float(np.median(tried.looks_s))
    of = "a camera's image" if tried.seen else "noise of 640x480, for no image came"
    told = f"a look takes {median_ms:.0f} ms ({of}); its budget is {budget.median_ms:g} ms"
    if median_ms <= budget.median_ms:
        return ok("detector", told)
    return warning(
        "detector",
        f"{told}: {_shed(median_ms, budget)}",
        "name fewer detectors in models.detectors, or give the runtime more of the processor",
    )


def _shed(median_ms: float, budget: StageBudget) -> str:
    """What the runtime would do less of."""
    if median_ms <= budget.p99_ms:
        return f"every look that takes over {budget.p99_ms:g} ms counts as an overrun"
    return (
        f"every look is an overrun ({budget.p99_ms:g} ms), for which the runtime sheds "
        f"{budget.shed}, then rests for {RESTS[1]:g} to {RESTS[-1]:g} looks after each"
    )


def _experts(tried: ModelsTried, budgets: Budgets) -> Iterator[Diagnosis]:
    ballot, budget = tried.ballot, budgets.stages.get(Stage.SCORE)
    if tried.prompts_s and budget is not None:
        median_ms = MS * float(np.median(tried.prompts_s))
        told = f"a prompt takes {median_ms:.0f} ms; its budget is {budget.median_ms:g} ms"
        if median_ms > budget.median_ms:
            remedy = "name a smaller models.language, or give the runtime more of the processor"
            yield warning("language model", told, remedy)
        else:
            yield ok("language model", told)
    if ballot is None:
        yield ok("experts", "none: panel.experts is empty")
        return
    votes = {vote.expert: ballot.latency_s.get(vote.expert, 0.0) for vote in ballot.votes}
    said = [f"{name} in {took_s:.2f} s" for name, took_s in votes.items()]
    failed = [one for one in ballot.missing if one.why in (Absence.LATE, Absence.ERROR)]
    said += [f"{one.expert}: {one.cause}" for one in failed]
    words = f"a first vote: {', '.join(said) or 'nobody had anything to say'}"
    if failed or any(took_s > tried.within_s for took_s in votes.values()):
        yield warning(
            "experts",
            f"{words}; what takes over {tried.within_s:g} s does not count",
            "later votes are faster, by what is scored already; panel.decide_budget_s gives more "
            "time",
        )
    else:
        yield ok("experts", words)
