"""`python -m hil_sim.benchmarks.relocation`: after how many frames a robot that was restarted knows
where it is in a home that it remembers, and whether it ever believes to be where it is not."""

import math
import random
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import click
import cv2
import numpy as np
from tqdm import tqdm

from hil_sim.benchmarks.relocation_drives import DrivenMap, HomeDrives, drives
from runtime.core.geometry import placed, seen_from, wrap_angle
from runtime.core.mapping.relocate import (
    ANYWHERE,
    SAID,
    SAID_WITHIN,
    Relief,
    believed,
    match,
)
from runtime.core.mapping.settling import Settling
from runtime.core.types import Pose
from runtime.errors import RfNavError

TUNED_ON = ("train-1", "train-2", "train-5", "FloorPlan_Train1_1")
"""What the limits of `relocate` were chosen by."""
HOMES = ("train-7", "train-9", "FloorPlan_Train5_3", *(f"val-{n}" for n in range(10)))
OTHERS = 3  # homes that each beginning is tried in and is not of
EVERY = 3  # looks, between two attempts: 18 frames
RIGHT_M, RIGHT_RAD = 0.75, math.radians(12.0)
"""The remembered map is by an odometry that has drifted: its far end lies that much askew."""


@dataclass(frozen=True)
class RelocationTrial:
    """`frames`: until it was believed where it is; None: it never was. `off`: m and rad, by truth;
    None in a home that it is not."""

    home: str
    remembered: str
    frames: int | None
    off: tuple[float, float] | None

    @property
    def wrong(self) -> bool:
        if self.frames is None:
            return False
        return self.off is None or self.off[0] > RIGHT_M or self.off[1] > RIGHT_RAD


def tried(known: Relief, remembered: HomeDrives, home: str, begun: DrivenMap) -> RelocationTrial:
    """A beginning in a home, with what is remembered of that or of another one."""
    settling = Settling()
    for look in begun.looks[EVERY - 1 :: EVERY]:
        found = match(Relief(look.map), look.pose, known)
        if found is None or not believed(found, ANYWHERE):
            continue
        if settling.settles(look.pose, found.at):
            off = None
            if home == remembered.home:
                off = _off(found.at, look.pose, begun.start, remembered.remembered.start)
            return RelocationTrial(home, remembered.home, look.frames, off)
    off = (0.0, 0.0) if home == remembered.home else None
    return RelocationTrial(home, remembered.home, None, off)


def _off(at: Pose, here: Pose, start: Pose, first_start: Pose) -> tuple[float, float]:
    true = seen_from(first_start, placed(start, here))
    turned = abs(wrap_angle(at.yaw_rad - true.yaw_rad))
    return math.hypot(at.x_m - true.x_m, at.y_m - true.y_m), turned


def trials(homes: Sequence[str]) -> Iterator[RelocationTrial]:
    """Each beginning in its own home, and in the next ones of the list."""
    driven = [drives(home) for home in tqdm(homes, unit="home", disable=None)]
    for n, remembered in enumerate(tqdm(driven, unit="memory", disable=None)):
        known = Relief(remembered.remembered.looks[-1].map)
        for there in (driven[(n + k) % len(driven)] for k in range(min(OTHERS + 1, len(driven)))):
            for begun in there.beginnings:
                yield tried(known, remembered, there.home, begun)


def table(done: Iterable[RelocationTrial]) -> str:
    """In Markdown."""
    told = list(done)
    head = "begins in | trials | bound right | not bound | bound wrong | frames: median, most"
    lines = [f"| {head} |", "|---|---|---|---|---|---|"]
    for name, its in (
        ("the home that is remembered", [t for t in told if t.off is not None]),
        ("another home", [t for t in told if t.off is None]),
    ):
        right = [t.frames for t in its if t.frames is not None and not t.wrong]
        wrong = sum(t.wrong for t in its)
        took = f"{np.median(right):.0f}, {max(right)}" if right else "-"
        unbound = len(its) - len(right) - wrong
        lines.append(f"| {name} | {len(its)} | {len(right)} | {unbound} | {wrong} | {took} |")
    return "\n".join(lines)


def said(homes: Sequence[str]) -> str:
    """What becomes of a robot that is said to be somewhere, after its first look round: rightly, to
    half a metre, or metres off, or in another home. In Markdown."""
    rng, driven = random.Random("said"), [drives(home) for home in homes]
    lines = ["| said | trials | believed rightly | not believed | believed wrongly |"]
    lines.append("|---|---|---|---|---|")
    for what, apart_m, turned_rad, further in (
        ("rightly", (0.0, 0.5), 0.3, 0), ("wrongly", (2.0, 5.0), math.pi, 0),
        ("in another home", (0.0, 5.0), math.pi, 1),
    ):  # fmt: skip
        count = Counter[str]()
        for n, remembered in enumerate(driven):
            known, first = Relief(remembered.remembered.looks[-1].map), remembered.remembered.start
            for begun in driven[(n + further) % len(driven)].beginnings:
                look, aside = begun.looks[EVERY - 1], rng.uniform(-math.pi, math.pi)
                true, off_m = (
                    seen_from(first, placed(begun.start, look.pose)),
                    rng.uniform(*apart_m),
                )
                x_m, y_m = true.x_m + off_m * math.cos(aside), true.y_m + off_m * math.sin(aside)
                yaw_rad = true.yaw_rad + rng.uniform(-turned_rad, turned_rad)
                about = Pose(x_m, y_m, wrap_angle(yaw_rad)), *SAID_WITHIN
                found = match(Relief(look.map), look.pose, known, about)
                if found is None or not believed(found, SAID):
                    count["not"] += 1
                    continue
                off = None if further else _off(found.at, look.pose, begun.start, first)
                trial = RelocationTrial("", "", look.frames, off)
                count["wrong" if trial.wrong else "right"] += 1
        told = f"{count.total()} | {count['right']} | {count['not']} | {count['wrong']}"
        lines.append(f"| {what} | {told} |")
    return "\n".join(lines)


@click.command()
@click.argument("homes", nargs=-1)
@click.option("--said", "by_word", is_flag=True, help="Where somebody says that the robot is.")
def main(homes: tuple[str, ...], by_word: bool) -> None:
    """Trials in these HOMES, else in those that the table in docs/memory.md is of. Drives are made
    at the first call, which takes a minute a home."""
    cv2.setNumThreads(1)
    done = []
    try:
        if by_word:
            click.echo(said(homes or HOMES))
            return
        for trial in trials(homes or HOMES):
            done.append(trial)
            if trial.frames is not None:
                off = "" if trial.off is None else f", {trial.off[0]:.2f} m off"
                told = f"{trial.home}, remembering {trial.remembered}: bound after {trial.frames}"
                click.echo(f"{told} frames{off}{', WRONG' if trial.wrong else ''}", err=True)
    except RfNavError as error:
        raise click.ClickException(str(error)) from error
    click.echo(table(done))


if __name__ == "__main__":
    main()
