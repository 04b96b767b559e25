"""One turn on the spot, driven as a search drives: by the control loop, with its guard, watchdog
and reflex, through the base's own contract; and what odometry and images told of it."""

import math
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final, Protocol

from runtime.clock import Clock, Deadline
from runtime.config import Config
from runtime.core.motion.courses import Spin
from runtime.core.types import Intrinsics, Mount, Observation, SearchState, Twist
from runtime.doctor.diagnosis import Diagnosis, bad, ok, warning
from runtime.doctor.hearing import Glimpse, HeardPose, glimpse
from runtime.doctor.reading import PoseReader
from runtime.errors import SensorError
from runtime.loops.control_loop import ControlLoop
from runtime.loops.plans import Plan
from runtime.loops.process import go_first_or_tell
from runtime.robot.bases import opened_base, watched
from runtime.robot.bus import Bus, Request
from runtime.robot.messages import WireMessage
from runtime.tracing.budgets import Budgets
from runtime.tracing.tracer import Tracer

STANDS_S: Final = 1.0  # before the turn and after it: by its ends a lag is seen
LATE: Final = 1.5  # times what a turn takes at its rate, and then LONGER_S, after which it is over
LONGER_S: Final = 6.0  # a first frame has to come, the base to obey
NEXT_S: Final = 0.2
BY_HAND: Final = "it was ended by hand"
BUSY: Final = "rfnav doctor turns the robot: ask again when that is over"


class SpinBus(Protocol):
    """The bus, as a turn needs it; see `Bus`."""

    def next(self, timeout_s: float) -> Observation | None: ...

    def delivered_s(self) -> float | None: ...

    def request(self) -> Request | None: ...


class SpinControl(Protocol):
    """The control loop, as a turn needs it; see `ControlLoop`."""

    def check(self) -> None: ...

    def follow(self, plan: Plan) -> None: ...

    def rest(self, state: SearchState, report: Mapping[str, object]) -> None: ...

    def sent(self) -> Twist: ...

    def halted(self) -> str: ...


@dataclass
class Turned:
    """What came of it: `sent_rad`, that the base was sent to turn, counter-clockwise; `held`: why
    it was held last, "" for never; `ended`: why the turn was ended early, "" where it was not."""

    sent_rad: float = 0.0
    held: str = ""
    ended: str = ""
    intrinsics: Intrinsics | None = None
    mount: Mount | None = None
    odometry: list[HeardPose] = field(default_factory=list)
    glimpses: list[Glimpse] = field(default_factory=list)


def turn_once(config: Config, clock: Clock, budgets: Budgets, ending: Callable[[], bool]) -> Turned:
    """Turn the robot once to the left at `control.look_radps`. `ending` ends it, and all motion, at
    once. RfNavError when bus or base cannot be opened. Nobody else may drive on that bus."""
    turned, lock = Turned(), threading.Lock()
    poses, odom = PoseReader(config), config.bus.topics.pose or config.bus.topics.odom

    def record(kind: str, value: object) -> None:
        if kind == "wire" and isinstance(value, WireMessage) and value.topic == odom:
            try:
                pose = poses.read(value.payload)
            except SensorError:
                return  # the bus counts it
            with lock:
                turned.odometry.append(pose)

    heard = not config.base.odometry, config.senses, config.safety, config.navigate
    with (
        watched(config.base, config.bus) as beat,
        Bus(config.bus, clock, False, config.camera, record, *heard) as bus,
        opened_base(config.base, bus, clock, False) as base,
    ):
        control = ControlLoop(
            base, bus, clock, config.safety, config.realtime, Tracer(budgets, clock.now_s),
            ending, go_first_or_tell, beat=beat,
        )  # fmt: skip
        bus.on_urgent = control.hurry
        control.start()
        try:
            turn_by(bus, control, config, clock, ending, turned)
        finally:
            control.close()
    return turned


def turn_by(
    bus: SpinBus,
    control: SpinControl,
    config: Config,
    clock: Clock,
    ending: Callable[[], bool],
    turned: Turned,
) -> None:
    """At rest, round, at rest: what came of it is put into `turned`."""
    rate, began_s = config.navigate.control.look_radps, clock.now_s()
    by = Deadline.after(LATE * math.tau / rate + LONGER_S, clock)
    course, moves_s, before_s = Spin(rate), math.inf, began_s
    while not turned.ended and not by.passed():
        now_s = clock.now_s()
        turned.sent_rad += control.sent().w_radps * (now_s - before_s)
        before_s = now_s
        turned.held = control.halted() or turned.held
        if abs(turned.sent_rad) >= math.tau:
            break
        turned.ended = BY_HAND if ending() else _asked(bus)
        control.check()
        if _look(bus, turned):
            moves_s = min(moves_s, clock.now_s() + STANDS_S)
            going = clock.now_s() >= moves_s
            frame_s = bus.delivered_s() or 0.0
            radius_m, limits = config.navigate.robot.radius_m, config.navigate.control
            told = {"mode": "doctor", "reason": "rfnav doctor --turn"}
            control.follow(Plan(course if going else None, frame_s, radius_m, limits, told))
    control.rest(SearchState.READY, {"mode": "doctor"})
    rests = Deadline.after(STANDS_S, clock)
    while not turned.ended and not rests.passed():
        _look(bus, turned)


def _look(bus: SpinBus, turned: Turned) -> bool:
    """The next frame; whether there was one."""
    obs = bus.next(NEXT_S)
    if obs is None:
        return False
    turned.intrinsics, turned.mount = obs.intrinsics, obs.mount
    turned.glimpses.append(glimpse(obs.stamp_ns, obs.rgb, obs.depth_m))
    return True


def _asked(bus: SpinBus) -> str:
    """Answer who asks meanwhile; why the turn is to end, "" for no reason."""
    why = ""
    while (request := bus.request()) is not None:
        if request.kind == "cancel":
            request.reply({"state": SearchState.CANCELLED})
            why = "it was cancelled on rfnav/cancel"
        else:
            request.refuse(BUSY)
    return why


def judge_turn(turned: Turned) -> Iterator[Diagnosis]:
    """Whether the base was driven round."""
    share = abs(turned.sent_rad) / math.tau
    told = f"the base was sent {share:.0%} of a turn to the left"
    if turned.ended:
        yield warning("turn", f"{told}: {turned.ended}", "run rfnav doctor --turn again")
    elif share < 1:
        why = f"held: {turned.held}" if turned.held else "too few frames came to drive by"
        yield bad("turn", f"{told}: {why}", "mend that first: a search would be held by it too")
    elif turned.held:
        yield warning(
            "turn", f"{told}; on the way it was held: {turned.held}", "look for its cause"
        )
    else:
        yield ok("turn", told)
