"""What is known of a home, as it is told to those who ask."""

import base64
import json
import zlib
from dataclasses import replace

import numpy as np
import pytest
from lived_in import lived_in

from runtime.core.belief import Belief, Expected
from runtime.core.objects.instances import Evidence
from runtime.core.types import Absence, Ballot, Decision, Frontier, Missing, Vote
from runtime.core.world import World
from runtime.service.atlas import (
    CELLS,
    FREE,
    NO_ROOM,
    OCCUPIED,
    POINTS,
    THINGS,
    UNKNOWN,
    Atlas,
    asked_name,
    atlas_of,
    nothing_told,
)

CLASSES = (("mug", "cup", "coffee mug"), ("sofa", "couch"))


def atlas(world: World, origin_xy: tuple[float, float] = (0.0, 0.0)) -> Atlas:
    return atlas_of(world, CLASSES, "odom", origin_xy)


def grid(told: dict, name: str) -> np.ndarray:
    raw = zlib.decompress(base64.b64decode(told[name]))
    return np.frombuffer(raw, np.uint8).reshape(told["rows"], told["cols"])


def test_a_thing_is_told_with_its_place_and_its_room():
    told = atlas(lived_in(), (10.0, -5.0)).told("things")
    assert json.loads(json.dumps(told)) == told
    [mug] = told["things"]
    assert (mug["id"], mug["name"], mug["room"]) == (1, "mug", "kitchen")
    assert mug["confidence"] == pytest.approx(0.953, abs=1e-3)
    assert mug["names"] == {"mug": 0.982, "sofa": 0.018}
    x, y = lived_in().semantic.instances[1].xy
    assert mug["xy"] == pytest.approx([x + 10.0, y - 5.0], abs=1e-3)


def test_what_is_hardly_believed_is_not_told_and_of_many_the_surest_are():
    world = lived_in()
    mug = world.semantic.instances[1]
    for n in range(2, THINGS + 4):
        evidence = {"mug": Evidence(-2.0 if n == 2 else 4.0)}
        world.semantic.instances[n] = replace(mug, id=n, evidence=evidence)
    told = atlas(world).told("things")
    assert len(told["things"]) == THINGS
    assert told["left_off"] == 2
    assert not {1, 2} & {thing["id"] for thing in told["things"]}  # the less sure, the hardly


@pytest.mark.parametrize(
    "name", ["mug", "Mug", "the mug", "mugs", "a coffee-mug", "cup", "COFFEE MUGS"]
)
def test_a_thing_is_found_by_any_of_its_names(name: str):
    told = atlas(lived_in()).told("where", name)
    assert (told["name"], told["called"]) == (name, "mug")
    assert [thing["id"] for thing in told["found"]] == [1]


def test_what_is_hardly_that_is_not_told_as_found():
    assert atlas(lived_in()).told("where", "couch")["found"] == []
    assert atlas(lived_in()).told("where", "piano") == {
        "name": "piano", "called": "piano", "frame": "odom", "stamp_ns": 0, "found": [],
        "expected": [],
    }  # fmt: skip


def voted() -> World:
    world = lived_in()
    cells = np.array([[1.0, 0.0], [1.0, 0.1]])
    world.frontiers = Frontier(3, cells, (1.0, 0.0), 1.0), Frontier(7, cells, (2.0, 1.0), 2.0)
    votes = (
        Vote("o2f", (7,), ((3, 0.1), (7, 0.8)), "sink near by", reasons=((7, "7: sink"),)),
        Vote("r2f", (3, 7), ((3, 0.4), (7, 0.4), (9, 0.2)), "kitchen"),
    )
    ballot = Ballot(votes, (Missing("sle", Absence.LATE),))
    places = (
        Expected("frontier", 7, (2.0, 1.0), 0.5, "4.0 m² unknown behind it"),
        Expected("frontier", 9, (5.0, 1.0), 0.2, "3.0 m² unknown behind it"),  # it is no more
        Expected("surface", "b3", (1.5, 0.0), 0.15, "0.5 m² on which it is missed with 40 %"),
        Expected("frontier", 3, (1.0, 0.0), 0.05, "0.4 m² unknown behind it"),
    )
    told = Decision(7, "all", (7,), 3, ballot, 0, "new evidence", belief=Belief(places, 0.1))
    world.standing.decision = told
    return world


