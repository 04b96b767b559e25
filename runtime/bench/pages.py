"""`python -m runtime.bench.pages`: what the operator's page costs, and how late control is beside
it: the same drive in turns without and with pages that look; and what the runtime draws for
them."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple

import click
import numpy as np

from runtime.bench import synthetic
from runtime.bench.measure import BenchError, Measured, Subject, free_port, measured, resident_mb
from runtime.bench.own_time import own_ms
from runtime.config import load
from runtime.core.types import Frontier
from runtime.robot.drawn_messages import DrawnObject, Stamp
from runtime.robot.drawn_scene import WAY_MOST, DrawnScene, encode_scene

READY_S: Final = 60.0
SETTLES_S: Final = 2.0  # until all pages have what there is
GOAL: Final = "toilet"
STAGES: Final = ("late", "tick", "frame")
FRONTIERS, THINGS = 24, 80  # of a home that is well known


class PageCost(NamedTuple):
    """Of the page's server: its share of a core, and its memory."""

    share: float
    memory_mb: float


@contextmanager
def pages_open(pages: int, costs: list[PageCost], endpoint: str) -> Iterator[None]:
    """So many pages look at the runtime on that bus; what that cost in the end. BenchError when the
    server does not come up, or they do not look to the end."""
    address = f"127.0.0.1:{free_port()}"
    bus = [f'bus.connect=["{endpoint}"]', 'bus.mode="client"']
    options = json.dumps({"listen": address, "settings": bus})
    view = [sys.executable, "-m", "runtime.commands.view_process", options]
    readers = [sys.executable, "-m", "runtime.bench.page_readers", address, str(pages)]
    server = subprocess.Popen(view, stdout=subprocess.PIPE, text=True)
    reading: subprocess.Popen[bytes] | None = None
    try:
        assert server.stdout is not None
        if not server.stdout.readline():
            raise BenchError("the page's server did not come up")
        reading = subprocess.Popen(readers)
        time.sleep(SETTLES_S)
        began_s, before_s = time.monotonic(), _cpu_s(server.pid)
        yield
        if reading.poll() is not None or server.poll() is not None:
            raise BenchError("the pages or their server ended before the drive")
        share = (_cpu_s(server.pid) - before_s) / (time.monotonic() - began_s)
        costs.append(PageCost(share, resident_mb(server)))
    finally:
        for child in (reading, server):
            if child is not None:
                child.terminate()
                child.wait(READY_S)


@click.command("pages")
@click.option("--pages", type=click.IntRange(1, 8), default=4, show_default=True)
@click.option("--seconds", type=click.FloatRange(5.0), default=60.0, show_default=True)
@click.option("--pairs", type=click.IntRange(1), default=3, show_default=True)
def pages_command(pages: int, seconds: float, pairs: int) -> None:
    """Print the stages of control and of frames without and with pages, ms, what the page's
    server took, and what the runtime takes to draw a scene for it."""
    config, costs = load(None), list[PageCost]()
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


def _cpu_s(pid: int) -> float:
    """What a process has used so far."""
    words = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    pages_command()
