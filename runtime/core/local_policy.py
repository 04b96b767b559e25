"""The local policy: how a base is moved toward an aim. There are two kinds of base, one of whole
steps and turns, as the benchmark protocols have it, and one of velocities; what differs between
them is here and nowhere else."""

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np

from runtime.core.distances.planner import Field, descend
from runtime.core.distances.terrain import DEAD_END_M
from runtime.core.geometry import bearing
from runtime.core.motion import discrete_policy, step_search, velocity_policy
from runtime.core.motion.courses import STILL, Along, ControlConfig, Course
from runtime.core.motion.footing import footing, no_floor
from runtime.core.settings import NavigateConfig
from runtime.core.types import F64, Action, Mask, Observation, Twist
from runtime.core.world import Command, Mode, World

GIVE_UP_AFTER = 24  # steps without coming closer to an aim
GIVE_UP_AFTER_S = 12.0  # the same for velocities
DECIDE_EVERY = 5  # steps between decisions that only new evidence asks for
DECIDE_EVERY_S = 1.0  # the same for velocities
BLOCKED_M = 0.08  # a step forward that moved less than this was a collision
BLOCKED_S = 0.6  # the same for velocities: so long not a quarter of the speed
STEPS_INTO = 4  # at most, forward, to be exactly at what is half a step away
PATIENCE = 8  # steps without coming closer, after which a way of several steps is looked for
BEYOND = 3  # cells
COURSE_M = 3.0  # of the terrain around the robot goes with a course: farther than it gets by it
LATE = 3.0  # times what a look around takes at its rate, after which it is over


class LocalPolicy(Protocol):
    """What navigation asks of a kind of base."""

    @property
    def patience(self) -> float:
        """The effort without coming closer after which an aim is given up."""

    def effort(self, world: World) -> float:
        """What this observation's step toward an aim counts."""

    def rested(self, world: World) -> bool:
        """Whether the standing decision is old enough for new evidence to ask for another."""

    def looks_on(self, world: World) -> bool:
        """Whether the first look around goes on; books a turn of it."""

    def blocked(self, world: World, obs: Observation) -> bool:
        """Whether the base has run into something since the observation before."""

    def arrived(self, world: World, field: Field, exactly: bool = False) -> bool:
        """Whether the robot is at a field's sources, as near as such a base can be; `exactly`: as
        near as it can be by a detour."""

    def turn(self, world: World, xy: tuple[float, float]) -> Action | None:
        """The turn that faces a point, m; None when it is faced."""

    def undoes(self, world: World, turn: Action) -> bool:
        """Whether a turn to face something only undoes the one before."""

    def drive(self, world: World, field: Field, exactly: bool = False) -> tuple[Action, Course]:
        """The way down a field, `exactly` to where it ends, as by `arrived`."""

    def steer(self, world: World, command: Command) -> Command:
        """The command as the base is told it until the next observation."""


def local_policy(cfg: NavigateConfig) -> LocalPolicy:
    """The policy of the configured kind of base."""
    return Velocities(cfg) if cfg.control.mode == "velocity" else WholeSteps(cfg)


def limited(world: World, cfg: NavigateConfig) -> ControlConfig:
    """How the robot may move now: one that sees nothing may turn, to see again, and no more."""
    return replace(cfg.control, max_speed_mps=0.0) if world.body.blind else cfg.control


def as_sent(command: Command, twist: Twist) -> Command:
    """A course's command with the velocity that was sent, and the action that resembles it; while
    the base stands, the action is what it is about to do."""
    sent = STILL if command.action is Action.STOP else twist
    action = command.action if sent == STILL else velocity_policy.nearest_action(sent)
    return replace(command, action=action, twist=sent)


