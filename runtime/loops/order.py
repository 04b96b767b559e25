"""A goal request that can be followed: understood by the models, its configuration read."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final, Protocol

from runtime.config import Config
from runtime.core.destination import Destination
from runtime.core.goal_phrase import in_turn
from runtime.core.mapping.keyframes import Keyframe
from runtime.core.objects.surfaces import Window
from runtime.core.types import F32, F64, U8, Detections
from runtime.errors import ConfigError, NotLocalisedError
from runtime.experts.panel import Panel
from runtime.loops.goal_request import GoalRequest, Terms
from runtime.loops.whereabouts import NoZones, ZoneKeeper
from runtime.perception.goal_words import Goal
from runtime.record import Record
from runtime.service.bounds import ANYWHERE, GoalBounds, place_words
from runtime.service.goal_queue import WAITING
from runtime.service.limits import NO_LIMITS, GoalLimits

PASSED: Final = "chair"  # a thing that every detector knows, for those that want one to look for


class SearchModels(Protocol):
    """The models, as the loops need them."""

    rooms: tuple[str, ...]

    def accept(self, goal: str, config: Config) -> tuple[Goal, Panel]:
        """Understand a goal, set the detector's vocabulary, seat and warm the experts."""

    def hear(self, text: str, config: Config, several: bool) -> tuple[Goal, ...]:
        """What a text names, without looking for it: one thing, or `several`. ConfigError."""

    def afford(self, usd: float | None) -> None:
        """What the goal accepted last may cost at most, if that is less than what any may."""

    def detect(self, rgb: U8, window: Callable[[], Window | None] = ...) -> Detections:
        """What is in an image; `window`: where small things may be, if there is time to look."""

    def notice(self, goal: str, names: tuple[str, ...]) -> None:
        """Objects that are on the map by now: score them in the background."""

    def hold(self, frames: Sequence[Keyframe]) -> None:
        """The keyframes that are kept now, the oldest first: look at them in the background."""

    def likeness(self, embeddings: F32) -> F64:
        """(N, D) unit rows of things seen before -> (N, C): with what probability each is each of
        the classes of the goal accepted last."""

    def capabilities(self) -> Mapping[str, object]:
        """What the detector can do and, once there is a goal, what stands for each class and what
        it cannot see."""

    def rung(self) -> str:
        """Which rung answers the experts."""

    def health(self) -> Mapping[str, object]:
        """For people: rungs by expert, what models said that failed, what the cloud costs."""

    def bills(self) -> Sequence[object]:
        """Calls of a cloud since this was asked last."""

    def finish(self) -> None:
        """The search for the goal accepted last is over."""


@dataclass(frozen=True)
class Order:
    """A goal request that can be followed: understood, with its own configuration."""

    goal: Goal
    config: Config
    panel: Panel
    log_dir: Path | None  # None: nothing can be written
    episode: str | int | None  # as the requester calls it
    rooms: tuple[str, ...]
    zones: ZoneKeeper = field(default_factory=NoZones)
    id: str = ""  # of the goal, as whoever asked was told
    limits: GoalLimits = NO_LIMITS
    returns: bool = False  # the robot is to go back to where it began
    bounds: GoalBounds = ANYWHERE
    binds: Mapping[str, Any] = field(default_factory=dict)  # what `bounds` were read from

    @property
    def named(self) -> str:
        """What is looked for, or gone to."""
        return self.bounds.to.name if self.bounds.to is not None else self.goal.name

    @property
    def names(self) -> tuple[str, ...]:
        """The classes that are looked for and looked at."""
        return tuple(names[0] for names in self.goal.classes)


def understand(
    body: Mapping[str, Any],
    models: SearchModels,
    configure: Callable[[Sequence[str]], Config],
    terms: Terms,
    id: str = "",
) -> Order:
    """A request for one thing, see `Terms.read`, by the robot's configuration; RfNavError says what
    is wrong."""
    request = terms.read(body)
    if unbound := terms.zones.unbound():
        raise NotLocalisedError(unbound)
    config = configure(request.settings)
    robot, camera = configure(()).camera, config.camera
    if camera.by_tf != robot.by_tf:
        raise ConfigError(
            "camera.mount: tf is read from the start or not at all: set it in rfnav's configuration"
        )
    if (camera.turned, camera.depth_at) != (robot.turned, robot.depth_at):
        what = "how images are set right is known from the start: set it in rfnav's configuration"
        raise ConfigError(f"camera.roll_rad, camera.depth_at: {what}")
    bounds = terms.zones.bounds(request.binds, models.rooms)
    if bounds.to is not None:
        goal, panel = _passing(bounds.to, models, config)
    else:
        goal, panel = models.accept(request.texts[0], config)
    models.afford(request.limits.money_usd)
    return Order(
        goal,
        config,
        panel,
        request.log_dir or terms.directory(),
        request.episode,
        models.rooms,
        terms.zones,
        id,
        request.limits,
        request.afterwards == "return",
        bounds,
        request.binds,
    )


def _passing(to: Destination, models: SearchModels, config: Config) -> tuple[Goal, Panel]:
    """What is looked at on the way to a place, where nothing is looked for and nobody votes."""
    silent = replace(config, panel=replace(config.panel, experts=()))
    goal, panel = models.accept(PASSED, silent)
    return replace(goal, text=place_words(to.name), how=f"a place: {to.name}"), panel


def hear_all(
    asked: GoalRequest,
    models: SearchModels,
    configure: Callable[[Sequence[str]], Config],
    record: Record,
) -> list[Goal]:
    """What is asked for, one after the other. One thing alone that need not wait is understood only
    when its search begins. ConfigError."""
    if asked.goes:
        return [Goal(asked.texts[0], "", (), "")]
    texts = [part for text in asked.texts for part in in_turn(text)]
    several, waits = asked.several == "in_turn", asked.if_busy == "queue"
    if len(texts) == 1 and not several and not waits:
        return [Goal(texts[0], "", (), "")]
    config = configure(asked.settings)
    goals: list[Goal] = []
    for text in texts[: WAITING + 1]:
        heard = models.hear(text, config, several)
        record("heard", {"name": "hears", "value": heard})
        goals += heard
    if len(goals) > WAITING:
        raise ConfigError(f"goal request: goal: {len(goals)} things: {WAITING} at most")
    return goals


def alone(body: Mapping[str, Any], text: str, number: int) -> dict[str, Any]:
    """The request for one thing of those that were asked for; each writes where no other does."""
    beside = {"log_dir": f"{body['log_dir']}-{number + 1}"} if number and "log_dir" in body else {}
    return {**body, "goal": text, "several": "refuse", **beside}
