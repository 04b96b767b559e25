"""Experts of which it is known what they see, asked about views whose content is known."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from looked import BED, write_homes

from hil_sim.expert_bench.plan_counts import PlanCounts
from hil_sim.expert_bench.scene_views import (
    GUESSING,
    HEAD,
    NEVER,
    ORACLE_FLOOR,
    ORACLE_ROOMS,
    TABLE,
    TAUGHT,
    About,
    HomesCounted,
    ViewTable,
    enough,
    judge_views,
)
from hil_sim.expert_bench.scene_ways import PRIOR
from hil_sim.expert_bench.view_questions import Floats, SightRows, ViewBank, load_views
from hil_sim.ground_truth.labels import LABELLED
from hil_sim.scenes.format import ROOM_TYPES

BEDROOM, KITCHEN = (ROOM_TYPES.index(name) for name in ("bedroom", "kitchen"))


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
    return judge_views(views, counted(views), kinds, np.eye(len(LABELLED)), never)


def counted(views: ViewBank | None) -> HomesCounted:
    """A bedroom of 10 m2 has a bed three times in four, a kitchen of 5 m2 never, nor has any other
    room anything; one kitchen in four is next to such a bedroom."""
    share, floor_m2 = np.full((len(ROOM_TYPES), len(LABELLED)), 1e-9), np.full(len(ROOM_TYPES), 5.0)
    share[BEDROOM, BED], floor_m2[BEDROOM] = 0.75, 10.0
    nearby = share.copy()
    nearby[KITCHEN, BED] = 0.25
    return HomesCounted(views, PlanCounts(share, nearby, floor_m2))


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
    judge_views(views, counted(views), {"sees": expert}, np.eye(len(LABELLED)), ())
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
    told = judge_views(views, counted(views), {"sees": Sighted()}, np.eye(len(LABELLED)), (), seen)
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


def test_who_is_told_the_truth_knows_what_the_counts_know(views: ViewBank) -> None:
    beyond, count = views.beyond, len(views.beyond.sights)
    beyond.asked[:, BED] = True
    beyond.true[:, BED] = np.arange(count) % 4 == 0
    views.ways.room_m2[:] = 0.0
    views.ways.room_m2[::2, BEDROOM] = 2.0  # half of the bedrooms are small, and have no bed
    views.ways.room_m2[::4, BEDROOM] = 8.0
    views.ways.room_m2[1::2, KITCHEN] = 5.0
    rows = judged(views).areas["beyond", TAUGHT]
    assert rows[ORACLE_FLOOR].macro.mean == 1.0
    assert rows[ORACLE_ROOMS].macro.mean == pytest.approx(1.0 - 0.5 * (1 / 3))
    assert ORACLE_ROOMS not in judged(views).areas["view", TAUGHT]


def test_without_train_views_the_table_is_that_of_plans(views: ViewBank) -> None:
    sights, bed = views.in_view.sights, views.in_view.true[:, BED]
    sights.rooms[:] = 1e-6
    sights.rooms[bed, BEDROOM] = sights.rooms[~bed, KITCHEN] = 1.0
    table = judge_views(views, counted(None), {}, np.eye(len(LABELLED)), ())
    assert table.areas["view", TAUGHT][TABLE].macro.mean == 1.0
    by_plans = counted(None).table("beyond").share[[BEDROOM, KITCHEN], BED]
    assert by_plans == pytest.approx([0.75, 0.25])  # the kitchen is next to some bedroom