def test_where_it_is_looked_for_is_told_of_the_goal_alone():
    told = atlas(voted(), (1.0, 1.0)).told("where", "cup")
    assert json.loads(json.dumps(told)) == told
    assert [(e["kind"], e["id"], e["p"], e["xy"]) for e in told["expected"]] == [
        ("frontier", 7, 0.5, [3.0, 2.0]),
        ("surface", "b3", 0.15, [2.5, 1.0]),
        ("frontier", 3, 0.05, [2.0, 1.0]),
    ]
    said = [e["why"] for e in told["expected"]]
    assert said[0] == "4.0 m² unknown behind it; objects near by: 7: sink; kind of room: kitchen"
    assert said[1] == "0.5 m² on which it is missed with 40 %"
    assert atlas(voted()).told("where", "sofa")["expected"] == []


def test_where_nothing_is_believed_nothing_is_expected():
    world = voted()
    assert world.standing.decision is not None
    world.standing.decision = replace(world.standing.decision, belief=None)
    assert atlas(world).told("where", "mug")["expected"] == []


def test_the_map_is_told_by_cell():
    world = lived_in()
    told = atlas(world, (3.0, 0.0)).told("map")
    assert json.loads(json.dumps(told)) == told
    cells, rooms = grid(told, "cells"), grid(told, "rooms")
    x0, y0 = told["origin_xy"]

    def at(x: float, y: float) -> tuple[int, int]:
        resolution_m = told["resolution_m"]
        return int((y - y0) / resolution_m), int((x + 3.0 - x0) / resolution_m)

    assert cells[at(0.0, 0.0)] == FREE
    assert cells[at(2.05, 0.0)] == OCCUPIED
    assert cells[0, 0] == UNKNOWN
    assert told["room_names"][rooms[at(0.0, 0.0)]] == "kitchen"
    assert rooms[0, 0] == NO_ROOM
    assert told["pose"] == [3.0, 0.0, 0.0]


def test_long_paths_are_told_coarser_and_end_where_they_end():
    world = voted()
    world.body.visited_xy = [(0.01 * n, 0.0) for n in range(10 * POINTS + 3)]
    many = np.column_stack([np.arange(500.0), np.zeros(500)])
    world.frontiers = (replace(world.frontiers[0], cells_xy=many),)
    told = atlas(world).told("map")
    assert POINTS / 2 < len(told["path_xy"]) <= POINTS + 1
    assert told["path_xy"][-1] == [pytest.approx(0.01 * (10 * POINTS + 2)), 0.0]
    assert len(told["frontiers"][0]["cells_xy"]) <= CELLS + 1
    assert told["elected"] == 7


def test_nobody_changes_what_was_copied():
    world = lived_in()
    copied = atlas(world)
    before = json.dumps(copied.told("map"))
    again = atlas(world)
    world.map.evidence[:] = 20
    world.map.changed()
    world.semantic.rooms[:] = 0.0
    world.body.visited_xy.append((9.0, 9.0))
    assert json.dumps(again.told("map")) == before


@pytest.mark.parametrize("kind", ["things", "where", "map"])
def test_while_nothing_is_known_the_answer_has_the_same_names(kind: str):
    nothing = nothing_told(kind, "mug", "odom")
    known = atlas(lived_in()).told(kind, "mug")
    assert nothing.pop("said").startswith("nothing is known yet")
    assert set(nothing) == set(known)
    if kind == "map":
        assert grid(nothing, "cells").size == 0


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ({}, 'ask {"name": NAME}'),
        ({"name": 3}, "ask"),
        ({"name": "  "}, "ask"),
        ({"name": "mug", "n": 1}, "ask"),
        ({"name": "m" * 81}, "at most 80"),
        ({"name": "mug\x1b[2J"}, "printable"),
    ],
)
def test_what_is_no_name_is_refused(body: dict, said: str):
    with pytest.raises(ValueError, match=said.replace("{", r"\{")):
        asked_name(body)
    assert asked_name({"name": " coffee   mug "}) == "coffee mug"
