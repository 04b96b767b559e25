"""All that is asked of a robot and its computer, in the order in which a person would mend it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from runtime.clock import Clock
from runtime.config import Config
from runtime.core.optics.upright import upright_mount
from runtime.doctor.camera import judge_camera
from runtime.doctor.diagnosis import Diagnosis, bad, can_search
from runtime.doctor.floor import judge_floor
from runtime.doctor.hearing import Hearing, NetworkHeard
from runtime.doctor.listening import listen
from runtime.doctor.machine import judge_machine, machine
from runtime.doctor.models import Load, judge_models, try_models
from runtime.doctor.network import judge_network
from runtime.doctor.odometry import judge_odometry
from runtime.doctor.reading import topics_heard
from runtime.doctor.rover import HeardRover, judge_rover, rover_heard
from runtime.doctor.sight import seen_turns
from runtime.doctor.spin import BY_HAND, judge_turn, turn_once
from runtime.doctor.topics import judge_commands, judge_dialect, judge_topics
from runtime.doctor.turning import judge_middle, judge_turning
from runtime.errors import BusError, RfNavError
from runtime.loops.process import heard_signals
from runtime.tracing.budgets import Budgets

SCORES = "scores.sqlite"


@dataclass(frozen=True)
class Instruments:
    """What an examination needs around it: how models are loaded, and who is told what goes on."""

    clock: Clock
    budgets: Budgets
    load: Load
    tell: Callable[[str], None]


@dataclass(frozen=True)
class Examined:
    """What was heard, and what was found, by part of the robot."""

    hearing: Hearing
    parts: Mapping[str, Sequence[Diagnosis]]

    @property
    def found(self) -> list[Diagnosis]:
        return [one for part in self.parts.values() for one in part]


def examine(config: Config, seconds: float, turn: bool, by: Instruments) -> Examined:
    """Listen, turn once where that is wanted, try what the computer has."""
    by.tell(f"listening for {seconds:g} s")
    hearing, rover = _heard(config, seconds, by.clock)
    parts = {"bus": [*judge_network(hearing, config), *judge_dialect(hearing, config)]}
    parts["topics"] = [*judge_topics(hearing, config), *judge_commands(hearing, config)]
    parts["camera"] = [*judge_camera(hearing, config), *judge_floor(hearing, config)]
    parts["motion"] = [*judge_odometry(hearing, config)]
    if rover is not None:
        parts["motion"] += judge_rover(rover)
    if hearing.held and can_search(one for part in parts.values() for one in part):
        held = f"the base would be held: {hearing.held}"
        parts["motion"].append(bad("search", held, "mend that first"))
    parts["motion"] += _turned(hearing, config, by) if turn else _by_the_way(hearing, config)
    by.tell("trying the models")
    parts["models"] = [*_models(hearing, config, by)]
    parts["computer"] = [*judge_machine(machine(), config, by.budgets.loop)]
    return Examined(hearing, parts)


def _heard(config: Config, seconds: float, clock: Clock) -> tuple[Hearing, HeardRover | None]:
    with rover_heard(config, clock) as rover:
        try:
            hearing = listen(config, seconds, clock)
        except BusError as error:
            hearing = Hearing(0.0, topics_heard(config), NetworkHeard(error=str(error)))
    if rover is not None and rover.poses:
        hearing.odometry = rover.poses
    return hearing, rover


def _by_the_way(hearing: Hearing, config: Config) -> Iterator[Diagnosis]:
    """What odometry and images tell of a turn, where there was one."""
    if hearing.intrinsics is None or not hearing.odometry:
        return
    mount = hearing.mount or upright_mount(config.camera)
    seen = seen_turns(hearing.glimpses, hearing.intrinsics, mount)
    yield from judge_turning(hearing.odometry, seen)


def _turned(hearing: Hearing, config: Config, by: Instruments) -> Iterator[Diagnosis]:
    if hearing.network.runtime:
        told = "refused: an rfnav run is on this bus, and two would drive"
        yield bad("turn", told, "stop it, then run rfnav doctor --turn")
        return
    if hearing.network.error or hearing.network.alone:
        yield bad("turn", "refused: nobody is on the bus", "first mend the bus, above")
        return
    by.tell(
        f"turning once to the left, at {config.navigate.control.look_radps:g} rad/s; Ctrl-C stops"
    )
    try:
        with heard_signals() as ending:
            turned = turn_once(config, by.clock, by.budgets, ending)
    except RfNavError as error:
        yield bad("turn", str(error), "mend that first: a search would end by it too")
        return
    if turned.ended == BY_HAND:
        raise KeyboardInterrupt  # the base is at rest
    yield from judge_turn(turned)
    if turned.intrinsics is None:
        return
    seen = seen_turns(
        turned.glimpses, turned.intrinsics, turned.mount or upright_mount(config.camera)
    )
    yield from judge_turning(turned.odometry, seen, turned.sent_rad)
    yield from judge_middle(turned.odometry)


def _models(hearing: Hearing, config: Config, by: Instruments) -> Iterator[Diagnosis]:
    """Without the cloud, which would cost, and without what is remembered of earlier votes."""
    with TemporaryDirectory() as folder:
        scores = str(Path(folder) / SCORES)
        alone = replace(
            config,
            models=replace(config.models, score_file=scores),
            cloud=replace(config.cloud, enabled=False),
        )
        tried = try_models(by.load, alone, by.clock, hearing.rgb)
    yield from judge_models(tried, by.budgets)
