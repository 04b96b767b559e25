"""What was known before a restart is used when it is known where that is, and not before."""

import math
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from apartment import TWO_ROOMS, Apartment
from fake_models import FakeModels
from floor_plan import OTHER_ROOMS, ROOMS, Box, survey
from lived_in import EMBEDDING
from manual_clock import ManualClock

from runtime.config import load
from runtime.core.geometry import placed, seen_from
from runtime.core.mapping import relocate
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.types import Pose
from runtime.core.world import World
from runtime.journal import read_journal
from runtime.loops import remembering
from runtime.loops.goal_request import Terms
from runtime.loops.order import understand
from runtime.loops.remembering import DOUBTS, KEEP_S, MEMORY_FILE, HomeMemory
from runtime.loops.search import Search
from runtime.robot.wire import Stamped
from runtime.service.binding import ORIGIN
from runtime.service.places import PLACES_FILE

WHOLE, LEFT = (0.0, 0.0, 9.0, 7.0), (0.0, 0.0, 4.5, 7.0)
FIRST, SECOND = Pose(2.0, 2.8, 0.3), Pose(3.2, 4.4, -2.0)  # where odometry began, in the home
MUG_XY = (7.0, 2.0)  # in the right room
TRIES = 3000


class Reminded(FakeModels):
    """What was seen before is what it was called."""

    def likeness(self, embeddings: np.ndarray) -> np.ndarray:
        return np.ones((len(embeddings), 1))


ROBOTS: list["Robot"] = []


