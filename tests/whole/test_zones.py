"""Searches through a simulated flat, every process real, with zones and an area drawn: where the
body truly was is asked of the simulation."""

import itertools
import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from places import TESTS

from hil_sim.driving.drawn_bounds import Corners, DrawnBounds
from hil_sim.driving.episode_result import EpisodeResult
from hil_sim.driving.episode_run import run_episode
from hil_sim.driving.link import Runtime, rfnav_command
from hil_sim.driving.methods import method_named
from hil_sim.driving.realtime import run_realtime
from hil_sim.driving.rig import home_of, open_world
from hil_sim.ground_truth.episodes import Episode, Start
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.protocol import HM3D
from runtime.core.mapping.zones import Zone

pytestmark = pytest.mark.slow  # whole processes
PROTOCOL = replace(HM3D, width=320, height=240)  # as where true labels are told
METHOD, RADIUS_M = "oracle-perception/closest", 0.18
SETTINGS = (*method_named(METHOD).start, "panel.experts=[]")
EPISODE = Episode("e", "flat", Start(0.5, 0.6, 0.0), "toilet", 3.0)
RUG = (1.2, -0.1), (1.8, -0.1), (1.8, 1.0), (1.2, 1.0)  # across the short way
DOOR = (2.6, 1.2), (3.6, 1.2), (3.6, 2.6), (2.6, 2.6)
BEDROOM = (0.0, 0.0), (3.1, 0.0), (3.1, 4.0), (0.0, 4.0)
Search = Callable[[DrawnBounds], tuple[EpisodeResult, list[tuple[float, float]]]]


@pytest.fixture(scope="module")
def search(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Search]:
    """A search for the toilet; where the robot truly was, from observation to observation."""
    out = tmp_path_factory.mktemp("zones")
    with (
        open_world(open_scene(str(TESTS / "refs/flat.json")), Assets(), "auto") as world,
        Runtime(out / "log", settings=SETTINGS) as runtime,
    ):
        from hil_sim.ground_truth.truth import SceneTruth

        home = home_of(world, SceneTruth(world, Assets()), PROTOCOL, EPISODE.goal)

        def go(bounds: DrawnBounds) -> tuple[EpisodeResult, list[tuple[float, float]]]:
            folder = out / str(len(list(out.iterdir())))
            result = run_episode(EPISODE, home, runtime, PROTOCOL, METHOD, folder, bounds=bounds)
            rows = [json.loads(line) for line in (folder / "track.jsonl").read_text().splitlines()]
            been = [(EPISODE.start.x_m, EPISODE.start.y_m), *((r["x"], r["y"]) for r in rows)]
            between = [
                ((a[0] * (4 - n) + b[0] * n) / 4, (a[1] * (4 - n) + b[1] * n) / 4)
                for a, b in itertools.pairwise(been)
                for n in range(4)
            ]
            return result, [*between, been[-1]]

        yield go


def nearest_m(corners: Corners, been: list[tuple[float, float]]) -> float:
    return min(Zone("", tuple(corners)).outside_m(xy) for xy in been)


def test_without_a_zone_the_short_way_leads_where_one_will_be(search: Search):
    result, been = search(DrawnBounds())
    assert result.success, (result.ended, result.reason, result.distance_m, been[-1])
    assert nearest_m(RUG, been) < RADIUS_M  # the body is in it


def test_the_body_never_enters_a_zone_and_the_goal_is_found_by_the_other_way(search: Search):
    result, been = search(DrawnBounds({"rug": RUG}))
    assert result.success, (result.ended, result.reason, result.distance_m, been[-1])
    assert RADIUS_M <= nearest_m(RUG, been) < 0.5


def test_a_goal_behind_a_zone_is_not_gone_to_and_the_search_says_so(search: Search):
    result, been = search(DrawnBounds({"rug": RUG, "door": DOOR}))
    assert not result.success
    assert str(result.ended) == "stop"
    assert "no way leads there" in result.reason or "nothing left to explore" in result.reason
    assert nearest_m(RUG, been) >= RADIUS_M
    assert nearest_m(DOOR, been) >= RADIUS_M


def test_an_area_is_not_left(search: Search):
    result, been = search(DrawnBounds(area=BEDROOM))
    assert not result.success
    assert str(result.ended) == "stop"
    assert all(Zone("", BEDROOM).outside_m(xy) <= -RADIUS_M for xy in been)


def test_in_real_time_no_course_cuts_a_corner_into_a_zone(tmp_path: Path):
    with (
        open_world(open_scene(str(TESTS / "refs/flat.json")), Assets(), "auto") as world,
        Runtime(tmp_path / "log", None, SETTINGS, rfnav_command(())) as runtime,
    ):
        from hil_sim.ground_truth.truth import SceneTruth

        home = home_of(world, SceneTruth(world, Assets()), PROTOCOL, EPISODE.goal)
        asked = EPISODE, home, runtime, PROTOCOL, METHOD, tmp_path / "e"
        result = run_realtime(*asked, bounds=DrawnBounds({"rug": RUG}))
    rows = [json.loads(line) for line in (tmp_path / "e/track.jsonl").read_text().splitlines()]
    assert result.success, (result.ended, result.reason)
    assert RADIUS_M <= nearest_m(RUG, [(row["x"], row["y"]) for row in rows]) < 0.5
