"""Teaching the plain head of the scene-layout expert."""

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional as F

from models.train.beyond_course import Course
from models.train.beyond_data import Homes, Moments
from models.train.beyond_losses import LayoutFacts, beyond_loss, onward_loss, room_loss, view_loss
from models.train.beyond_network import HALFWAY_M, TEXT_DIM, PlainHead, evidence
from models.train.beyond_scores import Scores, auc, judge, split
from models.train.beyond_words import LayoutWords
from models.train.trainer import save

RATE, DECAY = 2e-3, 0.2
MOMENTS, FRAMES, PHOTOGRAPHS = 24, 96, 48
"""Of a step."""
AVERAGED = 0.995
WITHOUT_DEPTH = 0.15
"""Share of pictures whose depth is left out: photographs have none."""
NOISE = 0.2
"""Of the features, whose deviation is 1."""
BLUR, VIEW_BLUR = 0.2, 0.05
"""Deviation of the noise in names' rows: of few names much is learned that holds of no other."""
AT_ONCE = 512
GAINS = (0.7, 1.0, 1.4, 2.0, 2.8, 4.0)
WEIGHTS = {"beyond": 1.0, "onward": 1.0, "view": 0.7, "room": 0.3, "rooms": 0.5, "area": 0.5,
           "photographs": 0.3}  # fmt: skip


@dataclass(frozen=True)
class Photographs:
    """(P, C, h, w) features and (P,) room types, an index into the homes' room names."""

    features: Tensor
    room: Tensor


@dataclass(frozen=True)
class Lesson:
    """All that is taught from and judged on; photographs of rooms may be among it."""

    train: Homes
    dev: Homes
    words: LayoutWords
    photographs: Photographs | None = None


def plain_head(homes: Homes) -> PlainHead:
    """One that nothing was taught yet."""
    return PlainHead(homes.features.shape[1], len(homes.room_names))


def pictures(homes: Homes, frames: NDArray[np.int64], way: NDArray[np.float32]) -> list[Tensor]:
    """What a network is shown: features, depth and way."""
    picked = [torch.from_numpy(x[frames].astype(np.float32)) for x in (homes.features, homes.depth)]
    return [*picked, torch.from_numpy(way) / torch.tensor([1.0, HALFWAY_M])]


def varied(shown: list[Tensor], rng: np.random.Generator) -> list[Tensor]:
    """The same as they might be: mirrored, without depth, with noise."""
    features, depth, way = shown
    count = len(features)
    mirrored = torch.from_numpy(rng.random(count) < 0.5)
    side = mirrored[:, None, None, None]
    features = torch.where(side, features.flip(3), features)
    depth = torch.where(side, depth.flip(3), depth)
    column = torch.where(mirrored, 1 - way[:, 0], way[:, 0])
    column = (column + torch.from_numpy(rng.normal(0, 0.02, count)).float()).clamp(0, 1)
    range_ = way[:, 1] * torch.from_numpy(rng.normal(1, 0.05, count)).float()
    features = features + NOISE * torch.randn_like(features)
    blind = torch.from_numpy(rng.random(count) < WITHOUT_DEPTH)[:, None, None, None]
    return [features, depth * ~blind, torch.stack((column, range_), 1)]


def any_way(count: int, rng: np.random.Generator) -> NDArray[np.float32]:
    """(count, 2) ways drawn at random, where it is only asked what is in view."""
    return np.stack((rng.random(count), rng.uniform(0.5, 6, count)), 1).astype(np.float32)


