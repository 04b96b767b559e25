from pathlib import Path

import numpy as np
import pytest
from drawn_homes import draw_homes

torch = pytest.importorskip("torch")

from models.train.beyond_data import Homes, Moments, read_homes  # noqa: E402
from models.train.beyond_losses import (  # noqa: E402
    WALK_M,
    LayoutFacts,
    beyond_loss,
    onward_loss,
    room_loss,
    view_loss,
)
from models.train.beyond_scores import TEMPERATURE  # noqa: E402


@pytest.fixture
def homes(tmp_path: Path) -> Homes:
    draw_homes(tmp_path, 2, seed=1)
    return read_homes(tmp_path)


def test_what_is_true_costs_least_and_what_is_not_taught_nothing(homes: Homes) -> None:
    taught = np.arange(len(homes.categories)) < 5
    facts, at = LayoutFacts(homes, taught), torch.arange(len(homes.frame))
    truth = torch.from_numpy(np.where(homes.there(), 9.0, -9.0)).float()
    assert float(beyond_loss(truth - facts.usual, facts, at)) < 0.01
    assert float(beyond_loss(-truth, facts, at)) > 3
    other = truth.clone()
    other[:, 5:] *= -1
    assert float(beyond_loss(other, facts, at)) == float(beyond_loss(truth, facts, at))
    frames = torch.arange(len(homes.features))
    seen = torch.from_numpy(np.where(homes.in_view, 9.0, -9.0)).float()
    assert float(view_loss(seen - facts.usual_view, facts, frames)) < 0.01


def test_the_vote_should_follow_the_way_on(homes: Homes) -> None:
    facts = LayoutFacts(homes, np.ones(len(homes.categories), bool))
    facts.prior = torch.zeros_like(facts.prior)
    rows = torch.from_numpy(Moments.of(homes).best())
    ideal = (-facts.onward.clamp(max=99) * TEMPERATURE / WALK_M)[rows]
    assert float(onward_loss(ideal, facts, rows)) == pytest.approx(0, abs=1e-4)
    assert float(onward_loss(-ideal, facts, rows)) > float(onward_loss(0 * ideal, facts, rows)) > 0


def test_rooms_are_weighed_by_their_floor() -> None:
    shares = torch.tensor([[8.0, 0.0], [0.1, 0.1]])
    right, wrong = torch.tensor([[9.0, 0.0], [0.0, 0.0]]), torch.tensor([[0.0, 9.0], [0.0, 0.0]])
    assert float(room_loss(right, shares)) < 0.01
    assert float(room_loss(wrong, shares)) == pytest.approx(9, abs=0.01)
