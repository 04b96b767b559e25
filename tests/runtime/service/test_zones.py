"""Zones that people draw: what is taken and refused, what a restart makes of them, and that none
is lost without a word."""

import json
import math
from pathlib import Path
from typing import Any

import pytest
from full_disk import largest_file

from runtime.core.types import Pose
from runtime.service.zones import FILE, MOST_ZONES, Binding, Surroundings, Zones, read_zone

SQUARE = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]]


def zones(folder: Path | None, binding: Binding | None = None, at: Pose | None = None) -> Zones:
    path = folder / FILE if folder is not None else None
    return Zones(path, Surroundings(lambda: at, lambda: (0.0, 0.0), binding))


def drawn(some: Zones) -> dict[str, list[tuple[float, ...]]]:
    return {zone.name: [tuple(round(v, 6) for v in xy) for xy in zone.corners_xy]
            for zone in some.now()}  # fmt: skip


def test_a_zone_that_is_drawn_lies_on_the_map_at_once_until_it_is_removed():
    some = zones(None)
    assert some.answer({"add": "stairs", "polygon": [*SQUARE, SQUARE[0]]}) == {
        "accepted": True, "zones": [{"name": "stairs", "polygon": SQUARE}], "bound": True,
    }  # fmt: skip
    assert drawn(some) == {"stairs": [tuple(xy) for xy in SQUARE]}
    assert some.answer({"list": True})["zones"] == [{"name": "stairs", "polygon": SQUARE}]
    moved = [[x + 1, y] for x, y in SQUARE]
    some.answer({"add": "stairs", "polygon": moved})
    assert drawn(some) == {"stairs": [tuple(xy) for xy in moved]}
    assert some.answer({"remove": "stairs"})["zones"] == []
    assert some.now() == ()


def test_no_zone_is_drawn_where_it_would_be_moved_again():
    some, seen = zones(None), [False]
    some.bind(lambda: Pose(1.0, 2.0, 0.5), lambda name: None, lambda: seen[0])
    refused = some.answer({"add": "stairs", "polygon": SQUARE})
    assert not refused["accepted"]
    assert "not seen to be so yet" in str(refused["error"])
    assert some.answer({"list": True})["zones"] == []
    seen[0] = True
    assert some.answer({"add": "stairs", "polygon": SQUARE})["accepted"]


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ({}, "must have one of add, remove, clear, list"),
        ({"add": "a", "remove": "a", "polygon": SQUARE}, "must have one of"),
        ({"adds": "a"}, "'adds': unknown; did you mean add?"),
        ({"add": "", "polygon": SQUARE}, "must be a name of at most 60 letters"),
        ({"add": "a\n", "polygon": SQUARE}, "must be a name of at most 60 letters"),
        ({"add": 5, "polygon": SQUARE}, "must be a name of at most 60 letters"),
        ({"add": "a" * 61, "polygon": SQUARE}, "must be a name of at most 60 letters"),
        ({"add": "a"}, "polygon: must be a list of corners"),
        ({"add": "a", "polygon": [[0, 0], [1, 1], [1]]}, "polygon: must be a list of corners"),
        ({"add": "a", "polygon": [[0, 0], [1, 1], [True, 0]]}, "polygon: must be a list"),
        ({"add": "a", "polygon": [[0, 0], [1, 1], [10**400, 0]]}, "polygon: must be a list"),
        ({"add": "a", "polygon": [[0, 0], [1, 1], [math.nan, 0]]}, "polygon: must be a list"),
        ({"add": "a", "polygon": SQUARE[:2]}, "polygon: has 2 corners"),
        ({"add": "a", "polygon": []}, "polygon: has 0 corners"),
        ({"add": "a", "polygon": [[0, 0], [1, 1], [1, 0], [0, 1]]}, "polygon: crosses itself"),
        ({"list": True, "polygon": SQUARE}, "polygon: only of a zone to add"),
        ({"remove": "b"}, "remove: 'b': unknown"),
    ],
)
def test_what_is_no_zone_is_refused_in_a_line_and_changes_nothing(body: Any, says: str):
    some = zones(None)
    some.answer({"add": "stairs", "polygon": SQUARE})
    answer = some.answer(body)
    assert answer["accepted"] is False
    assert str(answer["error"]).startswith(f"zones request: {says}") or says in str(answer["error"])
    assert "\n" not in str(answer["error"])
    assert list(drawn(some)) == ["stairs"]


def test_there_are_so_many_and_no_more():
    some = zones(None)
    answers = [some.answer({"add": str(n), "polygon": SQUARE}) for n in range(MOST_ZONES + 1)]
    assert [answer["accepted"] for answer in answers] == [True] * MOST_ZONES + [False]
    assert some.answer({"add": "0", "polygon": SQUARE})["accepted"]


