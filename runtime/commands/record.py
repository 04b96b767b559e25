"""`rfnav run --record`: what is recorded, and where."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from runtime.config import Config, known_keys
from runtime.errors import ConfigError
from runtime.record import Record, unrecorded
from runtime.recording.drive_files import Ring, WholeDrive
from runtime.recording.messages import Encoder
from runtime.recording.recorder import Recorder


@dataclass(frozen=True)
class RecordOptions:
    """`directory`: None for no recording; `minutes`: of a ring, 0 for all of the drive."""

    directory: Path | None
    minutes: float
    privacy: bool


def record_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options of `rfnav run` that say what is recorded."""
    for option in (
        click.option(
            "--privacy", is_flag=True, help="Never write colour. Also so with cloud.privacy: text."
        ),
        click.option(
            "--record-last",
            type=click.FloatRange(min=0.2),
            metavar="MINUTES",
            help="Keep only so much, and that only when something goes wrong.",
        ),
        click.option(
            "--record",
            type=click.Path(path_type=Path, file_okay=False),
            metavar="DIR",
            help="Record the drive as MCAP, for Foxglove and `rfnav replay`.",
        ),
    ):
        command = option(command)
    return command


@contextmanager
def recording(
    config: Config, options: RecordOptions, lockstep: bool, harness: bool = False
) -> Iterator[Record]:
    """What the loop tells is recorded until this ends; then a line says what became of it."""
    if options.directory is None:
        if options.minutes:
            raise ConfigError("--record-last: goes with --record DIR, which says where")
        yield unrecorded
        return
    cloud = config.cloud
    colour = not options.privacy and not (cloud.enabled and cloud.privacy == "text")
    about = {
        "began": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
        "loop": "lockstep" if lockstep else "realtime",
        "colour": "jpeg" if colour else "none",
    }
    values = {name: key.value(config) for name, key in known_keys().items()}
    told = "configuration", {"values": values, "lockstep": lockstep, "harness": harness}
    directory, minutes = options.directory, options.minutes
    files = Ring(directory, minutes, about) if minutes else WholeDrive(directory, about)
    recorder = Recorder(files, Encoder(config.bus, config.camera, colour), told)
    try:
        yield recorder
    except BaseException as error:
        if isinstance(error, Exception):
            recorder("fault", str(error))
        try:
            _end(recorder)
        except Exception as another:  # noqa: BLE001 -- what ended the drive is what is raised
            error.add_note(f"The recording had ended before: {another!r}")
        raise
    _end(recorder)


def _end(recorder: Recorder) -> None:
    """Write what waits, and say what became of it."""
    click.echo(recorder.close().in_words(), err=True)
