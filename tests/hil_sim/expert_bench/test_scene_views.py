"""Experts of which it is known what they see, asked about views whose content is known."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from looked import BED, write_homes

from hil_sim.expert_bench.scene_views import (
    GUESSING,
    HEAD,
    NEVER,
    TABLE,
    TAUGHT,
    About,
    ViewTable,
    enough,
    judge_views,
)
from hil_sim.expert_bench.scene_ways import PRIOR
from hil_sim.expert_bench.view_questions import Floats, SightRows, ViewBank, load_views
from hil_sim.ground_truth.labels import LABELLED
from hil_sim.scenes.format import ROOM_TYPES


class Sighted:
    """It knows a bed, and a bedroom, by the frame's first feature; or takes it the wrong way
    round."""

    def __init__(self, sign: float = 1.0) -> None:
        self.sign, self.asked = sign, list[tuple[About, tuple[str, ...]]]()

    def evidence(self, about: About, sights: SightRows, names: Sequence[str]) -> Floats:
        self.asked.append((about, tuple(names)))
        seen = self.sign * sights.features[:, 0, 0, 0].astype(float)
        known = np.array([name in ("bed", "bedroom") for name in names], float)
        return seen[:, None] * known


@pytest.fixture
def views(tmp_path: Path) -> ViewBank:
    return load_views(write_homes(tmp_path, homes=4, rows=32))


def judged(views: ViewBank, never: Sequence[str] = ()) -> ViewTable:
    kinds = {"sees": Sighted(), "mistakes": Sighted(-1.0)}
    return judge_views(views, views, kinds, np.eye(len(LABELLED)), never)


def test_who_sees_it_knows_what_is_in_view(views: ViewBank) -> None:
    rows = judged(views).areas["view", TAUGHT]
    assert rows["sees"].macro.mean == rows["sees"].micro.mean == 1.0
    assert rows["mistakes"].macro.mean == 0.0
    assert rows[TABLE].macro.mean == 0.5  # all rooms look alike to the head
    assert rows["sees"].gap.figure.low == 0.5
    assert rows["mistakes"].gap.mean == -0.5
    assert GUESSING not in rows


def test_names_never_taught_are_a_group_of_their_own(views: ViewBank) -> None:
    table = judged(views, never=("bed",))
    assert table.asked["view", TAUGHT] == (0, 0)
    assert table.areas["view", TAUGHT]["sees"].macro.n == 0
    assert table.asked["view", NEVER] == (1, 4 * 32)
    assert table.areas["view", NEVER]["sees"].macro.mean == 1.0
    assert table.areas["view", NEVER][GUESSING].macro.mean == 0.5


def test_a_thing_that_is_always_there_is_not_asked_about(views: ViewBank) -> None:
    assert enough(views.in_view).tolist() == [BED]
    assert enough(views.beyond).tolist() == []  # where no bed is in view, none is near
    expert = Sighted()
    judge_views(views, views, {"sees": expert}, np.eye(len(LABELLED)), ())
    assert expert.asked == [("beyond", ()), ("view", ("bed",)), ("room", tuple(ROOM_TYPES))]


def test_rooms_that_are_known_count(views: ViewBank) -> None:
    told = judged(views).rooms
    assert (told["sees"].mean, told["mistakes"].mean) == (1.0, 0.0)
    assert told[HEAD].mean == pytest.approx((views.room == 0).mean())  # it never knows: the first
    views.room[:] = -1
    views.room[0] = ROOM_TYPES.index("bedroom")
    assert judged(views).rooms["sees"].n == 1


def test_photographs_have_a_row_of_their_own(views: ViewBank) -> None:
    assert judged(views).photographs == {}
    seen = views.in_view.sights, np.full_like(views.room, ROOM_TYPES.index("bedroom"))
    told = judge_views(views, views, {"sees": Sighted()}, np.eye(len(LABELLED)), (), seen)
    assert set(told.photographs) == {"sees", HEAD}
    assert told.photographs["sees"].mean == 0.5
    assert told.photographs[HEAD].mean == 0.0


def test_what_evidence_adds_to_the_prior_is_told(views: ViewBank) -> None:
    beyond, count = views.beyond, len(views.beyond.sights)
    near = np.arange(count) % 2 == 0
    beyond.asked[:, BED], beyond.true[:, BED] = True, near
    shown = beyond.sights.features[:, 0, 0, 0]
    shown[:] = np.where(np.arange(count) % 4 < 2, np.where(near, 1, -1), 0)  # it sees every other
    views.ways.unknown_m2[:] = np.where(np.arange(count) % 4 < 2, 1.0, np.where(near, 3.0, 0.1))
    row = judged(views).areas["beyond", TAUGHT]["sees"]
    alone = judged(views).areas["beyond", TAUGHT][PRIOR]
    assert row.weighed is not None
    assert row.gain is not None
    assert row.weighed.mean == 1.0 > max(row.macro.mean, alone.macro.mean)
    assert row.gain.mean == pytest.approx(1.0 - alone.macro.mean)
    assert judged(views).areas["view", TAUGHT]["sees"].gain is None
