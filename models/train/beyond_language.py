"""Teaching the projector of the scene-layout expert: soft tokens, by what the frozen language model
makes of them. First what is in view, then what lies beyond."""

import copy
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional as F

from models.train.beyond_course import Course
from models.train.beyond_data import Homes, Moments
from models.train.beyond_head import (
    Lesson,
    any_way,
    follow,
    pace,
    photographed,
    pictures,
    varied,
)  # fmt: skip
from models.train.beyond_losses import LayoutFacts, beyond_loss, onward_loss, view_loss
from models.train.beyond_network import PlainHead, Projector
from models.train.beyond_scores import Scores, auc, judge, split
from models.train.beyond_speech import BEGINS, Speech
from models.train.trainer import save

RATE, DECAY = 6e-4, 0.05
WARM = 0.2
"""Share of the steps in which only what is in view is taught."""
MOMENTS, FRAMES, WARM_FRAMES = 5, 4, 16
"""Of a step; of frames as many are asked for things, and for rooms."""
EVERY = 100
EXAMINED = 500
"""Rows and frames of dev that checkpoints are chosen by."""
BLANK_FOLLOWS = 0.02
BLUR = 1.0
"""Of names' directions, as of names' rows in the plain head."""
SPOKEN = 0.3
"""Weight of the cross entropy of what is said."""


