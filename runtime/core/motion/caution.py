"""What the newest depth image allows of a command, before any map knows of it."""

import math
from dataclasses import dataclass

from runtime.core.motion.safety import HaltKind
from runtime.core.types import Twist


@dataclass(frozen=True)
class Caution:
    """`kind`: OBSTACLE, FLOOR or FRAME where something limits, else None; `reason`: for people.
    `most_mps`: how fast the base may go forward; backwards it may as before. `most_radps`: how
    fast it may turn, either way."""

    kind: HaltKind | None = None
    reason: str = ""
    most_mps: float = math.inf
    most_radps: float = math.inf

    def allowed(self, twist: Twist) -> Twist:
        """What is left of a command."""
        v_mps = min(twist.v_mps, self.most_mps)
        w_radps = max(-self.most_radps, min(self.most_radps, twist.w_radps))
        if v_mps == twist.v_mps and w_radps == twist.w_radps:
            return twist
        return Twist(v_mps, w_radps)


FREE = Caution()
