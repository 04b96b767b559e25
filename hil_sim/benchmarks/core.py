"""`python -m hil_sim.benchmarks.core`: what the core costs a frame, stage by stage, and how that
grows with the map."""

import platform
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import click
import cv2
import numpy as np
import skfmm
from tqdm import tqdm

from hil_sim.benchmarks import drive, growth, others
from hil_sim.benchmarks.drive import RecordedDrive
from hil_sim.benchmarks.performance_page import StageRow, draw_growth, page
from hil_sim.benchmarks.stopwatch import STAGES, ReferenceWork, StageTimes
from runtime import navigate
from runtime.config import Config
from runtime.core.distances.kept_plan import KeptPlan
from runtime.core.distances.planner import Field
from runtime.core.distances.terrain import Terrain
from runtime.core.geometry import GridFrame
from runtime.core.types import Pose
from runtime.core.world import World
from runtime.errors import RfNavError

REFERENCE, PERCEIVE, ACT = "reference", "perceive", "act"
VALID, TOUCHED = "plan, nothing touched it", "plan, touched or to another aim"
TAKEN, TOLD = "outlook taken", "what the experts are told"
TOLD_EVERY = 10  # frames
SIDES = (240, 480, 960, 1920, 3840)
SIDE_FRAMES = 60
FREE_CELLS = 960
ACROSS_GOAL = (60.0, 120.0)
GOALS: Mapping[str, tuple[float, float] | None] = {
    "integrate": None,
    "frontiers": (0.5, 2.0),
    "terrain and distances": (1.5, 6.0),
    "of that, terrain": None,
    "semantic layer": (2.0, 5.0),
    "keyframe": None,
    PERCEIVE: None,
    ACT: None,
    VALID: (0.1, 5.0),
    TOUCHED: (1.0, 5.0),
    "perceive + act": (7.0, 15.0),
    TAKEN: None,
    TOLD: (10.0, 25.0),
}
"""Median and p99, ms; None: no goal of its own."""


def timed(recorded: RecordedDrive, world: World, config: Config, frames: int) -> StageTimes:
    """Drive along; the world is there afterwards."""
    times, reference = StageTimes(), ReferenceWork()
    work, cfg = times.timed(REFERENCE, reference), config.navigate
    perceive, act = times.timed(PERCEIVE, navigate.perceive), times.timed(ACT, navigate.act)
    with times.watching(), watching_plans(times):
        for n, (obs, seen) in enumerate(recorded.frames()):
            if n == frames:
                break
            work()
            perceive(world, obs, seen, config.camera, cfg)
            if n % TOLD_EVERY == 0:
                _tell(world, config, times)
            drive.decide(world, config)
            navigate.steer(world, act(world, cfg), cfg)
            times.next_frame()
    whole = zip(times.seconds[PERCEIVE], times.seconds[ACT], strict=True)
    times.seconds["perceive + act"] = [a + b for a, b in whole]
    return times


@contextmanager
def watching_plans(times: StageTimes) -> Iterator[None]:
    """Whether a plan was kept is told by its field: the same as the last, or another."""
    toward = KeptPlan.toward
    last: list[Field | None] = [None]

    def stage_of(field: Field) -> str:
        kept, last[0] = field is last[0], field
        return VALID if kept else TOUCHED

    KeptPlan.toward = times.timed_by(stage_of, toward)  # type: ignore[method-assign]
    try:
        yield
    finally:
        KeptPlan.toward = toward  # type: ignore[method-assign]


def _tell(world: World, config: Config, times: StageTimes) -> None:
    outlook = times.timed(TAKEN, navigate.outlook)(world, "timed", config.navigate)
    times.timed(TOLD, lambda: outlook.brief)()


