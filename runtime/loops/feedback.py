"""What is said of a search to whoever asked for it: on `rfnav/feedback`, at changes and every now
and then."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from types import MappingProxyType
from typing import Final, Protocol

from runtime.core.inventory import in_doubt, searched, unreached
from runtime.core.types import SearchState
from runtime.core.world import World
from runtime.loops.search import Search

NO_MORE: Final[Mapping[str, object]] = MappingProxyType({})
FEEDBACK_S = 1.0  # between messages, where nothing changes


class Listener(Protocol):
    """Who hears it."""

    def publish_feedback(self, feedback: Mapping[str, object]) -> None: ...


@dataclass
class Feedback:
    """Of one search. `began_s` and `now_s` are monotonic seconds."""

    search: Search
    began_s: float
    told_s: float = -1e9  # when something was published last
    told: tuple[object, ...] = field(default=())  # and what of it a change is worth a message
    driven_m: float = 0.0
    counted: int = 0  # poses of the track that are in it
    newest: Mapping[str, object] = field(default_factory=dict)  # that was published
    led_s: float = 0.0  # for so long somebody else drove: no time of the search

    @classmethod
    def of(cls, search: Search, began_s: float) -> "Feedback":
        """Of a search that begins now; a way that it inherits is none of its own."""
        known = len(search.world.body.visited_xy) if search.world is not None else 0
        return cls(search, began_s, counted=known)

    def elapsed_s(self, now_s: float) -> float:
        """How long the search has taken."""
        return now_s - self.began_s - self.led_s

    def facts(self, now_s: float, usd: float) -> dict[str, object]:
        """What is told of the search with its result; `usd`: what it has cost."""
        facts: dict[str, object] = {
            "elapsed_s": round(self.elapsed_s(now_s), 1),
            "driven_m": round(self.way_m(), 2),
            "usd": usd,
        }
        if self.search.world is not None:
            facts["searched"] = searched(self.search.world)
            facts["unreached"] = unreached(self.search.world)
            if self.search.config.navigate.search.last_looks == "closer":
                facts["in_doubt"] = in_doubt(self.search.world)
        return facts

    def tell(
        self,
        listener: Listener,
        state: SearchState,
        reason: str,
        now_s: float,
        always: bool = False,
        more: Mapping[str, object] = NO_MORE,
    ) -> None:
        """Publish, where something changed or it is time to; `more` with it."""
        world = self.search.world
        command = world.body.last if world else None
        told = state, command.mode if command else ""
        if not (always or now_s - self.told_s >= FEEDBACK_S or told != self.told):
            return
        self.told, self.told_s = told, now_s
        self.newest = {
            "id": self.search.order.id,
            "goal": self.search.goal.text,
            "state": state,
            "mode": told[1],
            "reason": reason,
            "pose": _pose(world),
            "toward_xy": command.toward_xy if command else None,
            "elapsed_s": round(self.elapsed_s(now_s), 3),
            "driven_m": round(self.way_m(), 3),
            "decisions": self.search.decisions,
            "vote": self.search.in_words,
            "frontiers": _left(world),
            "limits": self.search.order.limits.told(),
            **more,
        }
        listener.publish_feedback(self.newest)

    def way_m(self) -> float:
        """How far the robot has come; the track only grows, and what is new of it is added."""
        world = self.search.world
        track = world.body.visited_xy if world else []
        new = track[max(0, self.counted - 1) :]
        self.driven_m += sum(math.dist(a, b) for a, b in pairwise(new))
        self.counted = len(track)
        return self.driven_m


def _pose(world: World | None) -> list[float] | None:
    """Where the robot is, in the map."""
    if world is None:
        return None
    return [round(v, 3) for v in (world.pose.x_m, world.pose.y_m, world.pose.yaw_rad)]


def _left(world: World | None) -> int:
    """Frontiers that can still be gone to."""
    return sum(math.isfinite(f.distance_m) for f in world.frontiers) if world else 0
