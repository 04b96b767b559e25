"""`rfnav calibrate`: how the camera is mounted, by the floor that it sees."""

import json
import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import Final

import click
import numpy as np

from runtime.clock import Deadline, SystemClock
from runtime.config import Config, load
from runtime.core.geometry import wrap_angle
from runtime.core.mapping.floor_plane import MISTAKEN, floor_seen
from runtime.core.optics.upright import QUARTER_RAD, quarters_of
from runtime.core.types import F64, Mount
from runtime.errors import SensorError
from runtime.robot.depth_listener import DepthListener
from runtime.robot.optics import DepthSight

LEAST: Final = 3  # images that show a floor: one may be a table's
SHARE: Final = 0.5  # of those that came, at least


@click.command(
    "calibrate",
    epilog="Example:  rfnav calibrate --config robot.toml. Exit status: 0 measured, 1 no floor "
    "was seen, 2 an error.",
)
@click.option(
    "--config", "path", type=click.Path(path_type=Path), help="TOML file; defaults otherwise."
)
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="Override one key.")
@click.option(
    "--seconds", type=click.FloatRange(1.0, 60.0), default=5.0, show_default=True,
    help="How long to look.",
)  # fmt: skip
@click.option(
    "--json", "told", type=click.Path(path_type=Path), help="Write the figures to a file."
)
def calibrate_command(
    path: Path | None, settings: tuple[str, ...], seconds: float, told: Path | None
) -> None:
    """Measure the camera's height, pitch and roll, while the robot stands still before free, level
    floor, and print what the configuration should have. A table that fills the image is taken for
    a floor."""
    config = load(path, settings)
    measured, images, placed = _look(config, seconds)
    topics = config.bus.topics
    if not images:
        click.echo(
            f"rfnav: {topics.depth}: no depth image with its camera info ({topics.camera_info}) in "
            f"{seconds:g} s: rfnav doctor tells what comes and what to mend",
            err=True,
        )
        sys.exit(1)
    if len(measured) < max(LEAST, SHARE * images):
        click.echo(
            f"rfnav: a floor in {len(measured)} of {images} depth images on "
            f"{topics.depth}: turn the robot to free floor, 1 to 4 m ahead",
            err=True,
        )
        sys.exit(1)
    seen = np.array([[m.z_m, m.pitch_rad, m.roll_rad] for m in measured])
    middle, spread = np.median(seen, axis=0), _spread(seen)
    lines = _report(placed or config.camera, middle, spread, len(measured), images)
    click.echo("\n".join([*lines, "", *_fits(middle, by_tf=placed is not None)]))
    if told is not None:
        names = "z_m", "pitch_rad", "roll_rad"
        figures = {
            n: {"value": v, "spread": s} for n, v, s in zip(names, middle, spread, strict=True)
        }
        told.write_text(json.dumps({"images": images, "floors": len(measured), **figures}) + "\n")


def _look(config: Config, seconds: float) -> tuple[list[Mount], int, Mount | None]:
    """The mounts that the depth images of so long show, as the keys have them, how many images
    could be used, and the mount by tf, where that is gone by: then all are of upright images. Where
    none could, what was wrong is said, and that is the end: the first may come before tf does."""
    clock, placed = SystemClock(), None
    by, found, images, wrong = Deadline.after(seconds, clock), [], 0, ""
    with DepthListener(config.bus, config.camera, clock) as camera:
        while not by.passed():
            try:
                sight = camera.look(by)
            except SensorError as error:
                wrong = str(error)
                continue
            if sight is None:
                continue
            images, placed = images + 1, sight.mount
            mount = _mount(sight, config.camera)
            if mount is not None:
                found.append(mount)
    if wrong and not images:
        click.echo(f"rfnav: {wrong}", err=True)
        sys.exit(1)
    return found, images, placed


def _mount(sight: DepthSight, configured: Mount) -> Mount | None:
    """What the floor in an image says of the camera that is configured: colour's, where depth is
    another's."""
    nominal = sight.mount or sight.mounted(configured)
    seen = floor_seen(sight.depth_m, sight.intrinsics, nominal, MISTAKEN)
    if seen is None or sight.mount is not None:
        return seen
    if sight.beside is None:
        turned = quarters_of(configured.roll_rad) * QUARTER_RAD
        return replace(seen, roll_rad=wrap_angle(seen.roll_rad + turned))
    return _before(sight, seen, configured)


def _before(sight: DepthSight, seen: Mount, configured: Mount) -> Mount:
    """The configured camera's mount, by that of the depth camera beside it: what differs between
    them is the same, whatever the mount."""
    assert sight.beside is not None
    found = configured
    for _ in range(3):  # the angles act on one another a little
        is_now = sight.mounted(found)
        found = replace(
            found,
            z_m=found.z_m + seen.z_m - is_now.z_m,
            pitch_rad=found.pitch_rad + seen.pitch_rad - is_now.pitch_rad,
            roll_rad=wrap_angle(found.roll_rad + wrap_angle(seen.roll_rad - is_now.roll_rad)),
        )
    return Mount(found.x_m, found.y_m, found.z_m, found.roll_rad, found.pitch_rad, found.yaw_rad)


def _spread(seen: F64) -> F64:
    """(N, 3) -> (3,) within which two thirds lie, about their median."""
    off = np.abs(seen - np.median(seen, axis=0))
    return np.asarray(np.quantile(off, 2 / 3, axis=0), np.float64)


def _report(configured: Mount, middle: F64, spread: F64, floors: int, images: int) -> list[str]:
    """For people."""
    was = np.array([configured.z_m, configured.pitch_rad, configured.roll_rad])
    lines = [f"A floor in {floors} of {images} depth images."]
    for n, (name, unit, factor) in enumerate(
        (
            ("height", "m", 1.0),
            ("pitch", "degrees", math.degrees(1)),
            ("roll", "degrees", math.degrees(1)),
        )
    ):
        lines.append(
            f"{name:7}{factor * middle[n]:z8.3f} {unit}, two thirds within "
            f"{factor * spread[n]:.3f}; configured {factor * was[n]:.3f}"
        )
    return lines


def _fits(middle: F64, by_tf: bool) -> list[str]:
    """For the file; or, where that does not say, for whoever publishes tf."""
    z_m, pitch_rad, roll_rad = middle
    if by_tf:
        what = f"z {z_m:.3f} m, pitch {pitch_rad:.4f}, roll {roll_rad:.4f} rad"
        return [
            f'camera.mount is "tf": let tf place the upright depth camera on the base at {what}'
        ]
    return [
        "[camera]",
        f"z_m = {z_m:.3f}",
        f"pitch_rad = {pitch_rad:z.4f}",
        f"roll_rad = {roll_rad:z.4f}",
    ]