class HeadTrainer:
    """All state of a run."""

    def __init__(self, lesson: Lesson, steps: int, seed: int) -> None:
        torch.manual_seed(seed)
        self.lesson, self.steps, self.seed = lesson, steps, seed
        self.facts = LayoutFacts(lesson.train, lesson.words.taught)
        self.moments = Moments.of(lesson.train)
        self.network = plain_head(lesson.train)
        self.average = copy.deepcopy(self.network).requires_grad_(False).eval()
        self.optimiser = torch.optim.AdamW(self.network.parameters(), lr=RATE, weight_decay=DECAY)
        self.step, self.best = 0, -math.inf

    def learn(self, rng: np.random.Generator, rows: NDArray[np.int64]) -> dict[str, float]:
        """One step; `rows` (M, G) of moments."""
        lesson, facts = self.lesson, self.facts
        names = lesson.words.draw(rng)
        names = names - names.mean(0)
        blurred, near = (names + b * torch.randn_like(names) for b in (BLUR, VIEW_BLUR))
        rooms = lesson.words.room_rows
        rooms = rooms - rooms.mean(0)
        flat = rows[rows >= 0]
        own = lesson.train
        shown = pictures(own, own.frame[flat], own.way()[flat])
        answer = self.network(*varied(shown, rng))
        beyond, nats = answer.beyond, evidence(answer.beyond, blurred)
        grouped = nats.new_zeros(*rows.shape, nats.shape[1])
        grouped[torch.from_numpy(rows >= 0)] = nats
        at = torch.from_numpy(flat)
        frames = rng.integers(0, len(own.features), FRAMES)
        view = self.network(*varied(pictures(own, frames, any_way(FRAMES, rng)), rng)).view
        seen = torch.from_numpy(frames)
        parts = {
            "beyond": beyond_loss(nats, facts, at),
            "onward": onward_loss(grouped, facts, torch.from_numpy(rows)),
            "rooms": room_loss(answer.rooms, facts.rooms[at]),
            "area": F.smooth_l1_loss(beyond[:, -1], facts.area[at]),
            "view": view_loss(evidence(view, near), facts, seen),
            "room": F.cross_entropy(view[:, :TEXT_DIM] @ rooms.T, facts.room[seen],
                                    ignore_index=-1),
            "photographs": self._photographs(rng, rooms),
        }  # fmt: skip
        total = torch.stack([WEIGHTS[k] * v for k, v in parts.items()]).sum()
        for group in self.optimiser.param_groups:
            group["lr"] = RATE * pace(self.step, self.steps)
        self.optimiser.zero_grad(set_to_none=True)
        total.backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(self.network.parameters(), 1.0)
        self.optimiser.step()
        follow(self.average, self.network, self.step)
        self.step += 1
        return {k: float(v.detach()) for k, v in parts.items()}

    def _photographs(self, rng: np.random.Generator, rooms: Tensor) -> Tensor:
        given = self.lesson.photographs
        if given is None:
            return torch.zeros(())
        at = torch.from_numpy(rng.integers(0, len(given.room), PHOTOGRAPHS))
        shown = photographed(given.features[at], rng)
        view = self.network(*varied(shown, rng)).view
        return F.cross_entropy(view[:, :TEXT_DIM] @ rooms.T, given.room[at])

    def examined(self) -> Scores:
        """How good the averaged weights are, on dev."""
        return examine(self.average, self.lesson, self.lesson.dev)

    def keep(self, path: Path) -> None:
        """Write the averaged weights."""
        save(path, self.average.state_dict())

    def save(self, path: Path) -> None:
        """Write everything."""
        save(path, {
            "network": self.network.state_dict(), "average": self.average.state_dict(),
            "optimiser": self.optimiser.state_dict(), "step": self.step, "best": self.best,
        })  # fmt: skip

    def restore(self, path: Path) -> None:
        """Go on from what `save` wrote."""
        state: dict[str, Any] = torch.load(path, map_location="cpu", weights_only=True)
        for name in ("network", "average", "optimiser"):
            getattr(self, name).load_state_dict(state[name])
        self.step, self.best = state["step"], state["best"]


def photographed(features: Tensor, rng: np.random.Generator) -> list[Tensor]:
    """What a network is shown of photographs: no depth, some way."""
    depth = features.new_zeros(len(features), 2, *features.shape[2:])
    way = torch.from_numpy(any_way(len(features), rng)) / torch.tensor([1.0, HALFWAY_M])
    return [features, depth, way]


