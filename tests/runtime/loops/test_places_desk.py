"""Places by query: told in the map of now, kept in a frame that outlives it."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from manual_clock import ManualClock

from runtime.core.types import Pose
from runtime.errors import ConfigError
from runtime.loops.places_desk import PlacesDesk
from runtime.loops.remembering import HomeMemory
from runtime.robot.requests import Request
from runtime.robot.wire import Stamped
from runtime.service.places import PLACES_FILE


class Here:
    """A memory, where a test says that the robot is."""

    def __init__(self, folder: Path) -> None:
        self.clock, self.pose = ManualClock(5.0), Pose(2.0, 1.0, 0.5)
        self.memory = HomeMemory(
            folder, False, "", self.clock, lambda: (Stamped(0, self.pose), 5.0)
        )
        self.desk = PlacesDesk(self.memory, lambda: self.origin_xy)
        self.origin_xy = (0.0, 0.0)

    def ask(self, **body: object) -> dict:
        answer = self.desk.answer(Request("places", body, None, "rfnav/places"))
        return json.loads(json.dumps(answer))


@pytest.fixture
def here(tmp_path: Path) -> Iterator[Here]:
    it = Here(tmp_path)
    yield it
    it.memory.close()


def test_a_place_is_where_the_robot_stands_or_where_somebody_says(here: Here):
    assert here.ask(list=True) == {
        "accepted": True, "memory": "none: it begins here", "places": {},
    }  # fmt: skip
    assert here.ask(name="desk")["places"] == {"desk": [2.0, 1.0, 0.5]}
    assert here.ask(name="sill", at=[0, 1, 2])["places"]["sill"] == [0.0, 1.0, 2.0]
    assert list(here.ask(remove="Desk")["places"]) == ["sill"]


def test_after_a_restart_places_are_nowhere_until_it_is_told_where_it_is(
    here: Here, tmp_path: Path
):
    here.ask(name="desk")
    here.ask(name="sill", at=[3.0, 1.0, 0.5])
    again = Here(tmp_path)
    assert again.ask(list=True)["places"] == {"desk": None, "sill": None}
    refused = again.ask(name="chair")
    assert not refused["accepted"]
    assert "not known where the robot is (unbound: " in refused["error"]
    assert '{"i_am_at": NAME}' in refused["error"]
    with pytest.raises(ConfigError, match=r"place 'desk': it is not known where the robot is"):
        again.memory.place("desk")
    again.pose = Pose(0.0, 0.0, 0.5)
    told = again.ask(i_am_at="DESK")
    assert told["memory"] == "bound by 'DESK', where it was said to be"
    assert told["places"] == {"desk": [0.0, 0.0, 0.5], "sill": [1.0, 0.0, 0.5]}
    again.memory.close()


def test_poses_are_odometrys_where_the_map_begins_elsewhere(here: Here):
    here.origin_xy = (100.0, -50.0)
    assert here.ask(name="desk")["places"] == {"desk": [102.0, -49.0, 0.5]}
    assert here.ask(name="sill", at=[100.0, 0.0, 0.0])["places"]["sill"] == [100.0, 0.0, 0.0]
    assert here.memory.place("sill") == Pose(0.0, 50.0, 0.0)
    assert here.memory.place("chair") is None


def test_forgetting_begins_here(here: Here, tmp_path: Path):
    here.ask(name="desk")
    assert here.ask(forget=True)["places"] == {}
    assert (tmp_path / f"{PLACES_FILE}.aside-1").is_file()


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ({}, "ask {"),
        ({"list": True, "name": "desk"}, "ask {"),
        ({"forget": False}, "ask {"),
        ({"name": ""}, "name of a place"),
        ({"name": "desk", "at": [1]}, "a place is"),
        ({"remove": "sofa"}, "no place is called 'sofa'"),
        ({"i_am_at": "sofa"}, "no place is called 'sofa'"),
        ({"i_am_at": 3}, "name of a place"),
    ],
)
def test_what_cannot_be_done_is_said(here: Here, body: dict[str, object], told: str):
    answer = here.ask(**body)
    assert not answer["accepted"]
    assert told in answer["error"]


def test_without_odometry_nobody_is_anywhere(here: Here):
    here.clock.advance(2.0)
    assert "no odometry" in here.ask(name="desk")["error"]


def test_what_is_not_written_is_not_there(here: Here, tmp_path: Path):
    here.memory.places.path = tmp_path / "file" / "below"
    (tmp_path / "file").touch()
    assert "cannot be written" in here.ask(name="desk")["error"]
    assert here.ask(list=True)["places"] == {}