class ProjectorTrainer:
    """All state of a run."""

    def __init__(
        self, lesson: Lesson, speech: Speech, bridge: Tensor, head: PlainHead, steps: int, seed: int
    ) -> None:
        torch.manual_seed(seed)
        self.lesson, self.speech, self.steps = lesson, speech, steps
        self.facts = LayoutFacts(lesson.train, speech.taught)
        self.moments = Moments.of(lesson.train)
        self.network = begun(lesson, speech, bridge, head)
        self.average = copy.deepcopy(self.network).requires_grad_(False).eval()
        self.optimiser = torch.optim.AdamW(self.network.parameters(), lr=RATE, weight_decay=DECAY)
        self.blank = self.network.start.detach().repeat(8, 1)
        self.step, self.best = 0, -math.inf

    def learn(self, rng: np.random.Generator, rows: NDArray[np.int64]) -> dict[str, float]:
        """One step; `rows` (M, G) of moments."""
        warm = self.step < WARM * self.steps
        parts = self._in_view(rng, WARM_FRAMES if warm else FRAMES)
        if not warm:
            parts |= self._beyond(rng, rows)
        total = torch.stack(list(parts.values())).sum()
        for group in self.optimiser.param_groups:
            group["lr"] = RATE * pace(self.step, self.steps)
        self.optimiser.zero_grad(set_to_none=True)
        total.backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(self.network.parameters(), 1.0)
        self.optimiser.step()
        follow(self.average, self.network, self.step)
        self.step += 1
        return {k: float(v.detach()) for k, v in parts.items()}

    def _in_view(self, rng: np.random.Generator, count: int) -> dict[str, Tensor]:
        own = self.lesson.train
        frames = rng.integers(0, len(own.features), count)
        shown = varied(pictures(own, frames, any_way(count, rng)), rng)
        room = self.facts.room[torch.from_numpy(frames)]
        tokens = self.network(*shown)
        heard, blank = self._asked(tokens, "view")
        nats = self.speech.things(heard, blank, BLUR)
        at = torch.from_numpy(frames)
        parts = {
            "view": view_loss(nats, self.facts, at),
            "said": SPOKEN * self._spoken(heard, self.facts.in_view[at]),
        }
        given = self.lesson.photographs
        if given is not None:
            drawn = torch.from_numpy(rng.integers(0, len(given.room), count // 2))
            more = self.network(*varied(photographed(given.features[drawn], rng), rng))
            tokens, room = torch.cat((tokens, more)), torch.cat((room, given.room[drawn]))
        if (room >= 0).any():
            heard, _ = self._asked(tokens, "room")
            odds = heard @ self.speech.model.embedding[self.speech.rooms].T
            parts["room"] = F.cross_entropy(odds, room, ignore_index=-1)
        return parts

    def _beyond(self, rng: np.random.Generator, rows: NDArray[np.int64]) -> dict[str, Tensor]:
        own, flat = self.lesson.train, rows[rows >= 0]
        tokens = self.network(*varied(pictures(own, own.frame[flat], own.way()[flat]), rng))
        self.blank.lerp_(tokens.detach().mean(0), BLANK_FOLLOWS if self.step else 1.0)
        heard, blank = self._asked(tokens, "beyond")
        nats = self.speech.things(heard, blank, BLUR)
        grouped = nats.new_zeros(*rows.shape, nats.shape[1])
        grouped[torch.from_numpy(rows >= 0)] = nats
        at = torch.from_numpy(flat)
        return {
            "beyond": beyond_loss(nats, self.facts, at),
            "onward": onward_loss(grouped, self.facts, torch.from_numpy(rows)),
            "spoken": SPOKEN * self._spoken(heard, self.facts.there[at]),
        }

    def _asked(self, tokens: Tensor, prompt: str) -> tuple[Tensor, Tensor]:
        """What follows the tokens, and what follows those of no picture."""
        heard = self.speech.heard(torch.cat((tokens, self.blank[None])), prompt)
        return heard[:-1], heard[-1].detach()

    def _spoken(self, heard: Tensor, there: Tensor) -> Tensor:
        """Cross entropy of the next token with the names of what is there, each as likely."""
        wanted = there & torch.from_numpy(self.speech.taught)
        total = wanted.sum(1)
        if not (total > 0).any():
            return heard.new_zeros(())
        log_p = (heard @ self.speech.model.embedding.T).log_softmax(1)[:, self.speech.names]
        return (-(log_p * wanted).sum(1) / total.clamp(min=1))[total > 0].mean()

    def examined(self) -> Scores:
        """How good the averaged weights are, on some of dev."""
        return examine_projector(self.average, self.blank, self.lesson, self.speech)

    def keep(self, path: Path) -> None:
        """Write the averaged weights."""
        save(path, self.average.state_dict())

    def save(self, path: Path) -> None:
        """Write everything."""
        save(path, {
            "network": self.network.state_dict(), "average": self.average.state_dict(),
            "optimiser": self.optimiser.state_dict(), "blank": self.blank, "step": self.step,
            "best": self.best,
        })  # fmt: skip

    def restore(self, path: Path) -> None:
        """Go on from what `save` wrote."""
        state: dict[str, Any] = torch.load(path, map_location="cpu", weights_only=True)
        for name in ("network", "average", "optimiser"):
            getattr(self, name).load_state_dict(state[name])
        self.blank, self.step, self.best = state["blank"], state["step"], state["best"]


def begun(lesson: Lesson, speech: Speech, bridge: Tensor, head: PlainHead) -> Projector:
    """A projector that looks as the plain head has learned to."""
    start = speech.model.embedding[BEGINS]
    network = Projector(lesson.train.features.shape[1], start, bridge)
    network.toward.load_state_dict(head.toward.state_dict())
    network.seen.load_state_dict(head.seen.state_dict())
    return network


@torch.no_grad()
def mean_tokens(network: Projector, homes: Homes) -> Tensor:
    """(8, E): the tokens of no picture are those of all, in the mean."""
    rows = np.flatnonzero(homes.best)
    parts = np.array_split(rows, max(1, len(rows) // 512))
    told = [network(*pictures(homes, homes.frame[at], homes.way()[at])) for at in parts]
    return torch.cat(told).mean(0)


@torch.no_grad()
def examine_projector(network: Projector, blank: Tensor, lesson: Lesson, speech: Speech) -> Scores:
    """How good what the model says of the tokens is, on some of dev."""
    homes, words = lesson.dev, lesson.words
    moments = Moments.of(homes)
    order = np.random.default_rng(0).permutation(len(moments.rows))
    share = EXAMINED / max(1, int((moments.best() >= 0).sum()))
    some = Moments(moments.rows[order[: max(1, round(share * len(order)))]])
    rows = some.best()[some.best() >= 0]
    nats = np.zeros((len(homes.frame), len(homes.categories)))
    nats[rows] = _nats(
        network, blank, speech, homes, homes.frame[rows], homes.way()[rows], "beyond"
    )
    scores = judge(nats, homes, rows, words.taught, some)
    frames = np.random.default_rng(0).permutation(len(homes.features))[:EXAMINED]
    middle = np.tile(np.array([[0.5, 2.0]], np.float32), (len(frames), 1))
    view = _nats(network, blank, speech, homes, frames, middle, "view")
    every = np.ones(len(frames), bool)
    by_name = [auc(view[:, k], homes.in_view[frames, k], every) for k in range(view.shape[1])]
    taught, never = split(by_name, words.taught)
    return Scores(scores.beyond, scores.beyond_never, scores.onward, scores.onward_prior, taught,
                  never, _rooms(network, speech, homes, frames, middle))  # fmt: skip


def _rooms(
    network: Projector, speech: Speech, homes: Homes, frames: NDArray[np.int64],
    way: NDArray[np.float32],
) -> float:  # fmt: skip
    heard = torch.cat([
        speech.heard(network(*pictures(homes, frames[at], way[at])), "room")
        for at in np.array_split(np.arange(len(frames)), max(1, len(frames) // 64))
    ])  # fmt: skip
    named = (heard @ speech.model.embedding[speech.rooms].T).argmax(1).numpy()
    known = homes.room[frames] >= 0
    return float((named == homes.room[frames])[known].mean()) if known.any() else math.nan


def _nats(
    network: Projector, blank: Tensor, speech: Speech, homes: Homes, frames: NDArray[np.int64],
    way: NDArray[np.float32], prompt: str,
) -> NDArray[np.float64]:  # fmt: skip
    none = speech.heard(blank[None], prompt)[0]
    heard = [
        speech.heard(network(*pictures(homes, frames[at], way[at])), prompt)
        for at in np.array_split(np.arange(len(frames)), max(1, len(frames) // 64))
    ]
    return speech.things(torch.cat(heard), none).numpy().astype(np.float64)


def teach_projector(
    lesson: Lesson, speech: Speech, bridge: Tensor, head: PlainHead, out: Path, steps: int,
    seed: int, say: Callable[[str], None],
) -> Projector:  # fmt: skip
    """Train, or go on training; the best weights, by names never taught, lie in
    OUT/projector.pt."""
    course = Course("projector", out, steps, MOMENTS, EVERY, seed, say, WARM)
    best = course.teach(ProjectorTrainer(lesson, speech, bridge, head, steps, seed))
    network = begun(lesson, speech, bridge, head)
    network.load_state_dict(torch.load(best, map_location="cpu", weights_only=True))
    return network.eval().requires_grad_(False)
