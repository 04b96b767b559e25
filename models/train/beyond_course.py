"""How either network of the scene-layout expert is taught: step by step, examined now and then, the
best weights kept; what was stopped is gone on with."""

import csv
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from models.train.beyond_data import Moments
from models.train.beyond_scores import Scores


class Learner(Protocol):
    """A network that is taught: after how many steps it is, what its best weights were worth, and
    the moments that it learns from."""

    step: int
    best: float
    moments: Moments

    def learn(self, rng: np.random.Generator, rows: NDArray[np.int64], /) -> dict[str, float]:
        """One step, on (M, G) rows of moments: the parts of its loss."""
        ...

    def examined(self) -> Scores:
        """How good it is, on dev."""
        ...

    def keep(self, path: Path, /) -> None:
        """Write its weights as they are."""
        ...

    def save(self, path: Path, /) -> None:
        """Write all that is needed to go on."""
        ...

    def restore(self, path: Path, /) -> None:
        """Go on from what `save` wrote."""
        ...


@dataclass(frozen=True)
class Course:
    """A run of so many steps with `moments` each, examined `every` so many; of the first ones,
    `warm` of all steps, no weights are kept. `name` begins the files in `out`: NAME.pt the best
    weights, NAME-run.pt all, NAME.csv the scores."""

    name: str
    out: Path
    steps: int
    moments: int
    every: int
    seed: int
    say: Callable[[str], None]
    warm: float = 0.0

    def teach(self, learner: Learner) -> Path:
        """Go through with it, or go on; where the best weights lie."""
        run, best = self.out / f"{self.name}-run.pt", self.out / f"{self.name}.pt"
        if run.exists():
            learner.restore(run)
            self.say(f"{self.name}: resumed at step {learner.step}")
        rng = np.random.default_rng((self.seed, learner.step))
        drawn = learner.moments.draw(self.moments, rng)
        while learner.step < self.steps:
            parts = learner.learn(rng, next(drawn))
            if learner.step % self.every and learner.step < self.steps:
                continue
            scores = learner.examined()
            lost = " ".join(f"{part} {value:.3f}" for part, value in parts.items())
            self.say(f"{self.name}: step {learner.step} {lost} | dev: {scores.told()}")
            self._log(learner.step, scores)
            if learner.step >= self.warm * self.steps and worth(scores) > learner.best:
                learner.best = worth(scores)
                learner.keep(best)
            learner.save(run)
        return best

    def _log(self, step: int, scores: Scores) -> None:
        """One row more of a table."""
        path = self.out / f"{self.name}.csv"
        new = not path.exists()
        with path.open("a", newline="") as stream:
            writer = csv.writer(stream)
            if new:
                writer.writerow(["step", *vars(scores)])
            writer.writerow([step, *(f"{value:.4f}" for value in vars(scores).values())])


def worth(scores: Scores) -> float:
    """What weights are chosen by: names never taught, on homes never seen, and the way on."""
    judged = (scores.beyond, scores.beyond_never, scores.onward, scores.onward_prior)
    return float(np.nan_to_num(judged).sum())
