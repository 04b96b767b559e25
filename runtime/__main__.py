"""`rfnav`: the robot's command line, and the composition root."""

import os
import signal
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

import click
import cv2

from models.command import models_command
from models.errors import ModelError as ModelFileError
from runtime import config as configuration
from runtime.edge.bus import Bus
from runtime.edge.clock import SystemClock
from runtime.errors import ConfigError, RfNavError
from runtime.lockstep import Lockstep
from runtime.mind import LocalMind


@click.group(epilog="Exit status: 0 done, 1 the thing attempted failed, 2 an error.")
def cli() -> None:
    """RF-NAV: finds things with a robot."""


cli.add_command(models_command)


@cli.command(epilog="Example:  rfnav run --lockstep --set 'bus.connect=[\"tcp/127.0.0.1:7447\"]'")
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
def run(path: Path | None, settings: tuple[str, ...], lockstep: bool) -> None:
    """Load the models, join the bus and serve goals until SIGTERM or Ctrl-C."""
    config = configuration.load(path, settings)
    if not lockstep:
        raise ConfigError("run: only --lockstep is built so far; real-time driving is not")

    def configure(more: Sequence[str]) -> configuration.Config:
        return configuration.load(path, (*settings, *more))

    clock = SystemClock()
    ending = threading.Event()
    for name in (signal.SIGTERM, signal.SIGINT):
        signal.signal(name, lambda *_: ending.set())
    cv2.setNumThreads(1)
    with LocalMind(config, clock) as mind, Bus(config.bus, clock, lockstep=True) as bus:
        Lockstep(bus, mind, configure, clock).run(ending.is_set)


@cli.command(epilog="Example:  rfnav check --config robot.toml")
@click.option("--config", "path", type=click.Path(path_type=Path), required=True)
def check(path: Path) -> None:
    """Read a configuration and say whether it can be used."""
    configuration.load(path)
    click.echo(f"{path}: ok")


def main() -> None:
    """Run the command line; every foreseeable error is one line and exit status 2."""
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")
    try:
        cli(prog_name="rfnav", standalone_mode=False)
    except click.UsageError as error:
        error.show()
        sys.exit(2)
    except (RfNavError, ModelFileError) as error:
        click.echo(f"rfnav: {error}", err=True)
        sys.exit(2)
    except click.exceptions.Abort:
        sys.exit(130)


if __name__ == "__main__":
    main()
