"""Recipes of the bundled suites: balanced from any beginning, spread over goals and homes."""

from collections import Counter
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.evaluation import sample
from hil_sim.evaluation.left_out import Undrivable
from hil_sim.evaluation.sample import adopted
from hil_sim.evaluation.starts import obstacle
from hil_sim.evaluation.suites import REPLICAS, UNSEEN, _home, interleaved, make_suite, offers
from hil_sim.ground_truth.episodes import (
    HM3D_GOALS,
    ROBOTHOR_GOALS,
    Episode,
    Start,
    check_start,
    known_suites,
    load_suite,
)
from hil_sim.ground_truth.freespace import FreeSpace, scene_hash
from hil_sim.scenes.format import Room, Scene, SceneError, SceneObject
from hil_sim.scenes.open import is_replica, open_scene
from hil_sim.scenes.robothor import metadata, unrecognised


def episode(scene: str, goal: str, number: int = 0, length: float = 5.0, x: float = 0.5) -> Episode:
    return Episode(f"{scene}-{goal}-{number}", scene, Start(x, 0.5, 0.0), goal, length)


@given(st.integers(1, 30), st.integers(1, 60))
def test_any_beginning_has_its_share_of_both(few: int, many: int) -> None:
    mixed = interleaved(
        [episode("few", "bed", i) for i in range(few)],
        [episode("many", "bed", i) for i in range(many)],
    )
    assert Counter(e.scene for e in mixed) == {"few": few, "many": many}
    for n in range(1, few + many + 1):
        here = sum(e.scene == "few" for e in mixed[:n])
        assert abs(here - n * few / (few + many)) <= 1.0


def test_official_episodes_are_offered_with_spread_goals() -> None:
    given = [episode(s, g, n) for s in REPLICAS for g in ROBOTHOR_GOALS for n in range(3)]
    given.append(episode(REPLICAS[0], "mug", 9, length=0.0))
    wishes = offers(given, 2)
    assert [w.scene for w in wishes] == sorted(REPLICAS)
    first = Counter(e.goal for w in wishes for e in w.given[:2])
    assert set(first) == set(ROBOTHOR_GOALS)
    assert max(first.values()) == 2
    assert all(len(w.given) == 36 and w.given[0].goal != w.given[1].goal for w in wishes)
    assert offers(given, 2) == wishes


def test_homes_ask_for_every_goal_about_as_often() -> None:
    firsts = Counter(_home(seed).goals[0] for seed in range(40))
    assert sum(firsts[g] for g in HM3D_GOALS) == 32
    assert all(5 <= firsts[g] <= 6 for g in HM3D_GOALS)
    assert all(set(HM3D_GOALS) <= {*_home(seed).goals} for seed in range(40))


class FakeTruth:
    """6 x 3 m of free floor; beds are at its far end, there are no mugs."""

    def __init__(self) -> None:
        free = np.zeros((60, 120), bool)
        free[2:58, 2:118] = True
        self.space = FreeSpace(Scene("hall", (), (), (), ()), (0.0, 0.0), free)

    def field(self, goal: str) -> Any:
        if goal == "mug":
            raise SceneError("no mug")
        return self.space.distance_field(np.array([[5.5, 0.5]]))


def test_official_episodes_are_taken_where_they_can_be_done() -> None:
    given = (
        episode("hall", "mug"),
        episode("hall", "bed", 1, x=0.05),  # in the wall
        episode("hall", "bed", 2, x=5.0),  # too near
        episode("hall", "bed", 3),
        episode("hall", "bed", 4),
        episode("hall", "sofa", 5),
    )
    found = adopted(given, FakeTruth(), 2)  # type: ignore[arg-type]
    assert [e.id for e in found] == ["hall-bed-3", "hall-sofa-5"]
    assert found[0].shortest_path_m == pytest.approx(5.0, abs=0.06)


