"""`rfnav check`: whether a configuration can be used."""

from pathlib import Path

import click

from runtime.config import load
from runtime.experts.cloud_config import read_key
from runtime.perception.configured_models import check_models
from runtime.robot import session
from runtime.robot.exposure import doubtful, exposed


@click.command("check", epilog="Example:  rfnav check --config robot.toml")
@click.option("--config", "path", type=click.Path(path_type=Path), required=True)
def check_command(path: Path) -> None:
    """Read a configuration and say whether it can be used, every value within its bounds and every
    model one that exists; which keys are called otherwise now, and what it opens to others."""
    config = load(path)
    check_models(config.models)
    cloud = config.cloud
    session.check(config.bus, files=True)
    for line in (*exposed(config.bus, config.base), *doubtful(config.bus)):
        click.echo(f"{path}: {line}")
    if cloud.enabled and cloud.key_file:  # a credential is there only under systemd
        read_key(cloud)
    click.echo(f"{path}: ok")
