"""What is left of an episode when it is over."""

import math
from dataclasses import asdict, dataclass, field
from enum import Enum
from typing import Any

from hil_sim.ground_truth.metrics import Outcome
from hil_sim.ground_truth.witness import Claim


class End(Enum):
    """What ended an episode."""

    STOP = "stop"  # the robot's own word
    STEPS = "steps"  # none left
    FELL = "fell"  # down a hole in the floor
    ERROR = "error"  # of the runtime or of the harness


@dataclass(frozen=True)
class Ended:
    """How an episode ended; `why` says what an error was, in a line. As text: "stop", "steps",
    "fell" or "error: WHY"."""

    end: End
    why: str = ""

    @property
    def failed(self) -> bool:
        """Whether nothing can be said of the robot's success."""
        return self.end is End.ERROR

    def __str__(self) -> str:
        return f"{self.end.value}: {self.why}" if self.failed else self.end.value

    @classmethod
    def parsed(cls, text: str) -> "Ended":
        """The inverse of `str`; ValueError when it is none."""
        end, _, why = text.partition(": ")
        return cls(End(end), why)


@dataclass(frozen=True)
class EpisodeResult:
    """One finished episode.

    Steps count from 1, an observation each. `seen_at`: the first at which an instance of the goal
    truly showed 200 pixels within 5 m; `seen_steps`: at how many. `believed_at`: the first at which
    the runtime went for a point within 0.5 m of an instance. `claim`: whether the place that it
    stopped for is one; `stands`: the categories of what truly stands there, () in older results.
    `frontier_m`: for each decision, the true way from the elected frontier to success, unless there
    is none. `actions`: steps by the runtime's mode; `purposes`: by what they were spent on, {} in
    older results. `stopped`: it ended standing still. `fault`: what was done to it. `wall` holds
    wall-clock seconds and nothing else does.
    """

    episode: str
    scene: str
    goal: str
    method: str
    protocol: str
    success: bool
    ended: Ended
    steps: int
    collisions: int
    decisions: int
    shortest_path_m: float
    path_m: float
    distance_m: float | None  # to success at the end; None when cut off from it
    spl: float | None  # None: too short a way to say anything
    soft_spl: float | None
    reason: str = ""  # the runtime's own, for its last action
    seen_at: int | None = None
    seen_steps: int = 0
    believed_at: int | None = None
    claim: Claim = Claim.NONE
    stands: tuple[str, ...] = ()
    frontier_m: tuple[float, ...] = ()
    actions: dict[str, int] = field(default_factory=dict)
    purposes: dict[str, int] = field(default_factory=dict)
    stopped: bool = False
    fault: str = ""
    wall: dict[str, float] = field(default_factory=dict)

    @property
    def outcome(self) -> Outcome:
        """What the metrics need."""
        left = math.inf if self.distance_m is None else self.distance_m
        return Outcome(self.success, self.shortest_path_m, self.path_m, left, self.steps)

    @classmethod
    def from_json(cls, row: dict[str, Any]) -> "EpisodeResult":
        """A row as `to_json` makes it."""
        steps, stands = tuple(row.get("frontier_m", ())), tuple(row.get("stands", ()))
        claim = Claim(row.get("claim", Claim.NONE))
        ended = Ended.parsed(row["ended"])
        told = {"ended": ended, "claim": claim, "stands": stands, "frontier_m": steps}
        return cls(**{**row, **told})

    def to_json(self) -> dict[str, Any]:
        """Plain data, in the order of the fields."""
        return {**asdict(self), "ended": str(self.ended), "claim": self.claim.value}