def across(side: int = FREE_CELLS, times: int = 5) -> StageTimes:
    """A plan from one corner of an open floor to the other, from scratch."""
    watch = StageTimes()
    whole, clear = np.ones((side, side), bool), np.ones((side, side), np.float32)
    terrain = Terrain(GridFrame(0.0, 0.0, 0.05, side, side), clear, whole, clear)
    robot = Pose(side * 0.05 - 0.1, side * 0.05 - 0.1, 0.0)
    goal = np.array([[2, 2]], np.int32)
    for _ in range(times):
        watch.timed("across", KeptPlan().toward)(terrain, goal, robot)
        watch.next_frame()
    return watch


def grown(recorded: RecordedDrive, explored: World, config: Config) -> dict[str, list[float]]:
    """By stage the median, ms, within known maps of SIDES² cells; `megabytes` of the map."""
    found: dict[str, list[float]] = {}
    for side in tqdm(SIDES, unit="map", disable=None):
        world = growth.surrounded(explored, side, config)
        times = timed(recorded, world, config, SIDE_FRAMES)
        for stage in (*STAGES, ACT, TAKEN, TOLD, REFERENCE):
            found.setdefault(stage, []).append(times.median_ms(stage))
        found.setdefault("megabytes", []).append(growth.megabytes(world))
    return found


def rows(times: StageTimes) -> list[StageRow]:
    """The table's lines."""
    reference = times.median_ms(REFERENCE)
    return [
        StageRow(stage, times.median_ms(stage), times.p99_ms(stage),
            times.median_ms(stage) / reference, goal)
        for stage, goal in GOALS.items()
    ]  # fmt: skip


def plan_row(reference_ms: float) -> StageRow:
    """The table's last line."""
    plan = across()
    middle, high = plan.median_ms("across"), plan.p99_ms("across")
    stage = f"plan across {FREE_CELLS}² free cells"
    return StageRow(stage, middle, high, middle / reference_ms, ACROSS_GOAL)


def machine() -> str:
    """What was measured on, and with what."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    except OSError:
        names = []
    cpu = f"{len(names)} x {names[0]}" if names else platform.processor()
    return (
        f"{cpu}; Python {platform.python_version()}, numpy {np.__version__}, OpenCV "
        f"{cv2.__version__}, scikit-fmm {skfmm.__version__}"
    )


@click.command()
@click.option("--out", type=click.Path(path_type=Path), help="Write the page here, and the plot "
              "into figures/ beside it; else the table is printed.")  # fmt: skip
@click.option("--vlfm", type=click.Path(path_type=Path), multiple=True, metavar="CHECKOUT",
              help="VLFM's; and once more for frontier_exploration's.")  # fmt: skip
@click.option("--semexp", type=click.Path(path_type=Path), metavar="CHECKOUT",
              help="Object-Goal-Navigation's.")  # fmt: skip
def main(out: Path | None, vlfm: Sequence[Path], semexp: Path | None) -> None:
    """Time the core on a drive of 300 frames, which is made at the first call."""
    cv2.setNumThreads(1)
    try:
        recorded, config = drive.recorded(), drive.configuration()
        world = drive.begin(config)
        times = timed(recorded, world, config, drive.FRAMES)
        field: dict[str, list[float]] = {}
        if vlfm:
            field["VLFM, obstacle map and frontiers"] = others.vlfm(vlfm[0], vlfm[1:], recorded)
        if semexp:
            field["SemExp, short-term goal"] = others.semexp(semexp, world)
    except RfNavError as error:
        raise click.ClickException(str(error)) from error
    lines = [*rows(times), plan_row(times.median_ms(REFERENCE))]
    larger = grown(recorded, world, config) if out else {}
    if out:
        out.parent.mkdir(parents=True, exist_ok=True)
        draw_growth(SIDES, larger, GOALS, out.parent / "figures" / "core-growth.png")
    text = page(machine(), times.median_ms(REFERENCE), lines, field, SIDES, larger)
    if out:
        out.write_text(text, encoding="utf-8")
    click.echo(text)


if __name__ == "__main__":
    main()
