"""Where a search may be: what it is kept out of, as people draw it while it goes on; the area that
it is bound to, and the place that it goes to."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, Protocol

from runtime import navigate
from runtime.core.destination import into, is_within, left_area
from runtime.core.mapping.zones import Zone
from runtime.core.motion.courses import Spin
from runtime.core.resorts import Resort
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action, SearchState
from runtime.core.world import Command, Mode, World
from runtime.errors import ConfigError
from runtime.journal import Journal
from runtime.record import Record
from runtime.service.bounds import ANYWHERE, GoalBounds, names_place
from runtime.service.outcomes import FailCause, GoalEnd

WITHIN_M: Final = 0.5  # a place that is farther within an area is gone to without leaving it


class ZoneKeeper(Protocol):
    """Who knows of the zones that people draw; see `service/zones.py` `Zones`."""

    def now(self) -> tuple[Zone, ...]:
        """As they are, in the map frame."""

    def unbound(self) -> str:
        """Why no goal can be taken; "" where one can."""

    def bounds(self, body: Mapping[str, Any], rooms: Sequence[str]) -> GoalBounds:
        """Where a goal binds the robot to, of those types of rooms; ConfigError."""

    def moved(
        self, before: GoalBounds, body: Mapping[str, Any], rooms: Sequence[str]
    ) -> GoalBounds:
        """The same again, where the saved map may lie elsewhere than `before`; ConfigError."""


class NoZones:
    """Nobody draws any."""

    def now(self) -> tuple[Zone, ...]:
        return ()

    def unbound(self) -> str:
        return ""

    def bounds(self, body: Mapping[str, Any], rooms: Sequence[str]) -> GoalBounds:
        return ANYWHERE

    def moved(
        self, before: GoalBounds, body: Mapping[str, Any], rooms: Sequence[str]
    ) -> GoalBounds:
        return before


@dataclass
class Whereabouts:
    """A search's. One thread's, which owns the world. `bounds`: as the keeper makes them of
    `binds`; `entered`: the robot was in the area; `drawn`: the zones that were on the map last;
    `astray`: why nobody knows where it is to go."""

    keeper: ZoneKeeper = field(default_factory=NoZones)
    bounds: GoalBounds = ANYWHERE
    binds: Mapping[str, Any] = field(default_factory=dict)
    rooms: Sequence[str] = ()
    astray: str = ""
    entered: bool = False
    drawn: tuple[Zone, ...] = ()

    @property
    def searching(self) -> bool:
        """Whether the robot looks for something: it goes to no place, and is where it may look."""
        return self.bounds.to is None and (self.bounds.area is None or self.entered)

    def lost(self, record: Record) -> GoalEnd | None:
        """How a search ends by now where it is not known any more where zones, or the places that
        it is bound to, lie."""
        why = self.keeper.unbound() or self.astray
        if not why:
            return None
        record("heard", {"name": "lost", "value": why})
        return GoalEnd(SearchState.FAILED, why, FailCause.NOT_LOCALISED)

    def lets_out(self, xy: tuple[float, float]) -> None:
        """The search is over, and the robot goes there: not even out of its area is it kept."""
        area = self.bounds.area
        if area is not None and area.outside_m(xy) > -WITHIN_M:
            self.bounds = replace(self.bounds, area=None)

    def keep(self, world: World, journal: Journal, record: Record) -> None:
        """Have on the map what is kept out of now; what was, while nobody knows where that lies."""
        self._follow(journal, record)
        area, lost = self.bounds.area, bool(self.keeper.unbound())
        drawn = self.drawn if lost else self.keeper.now()
        if drawn != self.drawn:
            self.drawn = drawn
            record("heard", {"name": "zones", "value": drawn})
            journal.write("zones", zones=drawn)
        world.explored.only_room = self.bounds.room
        navigate.keep_out(world, (*drawn, area) if area is not None and self.entered else drawn)

    def _follow(self, journal: Journal, record: Record) -> None:
        """Places lie on the saved map, wherever that is found to lie by now."""
        if not names_place(self.binds):
            return
        try:
            bounds, self.astray = self.keeper.moved(self.bounds, self.binds, self.rooms), ""
        except ConfigError as error:
            self.astray = str(error)
            return
        if self.bounds.area is None:
            bounds = replace(bounds, area=None)  # it was let out
        if bounds != self.bounds:
            self.bounds = bounds
            record("heard", {"name": "moved", "value": bounds})
            journal.write("bounds", **vars(bounds))

    def act(self, world: World, cfg: NavigateConfig) -> Command:
        """What to do now."""
        area, to = self.bounds.area, self.bounds.to
        if area is not None and self.entered and (left := left_area(world, area)) is not None:
            return left
        if area is not None and not self.entered:
            if not is_within(world, area, cfg):
                return navigate.go_to(world, into(area), cfg)
            self.entered = True  # its outside is on the map from the next frame on
            world.explored.resort = Resort.NONE  # what was tried to get there is none of it
            course = Spin(cfg.control.look_radps)
            return Command(Action.TURN_LEFT, Mode.LOOK, None, f"in {area.name}", course=course)
        return navigate.go_to(world, to, cfg) if to is not None else navigate.act(world, cfg)