def test_no_episode_asks_for_what_a_person_would_not_recognise(monkeypatch) -> None:
    truth = FakeTruth()
    bed = SceneObject("bed-1", "bed", "m", (5.5, 0.5, 0.0), 0.0, (2.0, 1.0, 0.5))
    truth.space = replace(truth.space, scene=replace(truth.space.scene, objects=(bed,)))
    given = (episode("hall", "bed", 3), episode("hall", "sofa", 5))
    assert len(adopted(given, truth, 2)) == 2  # type: ignore[arg-type]
    monkeypatch.setattr(unrecognised, "listed", lambda: {"hall": {"bed-1": "a slab"}})
    assert [e.goal for e in adopted(given, truth, 2)] == ["sofa"]  # type: ignore[arg-type]
    world = SimpleNamespace(scene=truth.space.scene, collides=lambda x, y: False)
    told = SimpleNamespace(space=truth.space, boxes=lambda goal: {0: None})
    assert obstacle(given[0], world, told) is Undrivable.UNRECOGNISED  # type: ignore[arg-type]


def test_what_is_not_asked_for_is_told(monkeypatch) -> None:
    hall = replace(FakeTruth().space.scene, name="FloorPlan_Val1_1")
    vase = SceneObject("vase-1", "vase", "m", (1, 1, 0))
    monkeypatch.setattr(sample, "open_scene", lambda name: replace(hall, objects=(vase,)))
    monkeypatch.setattr(unrecognised, "listed", lambda: {hall.name: {"vase-1": "a dish"}})
    pairs = [(hall.name, "vase"), (hall.name, "mug"), ("maple", "vase"), (hall.name, "vase")]
    assert sample.not_asked_for(pairs) == [
        "FloorPlan_Val1_1: vase left out, a person would not recognise it: a dish"
    ]


def test_an_episode_of_another_home_is_refused() -> None:
    truth = FakeTruth()
    found = adopted((episode("hall", "bed", 3),), truth, 1)[0]  # type: ignore[arg-type]
    check_start(found, truth.space)
    room = Room("hall", "hall", ((0, 0), (6, 0), (6, 3), (0, 3)))
    other = replace(truth.space, scene=Scene("hall", (), (), (room,), ()))
    with pytest.raises(SceneError, match="hall-bed-3: hall has changed since this was made"):
        check_start(found, other)
    check_start(replace(found, home=""), other)


def test_only_known_recipes(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="suite huge: no recipe; known: labels, official, val"):
        make_suite("huge", None)
    for name in ("val", "official"):
        with pytest.raises(SceneError, match=f"suite {name}: needs RoboTHOR's episodes; name"):
            make_suite(name, None)


@pytest.mark.skipif("val" not in known_suites(), reason="not made yet")
def test_the_bundled_suites_are_as_their_recipes_say() -> None:
    val = load_suite("val")
    assert len(val) == 60
    assert len({e.id for e in val}) == 60
    replicas = [e for e in val if e.scene in REPLICAS]
    assert len(replicas) == 20
    assert sum(e in replicas for e in val[:20]) in (6, 7)
    assert all(e.shortest_path_m >= 1.0 for e in val)
    assert len({e.goal for e in replicas}) >= 10


def test_the_official_suite_is_of_apartments_that_are_in_no_other() -> None:
    official = load_suite("official")
    assert len(official) == 81
    assert {e.scene for e in official} == set(UNSEEN)
    assert {e.scene for e in official[:5]} == set(UNSEEN)  # any beginning has them all
    assert {e.goal for e in official} == set(ROBOTHOR_GOALS) - {"vase"}
    others = {e.scene for name in known_suites() if name != "official" for e in load_suite(name)}
    assert not others & set(UNSEEN)


@pytest.mark.skipif("val" not in known_suites(), reason="not made yet")
def test_the_suites_homes_are_still_those_they_were_made_in() -> None:
    """A change to the generator or the furniture means: make the suites again."""
    for suite in ("val", "labels", "train", "official"):
        if suite in known_suites():
            episodes = load_suite(suite)
            there = [e for e in episodes if not is_replica(e.scene)][:4]
            if metadata.metadata_path().is_file():
                there += [e for e in episodes if is_replica(e.scene)][:10]
            for asked in there:
                assert scene_hash(open_scene(asked.scene)).startswith(asked.home), asked.id
