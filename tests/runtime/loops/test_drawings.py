"""What is handed over when, and that it is drawn beside the loop."""

import json
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from apartment import INTRINSICS, MOUNT, NO_DETECTIONS, TWO_ROOMS, Apartment
from drawn_reader import read
from manual_clock import ManualClock

from runtime import navigate
from runtime.core.mapping.zones import Zone
from runtime.core.types import Action, Pose
from runtime.core.world import Command, Mode, World
from runtime.loops.drawings import DIAGNOSE_S, EVERY_S, TOPICS, Drawings, NoDrawings
from runtime.navigate import NavigateConfig
from runtime.robot.dialects.dialect import RosTopic
from runtime.robot.messages import StreamHealth
from runtime.robot.session import DRAWN

PATIENCE_S = 20.0
COMMAND = Command(Action.MOVE_FORWARD, Mode.FRONTIER, None, "", np.array([[0.0, 0.0], [1.0, 0.0]]))


class FakePublisher:
    def __init__(self, topic: RosTopic, changed: threading.Condition) -> None:
        self.topic, self.changed = topic, changed
        self.put_: list[bytes] = []
        self.listeners = True

    def put(self, payload: bytes) -> None:
        with self.changed:
            self.put_.append(payload)
            self.changed.notify_all()

    def heard(self) -> bool:
        return self.listeners


class FakeBus:
    def __init__(self) -> None:
        self.changed = threading.Condition()
        self.publishers: dict[str, FakePublisher] = {}
        self.origin = (0.0, 0.0)

    def publisher(self, topic: RosTopic) -> Any:
        self.publishers[topic.name] = FakePublisher(topic, self.changed)
        return self.publishers[topic.name]

    def frame_of(self, stream: str, otherwise: str) -> str:
        return {"odom": "odom_combined", "color": "lens"}[stream]

    def origin_xy(self) -> tuple[float, float]:
        return self.origin

    def health(self) -> Mapping[str, StreamHealth]:
        return {"odom": StreamHealth(received=1)}

    def told(self, topic: str, count: int) -> list[Any]:
        publisher = self.publishers[topic]
        with self.changed:
            assert self.changed.wait_for(lambda: len(publisher.put_) >= count, PATIENCE_S)
            return [read(payload, publisher.topic.kind) for payload in publisher.put_]


@pytest.fixture
def world() -> World:
    home = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0))
    world = World.begin("toilet", ("toilet",), (), home.pose, NavigateConfig().robot.radius_m)
    navigate.perceive(world, home.observe(), NO_DETECTIONS, MOUNT, NavigateConfig())
    assert world.lens is not None
    assert world.lens[0] == INTRINSICS
    return world


def drawings(bus: FakeBus, clock: ManualClock, names: tuple[str, ...] = DRAWN) -> Drawings:
    return Drawings(names, bus, lambda: {"runtime": {"state": "ready", "cause": ""}}, clock)


def until(what: Callable[[], Any]) -> None:
    by_s = time.monotonic() + PATIENCE_S
    while not what():
        assert time.monotonic() < by_s
        time.sleep(0.01)


def test_all_that_can_be_drawn_has_a_topic_and_a_rate():
    assert set(TOPICS) == set(DRAWN)
    assert {*EVERY_S, "diagnostics"} == {*DRAWN, "scene"}
    assert [name for name, topic in TOPICS.items() if topic.qos.latched] == ["map"]


def test_a_world_is_drawn_in_the_odometrys_frame(world: World):
    bus, clock = FakeBus(), ManualClock()
    drawer = drawings(bus, clock)
    drawer.note(world, COMMAND)
    (grid,) = bus.told("rfnav/map", 1)
    assert grid.header.frame_id == "odom_combined"
    cells = np.array(grid.data, np.int8)
    assert (cells == 0).sum() == world.map.free.sum()
    assert (cells == 100).sum() == world.map.occupied.sum()
    (path,) = bus.told("rfnav/path", 1)
    assert len(path.poses) == 2
    (frontiers,) = bus.told("rfnav/frontiers", 1)
    assert {m.id for m in frontiers.markers} == {f.id for f in world.frontiers}
    drawer.close()


def test_where_the_map_begins_far_away_all_is_drawn_there(world: World):
    """Odometry in UTM: the map is kept about where it began."""

    def drawn(origin: tuple[float, float]) -> np.ndarray:
        bus = FakeBus()
        bus.origin = origin
        drawer = drawings(bus, ManualClock())
        drawer.note(world, COMMAND)
        (grid,), (path,) = bus.told("rfnav/map", 1), bus.told("rfnav/path", 1)
        (frontiers,) = bus.told("rfnav/frontiers", 1)
        drawer.close()
        places = [grid.info.origin, *(one.pose for one in path.poses)]
        placed = [m.pose.position for m in frontiers.markers] + [p.position for p in places]
        return np.array([(p.x, p.y) for p in placed])

    moved = drawn((500_000.0, 4_000_000.0)) - drawn((0.0, 0.0))
    assert np.allclose(moved, (500_000.0, 4_000_000.0), atol=1e-6)


