"""The best weights are kept, and what was stopped goes on, whatever it is that learns."""

import json
from pathlib import Path

import numpy as np
import pytest
from drawn_homes import draw_homes

from models.train.beyond_course import Course, worth
from models.train.beyond_data import Moments, read_homes
from models.train.beyond_scores import Scores


class Learns:
    """It gets better until step 4, and worse from there on."""

    def __init__(self, moments: Moments) -> None:
        self.step, self.best, self.moments = 0, -np.inf, moments
        self.seen: list[tuple[int, ...]] = []

    def learn(self, rng: np.random.Generator, rows: np.ndarray) -> dict[str, float]:
        self.step += 1
        self.seen.append(rows.shape)
        return {"beyond": 1.0 / self.step}

    def examined(self) -> Scores:
        return Scores(0.5 - 0.1 * abs(4 - self.step), float("nan"), 0.0, 0.0)

    def keep(self, path: Path) -> None:
        path.write_text(str(self.step))

    def save(self, path: Path) -> None:
        path.write_text(json.dumps([self.step, self.best]))

    def restore(self, path: Path) -> None:
        self.step, self.best = json.loads(path.read_text())


@pytest.fixture
def moments(tmp_path: Path) -> Moments:
    draw_homes(tmp_path / "homes-of-tests", 1, seed=1)
    return Moments.of(read_homes(tmp_path / "homes-of-tests"))


def course(out: Path, steps: int, said: list[str], warm: float = 0.0) -> Course:
    return Course("it", out, steps, 3, 2, 1, said.append, warm)


def test_the_best_weights_are_kept_and_not_the_last(tmp_path: Path, moments: Moments):
    learner, said = Learns(moments), list[str]()
    best = course(tmp_path, 7, said).teach(learner)
    assert (best, best.read_text()) == (tmp_path / "it.pt", "4")
    assert [line.partition(" |")[0] for line in said] == [
        "it: step 2 beyond 0.500", "it: step 4 beyond 0.250", "it: step 6 beyond 0.167",
        "it: step 7 beyond 0.143",
    ]  # fmt: skip
    assert learner.seen[0][0] == 3  # moments; the last of a round may be fewer
    table = (tmp_path / "it.csv").read_text().splitlines()
    assert table[0].startswith("step,beyond,beyond_never,")
    assert [row.partition(",")[0] for row in table[1:]] == ["2", "4", "6", "7"]


def test_what_was_stopped_goes_on(tmp_path: Path, moments: Moments):
    course(tmp_path, 4, []).teach(Learns(moments))
    again, said = Learns(moments), list[str]()
    best = course(tmp_path, 8, said).teach(again)
    assert said[0] == "it: resumed at step 4"
    assert len(again.seen) == 4
    assert best.read_text() == "4"  # what comes after is worse


def test_weights_of_the_first_steps_are_not_kept(tmp_path: Path, moments: Moments):
    best = course(tmp_path, 8, [], warm=0.7).teach(Learns(moments))
    assert best.read_text() == "6"


def test_what_cannot_be_judged_is_worth_nothing():
    assert worth(Scores(0.7, float("nan"), 0.2, 0.1)) == pytest.approx(1.0)
