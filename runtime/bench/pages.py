"""`python -m runtime.bench.pages`: what the operator's page costs, and how late control is beside
it: the same drive in turns without and with pages that look; and what the runtime draws for
them."""

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Final

import click
import numpy as np

from runtime.bench import synthetic
from runtime.bench.beside import ServerCost, served
from runtime.bench.measure import Measured, Subject, free_port, measured
from runtime.bench.own_time import own_ms
from runtime.config import load
from runtime.core.types import Frontier
from runtime.robot.drawn_messages import DrawnObject, Stamp
from runtime.robot.drawn_scene import WAY_MOST, DrawnScene, encode_scene

GOAL: Final = "toilet"
STAGES: Final = ("late", "tick", "frame")
FRONTIERS, THINGS = 24, 80  # of a home that is well known


@contextmanager
def pages_open(pages: int, costs: list[ServerCost], endpoint: str) -> Iterator[None]:
    """So many pages look at the runtime on that bus; what that cost in the end."""
    address = f"127.0.0.1:{free_port()}"
    bus = [f'bus.connect=["{endpoint}"]', 'bus.mode="client"']
    options = json.dumps({"listen": address, "settings": bus})
    view = [sys.executable, "-m", "runtime.commands.view_process", options]
    readers = [sys.executable, "-m", "runtime.bench.page_readers", address, str(pages)]
    with served(view, readers, costs):
        yield


@click.command("pages")
@click.option("--pages", type=click.IntRange(1, 8), default=4, show_default=True)
@click.option("--seconds", type=click.FloatRange(5.0), default=60.0, show_default=True)
@click.option("--pairs", type=click.IntRange(1), default=3, show_default=True)
def pages_command(pages: int, seconds: float, pairs: int) -> None:
    """Print the stages of control and of frames without and with pages, ms, what the page's
    server took, and what the runtime takes to draw a scene for it."""
    config, costs = load(None), list[ServerCost]()
    topics, hz = config.bus.topics, config.realtime.control_hz
    beside = partial(pages_open, pages, costs)

    def run(looks: bool) -> Measured:
        drive = synthetic.drive(seconds, topics, config.camera)
        given = Subject(), (GOAL,), drive, topics, hz
        return measured(*given, beside) if looks else measured(*given)

    click.echo(f"{'pages':>6}{'stage':>8}{'p50':>9}{'p99':>9}{'max':>9}   halts")
    for n in range(2 * pairs):
        looks = n % 4 in (1, 2)  # without, with, with, without: a machine that warms up tells less
        click.echo(_told(run(looks), pages if looks else 0))
    for cost in costs:
        click.echo(f"view: {100 * cost.share:.1f} % of a core, {cost.memory_mb:.0f} MB")

    frontiers, things = f"{FRONTIERS} frontiers", f"{THINGS} things"
    click.echo(f"scene: {scene_ms():.1f} ms to draw {frontiers} and {things}, twice a second")


def scene_ms() -> float:
    """What it takes the thread that draws to make a page's scene of a home that is well known: the
    median of its own time."""
    cells_xy = np.linspace((0.0, 0.0), (1.0, 1.0), 40)
    frontiers = [Frontier(n, cells_xy + n, (float(n), 0.0), float(n)) for n in range(FRONTIERS)]
    things = [
        DrawnObject(n, f"thing {n}", 0.5, (float(n), 0.0, 0.5), (0.5, 0.5, 1.0))
        for n in range(THINGS)
    ]
    way_xy = np.linspace((0.0, 0.0), (9.0, 9.0), WAY_MOST)
    scene = DrawnScene(GOAL, frontiers, 1, things, way_xy, way_xy)
    return own_ms(partial(encode_scene, scene, Stamp(1, "odom")))[0]


def _told(found: Measured, pages: int) -> str:
    halts = ", ".join(f"{kind} {n}" for kind, n in found.halts.items()) or "none"
    rows = {"sleeper": found.sleeper, **{name: found.stages.get(name, {}) for name in STAGES}}
    names = "p50_ms", "p99_ms", "max_ms"
    return "\n".join(
        f"{pages:>6}{stage:>8}" + "".join(f"{row.get(name, 0.0):>9.2f}" for name in names)
        + (f"   {halts}" if stage == "late" else "")
        for stage, row in rows.items()
    )  # fmt: skip


if __name__ == "__main__":
    pages_command()
