"""What people draw over the bus is kept out of at once, journaled, and the same in a replay."""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from apartment import Apartment
from fake_models import FakeModels
from goal_bench import Bench
from lockstep_double import begin, home, running

from runtime.clock import SystemClock
from runtime.commands.record import RecordOptions, recording
from runtime.config import load
from runtime.core.destination import NEAR_M
from runtime.core.resorts import Resort
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action, Pose, SearchState
from runtime.core.world import World
from runtime.errors import ConfigError, NotLocalisedError
from runtime.journal import read_journal
from runtime.loops.goal_request import Terms
from runtime.loops.order import understand
from runtime.loops.places_desk import PlacesDesk
from runtime.loops.remembering import HomeMemory
from runtime.loops.whereabouts import NoZones, Whereabouts
from runtime.record import Record, unrecorded
from runtime.replay.drive import replay
from runtime.replay.script import Script
from runtime.robot.base import WELL
from runtime.robot.requests import Request
from runtime.robot.wire import Stamped
from runtime.service.bounds import GoalBounds, read_bounds, read_zone
from runtime.service.zones import Surroundings, Zones

HALL = [[0.2, 0.2], [9.8, 0.2], [9.8, 1.45], [0.2, 1.45]]
GAP = [[4.6, 2.4], [5.2, 2.4], [5.2, 4.2], [4.6, 4.2]]
RADIUS_M, TOLD = 0.18, 13
DOOR = Pose(4.4, 3.2, 1.0)


def searched(folder: Path, record: Record = unrecorded) -> list[tuple[float, float]]:
    """A search that is told of a zone before it begins, and at step TOLD of another: where the
    robot was at each."""
    there, been = home(), []
    with running(FakeModels(there), record=record) as (peer, ended):
        assert peer.ask("zones", {"add": "the hall", "polygon": HALL})["accepted"]
        assert begin(peer, folder)["accepted"]
        for step in range(40):
            if step == TOLD:
                assert peer.ask("zones", {"add": "a gap", "polygon": GAP})["accepted"]
            action = peer.show(there)
            assert action is not None, ended
            been.append((there.pose.x_m, there.pose.y_m))
            if action == "stop":
                break
            there.apply(Action(action))
        peer.ask("cancel", {"reason": "enough"})
    assert not ended
    return been


def test_a_zone_counts_from_the_next_frame_on_and_is_journaled(tmp_path: Path):
    been = searched(tmp_path)
    hall, gap = read_zone("", HALL), read_zone("", GAP)
    assert all(hall.outside_m(xy) >= RADIUS_M for xy in been)
    assert all(gap.outside_m(xy) >= RADIUS_M for xy in been[TOLD:])
    assert max(math.dist(xy, been[0]) for xy in been) > 0.5
    lines = [line for line in read_journal(tmp_path / "decisions.jsonl") if line["kind"] == "zones"]
    names = [[zone["name"] for zone in line["zones"]] for line in lines]
    assert names == [["the hall"], ["the hall", "a gap"]]


def test_a_drive_with_zones_is_replayed_to_the_last_bit(tmp_path: Path):
    with recording(load(None), RecordOptions(tmp_path / "r", 0.0, False), True, True) as record:
        searched(tmp_path / "log", record)
    (path,) = (tmp_path / "r").iterdir()
    again = replay(Script.open(path))
    assert again.equal, again.differences.found[0].in_words()
    assert again.differences.compared["command"] >= 14


class Unbound(NoZones):
    def bounds(self, body: object, rooms: object) -> GoalBounds:
        raise AssertionError("nothing is read that is refused")

    def unbound(self) -> str:
        return "keep-out zones (1) were drawn before the last start"


def test_while_nobody_knows_where_they_lie_no_goal_is_taken():
    models = FakeModels(home())
    terms = Terms(True, zones=Unbound())
    with pytest.raises(
        ConfigError, match=r"^keep-out zones \(1\) were drawn before the last start"
    ):
        understand({"goal": "toilet"}, models, lambda more: load(None, more), terms)
    models.panel.close()


def steps(folder: Path, body: dict[str, Any], led: dict[int, Pose]) -> tuple[Apartment, list[dict]]:
    """A goal in lockstep with those bounds; `led`: at which step the robot is put where."""
    there = home()
    with running(FakeModels(there)) as (peer, ended):
        answer = peer.ask("goal", {"log_dir": str(folder), **body})
        assert answer["accepted"], answer
        for step in range(80):
            there.pose = led.get(step, there.pose)
            action = peer.show(there)
            assert action is not None, ended
            if action == "stop":
                break
            there.apply(Action(action))
        peer.ask("cancel", {"reason": "enough"})
    assert not ended
    return there, list(read_journal(folder / "decisions.jsonl"))


