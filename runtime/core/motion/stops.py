"""Why the base was held, told for a person: what it means, since when and for how long, and what to
do about it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from runtime.core.motion.safety import HaltKind

BY_ITSELF: Final = "Nothing: it goes on by itself"


@dataclass(frozen=True)
class HaltWords:
    """Of a kind of halt: what it means, and what a person can do."""

    meaning: str
    remedy: str


HALTS: Final[Mapping[str, HaltWords]] = {
    HaltKind.ODOMETRY: HaltWords(
        "it does not know where it is now: odometry has stopped coming, or is late",
        "Look whether the base's driver runs: rfnav status, rfnav doctor",
    ),
    HaltKind.CLOCK: HaltWords(
        "a clock went back, so that old and new cannot be told apart",
        f"{BY_ITSELF}, with the next plan; if it comes again, see that one time service sets the "
        "clock",
    ),
    HaltKind.JUMP: HaltWords(
        "odometry jumped farther than the robot can drive",
        f"{BY_ITSELF}, with the next plan; if it comes again, the wheels slip, somebody lifts the "
        "robot, or two sources publish odometry",
    ),
    HaltKind.FRAME: HaltWords(
        "it does not see what is ahead: no camera image that can be used",
        "Look whether the camera's driver runs, the lens is free and the computer keeps up: "
        "rfnav status, rfnav doctor",
    ),
    HaltKind.PLAN: HaltWords(
        "the plan it drives by is too old: the computer does not keep up, or the camera shows "
        "nothing new",
        f"{BY_ITSELF}; if it comes again, see which stage is over its budget: rfnav status",
    ),
    HaltKind.BASE: HaltWords(
        "the base says that it cannot be driven", "Do what the base asks for, e.g. arm it"
    ),
    HaltKind.HAND: HaltWords("somebody drives the robot by hand", "Let go of the sticks"),
    HaltKind.BUMPER: HaltWords(
        "it touched something", f"{BY_ITSELF}: it backs off and goes another way"
    ),
    HaltKind.CLIFF: HaltWords(
        "there is no floor under its rim", f"{BY_ITSELF}: it backs off and goes another way"
    ),
    HaltKind.WHEEL: HaltWords("a wheel hangs in the air", "Set the robot down on the floor"),
    HaltKind.STOP: HaltWords(
        "somebody stopped it", "When all is safe, release it: a query on rfnav/release"
    ),
    HaltKind.CANCEL: HaltWords("a cancel waited to be answered", BY_ITSELF),
    HaltKind.OVERRUN: HaltWords(
        "the control loop itself stood still: the computer did something else, or slept",
        f"{BY_ITSELF}, with the next plan; if it comes again, give rfnav a processor of its own",
    ),
    HaltKind.TILT: HaltWords("the robot leans", "Set it down upright on level floor"),
    HaltKind.AREA: HaltWords(
        "it left the area that it may be in (safety.area_m)", "Bring it back by hand"
    ),
    HaltKind.OBSTACLE: HaltWords(
        "something stands closer ahead than it could brake for",
        f"{BY_ITSELF} when that has gone, or round it with the next plan",
    ),
    HaltKind.FLOOR: HaltWords(
        "floor is missing ahead, or cannot be seen", f"{BY_ITSELF}, another way, with the next plan"
    ),
}
FAULT: Final = HaltWords(
    "rfnav met a mistake of its own and ends", "Start it again, and report the line"
)
OTHER: Final = HaltWords("it was asked to stand", "Ask it to go on: rfnav resume")


@dataclass(frozen=True)
class BaseStop:
    """While `state` the base stood still that was to be driven. `kind`: of the halt, "" for one
    that is none; `ended_s`: None while it goes on. Times are of one clock, s."""

    number: int
    state: str
    kind: str
    reason: str
    began_s: float
    ended_s: float | None = None
    then: str = ""  # how it stood after


def stop_in_full(stop: BaseStop, now_s: float | None) -> tuple[str, ...]:
    """Lines for a person. `now_s`: None where the clock's zero is nobody's: of a journal."""
    words = HALTS.get(stop.kind, FAULT if stop.state == "fault" else OTHER)
    about = f"{stop.state}, {stop.kind}" if stop.kind else stop.state
    lines = [f"Stop {stop.number} ({about}): {words.meaning}."]
    lines.append(f"What was noticed: {stop.reason or 'nothing more'}.")
    if stop.ended_s is None:
        lasts = (
            "it goes on" if now_s is None else f"it goes on, {now_s - stop.began_s:.1f} s by now"
        )
    else:
        lasts = f"it lasted {stop.ended_s - stop.began_s:.1f} s"
        lasts += f", then: {stop.then}" if stop.then else ""
    began = f"at {stop.began_s:.1f} s" if now_s is None else f"{now_s - stop.began_s:.1f} s ago"
    lines.append(f"It began {began}; {lasts}.")
    if stop.ended_s is None or not words.remedy.startswith(BY_ITSELF):
        lines.append(f"What to do: {words.remedy}.")
    return tuple(lines)
