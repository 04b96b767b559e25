"""Counting what stands in rooms."""

import json

import pytest

from hil_sim.importers import placement_stats
from hil_sim.importers.placement_stats import Standing, count_rooms, read_room
from hil_sim.scenes.generated.placement import TABLE
from hil_sim.scenes.robothor.metadata import Thing, metadata_path

ROOM = (0.0, 0.0, 4.0, 3.0)


def thing(kind: str, low: tuple[float, float, float], *parents: str) -> Thing:
    high = (low[0] + 0.5, low[1] + 0.5, low[2] + 0.5)
    return Thing(f"{kind}|1", kind, "", low, (0.0, 0.0, 0.0), low, high, (), parents)


def test_a_room_is_read_by_what_stands_on_what() -> None:
    rows = [
        thing("Floor", (0.0, 0.0, -0.1)),
        thing("Desk", (0.0, 0.0, 0.0), "Floor|1"),
        thing("Laptop", (0.1, 0.1, 0.7), "Desk|1"),
        thing("Painting", (2.0, 0.0, 1.2)),
        thing("Pan", (3.5, 2.5, 0.5), "StoveBurner|9"),
        thing("LightSwitch", (3.9, 1.0, 1.0)),
    ]
    standing, rect = read_room(rows)
    assert {s.category: s.on for s in standing} == {
        "desk": "floor", "laptop": "desk", "picture": "wall", "pan": "stove",
    }  # fmt: skip
    assert rect == (0.0, 0.0, 4.4, 3.0)


def test_counts_of_rooms() -> None:
    sofa = Standing("sofa", (0.0, 0.1, 2.0, 1.0), "floor")
    lamp = Standing("lamp", (2.5, 0.0, 2.8, 0.3), "floor")
    far = Standing("lamp", (1.9, 1.7, 2.1, 1.9), "floor")
    rooms = [([sofa, lamp, far], ROOM), ([lamp], ROOM), ([], ROOM), ([lamp], ROOM)]
    row = count_rooms(rooms)["lamp"]
    assert row["counts"] == [0.25, 0.5, 0.25]
    assert row["present"] == 0.75
    assert row["mean"] == 1.33
    assert row["on"] == {"floor": 1.0}
    assert row["wall"] == 0.75
    assert row["near"] == {"sofa": 0.5}
    assert "near" not in count_rooms(rooms)["sofa"], "one sofa says nothing about neighbours"


@pytest.mark.slow
def test_the_committed_table_is_what_the_rooms_say() -> None:
    if not metadata_path().is_file():
        pytest.skip("hil-sim assets pull")
    made = placement_stats.as_text(placement_stats.count_all())
    assert TABLE.read_text(encoding="utf-8") == made


def test_the_committed_table_names_its_source() -> None:
    table = json.loads(TABLE.read_text(encoding="utf-8"))
    assert table["source"]["licence"] == "Apache-2.0"
    assert set(table["rooms"]) == {"kitchen", "living room", "bedroom", "bathroom"}
