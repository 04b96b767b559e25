"""How a search ends, and the way that the robot has to go before that is said."""

from dataclasses import dataclass, replace

from runtime import navigate
from runtime.core.destination import Destination
from runtime.core.types import SearchState
from runtime.core.world import Command, World
from runtime.loops.search import Search
from runtime.service.outcomes import FailCause, GoalEnd


@dataclass
class Leaving:
    """Of one search. `returns_low`: it goes back where the battery is low. `end`: how it ends once
    the robot is where it is to go then; None while it goes on."""

    search: Search
    returns_low: bool
    end: GoalEnd | None = None

    def ends(self, end: GoalEnd) -> GoalEnd | None:
        """The end, or None where the robot is to go back to where it began, or elsewhere, first."""
        search, to = self.search, self._to(end)
        wished = search.order.returns or to is not None
        if end.cause is FailCause.BATTERY:
            wished = self.returns_low
        astray = end.state is SearchState.AREA_LEFT or end.cause is FailCause.NOT_LOCALISED
        if not wished or search.start_xy is None or astray:
            return end
        self.end = end
        search.whereabouts.lets_out(to.xy if to is not None else search.start_xy)
        search.journal.write("return", then=end.state, reason=end.reason)
        return None

    def act(self, world: World) -> Command:
        """What to do now: search on, or go where it is to go."""
        cfg, start_xy = self.search.config.navigate, self.search.start_xy
        if self.end is None or start_xy is None:
            return self.search.act(world)
        if (to := self._to(self.end)) is not None:
            return navigate.go_to(world, to, cfg)
        return navigate.go_back(world, self.end.reason, start_xy, cfg)

    def concluded(self, command: Command, ended: SearchState) -> GoalEnd | None:
        """What a command that ends the search, or the way after it, makes of the goal."""
        if self.end is None:
            return self.ends(GoalEnd(ended, command.reason, at_xy=command.toward_xy))
        reason = command.reason  # of a way back it says both
        if self._to(self.end) is not None:
            reason = f"{self.end.reason}; {reason}"
        return self._stays(self.end, reason, ended is SearchState.ARRIVED)

    def lost(self) -> GoalEnd | None:
        """How it ends on its way, where nobody knows any more where it must not go."""
        lost = self.search.whereabouts.lost(self.search.record)
        if lost is None or self.end is None:
            return None
        return self._stays(self.end, f"{self.end.reason}; {lost.reason}", there=False)

    def _stays(self, end: GoalEnd, reason: str, there: bool) -> GoalEnd:
        """`there`: where it was to go."""
        to = self._to(end)
        return replace(end, reason=reason, returned=there, returned_to=to.name if to else "")

    def _to(self, end: GoalEnd) -> Destination | None:
        """Where to after such an end; None: back, if anywhere."""
        return (
            self.search.whereabouts.bounds.then_to if end.cause is not FailCause.BATTERY else None
        )
