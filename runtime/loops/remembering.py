"""What is known over restarts, as the loop uses it: it is written down as a search goes on, and
taken into a search when it is known where in it the robot is. Until then none of it is used."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple

from runtime.clock import Clock
from runtime.core.geometry import placed, seen_from, wrap_angle
from runtime.core.keepsake import Keepsake, forget_looks, keepsake_of, turned_onto
from runtime.core.mapping.grid import NavigationMap
from runtime.core.mapping.relocate import (
    ANYWHERE,
    SAID,
    SAID_WITHIN,
    Relief,
    Relocation,
    believed,
    knowable,
    match,
    refuted,
)
from runtime.core.mapping.settling import Settling
from runtime.core.types import Pose
from runtime.core.world import World
from runtime.errors import NotLocalisedError, SavedError
from runtime.log import say
from runtime.loops.errands import Errands
from runtime.loops.order import SearchModels
from runtime.loops.recalling import remember
from runtime.loops.search import Search
from runtime.robot.steady import STEADY_S, SteadyOdometry
from runtime.robot.wire import Stamped
from runtime.service.binding import BEGUN_HERE, ORIGIN, Binding, Bound
from runtime.service.memory_file import packed, remembered
from runtime.service.places import NamedPlaces
from runtime.service.saved import put_aside, save

MEMORY_FILE: Final = "memory.zip"
NICE: Final = 12
KEEP_S: Final = 60.0  # a crash loses no more of what was seen
LOOK_S: Final = 3.0  # between two attempts to find where it is, at least,
LOOK_REST: Final = 4.0  # and in lengths of the last one
MOVED_M, TURNED_RAD = 0.25, 0.4  # since the last attempt, to see something else
FRESH_S: Final = 1.0  # what odometry told longer ago is not where the robot is
SAME_PLACE_M, SAME_HEADING_RAD = 0.7, math.radians(20.0)  # what somebody says is no contradiction
DOUBTS: Final = 3  # after so many looks what was said is not believed any more
DOCK: Final = "dock"
LOCATE, TURN, SAVE = "locate", "turn", "save"


class _Located(NamedTuple):
    """What an attempt came to: a match, whether it settles the matter, and what it took. `epoch`:
    of what was believed when it began."""

    epoch: int
    here: Pose
    found: Relocation | None
    settled: bool
    took_s: float


class _Turned(NamedTuple):
    """What is known, on the lattice of a map's cells."""

    epoch: int
    onto: NavigationMap
    known: Keepsake