def test_each_is_drawn_at_its_own_rate_and_only_what_is_asked_for(world: World):
    bus, clock = FakeBus(), ManualClock()
    drawer = drawings(bus, clock, ("map", "path"))
    assert set(bus.publishers) == {"rfnav/map", "rfnav/path", "rfnav/scene"}
    drawer.note(world, COMMAND)
    drawer.note(world, COMMAND)
    bus.told("rfnav/map", 1)
    bus.told("rfnav/path", 1)
    clock.advance(EVERY_S["path"])
    drawer.note(world, None)
    paths = bus.told("rfnav/path", 2)
    assert paths[1].poses == []  # somebody else drives
    assert len(bus.publishers["rfnav/map"].put_) == 1
    drawer.close()


def test_the_scene_of_a_page_has_what_is_drawn_of_a_search_in_one(world: World):
    bus, clock = FakeBus(), ManualClock()
    bus.origin = (100.0, -50.0)
    square = ((1.0, 0.0), (2.0, 0.0), (2.0, 1.0))
    navigate.keep_out(world, (Zone("stairs", square), Zone("the area", square, area=True)))
    drawer = drawings(bus, clock, ())
    drawer.note(world, COMMAND)
    (told,) = bus.told("rfnav/scene", 1)
    scene = json.loads(told.data)
    assert scene["goal"] == "toilet"
    assert {one["id"] for one in scene["frontiers"]} == {f.id for f in world.frontiers}
    assert scene["plan"] == [[100.0, -50.0], [101.0, -50.0]]
    x_m, y_m = world.body.visited_xy[-1]
    assert scene["path"][-1] == [round(100.0 + x_m, 2), round(-50.0 + y_m, 2)]
    assert scene["area"] == [[101.0, -50.0], [102.0, -50.0], [102.0, -49.0]]
    drawer.close()


def test_a_scene_that_nobody_looks_at_is_not_made(world: World):
    bus, clock = FakeBus(), ManualClock()
    drawer = drawings(bus, clock, ("path",))
    bus.publishers["rfnav/scene"].listeners = False
    drawer.note(world, COMMAND)
    bus.told("rfnav/path", 1)
    assert bus.publishers["rfnav/scene"].put_ == []
    drawer.close()


def test_what_nobody_listens_to_is_not_drawn(world: World):
    bus, clock = FakeBus(), ManualClock()
    drawer = drawings(bus, clock, ("path", "frontiers"))
    bus.publishers["rfnav/path"].listeners = False
    drawer.note(world, COMMAND)
    bus.told("rfnav/frontiers", 1)
    assert bus.publishers["rfnav/path"].put_ == []
    drawer.close()


def test_a_frontier_that_is_gone_is_taken_away(world: World):
    bus, clock = FakeBus(), ManualClock()
    drawer = drawings(bus, clock, ("frontiers",))
    drawer.note(world, COMMAND)
    bus.told("rfnav/frontiers", 1)
    ids = [f.id for f in world.frontiers]
    world.frontiers = world.frontiers[1:]
    clock.advance(EVERY_S["frontiers"])
    drawer.note(world, COMMAND)
    later = bus.told("rfnav/frontiers", 2)[1]
    assert {m.id for m in later.markers if m.action == 2} == {ids[0]}
    drawer.close()


def test_a_zone_that_was_removed_is_taken_away(world: World):
    bus, clock = FakeBus(), ManualClock()
    drawer = drawings(bus, clock, ("zones",))
    square = ((1.0, 0.0), (2.0, 0.0), (2.0, 1.0))
    navigate.keep_out(world, (Zone("stairs", square), Zone("the area", square, area=True)))
    drawer.note(world, COMMAND)
    (told,) = bus.told("rfnav/keep_out", 1)
    lines = [m for m in told.markers if m.ns == "zones"]
    assert [m.text for m in told.markers if m.ns == "zone names"] == ["stairs", "the area"]
    assert [(p.x, p.y) for p in lines[0].points] == [*square, square[0]]
    assert lines[0].color != lines[1].color
    navigate.keep_out(world, (Zone("stairs", square),))
    clock.advance(EVERY_S["zones"])
    drawer.note(world, COMMAND)
    later = bus.told("rfnav/keep_out", 2)[1]
    assert {m.id for m in later.markers if m.action == 2} == {1}
    drawer.close()


def test_what_the_detectors_saw_is_in_the_images_frame():
    bus, clock = FakeBus(), ManualClock()
    drawer = drawings(bus, clock, ("detections",))
    drawer.seen(5, NO_DETECTIONS, ("toilet",))
    (told,) = bus.told("rfnav/detections", 1)
    assert told.header.frame_id == "lens"
    drawer.close()


def test_diagnostics_are_told_whether_or_not_there_is_a_search():
    bus, clock = FakeBus(), ManualClock()
    drawer = drawings(bus, clock, ("diagnostics",))
    clock.advance(DIAGNOSE_S)
    (told,) = bus.told("diagnostics", 1)
    assert [status.name for status in told.status] == ["rfnav: runtime", "rfnav: odom"]
    drawer.close()


def test_a_mistake_in_drawing_is_raised_where_the_world_is_noted(world: World):
    bus, clock = FakeBus(), ManualClock()
    drawer = drawings(bus, clock, ("path",))
    drawer.note(world, Command(Action.STOP, Mode.STOP, None, "", np.zeros(3)))
    until(lambda: drawer._thread._error is not None)
    with pytest.raises(IndexError):
        drawer.note(world, COMMAND)
    drawer.close()


def test_nobody_draws(world: World):
    NoDrawings().note(world, COMMAND)
    NoDrawings().seen(5, NO_DETECTIONS, ())
