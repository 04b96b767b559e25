"""While the search does not drive: who does, or why nobody."""

from typing import NamedTuple

from runtime.robot.base import BaseCondition


class Led(NamedTuple):
    """`kind`: as the journal calls it; `mode` and `reason` are told meanwhile."""

    kind: str
    who: str
    mode: str
    reason: str


def led_by(condition: BaseCondition, paused: str) -> Led | None:
    """`paused`: by whom. None where the search drives."""
    if condition.hand:
        return Led("hand", condition.hand, "hand", f"a hand has the sticks: {condition.hand}")
    if condition.held:
        return Led("held", condition.held, "wait", f"base: {condition.held}")
    return Led("paused", paused, "pause", f"paused by {paused}") if paused else None