@pytest.fixture(autouse=True)
def closed(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """What a test leaves open. A coarser search does for rooms that are drawn."""
    monkeypatch.setattr(relocate, "HEADINGS", 72)
    monkeypatch.setattr(relocate, "FINE", 4)
    monkeypatch.setattr(relocate, "SAMPLED", 200)
    yield
    while ROBOTS:
        robot = ROBOTS.pop()
        robot.memory.close()
        for search in robot.searches:
            search.journal.close()


class Robot:
    """A process: its memory, and a search whose map a test draws."""

    def __init__(
        self, folder: Path, start: Pose, boxes: tuple[Box, ...] = ROOMS, keep: bool = True
    ):
        self.clock, self.start, self.boxes = ManualClock(1000.0), start, boxes
        self.told: tuple[Pose, float] | None = (Pose(0.0, 0.0, 0.0), 1000.0)
        eyes = ", ".join(load(None).models.detectors)
        self.zones = self.charges = False
        self.memory = HomeMemory(
            folder, keep, eyes, self.clock,
            lambda: (Stamped(0, self.told[0]), self.told[1]) if self.told else None,
            lambda: self.zones,
            lambda: self.charges,
        )  # fmt: skip
        self.models, self.folder = Reminded(Apartment.of(TWO_ROOMS, FIRST)), folder
        self.searches: list[Search] = []
        ROBOTS.append(self)
        self.search = self.begin()

    def begin(self, settings: tuple[str, ...] = ("goal.keep_map=true",)) -> Search:
        log = self.folder / f"log-{self.clock.now_s():.0f}"
        body = {"goal": "mug", "log_dir": str(log)}

        def configure(more: tuple[str, ...]):
            return load(None, (*settings, *more))

        search = Search.begin(understand(body, self.models, configure, Terms(harness=True)))
        self.searches.append(search)
        search.world = World.begin("mug", ("mug",), ("hall",), Pose(0.0, 0.0, 0.0), 0.18)
        return search

    @property
    def world(self) -> World:
        assert self.search.world is not None
        return self.search.world

    def sees(self, part: Box, at: Pose) -> None:
        """The part of the home, and that it is somewhere in its own frame."""
        survey(self.world, self.boxes, part, self.start)
        self.world.pose = at
        self.told = at, self.clock.now_s()

    def until(self, what: Callable[[], bool]) -> None:
        """Frame by frame, the clock going on."""
        pause = threading.Event()
        for _ in range(TRIES):
            self.memory.turn()
            self.memory.saw(self.search, self.models)
            if what():
                return
            self.clock.advance(0.5)
            pause.wait(0.005)
        raise AssertionError(self.memory.in_words())

    def looks(self, times: int = 1) -> list[dict]:
        """After so many attempts more to find where it is: all of them."""
        had = len(self.located())
        self.until(lambda: len(self.located()) >= had + times)
        return self.located()

    def located(self) -> list[dict]:
        path = self.search.journal.path
        return [line for line in read_journal(path) if line["kind"] == "located"]

    def own(self, x: float, y: float) -> tuple[int, int]:
        """The cell of a place of the home."""
        there = seen_from(self.start, Pose(x, y, 0.0))
        return self.world.map.frame.cell(there.x_m, there.y_m)

    def words(self) -> str:
        return self.memory.in_words()


def first(folder: Path, dock: Pose | None = None) -> Robot:
    """It has seen the whole home, with a mug in its right room, and knows a desk; it has ended."""
    robot = Robot(folder, FIRST)
    robot.sees(WHOLE, Pose(0.5, 0.0, 0.0))
    there = seen_from(FIRST, Pose(*MUG_XY, 0.0))
    cells = robot.world.map.frame.centres(
        np.array([robot.world.map.frame.cell(there.x_m, there.y_m)], np.int32)
    )
    mug = Instance(1, {"mug": Evidence(4.0)}, (there.x_m, there.y_m), 0.5, cells, 0.4, 0.6,
                   EMBEDDING, 0.9, 1.0)  # fmt: skip
    robot.world.semantic.instances[1] = mug
    robot.memory.places.put("desk", seen_from(FIRST, Pose(1.0, 3.5, 1.0)))
    if dock is not None:
        robot.memory.places.put("dock", seen_from(FIRST, dock))
    robot.memory.saw(robot.search, robot.models)
    robot.memory.ended(robot.search)
    robot.memory.close()
    return robot


def bound(folder: Path) -> Robot:
    """Begun anew elsewhere, and bound by what it sees."""
    robot = Robot(folder, SECOND)
    robot.sees(LEFT, Pose(0.0, 0.0, 0.0))
    assert not robot.looks()[-1]["settled"]
    robot.sees(LEFT, Pose(1.2, 0.0, 0.4))
    robot.until(lambda: "bound by the map" in robot.words())
    return robot


def test_the_first_of_all_begins_here_and_leaves_what_it_saw(tmp_path: Path):
    robot = first(tmp_path)
    assert robot.words() == "none: it begins here"
    assert (tmp_path / MEMORY_FILE).is_file()


def test_after_a_restart_elsewhere_all_is_where_it_was(tmp_path: Path):
    first(tmp_path)
    robot = bound(tmp_path)
    robot.until(lambda: bool(robot.world.semantic.instances))
    assert robot.world.map.free[robot.own(7.0, 2.2)]  # the other room
    (mug,) = robot.world.semantic.instances.values()
    true = seen_from(SECOND, Pose(*MUG_XY, 0.0))
    assert math.dist(mug.xy, (true.x_m, true.y_m)) < 0.15
    assert mug.evidence["mug"].odds > 0.8  # worth going there, not more
    transform, desk = robot.memory.binding.transform(), robot.memory.places.of("desk")
    assert transform is not None
    assert desk is not None
    there, true = placed(transform, desk), seen_from(SECOND, Pose(1.0, 3.5, 1.0))
    assert math.dist((there.x_m, there.y_m), (true.x_m, true.y_m)) < 0.15
    (told,) = [x for x in read_journal(robot.search.journal.path) if x["kind"] == "memory"]
    assert told["objects"] == 1
    assert told["goal"][0]["xy"] == list(mug.xy)


def test_until_then_nothing_of_it_is_used_nor_written_over(tmp_path: Path):
    first(tmp_path)
    before = (tmp_path / MEMORY_FILE).read_bytes()
    robot = Robot(tmp_path, SECOND)
    robot.sees(LEFT, Pose(0.0, 0.0, 0.0))
    for _ in range(3):  # as often as it looks from the same place
        robot.looks()
        robot.world.pose = Pose(0.0, 0.0, robot.world.pose.yaw_rad + 0.5)
    assert robot.words().startswith("unbound: ")
    assert robot.memory.binding.transform() is None
    assert not robot.world.map.free[robot.own(7.0, 2.2)]
    robot.memory.ended(robot.search)
    robot.memory.close()
    assert (tmp_path / MEMORY_FILE).read_bytes() == before


def test_what_is_remembered_was_seen_by_an_earlier_search(tmp_path: Path):
    """Where the goal was said to be near it, it is looked at again."""
    first(tmp_path)
    robot = bound(tmp_path)
    robot.until(lambda: bool(robot.world.semantic.instances))
    assert robot.world.explored.hint.before == frozenset(robot.world.semantic.instances)


def test_in_another_home_nothing_is_ever_used(tmp_path: Path):
    first(tmp_path)
    robot = Robot(tmp_path, Pose(3.0, 2.5, 1.0), OTHER_ROOMS)
    for n in range(4):
        robot.sees((0.0, 0.0, 7.0, 4.0 + n), Pose(0.5 * n, 0.0, 0.0))
        robot.looks()
    assert robot.words().startswith("unbound: ")
    assert not robot.world.semantic.instances


def test_a_second_goal_of_the_same_process_knows_it_too_and_what_was_added(tmp_path: Path):
    first(tmp_path)
    robot = bound(tmp_path)
    robot.until(lambda: bool(robot.world.semantic.instances))
    robot.world.map.evidence[robot.own(8.0, 6.0)] = 20  # something new
    robot.world.map.changed()
    robot.memory.ended(robot.search)
    robot.clock.advance(5.0)
    robot.search = robot.begin()
    robot.sees((3.0, 4.0, 4.0, 5.0), Pose(0.0, 0.0, 0.0))
    robot.until(lambda: bool(robot.world.semantic.instances))
    assert robot.world.map.occupied[robot.own(8.0, 6.0)]
    robot.memory.close()


def test_what_a_restart_has_added_is_there_after_the_next(tmp_path: Path):
    first(tmp_path)
    robot = bound(tmp_path)
    robot.until(lambda: bool(robot.world.semantic.instances))
    robot.memory.places.put("sill", seen_from(robot.memory.binding.transform(), ORIGIN))
    robot.memory.ended(robot.search)
    robot.memory.close()
    again = bound(tmp_path)
    again.until(lambda: bool(again.world.semantic.instances))
    transform, sill = again.memory.binding.transform(), again.memory.places.of("sill")
    assert transform is not None
    assert sill is not None
    there = placed(transform, sill)
    assert math.hypot(there.x_m, there.y_m) < 0.15  # where the second began, and so does this


def test_a_map_that_could_never_be_known_again_is_not_kept(tmp_path: Path):
    robot = Robot(tmp_path, FIRST)
    robot.sees((1.0, 3.0, 4.0, 4.6), Pose(0.0, 0.0, 0.0))
    robot.memory.saw(robot.search, robot.models)
    robot.memory.ended(robot.search)
    robot.sees(LEFT, Pose(0.0, 0.0, 0.0))
    robot.until((tmp_path / MEMORY_FILE).is_file)


def test_every_so_often_it_is_written_down(tmp_path: Path):
    robot = Robot(tmp_path, FIRST)
    robot.sees(LEFT, Pose(0.0, 0.0, 0.0))
    robot.until((tmp_path / MEMORY_FILE).is_file)
    robot.memory._errands.take("save")
    (tmp_path / MEMORY_FILE).unlink()
    robot.memory.saw(robot.search, robot.models)
    robot.clock.advance(KEEP_S)
    robot.until((tmp_path / MEMORY_FILE).is_file)
    robot.memory.close()


def test_who_says_where_it_is_is_believed_and_then_checked(tmp_path: Path):
    first(tmp_path)
    robot = Robot(tmp_path, SECOND)
    desk, off = robot.memory.places.of("desk"), Pose(0.4, 0.2, 0.15)
    assert desk is not None
    here = placed(seen_from(SECOND, Pose(1.0, 3.5, 1.0)), off)
    robot.memory.said_at("desk", desk, here)
    assert robot.words() == "bound by 'desk', where it was said to be, not seen yet"
    robot.sees(LEFT, here)
    robot.until(lambda: robot.words() == "bound by 'desk', where it was said to be")
    transform = robot.memory.binding.transform()
    assert transform is not None
    there, true = placed(transform, desk), seen_from(SECOND, Pose(1.0, 3.5, 1.0))
    assert math.dist((there.x_m, there.y_m), (true.x_m, true.y_m)) < 0.12  # set right
    robot.until(lambda: bool(robot.world.semantic.instances))


def test_at_the_dock_it_knows_where_it_is_once_it_charges(tmp_path: Path):
    at = Pose(1.0, 3.5, 1.0)
    robot = first(tmp_path, dock=at)
    robot.memory.turn()
    robot.charges = True
    robot.memory.turn()
    assert robot.words() == "none: it begins here"  # and knows it without
    robot = Robot(tmp_path, SECOND)
    here = seen_from(SECOND, at)
    robot.told = None
    robot.charges = True
    robot.memory.turn()
    assert robot.words().startswith("unbound: ")  # it has no odometry yet
    robot.told = here, robot.clock.now_s()
    robot.memory.turn()
    assert robot.words() == "bound by the dock, not seen yet"
    robot.sees(LEFT, here)
    robot.until(lambda: robot.words() == "bound by the dock")


def test_who_charges_elsewhere_is_not_at_the_dock_for_long(tmp_path: Path):
    first(tmp_path, dock=Pose(7.0, 6.0, -1.0))
    robot = Robot(tmp_path, SECOND)
    robot.charges = True
    robot.memory.turn()
    assert robot.words() == "bound by the dock, not seen yet"
    robot.sees(LEFT, Pose(0.0, 0.0, 0.0))
    robot.until(lambda: robot.words().startswith("unbound: what is seen is not what is known"))
    robot.memory.turn()
    assert robot.words().startswith("unbound: ")  # it does not say so again and again


def test_who_says_so_wrongly_is_not_believed_for_long(tmp_path: Path):
    first(tmp_path)
    robot = Robot(tmp_path, Pose(2.0, 6.0, 0.4), OTHER_ROOMS)
    desk = robot.memory.places.of("desk")
    assert desk is not None
    robot.memory.said_at("desk", desk, Pose(0.0, 0.0, 0.0))
    robot.sees((0.0, 4.1, 7.0, 8.5), Pose(0.0, 0.0, 0.0))
    robot.until(lambda: robot.words().startswith("unbound: what is seen is not what is known"))
    assert not robot.world.semantic.instances


def test_what_is_said_and_never_shows_is_not_believed_for_long(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    first(tmp_path)
    neither = relocate.Relocation(ORIGIN, 0.8, 0.8, 20.0, 0.5)
    monkeypatch.setattr("runtime.loops.remembering.match", lambda *_: neither)
    robot = Robot(tmp_path, SECOND)
    desk = robot.memory.places.of("desk")
    assert desk is not None
    robot.memory.said_at("desk", desk, ORIGIN)
    for n in range(DOUBTS):
        assert robot.words().endswith("not seen yet")
        robot.sees(LEFT, Pose(0.4 * n, 0.0, 0.0))
        robot.looks()
    assert robot.words().startswith("unbound: what is seen is not what is known of 'desk'")


def test_saying_again_what_is_known_changes_nothing_and_something_else_does(tmp_path: Path):
    first(tmp_path)
    robot = bound(tmp_path)
    before, desk = robot.memory.binding.bound(), robot.memory.places.of("desk")
    assert before is not None
    assert desk is not None
    there = placed(before.transform, desk)
    robot.memory.said_at("desk", desk, Pose(there.x_m + 0.3, there.y_m, there.yaw_rad))
    assert robot.memory.binding.bound() is before
    robot.until(lambda: bool(robot.world.semantic.instances))
    robot.memory.said_at("desk", desk, Pose(there.x_m + 2.0, there.y_m, there.yaw_rad))
    assert robot.words().endswith("not seen yet")
    assert not robot.memory.holds(robot.world)  # what was taken into it was in the wrong place


def test_an_odometry_that_jumps_is_another(tmp_path: Path):
    first(tmp_path)
    robot = bound(tmp_path)
    assert robot.memory.holds(robot.world)
    for n in range(8):
        robot.told = Pose(50.0 + 0.01 * n, 0.0, 0.0), robot.clock.now_s()
        robot.memory.turn()
        robot.clock.advance(0.25)
    assert robot.words() == "unbound: odometry has jumped"
    assert not robot.memory.holds(robot.world)
    robot.memory.saw(robot.search, robot.models)
    robot.memory.ended(robot.search)
    assert robot.memory.binding.bound() is None


def test_a_single_wild_message_is_no_jump(tmp_path: Path):
    robot = Robot(tmp_path, FIRST)
    for x in (0.0, 50.0, 0.0):
        robot.told = Pose(x, 0.0, 0.0), robot.clock.now_s()
        robot.memory.turn()
        robot.clock.advance(0.1)
    robot.told = None
    robot.memory.turn()
    assert robot.words() == "none: it begins here"


def test_where_it_is_is_not_known_of_old_odometry(tmp_path: Path):
    robot = Robot(tmp_path, FIRST)
    assert robot.memory.here() == Pose(0.0, 0.0, 0.0)
    robot.clock.advance(1.5)
    assert robot.memory.here() is None
    robot.told = None
    assert robot.memory.here() is None


@pytest.mark.parametrize("keep", [False, True])
def test_who_does_not_want_it_has_nothing_kept(tmp_path: Path, keep: bool):
    robot = Robot(tmp_path, FIRST, keep=keep)
    robot.search = robot.begin(() if keep else ("goal.keep_map=true",))
    robot.sees(LEFT, Pose(0.0, 0.0, 0.0))
    robot.memory.saw(robot.search, robot.models)
    robot.memory.ended(robot.search)
    robot.search.world = None
    robot.memory.saw(robot.search, robot.models)
    robot.memory.ended(robot.search)
    robot.memory.close()
    assert not (tmp_path / MEMORY_FILE).exists()


def test_forgetting_puts_aside_and_begins_here(tmp_path: Path):
    first(tmp_path)
    robot = Robot(tmp_path, SECOND)
    robot.zones = True
    with pytest.raises(ValueError, match="remove them first"):
        robot.memory.forget()
    robot.zones = False
    robot.memory.forget()
    robot.memory.forget()  # nothing is there any more
    assert robot.words() == "none: it begins here"
    assert len(robot.memory.places) == 0
    assert (tmp_path / f"{MEMORY_FILE}.aside-1").is_file()
    assert (tmp_path / f"{PLACES_FILE}.aside-1").is_file()


def test_what_was_taken_in_before_it_was_forgotten_is_not_written_again(tmp_path: Path):
    first(tmp_path)
    robot = bound(tmp_path)
    robot.until(lambda: bool(robot.world.semantic.instances))
    robot.until(lambda: not robot.memory._errands.busy(remembering.SAVE))
    robot.memory.forget()
    assert not robot.memory.holds(robot.world)
    robot.memory.saw(robot.search, robot.models)
    robot.memory.ended(robot.search)
    robot.memory.close()
    assert not (tmp_path / MEMORY_FILE).exists()


def test_what_is_being_written_is_not_forgotten_and_there_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    may_end, writes = threading.Event(), remembering.save

    def slow(path: Path, raw: bytes) -> None:
        may_end.wait(20.0)
        writes(path, raw)

    monkeypatch.setattr(remembering, "save", slow)
    robot = Robot(tmp_path, FIRST)
    robot.sees(WHOLE, Pose(0.5, 0.0, 0.0))
    robot.memory.saw(robot.search, robot.models)
    with pytest.raises(ValueError, match="ask again"):
        robot.memory.forget()
    may_end.set()
    robot.until(lambda: not robot.memory._errands.busy(remembering.SAVE))
    assert (tmp_path / MEMORY_FILE).is_file()
    robot.memory.forget()
    robot.memory.close()
    assert not (tmp_path / MEMORY_FILE).exists()


def test_once_all_that_was_saved_is_removed_it_begins_here(tmp_path: Path):
    first(tmp_path)
    (tmp_path / MEMORY_FILE).unlink()
    robot = Robot(tmp_path, SECOND)
    robot.memory.turn()
    assert robot.words().startswith("unbound: ")  # the desk is in another frame
    assert robot.memory.places.remove("desk")
    robot.zones = True
    robot.memory.turn()
    assert robot.words().startswith("unbound: ")  # and so are zones
    robot.zones = False
    robot.memory.turn()
    assert robot.words() == "none: it begins here"


def test_what_cannot_be_read_is_told_and_put_aside(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    for name in (MEMORY_FILE, PLACES_FILE):
        (tmp_path / name).write_bytes(b"spoilt")
    robot = Robot(tmp_path, FIRST)
    said = capsys.readouterr().err
    assert f"put aside as {MEMORY_FILE}.aside-1" in said
    assert f"put aside as {PLACES_FILE}.aside-1" in said
    assert robot.words() == "none: it begins here"


def test_what_cannot_even_be_read_is_not_written_over(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    (tmp_path / MEMORY_FILE).mkdir()
    first(tmp_path)
    assert "cannot be read" in capsys.readouterr().err
    assert (tmp_path / f"{MEMORY_FILE}.aside-1").is_dir()
    assert (tmp_path / MEMORY_FILE).is_file()


def test_embeddings_of_other_models_are_not_compared(tmp_path: Path):
    first(tmp_path)
    memory = HomeMemory(tmp_path, True, "other eyes", ManualClock(), lambda: None)
    assert memory._known is not None
    assert memory._known.instances[0].embedding.size == 0
    memory.close()


def test_a_disk_that_takes_nothing_is_told_of_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    robot = Robot(tmp_path, FIRST)
    robot.sees(LEFT, Pose(0.0, 0.0, 0.0))
    robot.memory._file = tmp_path / "file" / "below" / MEMORY_FILE
    (tmp_path / "file").touch()
    robot.until(lambda: "cannot be written" in robot.words())
    robot.memory.ended(robot.search)
    robot.memory.close()
    assert capsys.readouterr().err.count("cannot be written") == 1


def test_a_map_that_is_not_used_is_put_aside_before_places_are_saved_in_another_frame(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    first = Robot(tmp_path, FIRST)
    first.sees(WHOLE, Pose(1.0, 0.0, 0.0))
    first.memory.ended(first.search)
    first.memory.close()
    kept = (tmp_path / MEMORY_FILE).read_bytes()
    second = Robot(tmp_path, SECOND, keep=False)
    second.memory.turn()
    assert (tmp_path / MEMORY_FILE).read_bytes() == kept
    second.memory.places.put("sofa", ORIGIN)
    second.memory.turn()
    assert not (tmp_path / MEMORY_FILE).exists()
    assert (tmp_path / f"{MEMORY_FILE}.aside-1").read_bytes() == kept
    assert f"{MEMORY_FILE}: of another frame than what is saved now" in capsys.readouterr().err


def test_a_map_that_is_not_used_stays_beside_the_places_of_its_frame(tmp_path: Path):
    first = Robot(tmp_path, FIRST)
    first.sees(WHOLE, Pose(1.0, 0.0, 0.0))
    first.memory.places.put("sofa", ORIGIN)
    first.memory.ended(first.search)
    first.memory.close()
    second = Robot(tmp_path, SECOND, keep=False)
    second.memory.turn()
    assert (tmp_path / MEMORY_FILE).exists()