def pace(step: int, steps: int) -> float:
    """Factor of the learning rate: up, then down as a cosine."""
    return min(1.0, (step + 1) / 100) * (0.02 + 0.98 * 0.5 * (1 + math.cos(math.pi * step / steps)))


@torch.no_grad()
def follow(average: nn.Module, network: nn.Module, step: int) -> None:
    """Have an average of the weights follow."""
    decay = min(AVERAGED, (1 + step) / (10 + step))
    for mine, theirs in zip(average.parameters(), network.parameters(), strict=True):
        mine.lerp_(theirs, 1 - decay)


@torch.no_grad()
def answers(head: PlainHead, homes: Homes) -> tuple[Tensor, Tensor]:
    """(N, 386) beyond each row, (F, 386) in view of each frame."""
    beyond = [head(*pictures(homes, homes.frame[at], homes.way()[at])).beyond
              for at in _parts(len(homes.frame))]  # fmt: skip
    middle = np.tile(np.array([[0.5, 2.0]], np.float32), (len(homes.features), 1))
    view = [head(*pictures(homes, at, middle[at])).view for at in _parts(len(homes.features))]
    return torch.cat(beyond), torch.cat(view)


def _parts(count: int) -> list[NDArray[np.int64]]:
    return np.array_split(np.arange(count), max(1, count // AT_ONCE))


def examine(head: PlainHead, lesson: Lesson, homes: Homes) -> Scores:
    """How good the head is on these homes."""
    words = lesson.words
    rows = words.canonical()
    rows = rows - rows.mean(0)
    beyond, view = answers(head, homes)
    scores = judge(
        evidence(beyond, rows).numpy().astype(np.float64), homes, np.flatnonzero(homes.best),
        words.taught, Moments.of(homes),
    )  # fmt: skip
    in_view = evidence(view, rows).numpy().astype(np.float64)
    everything = np.ones(len(in_view), bool)
    by_name = [auc(in_view[:, k], homes.in_view[:, k], everything) for k in range(len(rows))]
    rooms = words.room_rows - words.room_rows.mean(0)
    named = (view[:, :TEXT_DIM] @ rooms.T).argmax(1).numpy()
    known = homes.room >= 0
    room = float((named == homes.room)[known].mean()) if known.any() else math.nan
    taught, never = split(by_name, words.taught)
    return Scores(scores.beyond, scores.beyond_never, scores.onward, scores.onward_prior,
                  taught, never, room)  # fmt: skip


def teach_head(
    lesson: Lesson, out: Path, steps: int, seed: int, say: Callable[[str], None], every: int = 100
) -> PlainHead:
    """Train, or go on training; the best weights, by names never taught, lie in OUT/head.pt."""
    course = Course("head", out, steps, MOMENTS, every, seed, say)
    best = course.teach(HeadTrainer(lesson, steps, seed))
    done = plain_head(lesson.train)
    done.load_state_dict(torch.load(best, map_location="cpu", weights_only=True))
    return done.eval().requires_grad_(False)


@torch.no_grad()
def rooms_told(head: PlainHead, given: Photographs, words: LayoutWords) -> float:
    """Share of the photographs whose room type is told right, among all types."""
    shown = photographed(given.features, np.random.default_rng(0))
    rooms = words.room_rows - words.room_rows.mean(0)
    named = (head(*shown).view[:, :TEXT_DIM] @ rooms.T).argmax(1)
    return float((named == given.room).float().mean())


@torch.no_grad()
def fit_gain(head: PlainHead, homes: Homes, words: LayoutWords) -> float:
    """By what the evidence of what lies beyond is multiplied for the vote: names that are blurred
    in training make it timid. Of GAINS the one whose votes are best in these homes."""
    rows = torch.from_numpy(Moments.of(homes).best())
    names = words.canonical()
    beyond = answers(head, homes)[0]
    nats = evidence(beyond, names - names.mean(0))[rows.clamp(min=0)]
    facts = LayoutFacts(homes, words.taught)
    loss = [float(onward_loss(gain * nats, facts, rows)) for gain in GAINS]
    return GAINS[int(np.argmin(loss))]