def test_a_search_in_an_area_goes_into_it_first_and_ends_when_the_robot_has_left_it(tmp_path: Path):
    area = [[5.0, 2.0], [9.0, 2.0], [9.0, 4.8], [5.0, 4.8]]
    body = {"goal": "toilet", "area": {"polygon": area}}
    _, lines = steps(tmp_path, body, {30: Pose(3.9, 3.2, 0.0)})
    told = [line for line in lines if line["kind"] == "step"]
    assert told[0]["reason"] == "drive to the area of the search"
    inside = next(n for n, line in enumerate(told) if line["reason"] == "in the area of the search")
    assert inside < 12
    assert not any(line["kind"] == "decision" for line in lines[: lines.index(told[inside])])
    zone = read_zone("", area)
    assert all(zone.outside_m(tuple(line["pose"][:2])) < -RADIUS_M for line in told[inside:30])
    assert told[-1]["reason"] == "the robot is 1.1 m outside of the area of the search"
    assert len(told) == 31


def test_a_place_is_gone_to_and_nobody_votes_on_the_way(tmp_path: Path):
    there, lines = steps(tmp_path, {"go_to": {"x_m": 6.5, "y_m": 3.3, "yaw_rad": 1.57}}, {})
    told = [line for line in lines if line["kind"] == "step"]
    assert told[-1]["reason"] == "arrived at (6.5, 3.3)"
    assert math.dist((there.pose.x_m, there.pose.y_m), (6.5, 3.3)) <= NEAR_M
    assert not any(line["kind"] == "decision" for line in lines)
    goal = next(line for line in lines if line["kind"] == "goal")
    assert (goal["text"], goal["how"]) == ("go to (6.5, 3.3)", "a place: (6.5, 3.3)")


def test_a_place_that_has_moved_is_replayed_with_its_goal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    known = SavedMap()
    there, doors = home(), [Pose(4.4, 3.3, 0.0), Pose(6.5, 3.3, 1.57)]
    known.door = doors[0]
    monkeypatch.setattr(
        Zones, "bounds",
        lambda zones, body, rooms: read_bounds(body, rooms, (0.0, 0.0), known.place),
    )  # fmt: skip
    with (
        recording(load(None), RecordOptions(tmp_path / "r", 0.0, False), True, True) as record,
        running(FakeModels(there), record=record) as (peer, ended),
    ):
        body = {"go_to": "door", "log_dir": str(tmp_path / "log")}
        assert peer.ask("goal", body)["accepted"]
        for step in range(16):
            known.door = doors[step > 1]
            action = peer.show(there)
            assert action is not None, ended
            there.apply(Action(action))
        peer.ask("cancel", {"reason": "enough"})
    assert there.pose.x_m > 4.6
    (path,) = (tmp_path / "r").iterdir()
    again = replay(Script.open(path))
    assert again.equal, again.differences.found[0].in_words()


def test_what_a_goal_was_bound_to_is_replayed_with_it(tmp_path: Path):
    area = {"polygon": [[5.0, 2.0], [9.0, 2.0], [9.0, 4.8], [5.0, 4.8]]}
    with (
        recording(load(None), RecordOptions(tmp_path / "r", 0.0, False), True, True) as record,
        running(FakeModels(home()), record=record) as (peer, ended),
    ):
        for body in ({"goal": "toilet", "area": area}, {"go_to": {"x_m": 6.5, "y_m": 3.3}}):
            there = home()
            assert peer.ask("goal", {"log_dir": str(tmp_path / "log"), **body})["accepted"]
            for _ in range(16):
                action = peer.show(there)
                assert action is not None, ended
                there.apply(Action(action))
            peer.ask("cancel", {"reason": "enough"})
    (path,) = (tmp_path / "r").iterdir()
    again = replay(Script.open(path))
    assert again.equal, again.differences.found[0].in_words()
    assert again.differences.compared["command"] > 20  # of both


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    """Goals in real time; the robot stands where the test puts it."""
    nowhere = Surroundings(lambda: None, lambda: (0.0, 0.0), place={"door": DOOR}.get)
    bench = Bench(tmp_path, zones=Zones(None, nowhere))
    yield bench
    bench.close()


def test_in_real_time_a_place_is_arrived_at(bench: Bench):
    answer = bench.life.accept({"go_to": "door"})
    assert (answer["name"], answer["how"]) == ("door", "a place: door")
    id = answer["id"]
    bench.frames(2)
    assert bench.mode == "place"
    assert bench.plans[-1].course is not None
    bench.stand(4.3, 3.1)
    bench.frames()
    assert bench.mode == "face"
    bench.home.pose = replace(bench.home.pose, yaw_rad=DOOR.yaw_rad)
    bench.frames()
    told = bench.result(id)
    assert (told["result"], told["code"], told["goal"]) == ("arrived", 0, "go to door")
    assert told["sentence"].startswith('"go to door": the robot has arrived at (4.4, 3.2); it took')


