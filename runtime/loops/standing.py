"""How the runtime stands, for people and whoever watches it: one word, and what it is due to."""

import math
import re
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import numpy as np

from runtime.core.motion.caution import Caution
from runtime.core.motion.safety import Halt, HaltKind, Odometry
from runtime.core.types import SearchState, Twist
from runtime.robot.base import BaseCondition

KEPT: Final = 256  # changes that nobody has asked for yet
FALLEN_BACK: Final = ("embedding", "counts alone", "none")  # rungs where no language model votes


class RunState(StrEnum):
    """From what matters most to a person beside the robot down to what matters least."""

    FAULT = "fault"  # it ends, by a mistake of its own
    STOPPED = "stopped"  # by hand, until that is released
    PAUSED = "paused"  # a hand has the sticks, or somebody asked for it
    HELD = "held"  # a search wants to drive, and must not
    DEGRADED = "degraded"  # it searches, with less than it was given
    SEARCHING = "searching"
    STARTING = "starting"  # models load
    READY = "ready"  # for a goal


@dataclass(frozen=True)
class RunStanding:
    """`cause`: what of; "" where the state says all."""

    state: RunState
    cause: str = ""

    def in_words(self) -> str:
        return f"{self.state}: {self.cause}" if self.cause else str(self.state)


@dataclass(frozen=True)
class Change:
    """From one standing to another, at a monotonic second."""

    now_s: float
    before: RunStanding
    after: RunStanding


def stands(
    fault: str,
    stopped: Halt | None,
    base: BaseCondition,
    halt: Halt | None,
    state: SearchState,
    report: Mapping[str, object],
    started: bool,
    unguarded: str = "",
) -> RunStanding:
    """`stopped`: a stop that is not released; `halt`: why the base is held; `report`: of the
    search; `unguarded`: why nobody watches the control loop."""
    if fault:
        return RunStanding(RunState.FAULT, fault)
    if stopped is not None:
        return RunStanding(RunState.STOPPED, stopped.reason)
    if base.hand:
        return RunStanding(RunState.PAUSED, f"a hand has the sticks: {base.hand}")
    if state is not SearchState.SEARCHING:
        return RunStanding(RunState.READY if started else RunState.STARTING)
    if paused := report.get("paused"):
        return RunStanding(RunState.PAUSED, str(paused))
    if halt is not None:
        return RunStanding(RunState.HELD, f"{halt.kind}: {halt.reason}")
    lacks = ", ".join(part for part in (_lacks(report), unguarded) if part)
    return RunStanding(RunState.DEGRADED, lacks) if lacks else RunStanding(RunState.SEARCHING)


def _lacks(report: Mapping[str, object]) -> str:
    rung, told = report.get("rung"), []
    if rung in FALLEN_BACK:
        told.append(f"rung: {rung}")
    if shed := report.get("shed"):
        told.append(str(shed))
    if unstamped := report.get("unstamped"):
        assert isinstance(unstamped, tuple)
        told.append(f"stamps stand still: {', '.join(unstamped)}")
    return ", ".join(told)


def told_state(
    state: SearchState,
    standing: RunStanding,
    halt: Halt | None,
    twist: Twist,
    odometry: Odometry | None,
    base: BaseCondition,
    caution: Caution,
) -> dict[str, object]:
    """What `rfnav/state` has beside the search's report. `twist`: sent to the base last."""
    pose = odometry.pose if odometry else None
    at = [round(v, 4) for v in (pose.x_m, pose.y_m, pose.yaw_rad)] if pose else None
    return {
        "state": state,
        "runtime": vars(standing),
        "halt": halt.reason if halt else "",
        "v_mps": round(twist.v_mps, 4),
        "w_radps": round(twist.w_radps, 4),
        "pose": at,
        "odom_stamp_ns": odometry.stamp_ns if odometry else None,
        "base": vars(base),
        "caution": _told_caution(caution),
    }


def _told_caution(caution: Caution) -> dict[str, object] | None:
    if caution.kind is None:
        return None
    most = caution.most_mps if math.isfinite(caution.most_mps) else None
    return {"kind": caution.kind, "reason": caution.reason, "most_mps": most}


def late_told(late_s: Sequence[float]) -> dict[str, object]:
    """How late turns of control were: {"tick_late_ms": ...}, without any {}."""
    if not late_s:
        return {}
    late_ms = np.array(late_s) * 1e3
    p50, p99 = np.percentile(late_ms, [50, 99])
    told = {"p50": round(float(p50), 2), "p99": round(float(p99), 2)}
    return {"tick_late_ms": {**told, "max": round(float(late_ms.max()), 2), "ticks": len(late_s)}}


def forbids(base: BaseCondition) -> Halt | None:
    """What the base says, as a reason not to drive."""
    if base.hand:
        return Halt(HaltKind.HAND, f"a hand has the sticks: {base.hand}")
    return Halt(HaltKind.BASE, f"base: {base.held}") if base.held else None


class Occasion:
    """When the state is told again: at once where something of it is another, else every so many
    turns."""

    def __init__(self, turns: float) -> None:
        self._turns, self._silent = turns, 0
        self._told: tuple[object, ...] = ()

    def comes(self, *now: object) -> bool:
        self._silent += 1
        if now == self._told and self._silent < self._turns:
            return False
        self._told, self._silent = now, 0
        return True


class Changes:
    """The newest standing, and every change of it that nobody has asked for yet. A lock is the
    caller's affair."""

    def __init__(self) -> None:
        self.now = RunStanding(RunState.STARTING)
        self._changes: deque[Change] = deque(maxlen=KEPT)

    def note(self, now_s: float, standing: RunStanding) -> None:
        """How it stands now. The age of what is missing grows in words with every turn: a cause
        that differs in its numbers alone is no other standing."""
        before, self.now = self.now, standing
        if (before.state, _wording(before)) != (standing.state, _wording(standing)):
            self._changes.append(Change(now_s, before, standing))

    def take(self) -> tuple[Change, ...]:
        changes = tuple(self._changes)
        self._changes.clear()
        return changes


def _wording(standing: RunStanding) -> str:
    """The cause, without its numbers where it is one that holds the base."""
    held = standing.state is RunState.HELD
    return re.sub(r"\d+(\.\d+)?", "", standing.cause) if held else standing.cause