def test_who_draws_one_round_the_robot_is_told_that_it_will_leave():
    some = zones(None, at=Pose(1.5, 0.5, 0.0))
    answer = some.answer({"add": "mat", "polygon": SQUARE})
    assert answer["accepted"]
    assert "the robot stands in mat" in str(answer["warning"])
    far = [[x + 5, y] for x, y in SQUARE]
    assert "warning" not in some.answer({"add": "rug", "polygon": far})


def test_where_odometry_begins_far_off_they_are_told_in_its_frame():
    some = Zones(None, Surroundings(lambda: Pose(1.5, 0.5, 0.0), lambda: (100.0, -50.0)))
    answer = some.answer({"add": "mat", "polygon": [[x + 100, y - 50] for x, y in SQUARE]})
    assert "warning" in answer
    assert drawn(some) == {"mat": [tuple(xy) for xy in SQUARE]}


def test_after_a_restart_no_goal_is_taken_until_it_is_known_where_they_lie(tmp_path: Path):
    zones(tmp_path).answer({"add": "stairs", "polygon": SQUARE})
    where: list[Pose | None] = [None]
    again = zones(tmp_path, lambda: where[0])
    assert again.now() == ()
    assert again.unbound().startswith("keep-out zones (1) were drawn before the last start")
    assert again.answer({"list": True}) == {
        "accepted": True, "zones": [{"name": "stairs", "polygon": SQUARE}], "bound": False,
    }  # fmt: skip
    assert not again.answer({"add": "rug", "polygon": SQUARE})["accepted"]
    where[0] = Pose(3.0, 1.0, math.pi / 2)
    assert again.unbound() == ""
    assert drawn(again) == {"stairs": [(3.0, 2.0), (3.0, 3.0), (2.0, 3.0), (2.0, 2.0)]}
    here = [[5.0, 1.0], [6.0, 1.0], [6.0, 2.0]]
    again.answer({"add": "rug", "polygon": here})
    assert drawn(again)["rug"] == [tuple(xy) for xy in here]
    where[0] = None
    assert again.now() == ()
    later = zones(tmp_path, lambda: Pose(3.0, 1.0, math.pi / 2))
    assert drawn(later)["rug"] == [tuple(xy) for xy in here]


def test_one_is_not_drawn_where_nobody_knows_but_goals_are_taken_as_long_as_there_is_none():
    some = Zones(None, Surroundings(lambda: None, lambda: (0.0, 0.0), lambda: None))
    assert some.unbound() == ""
    answer = some.answer({"add": "rug", "polygon": SQUARE})
    assert "it is not known where the robot is" in str(answer["error"])
    assert str(answer["error"]).endswith("(rfnav/places), or begin a search: it looks round")


def test_without_a_memory_they_can_be_removed_and_drawn_again(tmp_path: Path):
    zones(tmp_path).answer({"add": "stairs", "polygon": SQUARE})
    again = zones(tmp_path)
    assert again.unbound()
    assert again.unbound() in str(again.answer({"add": "rug", "polygon": SQUARE})["error"])
    again.answer({"remove": "stairs"})
    assert again.unbound() == ""
    again.answer({"add": "stairs", "polygon": SQUARE})
    assert drawn(again) == {"stairs": [tuple(xy) for xy in SQUARE]}
    assert zones(tmp_path).unbound()


@pytest.mark.parametrize(
    "raw",
    [
        b"", b"[]", b"{}", b'{"zones": 5}', b'{"zones": [5]}', b'{"zones": [{"name": "a"}]}',
        b"\xff\xfe", b'{"zones": [{"name": "a", "polygon": [[0,0],[1,1],[NaN,0]]}]}',
        json.dumps({"zones": [{"name": str(n), "polygon": SQUARE} for n in range(65)]}).encode(),
    ],
)  # fmt: skip
def test_a_file_that_is_none_is_put_aside_and_no_goal_is_taken_until_people_have_seen_to_it(
    tmp_path: Path, raw: bytes
):
    (tmp_path / FILE).write_bytes(raw)
    for some in (zones(tmp_path), zones(tmp_path)):  # and after the next start
        assert "draw the keep-out zones again" in some.unbound()
        assert not some.answer({"add": "stairs", "polygon": SQUARE})["accepted"]
    assert (tmp_path / f"{FILE}.aside-1").read_bytes() == raw
    assert some.answer({"clear": True})["accepted"]
    assert some.unbound() == ""
    assert zones(tmp_path).unbound() == ""


def test_zones_that_cannot_be_kept_are_refused(tmp_path: Path):
    some = zones(tmp_path)
    with largest_file(10):
        answer = some.answer({"add": "stairs", "polygon": SQUARE})
    assert answer["accepted"] is False
    assert "cannot be written" in str(answer["error"])
    assert some.now() == ()


def test_an_area_is_read_as_a_zone_is():
    assert read_zone("", SQUARE, area=True).area
