"""What the body does by itself where it touches something, or the floor ends under its rim: it
halts, backs off the way that it came, and stands until there is a plan that knows of it. No clock:
times are arguments, monotonic seconds of arrival."""

import math
from collections import deque
from dataclasses import dataclass, field
from enum import StrEnum

from runtime.core.geometry import wrap_angle
from runtime.core.motion.courses import STILL
from runtime.core.motion.safety import Halt, HaltKind, Odometry
from runtime.core.types import Pose, Twist

BACK_M = 0.15  # as far the robot backs off; less where it came less far
BACK_MPS = 0.1
REST_S = 0.3  # until the base stands, after which it backs off
STUCK_S = 1.0  # longer than BACK_M takes, after which a base that does not back off is left alone
BACK_TURN_RADPS = 0.5
AHEAD_RAD = 1.75  # what is met more to the side than that is not backed off from
FACING_RAD = 1.0  # of what the bumper still touches: no way forward
TRAIL_M = 0.5  # of the way that the robot came, which is kept
STEP_M = 0.01
JUMP_M = 0.25  # between two odometry messages: no way was driven
TURNED_RAD = 0.3  # on the spot: what is behind the robot now is not the way that it came


class Touch(StrEnum):
    """What the body meets."""

    BUMPER = "bumper"
    CLIFF = "cliff"
    WHEEL = "wheel"


_KINDS = {Touch.BUMPER: HaltKind.BUMPER, Touch.CLIFF: HaltKind.CLIFF, Touch.WHEEL: HaltKind.WHEEL}
_WORDS = {
    Touch.BUMPER: "touches something",
    Touch.CLIFF: "has no floor under it",
    Touch.WHEEL: "hangs in the air",
}


@dataclass(frozen=True)
class Contact:
    """What one sensor said: `bearing_rad` is where it is, to the left of straight ahead; `since_s`
    when it began, `held` whether it lasts."""

    touch: Touch
    sensor: str
    bearing_rad: float
    since_s: float
    held: bool

    @property
    def in_words(self) -> str:
        """For people."""
        return f"{self.sensor} {_WORDS[self.touch]}"


@dataclass(frozen=True)
class Felt:
    """What lasts, by the last word of each sensor, and what was over a short while ago.
    `cliffs_watched`: cliff sensors look ahead, and all that ever spoke still do, so that the end of
    the floor will be felt."""

    contacts: tuple[Contact, ...] = ()
    cliffs_watched: bool = False


NOTHING = Felt()


@dataclass(frozen=True)
class Met:
    """Where the body met something: what the map is told."""

    touch: Touch
    pose: Pose
    bearing_rad: float


@dataclass
class _Trail:
    """The way that the robot came, driving forward: (m since it began, pose), oldest first."""

    poses: deque[tuple[float, Pose]] = field(default_factory=deque)

    def follow(self, pose: Pose) -> None:
        """Add where the robot is; going back takes off what it came by."""
        way_m, last = self.poses[-1] if self.poses else (0.0, pose)
        dx, dy = pose.x_m - last.x_m, pose.y_m - last.y_m
        if not self.poses or math.hypot(dx, dy) > JUMP_M:
            self._begin(pose)
            return
        ahead_m = dx * math.cos(last.yaw_rad) + dy * math.sin(last.yaw_rad)
        if ahead_m >= STEP_M:
            self.poses.append((way_m + ahead_m, pose))
            while way_m + ahead_m - self.poses[0][0] > TRAIL_M:
                self.poses.popleft()
        elif ahead_m <= -STEP_M:
            while len(self.poses) > 1 and self.poses[-1][0] > way_m + ahead_m:
                self.poses.pop()
            if self.poses[-1][0] > way_m + ahead_m:
                self._begin(pose)  # it has gone back beyond all that is known
        elif abs(wrap_angle(pose.yaw_rad - last.yaw_rad)) > TURNED_RAD:
            self._begin(pose)

    def _begin(self, pose: Pose) -> None:
        self.poses.clear()
        self.poses.append((0.0, pose))

    def back(self, most_m: float) -> tuple[float, Pose | None]:
        """How far back there is a way, `most_m` at most, and the pose there; None for no way. After
        `follow`."""
        ways = ((self.poses[-1][0] - at_m, pose) for at_m, pose in self.poses)
        way_m, pose = next((m, pose) for m, pose in ways if m <= most_m)
        return way_m, pose if way_m > 0 else None


@dataclass
class _Backing:
    """Under way: until when, how far, from where and to where."""

    until_s: float
    way_m: float
    begin: Pose
    end: Pose

    def left_m(self, pose: Pose) -> float:
        return self.way_m - math.hypot(pose.x_m - self.begin.x_m, pose.y_m - self.begin.y_m)