def test_what_was_tried_to_get_into_the_area_is_none_of_the_search():
    world = World.begin("toilet", ("toilet",), (), Pose(0.0, 0.0, 0.0), RADIUS_M, 0)
    area = read_zone("", [[-1, -1], [1, -1], [1, 1], [-1, 1]], area=True)
    world.explored.resort = Resort.TIGHT
    command = Whereabouts(bounds=GoalBounds(area)).act(world, NavigateConfig())
    assert command.reason.startswith("in ")
    assert world.explored.resort is Resort.NONE


def test_in_real_time_a_robot_that_is_pushed_out_of_its_area_ends_its_search(bench: Bench):
    area = {"polygon": [[3.0, 2.0], [4.3, 2.0], [4.3, 4.4], [3.0, 4.4]]}
    bench.stand(3.6, 3.2)
    id = bench.ask(area=area)["id"]
    bench.frames(4)
    assert bench.mode == "look"
    bench.stand(4.5, 3.2)
    bench.frames()
    assert bench.life.drive is not None
    bench.stand(4.7, 3.2)
    bench.frames()
    told = bench.result(id)
    assert (told["result"], told["code"]) == ("area_left", 4706)
    assert bench.rests == [SearchState.AREA_LEFT]


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ({"go_to": "sofa"}, "go_to: place 'sofa' is not known"),
        ({"go_to": "door", "goal": "toilet"}, "go_to: a goal is either a thing or a place"),
        ({"goal": "toilet", "area": {"room": "cellar"}}, "area: room: 'cellar': unknown"),
        ({"goal": "toilet", "area": {}, "if_busy": "queue"}, "area: must have one of"),
    ],
)
def test_what_cannot_be_gone_to_takes_nothing_from_the_goal_under_way(
    bench: Bench, body: dict[str, Any], says: str
):
    id = bench.ask()["id"]
    refused = bench.life.accept(body)
    assert (refused["accepted"], refused["code"]) == (False, 4720)
    assert says in str(refused["error"])
    assert bench.life.told()["id"] == id


class SavedMap:
    """It has a door; where it lies is found out by and by."""

    def __init__(self) -> None:
        self.door: Pose | None = DOOR

    def place(self, name: str) -> Pose | None:
        if self.door is None:
            raise NotLocalisedError(f"place {name!r}: it is not known where the robot is")
        return self.door


@pytest.fixture
def moving(tmp_path: Path) -> Iterator[tuple[Bench, SavedMap]]:
    known = SavedMap()
    around = Surroundings(lambda: None, lambda: (0.0, 0.0), place=known.place)
    bench = Bench(tmp_path, zones=Zones(None, around))
    yield bench, known
    bench.close()


def test_a_place_is_gone_to_where_it_is_found_to_lie_by_now(moving: tuple[Bench, SavedMap]):
    bench, known = moving
    id = bench.life.accept({"go_to": "door"})["id"]
    bench.frames(2)
    known.door = replace(DOOR, x_m=DOOR.x_m + 0.8, yaw_rad=0.0)
    bench.stand(5.1, 3.1)
    bench.frames()
    told = bench.result(str(id))
    assert (told["result"], told["at_xy"]) == ("arrived", [5.2, 3.2])
    lines = list(read_journal(bench.folder / "search" / "decisions.jsonl"))
    assert [line["to"]["xy"][0] for line in lines if line["kind"] == "bounds"] == [4.4, 5.2]


@pytest.mark.parametrize("binds", [{"go_to": "door"}, {"goal": "bed", "area": {"place": "door"}}])
def test_a_place_that_nobody_knows_the_way_to_any_more_is_not_arrived_at(
    moving: tuple[Bench, SavedMap], binds: dict[str, Any]
):
    bench, known = moving
    id = bench.life.accept(binds)["id"]
    bench.frames(2)
    known.door = None
    bench.frames(2)
    told = bench.result(str(id))
    assert (told["result"], told["cause"], told["code"]) == ("failed", "not_localised", 4714)
    assert told["reason"].endswith("it is not known where the robot is")