@dataclass
class HomeMemory:
    """`folder`: the state's; `keep`: whether maps outlive the process; `looks`: whose embeddings it
    has; `odometry`: the newest pose and when it arrived, monotonic; `charging`: whether the battery
    does; `others`: whether anything else is saved in that frame. The loop's thread owns it."""

    folder: Path
    keep: bool
    looks: str
    clock: Clock
    odometry: Callable[[], tuple[Stamped[Pose], float] | None]
    others: Callable[[], bool] = lambda: False
    charging: Callable[[], bool] = lambda: False
    binding: Binding = field(init=False)
    places: NamedPlaces = field(init=False)
    _known: Keepsake | None = field(init=False, default=None)
    _relief: tuple[Keepsake, Relief] | None = None  # of what is known, to be matched
    _into: NavigationMap | None = None  # the map that knows it, or of which it was made
    _now: NavigationMap | None = None  # the newest
    _spoilt: NavigationMap | None = None  # one whose odometry has jumped
    _settling: Settling = field(default_factory=Settling)
    _steady: SteadyOdometry = field(default_factory=SteadyOdometry)
    _off_s: float | None = None  # since when odometry is elsewhere
    _tried: tuple[float, Pose] = (-math.inf, ORIGIN)  # not before, and not from here
    _charged: bool = False
    _doubts: int = 0  # attempts that did not show it to be where it was said to be
    _kept_s: float = -math.inf
    _epoch: int = 0  # changes with what is believed of where it is
    _file: Path = field(init=False)
    _older: bool = False  # a map is on disk, and the frame of now is not its
    lost: str = ""  # why what is known is not on disk

    def __post_init__(self) -> None:
        self._errands, self._file = Errands(NICE), self.folder / MEMORY_FILE
        self.places = self._opened()
        self._known = self._remembered() if self.keep else None
        self.binding = Binding(self._something())
        self._older = not self.keep and not self._something() and self._file.exists()

    def _something(self) -> bool:
        """Whether anything is saved in the frame that is bound."""
        return self._known is not None or len(self.places) > 0 or self.others()

    def _opened(self) -> NamedPlaces:
        try:
            return NamedPlaces(self.folder)
        except SavedError as error:
            say(f"places: {error}")
            return NamedPlaces(self.folder)  # what could not be read was put aside

    def _remembered(self) -> Keepsake | None:
        known = remembered(self._file)
        return known if known is None or known.looks == self.looks else forget_looks(known)

    # -- the loop ------------------------------------------------------------------------------

    def turn(self) -> None:
        """Watch odometry and the dock, at every turn of the loop."""
        self._errands.take(SAVE)
        if self._older and self._something():  # places beside it would be taken for its own
            self._older = False
            say(f"{MEMORY_FILE}: of another frame than what is saved now: {put_aside(self._file)}")
        if self.binding.bound() is None and not self._something():  # all of it was removed
            self._bind(BEGUN_HERE)
        if (told := self.odometry()) is None:
            return
        now_s = told[1]
        if not self._steady.takes(told[0].value, now_s):
            self._off_s = now_s if self._off_s is None else self._off_s
        elif self._off_s is not None:
            jumped, self._off_s = now_s - self._off_s >= STEADY_S, None
            if jumped:
                self._unbind("odometry has jumped", jumped=True)
        self._watch_dock()

    def _watch_dock(self) -> None:
        """A battery that begins to charge, while it is not known where the robot is, tells that it
        is at the place called dock: as somebody would who says so."""
        here, dock = self.here(), self.places.of(DOCK)
        if here is None or dock is None or self.charging() == self._charged:
            return
        self._charged = not self._charged
        if self._charged and self.binding.bound() is None:
            self._say(Bound(placed(here, seen_from(dock, ORIGIN)), "the dock", self.clock.now_s()))

    def saw(self, search: Search, models: SearchModels) -> None:
        """A frame was surveyed: find where it is, take in what is known there, write down."""
        world = search.world
        if world is None or not self._keeps(search):
            return
        self._now = world.map
        if world.map is self._spoilt:
            return
        bound = self.binding.bound()
        if self._known is not None and world.map is not self._into:
            if bound is None or not bound.sure:
                self._locate(search, world, bound)
            else:
                self._take_in(search, world, bound, models)
        elif bound is not None and bound.sure and self.clock.now_s() - self._kept_s >= KEEP_S:
            self._write(world, bound)

    def ended(self, search: Search) -> None:
        """A search is over."""
        world, bound = search.world, self.binding.bound()
        if world is None or bound is None or not bound.sure or not self._keeps(search):
            return
        if world.map is not self._spoilt and (self._known is None or world.map is self._into):
            self._write(world, bound)

    def holds(self, world: World) -> bool:
        """Whether a world's map is of the odometry of now."""
        return world.map is not self._spoilt

    def in_words(self) -> str:
        """As it is told in `rfnav/status`."""
        return f"{self.binding.in_words()}; {self.lost}" if self.lost else self.binding.in_words()

    def place(self, name: str) -> Pose | None:
        """Where it is in the map of now; None for one that nobody has named. NotLocalisedError
        while nobody knows where the robot is."""
        transform, at = self.binding.transform(), self.places.of(name)
        if at is None:
            return None
        if transform is not None:
            return placed(transform, at)
        where = f"it is not known where the robot is ({self.binding.in_words()})"
        raise NotLocalisedError(f"place {name!r}: {where}: say where it stands (rfnav/places)")

    def here(self) -> Pose | None:
        """Where the robot is now, by its odometry; None where that is not known."""
        told = self.odometry()
        if told is None or self.clock.now_s() - told[1] > FRESH_S:
            return None
        return told[0].value

    def said_at(self, name: str, place: Pose, here: Pose) -> None:
        """Somebody says that it is at a place, in the saved frame."""
        transform = placed(here, seen_from(place, ORIGIN))
        bound, by = self.binding.bound(), f"{name!r}, where it was said to be"
        if bound is not None:
            expected = placed(bound.transform, place)
            off_m = math.hypot(expected.x_m - here.x_m, expected.y_m - here.y_m)
            if off_m <= SAME_PLACE_M and _apart_rad(expected, here) <= SAME_HEADING_RAD:
                return
            self._unbind(f"it was said to be at {name!r}")
        self._say(Bound(transform, by, self.clock.now_s()))

    def _say(self, bound: Bound) -> None:
        """What is said is checked, where there is a map to check it by."""
        self._bind(replace(bound, sure=self._known is None))

    def forget(self) -> None:
        """What is saved is put aside; the frame of now is the one that things are saved in."""
        if self.others():
            raise ValueError("zones are saved in the same frame: remove them first")
        if self._errands.busy(SAVE):  # or it would be there again
            raise ValueError("what is known is being written: ask again")
        for path in filter(Path.exists, (self._file, self.places.path)):
            put_aside(path)
        if self._into is self._now:  # what was known is in it
            self._spoilt = self._now
        self._known, self.places, self._into = None, NamedPlaces(self.folder), None
        self._bind(BEGUN_HERE)

    def close(self) -> None:
        """What waits to be written is."""
        self._errands.close()

    # -- on disk -------------------------------------------------------------------------------

    def _keeps(self, search: Search) -> bool:
        return self.keep and search.config.goal.keep_map

    def _write(self, world: World, bound: Bound) -> None:
        self._kept_s = self.clock.now_s()
        known = keepsake_of(world, seen_from(bound.transform, ORIGIN), self.looks)
        if not knowable(Relief(known.map)):
            return
        self._known, self._into = known, world.map
        self._errands.ask(SAVE, partial(self._save, self._known))

    def _save(self, known: Keepsake) -> None:
        """In the errands' thread."""
        try:
            save(self._file, packed(known))
            self.lost = ""
        except SavedError as error:
            if not self.lost:
                say(f"memory: {error}")
            self.lost = str(error)

    # -- where it is ---------------------------------------------------------------------------

    def _locate(self, search: Search, world: World, bound: Bound | None) -> None:
        result = self._errands.take(LOCATE)
        if isinstance(result, _Located):
            rests_s = max(LOOK_S, LOOK_REST * result.took_s)
            self._tried = self.clock.now_s() + rests_s, result.here
            if result.epoch == self._epoch:
                self._judge(search, result, bound)
            return
        not_before_s, was = self._tried
        if self._errands.busy(LOCATE) or self.clock.now_s() < not_before_s:
            return
        here = world.pose
        moved = math.hypot(here.x_m - was.x_m, here.y_m - was.y_m) >= MOVED_M
        if moved or _apart_rad(here, was) >= TURNED_RAD or math.isinf(not_before_s):
            seen = Relief(world.map.copied(world.map.known_window()))
            assert self._known is not None
            work = partial(self._attempt, self._known, seen, here, bound, self._epoch)
            self._errands.ask(LOCATE, work)

    def _attempt(
        self, known: Keepsake, seen: Relief, here: Pose, bound: Bound | None, epoch: int
    ) -> _Located:
        """In the errands' thread."""
        began_s = self.clock.now_s()
        if self._relief is None or self._relief[0] is not known:
            self._relief = known, Relief(known.map)
        about = None
        if bound is not None:
            about = seen_from(placed(bound.transform, known.on), here), *SAID_WITHIN
        found = match(seen, here, self._relief[1], about)
        good = found is not None and believed(found, ANYWHERE if bound is None else SAID)
        settled = good and (
            bound is not None or (found is not None and self._settling.settles(here, found.at))
        )
        return _Located(epoch, here, found, settled, self.clock.now_s() - began_s)

    def _judge(self, search: Search, result: _Located, bound: Bound | None) -> None:
        found, known = result.found, self._known
        told = found._asdict() if found is not None else {}
        search.journal.write("located", settled=result.settled, **told)
        if result.settled and found is not None and known is not None:
            there = placed(known.on, found.at)
            transform = placed(result.here, seen_from(there, ORIGIN))
            by = bound.by if bound else "the map, which is seen again"
            self._bind(Bound(transform, by, self.clock.now_s()))
        elif bound is not None:
            self._doubts += 1
            if refuted(found) or self._doubts == DOUBTS:
                self._unbind(f"what is seen is not what is known of {bound.by}")

    def _take_in(self, search: Search, world: World, bound: Bound, models: SearchModels) -> None:
        turned = self._errands.take(TURN)
        fresh = isinstance(turned, _Turned) and turned.epoch == self._epoch
        if isinstance(turned, _Turned) and fresh and turned.onto is world.map:
            remember(search, turned.known, models)
            self._into = world.map
        elif not self._errands.busy(TURN):
            known, epoch, onto = self._known, self._epoch, world.map
            assert known is not None
            at, frame = placed(bound.transform, known.on), onto.frame
            self._errands.ask(TURN, lambda: _Turned(epoch, onto, turned_onto(known, at, frame)))

    def _bind(self, bound: Bound) -> None:
        self.binding.bind(bound)
        self._changed_mind()

    def _unbind(self, why: str, jumped: bool = False) -> None:
        """The map of now is not what is remembered, or its odometry is another."""
        if jumped or self._into is self._now:
            self._spoilt = self._now
        self._into = None
        self.binding.unbind(why)
        self._changed_mind()

    def _changed_mind(self) -> None:
        self._doubts = 0
        self._settling, self._tried = Settling(), (-math.inf, ORIGIN)
        self._epoch += 1
        say(f"memory: {self.binding.in_words()}")


def _apart_rad(a: Pose, b: Pose) -> float:
    return abs(wrap_angle(a.yaw_rad - b.yaw_rad))