class ContactResponse:
    """Fed with every tick's odometry and contacts, whoever drives; `judge` says what follows for a
    base that is driven by a plan."""

    def __init__(self) -> None:
        self._trail = _Trail()
        self._known_s = -math.inf  # contacts up to then have been seen
        self._met: Contact | None = None  # what the base is held for
        self._met_s = -math.inf
        self._backing: _Backing | None = None
        self._over_s: float | None = None  # when all that it does by itself was done
        self._held: tuple[Contact, ...] = ()
        self._facing: dict[str, float] = {}  # heading of what is touched, by sensor

    def watch(
        self, now_s: float, odometry: Odometry, contacts: tuple[Contact, ...], driving: bool
    ) -> tuple[Met, ...]:
        """What has newly been met. A base that is not `driving` by a plan does nothing by
        itself."""
        pose = odometry.pose
        if not driving:
            self._backing = None
        if self._backing is None:
            self._trail.follow(pose)
        new = [contact for contact in contacts if contact.since_s > self._known_s]
        self._known_s = max((contact.since_s for contact in new), default=self._known_s)
        self._held = tuple(contact for contact in contacts if contact.held)
        held = {contact.sensor for contact in self._held}
        self._facing = {name: rad for name, rad in self._facing.items() if name in held}
        for contact in new:
            if contact.touch is Touch.BUMPER and contact.held:
                self._facing[contact.sensor] = pose.yaw_rad + contact.bearing_rad
        if new:
            self._halt_for(min(new, key=_gravity), now_s, pose, driving)
        return tuple(
            Met(contact.touch, pose, contact.bearing_rad)
            for contact in new
            if contact.touch is not Touch.WHEEL
        )

    def judge(self, now_s: float, pose: Pose, plan_s: float) -> tuple[Halt | None, Twist]:
        """Why the base is not driven by the plan, which was made of a frame that arrived at
        `plan_s`; and what it does instead."""
        if self._met is None:
            return None, STILL
        if self._backing is not None:
            twist = self._back(now_s, pose)
            if twist is not None:
                return _halt(self._met), twist
        lasting = next((c for c in self._held if c.touch is not Touch.BUMPER), None)
        if lasting is not None or self._over_s is None:
            self._over_s = now_s
        if plan_s <= self._over_s:
            return _halt(lasting or self._met), STILL
        self._met = None
        return None, STILL

    def allowed(self, twist: Twist, pose: Pose) -> Twist:
        """Of a velocity, what does not push on against what the bumper touches."""
        facing = (abs(wrap_angle(rad - pose.yaw_rad)) < FACING_RAD for rad in self._facing.values())
        return Twist(0.0, twist.w_radps) if twist.v_mps > 0 and any(facing) else twist

    # -- inside ------------------------------------------------------------------------------------

    def _halt_for(self, contact: Contact, now_s: float, pose: Pose, driving: bool) -> None:
        if self._backing is not None and not _behind(contact):
            return  # another sensor of the front; it backs off from that, too
        self._met, self._met_s, self._backing, self._over_s = contact, now_s, None, None
        way_m, end = self._trail.back(BACK_M)
        barred = any(map(_behind, (contact, *self._held)))
        if driving and not barred and end is not None:
            until_s = now_s + REST_S + way_m / BACK_MPS + STUCK_S
            self._backing = _Backing(until_s, way_m, pose, end)

    def _back(self, now_s: float, pose: Pose) -> Twist | None:
        """The velocity that backs off; None when that is done."""
        backing = self._backing
        assert backing is not None
        if now_s < self._met_s + REST_S:
            backing.begin = pose  # it may still roll
            return STILL
        left_m = backing.left_m(pose)
        if left_m <= 0 or now_s > backing.until_s:
            self._trail, self._backing = _Trail(), None
            return None
        turn = wrap_angle(backing.end.yaw_rad - pose.yaw_rad) * BACK_MPS / max(left_m, STEP_M)
        return Twist(-BACK_MPS, min(BACK_TURN_RADPS, max(-BACK_TURN_RADPS, turn)))


def _behind(contact: Contact) -> bool:
    """Whether backing off would make it worse."""
    return contact.touch is Touch.WHEEL or abs(contact.bearing_rad) > AHEAD_RAD


def _gravity(contact: Contact) -> int:
    """The gravest first."""
    return (Touch.WHEEL, Touch.CLIFF, Touch.BUMPER).index(contact.touch)


def _halt(contact: Contact) -> Halt:
    return Halt(_KINDS[contact.touch], contact.in_words)