def test_a_place_that_nobody_knows_the_way_to_yet_is_refused_as_such_and_fails_as_such(
    moving: tuple[Bench, SavedMap],
):
    bench, known = moving
    bench.ask("bed")
    id = bench.life.accept({"go_to": "door", "if_busy": "queue"})["id"]
    known.door = None
    for binds in ({"go_to": "door"}, {"goal": "sofa", "area": {"place": "door"}}):
        refused = bench.life.accept(binds)
        assert (refused["accepted"], refused["code"]) == (False, 4724)
    bench.request("cancel", id=bench.life.told()["id"])
    bench.life.next()
    told = bench.result(str(id))
    assert (told["cause"], told["code"]) == ("not_localised", 4714)


def test_an_area_that_was_left_for_good_is_not_entered_again_by_its_place(
    moving: tuple[Bench, SavedMap],
):
    bench, known = moving
    bench.ask("bed", area={"place": "door"}, afterwards={"place": "door"})
    bench.frames(2)
    drive = bench.life.drive
    assert drive is not None
    drive.search.whereabouts.lets_out((20.0, 3.0))
    known.door = replace(DOOR, x_m=DOOR.x_m + 0.8)
    bench.frames()
    bounds = drive.search.whereabouts.bounds
    assert bounds.area is None
    assert bounds.then_to is not None
    assert bounds.then_to.xy[0] == DOOR.x_m + 0.8


def test_a_place_may_wait_for_its_turn(bench: Bench):
    bench.ask()
    waits = bench.life.accept({"go_to": "door", "if_busy": "queue"})
    assert waits["queued"] == 1
    bench.request("cancel", id=bench.life.told()["id"])
    bench.life.next()
    assert bench.life.told()["id"] == waits["id"]
    bench.frames(2)
    assert bench.mode == "place"


def test_a_search_ends_where_it_is_not_known_any_more_where_zones_lie(tmp_path: Path):
    frames: list[Pose | None] = [Pose(0.0, 0.0, 0.0)]
    zones = Zones(None, Surroundings(lambda: None, lambda: (0.0, 0.0), lambda: frames[0]))
    assert zones.answer({"add": "the hall", "polygon": HALL})["accepted"]
    bench = Bench(tmp_path, zones=zones)
    id = bench.ask()["id"]
    bench.frames(2)
    assert bench.life.drive is not None
    world = bench.life.drive.search.world
    assert world is not None
    kept = world.map.zones.zones
    assert [zone.name for zone in kept] == ["the hall"]
    frames[0], bench.base = None, replace(WELL, hand="sticks")
    bench.frames(2)
    assert bench.mode == "hand"
    assert world.map.zones.zones == kept  # as long as nobody knows better
    bench.base = WELL
    bench.frames()
    told = bench.result(id)
    assert (told["result"], told["cause"], told["code"]) == ("failed", "not_localised", 4714)
    bench.close()


def test_the_type_of_room_that_is_searched_is_known_to_the_core(bench: Bench):
    bench.ask(area={"room": "bathroom"})
    bench.frames()
    assert bench.life.drive is not None
    assert bench.life.drive.search.world is not None
    assert bench.life.drive.search.world.explored.only_room == "bathroom"


class Process:
    """What a restart begins anew: zones and memory of one folder, and an odometry of its own."""

    def __init__(self, folder: Path, here: Pose) -> None:
        clock = SystemClock()
        around = Surroundings(lambda: here, lambda: (0.0, 0.0))
        self.zones = Zones(folder / "zones.json", around)
        odometry = lambda: (Stamped(0, here), clock.now_s())  # noqa: E731
        others = lambda: len(self.zones) > 0  # noqa: E731
        self.memory = HomeMemory(folder, False, "", clock, odometry, others)
        binding = self.memory.binding
        self.zones.bind(binding.transform, self.memory.place, binding.sure)

    def places(self, **body: object) -> dict[str, object]:
        desk = PlacesDesk(self.memory, lambda: (0.0, 0.0))
        return dict(desk.answer(Request("places", body, None, "rfnav/places")))


def test_after_a_restart_zones_lie_as_they_did_to_the_place_where_the_robot_is_said_to_be(
    tmp_path: Path,
):
    before = Process(tmp_path, Pose(1.0, 0.0, 0.0))
    assert before.places(name="dock")["accepted"]
    ahead = [[2.0, -0.5], [3.0, -0.5], [3.0, 0.5], [2.0, 0.5]]  # a metre before the dock
    assert before.zones.answer({"add": "stairs", "polygon": ahead})["accepted"]
    before.memory.close()
    after = Process(tmp_path, Pose(5.0, 5.0, math.pi / 2))
    assert after.zones.unbound()
    assert after.zones.now() == ()
    assert after.places(i_am_at="dock")["accepted"]
    assert after.zones.unbound() == ""
    (stairs,) = after.zones.now()
    assert np.allclose(stairs.corners_xy, [[5.5, 6.0], [5.5, 7.0], [4.5, 7.0], [4.5, 6.0]])
    after.memory.close()
