"""`rfnav run`, the composition root: bus, models and loop put together."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path

import click
import cv2

from runtime import config as configuration
from runtime.clock import SystemClock
from runtime.commands.record import RecordOptions, record_options, recording
from runtime.errors import ConfigError
from runtime.experts.cloud_config import read_key
from runtime.loops.control_loop import ControlLoop
from runtime.loops.desk import Answering
from runtime.loops.drawings import Drawings
from runtime.loops.goal_request import Terms
from runtime.loops.goals import Custom
from runtime.loops.known_desk import KnownDesk
from runtime.loops.loading import loaded
from runtime.loops.lockstep import Lockstep
from runtime.loops.places_desk import PlacesDesk
from runtime.loops.process import EndSignal, Garbage, go_first_or_tell, prepare, seal
from runtime.loops.realtime import RealTime
from runtime.loops.remembering import HomeMemory
from runtime.loops.ros_goals import RosGoals
from runtime.loops.standing import RunStanding
from runtime.loops.worker_thread import lower_priority
from runtime.perception.configured_models import check_models
from runtime.perception.loaded_models import LoadedModels
from runtime.private_files import state_directory
from runtime.record import Record
from runtime.robot.bases import opened_base, watched
from runtime.robot.bus import Bus
from runtime.robot.exposure import doubtful, exposed
from runtime.robot.frame_names import ODOM
from runtime.robot.loopback import check_alone
from runtime.robot.told_votes import ToldVotes
from runtime.service.goal_queue import GoalFile
from runtime.service.notify import Systemd
from runtime.service.telemetry import Telemetry
from runtime.service.zones import Zones, zones_beside
from runtime.tracing.budgets import Budgets, read_budgets
from runtime.tracing.stages import Stage
from runtime.tracing.tracer import Tracer

WORKERS_NICE = 5
DRAWINGS_NICE = 15
MODELS_NICE = 10  # of the threads that models compute in: a frame's depth goes before its detection


@click.command(
    "run", epilog="Example:  rfnav run --lockstep --set 'bus.connect=[\"tcp/127.0.0.1:7447\"]'"
)
@click.option(
    "--config", "path", type=click.Path(path_type=Path), help="TOML file; defaults otherwise."
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="KEY=VALUE",
    help="Override one key, e.g. panel.decide_budget_s=1.0.",
)
@click.option("--lockstep", is_flag=True, help="Answer each observation once, under a harness.")
@click.option(
    "--harness",
    is_flag=True,
    help="Goals may set everything and say where files go: for hil-sim, on loopback alone.",
)
@click.option(
    "--arm", is_flag=True, help="A base on MAVLink may be armed, once when a search begins."
)
@click.option(
    "--guard",
    "guarded",
    type=click.Path(path_type=Path),
    help="Socket of an `rfnav guard` that is there already; else one is started.",
)
@click.option(
    "--budgets",
    "budgets_path",
    type=click.Path(path_type=Path),
    help="TOML file of what each stage may take; deploy/budgets.toml otherwise.",
)
@record_options
def run_command(
    path: Path | None,
    settings: tuple[str, ...],
    lockstep: bool,
    harness: bool,
    arm: bool,
    guarded: Path | None,
    budgets_path: Path | None,
    record: Path | None,
    record_last: float | None,
    privacy: bool,
) -> None:
    """Load the models, join the bus and serve goals until SIGTERM or Ctrl-C."""
    always = () if lockstep else ('research.control_mode="velocity"',)

    def configure(more: Sequence[str]) -> configuration.Config:
        return configuration.load(path, (*settings, *more, *always))

    seal()
    config, budgets = configure(()), read_budgets(budgets_path)
    if arm and (lockstep or config.base.kind != "mavlink"):
        raise ConfigError("--arm: only a base of kind mavlink, in real time, is armed")
    check_models(config.models)
    _precautions(config)
    if harness:
        check_alone(config.bus)
    clock, terms = SystemClock(), Terms(harness)
    ending = EndSignal()
    cv2.setNumThreads(1)
    options = RecordOptions(record, record_last or 0.0, privacy)
    with recording(config, options, lockstep, harness) as recorder:
        if not lockstep:
            _drive(config, configure, clock, budgets, ending, recorder, arm, guarded, terms)
            return
        with (
            loaded(lambda: LoadedModels(config, clock), 0, ending) as models,
            Bus(config.bus, clock, True, config.camera, recorder, True, config.senses) as bus,
        ):
            custom, answers = _custom(terms, bus, config)
            told = ToldVotes(bus.node, clock)
            loop = bus, models, configure, clock, recorder, custom.terms, answers, told
            Lockstep(*loop).run(ending)


def _precautions(config: configuration.Config) -> None:
    """What others may reach. A key that is none is told before anything is written: what stands in
    its place may be the key itself."""
    for line in (*exposed(config.bus, config.base), *doubtful(config.bus)):
        click.echo(f"rfnav: {line}", err=True)
    if config.cloud.enabled:
        read_key(config.cloud)


def _drive(
    config: configuration.Config,
    configure: Callable[[Sequence[str]], configuration.Config],
    clock: SystemClock,
    budgets: Budgets,
    ending: Callable[[], bool],
    record: Record,
    arm: bool,
    guarded: Path | None,
    terms: Terms,
) -> None:
    """Real time. The threads of the models inherit the lower priority: they are loaded last."""
    prepare()
    tracer, garbage = Tracer(budgets, clock.now_s), Garbage(clock)
    telemetry = Telemetry(clock, config.metrics.port > 0 or "diagnostics" in config.bus.draws)
    senses = not config.base.odometry, config.senses, config.safety, config.navigate
    with (
        Systemd(clock) as systemd,
        watched(config.base, config.bus, guarded) as beat,
        Bus(config.bus, clock, False, config.camera, record, *senses) as bus,
        opened_base(config.base, bus, clock, arm) as base,
    ):
        control = ControlLoop(
            base, bus, clock, config.safety, config.realtime, tracer, ending, go_first_or_tell,
            record, systemd.fed(beat),
        )  # fmt: skip
        bus.on_urgent = control.hurry
        control.start()
        try:
            lower_priority(WORKERS_NICE)
            load = partial(LoadedModels, config, clock, partial(tracer.book, Stage.SCORE))
            told = _told_to_prometheus(config.metrics.port, telemetry, tracer, clock)
            with told, loaded(load, MODELS_NICE, ending) as models, closing(RosGoals(bus)):
                parts = bus, control, models, configure, clock, tracer, budgets, garbage
                until = systemd.served(ending, lambda: _standing(control))
                _serve(parts, config, terms, telemetry, record, until)
        finally:
            control.close()


Parts = tuple[
    Bus, ControlLoop, LoadedModels, Callable[[Sequence[str]], configuration.Config], SystemClock,
    Tracer, Budgets, Garbage,
]  # fmt: skip


def _serve(
    parts: Parts,
    config: configuration.Config,
    terms: Terms,
    telemetry: Telemetry,
    record: Record,
    until: Callable[[], bool],
) -> None:
    bus, control, _, _, clock, _, _, garbage = parts
    custom, answers = _custom(terms, bus, config)
    known = lambda: bus.frame_of("odom", ODOM), bus.origin_xy, clock, DRAWINGS_NICE
    drawn = config.bus.draws, bus, control.status, clock, DRAWINGS_NICE
    with (
        closing(Drawings(*drawn, lambda: telemetry.newest.status)) as drawer,
        closing(KnownDesk(*known)) as desk,
        _memory(custom, answers, bus, config, clock) as memory,
    ):
        loop = RealTime(
            *parts, record, custom=custom, drawer=drawer, answers=answers, telemetry=telemetry,
            memory=memory, known=desk,
        )  # fmt: skip
        garbage.begin()
        loop.run(until)


def _custom(
    terms: Terms, bus: Bus, config: configuration.Config
) -> tuple[Custom, dict[str, Answering]]:
    """What is usual with goals, what all searches keep out of among it, and who answers what is
    asked of that. Zones and goals of a harness go with it."""
    zones = zones_beside(bus, kept=not terms.harness)
    file = None if terms.harness else GoalFile(state_directory())
    custom = Custom(replace(terms, zones=zones), file, config.goal.after_restart)
    return custom, {"zones": lambda request: zones.answer(request.body)}


@contextmanager
def _memory(
    custom: Custom,
    answers: dict[str, Answering],
    bus: Bus,
    config: configuration.Config,
    clock: SystemClock,
) -> Iterator[HomeMemory | None]:
    """What is known over restarts, and who answers what is asked of places. A harness, which has
    many homes, must ask for it."""
    zones, keep = custom.terms.zones, config.goal.keep_map
    if custom.terms.harness and not keep:
        yield None
        return
    assert isinstance(zones, Zones)
    eyes = ", ".join(config.models.detectors)
    memory = HomeMemory(
        state_directory(), keep, eyes, clock, bus.pose, lambda: len(zones) > 0, bus.charging
    )
    zones.bind(memory.binding.transform, memory.place, memory.binding.sure)
    answers["places"] = PlacesDesk(memory, bus.origin_xy).answer
    with closing(memory):
        yield memory


def _told_to_prometheus(
    port: int, telemetry: Telemetry, tracer: Tracer, clock: SystemClock
) -> AbstractContextManager[object]:
    if not port:
        return nullcontext()
    from runtime.service.metrics import metrics_served  # 5 MB that nobody else needs

    return metrics_served(port, telemetry, tracer, clock.now_s)


def _standing(control: ControlLoop) -> str:
    told = control.status()["runtime"]
    assert isinstance(told, dict)
    return RunStanding(**told).in_words()