@dataclass(frozen=True)
class WholeSteps:
    """One action an observation: a step forward or a turn, no more and no less."""

    cfg: NavigateConfig

    @property
    def patience(self) -> float:
        return GIVE_UP_AFTER

    def effort(self, world: World) -> float:
        return 1

    def rested(self, world: World) -> bool:
        return world.body.step - world.standing.step >= DECIDE_EVERY

    def looks_on(self, world: World) -> bool:
        if world.explored.looks_left <= 0:
            return False
        world.explored.looks_left -= 1
        return True

    def blocked(self, world: World, obs: Observation) -> bool:
        last = world.body.last
        forward = last is not None and last.action is Action.MOVE_FORWARD
        return forward and _moved_m(world, obs) < BLOCKED_M

    def arrived(self, world: World, field: Field, exactly: bool = False) -> bool:
        """At the sources, or half a step from them and a step ahead would lead no nearer: whole
        steps do not end anywhere. `exactly`: only where a few of them lead no nearer, either. Who
        has arrived, and turns to face what is there, goes on being there."""
        left, last = field.at(world.pose.x_m, world.pose.y_m), world.body.last
        if left <= 0:
            return True
        if last is not None and last.mode is Mode.FACE and left <= discrete_policy.FORWARD_M / 2:
            return True
        return self._beside(world, field) and not (exactly and self._into(world, field))

    def turn(self, world: World, xy: tuple[float, float]) -> Action | None:
        toward_rad = bearing((world.pose.x_m, world.pose.y_m), xy)
        return discrete_policy.face(world.pose, toward_rad)

    def undoes(self, world: World, turn: Action) -> bool:
        opposite = Action.TURN_RIGHT if turn is Action.TURN_LEFT else Action.TURN_LEFT
        last = world.body.last
        return last is not None and last.mode is Mode.FACE and last.action is opposite

    def _beside(self, world: World, field: Field) -> bool:
        """Whether the sources are half a step away, and a step ahead leads no nearer."""
        pose, step_m = world.pose, discrete_policy.FORWARD_M
        left = field.at(pose.x_m, pose.y_m)
        if not 0 < left <= step_m / 2:
            return False
        x_m = pose.x_m + step_m * math.cos(pose.yaw_rad)
        return field.at(x_m, pose.y_m + step_m * math.sin(pose.yaw_rad)) >= left

    def _into(self, world: World, field: Field) -> tuple[Action, ...]:
        """What leads to a field's sources from right beside them; nothing where whole steps end
        only beside them, too, or where it takes more than a few."""
        way = step_search.through(world.terrain, field, world.pose, self.cfg.robot.radius_m, 0.0)
        few = way.actions.count(Action.MOVE_FORWARD) <= STEPS_INTO
        return way.actions if few else ()

    def drive(self, world: World, field: Field, exactly: bool = False) -> tuple[Action, Course]:
        """One action, or the next of several planned together where none leads on by itself."""
        course, body_m = Along(world.terrain, field), self.cfg.robot.radius_m
        place = world.terrain, field, world.pose, body_m
        action = discrete_policy.follow(*place)
        p = world.pursuit.progress.get(world.pursuit.aim)
        if p is None:
            return action or Action.TURN_LEFT, course
        if not step_search.clear(world.terrain, world.pose, p.plan, body_m):
            p.plan = ()
        if exactly and not p.plan and self._beside(world, field):
            p.plan = self._into(world, field)
        if not p.plan and p.idle > (PATIENCE if action else 0):
            field = world.plan.farther(field, world.terrain, world.pose, step_search.BEYOND_M)
            way = step_search.through(world.terrain, field, world.pose, body_m, best_m=p.run_m)
            p.plan, p.idle = way.actions, p.idle + (PATIENCE if way.actions else 0)
            if not way.actions and p.idle > math.tau / discrete_policy.TURN_RAD:
                beyond = descend(field, way.nearest_xy, BEYOND)[-1:]
                return self._unwedge(world, beyond, action), course
        if p.plan:
            action, p.plan = p.plan[0], p.plan[1:]
        return action or Action.TURN_LEFT, course

    def steer(self, world: World, command: Command) -> Command:
        return command

    def _unwedge(self, world: World, beyond_xy: F64, action: Action | None) -> Action:
        """After a whole turn in vain nothing is planned any more through what lies beyond where
        whole steps lead; nor through here, when no heading can be driven: then the robot squeezes
        out."""
        for x_m, y_m in beyond_xy:
            world.map.close(float(x_m), float(y_m), DEAD_END_M)
        if action is not None:
            return action
        world.map.close(world.pose.x_m, world.pose.y_m, DEAD_END_M)
        return discrete_policy.squeeze(world.terrain, world.pose, partial(self._no_way, world))

    def _no_way(self, world: World, points_xy: F64) -> Mask:
        """(..., 2) m -> (...) where there is no floor, or the body would be in a zone, and deeper
        than it is."""
        drops, zones = no_floor(world.map, points_xy), world.map.zones
        if not zones.zones:
            return drops
        frame = world.map.frame
        room_m, _ = zones.clearance(frame, (slice(0, frame.rows), slice(0, frame.cols)))
        here_m = float(room_m[frame.cell(world.pose.x_m, world.pose.y_m)])
        cells = np.clip(frame.cells(points_xy), 0, np.array(frame.shape) - 1)
        least_m = min(self.cfg.robot.radius_m, here_m)
        return drops | (room_m[cells[..., 0], cells[..., 1]] < least_m)


