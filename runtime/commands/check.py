"""`rfnav check`: whether a configuration can be used."""

from pathlib import Path

import click

from runtime.config import load
from runtime.experts.cloud_config import read_key


@click.command("check", epilog="Example:  rfnav check --config robot.toml")
@click.option("--config", "path", type=click.Path(path_type=Path), required=True)
def check_command(path: Path) -> None:
    """Read a configuration and say whether it can be used, and which keys are called otherwise
    now."""
    cloud = load(path).cloud
    if cloud.enabled and cloud.key_file:  # a credential is there only under systemd
        read_key(cloud)
    click.echo(f"{path}: ok")
