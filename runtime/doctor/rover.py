"""A base on MAVLink: whether it speaks, what it says of itself, and its odometry."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Final

from runtime.clock import Clock
from runtime.config import Config
from runtime.core.types import Pose
from runtime.doctor.diagnosis import Diagnosis, bad, ok, warning
from runtime.doctor.hearing import HeardPose
from runtime.errors import BaseError
from runtime.robot.base import WELL, BaseCondition

FRAMES: Final = "odom", "base_link"  # of what a vehicle tells as NED


@dataclass
class HeardRover:
    """`condition`: what it says of itself in the end; `known`: whether a vehicle was heard."""

    link: str
    odometry_wanted: bool
    condition: BaseCondition = WELL
    known: bool = False
    poses: list[HeardPose] = field(default_factory=list)


@contextmanager
def rover_heard(config: Config, clock: Clock) -> Iterator[HeardRover | None]:
    """While it is listened to; None where the base is no rover. Nothing is asked of it but what it
    tells: it is neither armed nor driven."""
    if config.base.kind != "mavlink":
        yield None
        return
    from runtime.robot.mavlink.base import MavlinkBase  # its messages take a while to import

    heard = HeardRover(config.base.link, config.base.odometry)

    def note(pose: Pose, stamp_ns: int) -> None:
        half = pose.yaw_rad / 2
        turned = 0.0, 0.0, math.sin(half), math.cos(half)
        heard.poses.append(HeardPose(stamp_ns, *FRAMES, (pose.x_m, pose.y_m), turned))

    def tell(line: str) -> None:
        heard.known = True

    with MavlinkBase(
        config.base.link, clock, False, note if heard.odometry_wanted else None, tell
    ) as base:
        yield heard
        try:
            heard.condition = base.condition()
        except BaseError as error:
            heard.condition = BaseCondition(held=str(error))


def judge_rover(heard: HeardRover) -> Iterator[Diagnosis]:
    """What keeps it from being driven; and whether its odometry comes."""
    told, link = heard.condition, heard.link
    battery = "" if told.battery_percent is None else f"; battery {told.battery_percent:.0f} %"
    if not heard.known:
        yield bad(
            "rover", told.held or f"no vehicle on {link}", f"is it on, and at base.link = {link}?"
        )
        return
    if told.hand:
        yield warning(
            "rover", f"a hand has the sticks: {told.hand}{battery}", "leave it, to search"
        )
    elif told.held:
        yield warning("rover", f"{told.held}{battery}", "rfnav run --arm arms it for a search")
    else:
        yield ok("rover", f"it may be driven{battery}")
    if heard.odometry_wanted and not heard.poses:
        remedy = "has it a position (EKF)? else set base.odometry = false, and bus.topics.odom"
        yield bad("odom", "the vehicle tells no position", remedy)
    elif heard.odometry_wanted:
        yield ok("odom", f"{len(heard.poses)} positions from the vehicle")
