"""`hil-sim assets pull`: furniture, and what stands where in RoboTHOR, into the cache."""

import click

from hil_sim.scenes.furniture import assets as furniture
from hil_sim.scenes.robothor import metadata


@click.command("pull", epilog="Example:  hil-sim assets pull")
def pull_command() -> None:
    """Fetch into the cache what homes are furnished with (Debian package, 120 MB) and what stands
    where in RoboTHOR's apartments (PyPI wheel, 4 MB)."""

    def report(message: str) -> None:
        click.echo(message, err=True)

    click.echo(furniture.pull(furniture.Assets(), report))
    click.echo(metadata.pull(report))