@dataclass(frozen=True)
class Velocities:
    """A velocity that follows a course, until the next observation brings another course."""

    cfg: NavigateConfig

    @property
    def patience(self) -> float:
        return GIVE_UP_AFTER_S

    def effort(self, world: World) -> float:
        return 0.0 if world.body.held else world.body.dt_s

    def rested(self, world: World) -> bool:
        since_s = world.body.elapsed_s - world.standing.elapsed_s
        return since_s >= DECIDE_EVERY_S

    def looks_on(self, world: World) -> bool:
        if world.explored.looks_left <= 0:
            return False
        whole_rad = world.explored.looks_left * discrete_policy.TURN_RAD
        late = world.body.free_s > LATE * whole_rad / self.cfg.control.look_radps
        over = late or world.body.turned_rad >= whole_rad
        if over:
            world.explored.looks_left = 0
        return not over

    def blocked(self, world: World, obs: Observation) -> bool:
        body = world.body
        asked_m = body.asked_mps * body.dt_s
        if asked_m <= 0 or _moved_m(world, obs) >= asked_m / 4:
            body.blocked_s = 0.0
            return False
        body.blocked_s += body.dt_s
        if body.blocked_s < BLOCKED_S:
            return False
        body.blocked_s = 0.0
        return True

    def arrived(self, world: World, field: Field, exactly: bool = False) -> bool:
        return field.at(world.pose.x_m, world.pose.y_m) <= 0

    def turn(self, world: World, xy: tuple[float, float]) -> Action | None:
        rate = velocity_policy.face_rate(world.pose, xy, self.cfg.control)
        if rate is None:
            return None
        return Action.TURN_LEFT if rate > 0 else Action.TURN_RIGHT

    def undoes(self, world: World, turn: Action) -> bool:
        return False  # a rate that overshoots comes back by itself

    def drive(self, world: World, field: Field, exactly: bool = False) -> tuple[Action, Course]:
        # The control loop follows it in a thread of its own, while the terrain goes on changing.
        near = world.terrain.around(world.pose, COURSE_M)
        ground = footing(world.map, world.pose, COURSE_M, world.lens)
        return Action.MOVE_FORWARD, Along(near, field, ground)

    def steer(self, world: World, command: Command) -> Command:
        """With the velocity that begins the command's course, and the action that resembles it."""
        if command.action is Action.STOP:
            return replace(command, twist=STILL)
        limits, body = limited(world, self.cfg), world.body
        twist = velocity_policy.steer(
            command.course, world.pose, body.twist, body.dt_s, self.cfg.robot.radius_m, limits
        )
        return replace(command, action=velocity_policy.nearest_action(twist), twist=twist)


def _moved_m(world: World, obs: Observation) -> float:
    return math.hypot(obs.pose.x_m - world.pose.x_m, obs.pose.y_m - world.pose.y_m)
