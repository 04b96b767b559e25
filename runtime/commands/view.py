"""`rfnav view`: the operator's page, served by a process of its own."""

from pathlib import Path
from typing import Any

import click

from runtime.commands.own_process import become, check_packages

NEEDED = ("starlette", "uvicorn", "websockets")
PROCESS = "runtime.commands.view_process"


@click.command(
    "view",
    epilog="Examples:  rfnav view   |   rfnav view --replay drives/rfnav-20261129-063438.mcap",
)
@click.option("--config", type=click.Path(path_type=Path), help="The robot's TOML file.")
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="Override one key.")
@click.option("--listen", default="127.0.0.1:8080", show_default=True, metavar="HOST:PORT")
@click.option("--name", "names", multiple=True, help="Another name that browsers call it by.")
@click.option(
    "--replay",
    type=click.Path(path_type=Path, exists=True),
    help="Show a recording, in place of a robot.",
)
@click.option("--certificate", type=click.Path(path_type=Path, dir_okay=False), help="PEM.")
@click.option("--key", type=click.Path(path_type=Path, dir_okay=False), help="Of it, PEM.")
@click.option(
    "--token-file",
    type=click.Path(path_type=Path, dir_okay=False),
    help="What people must show stands in it.",
)
def view_command(**given: Any) -> None:
    """Show what the robot sees, knows and does in a browser, and take goals, zones and a stop from
    there, until Ctrl-C.

    On this computer alone, unless it is given a certificate and a token. The service need not be
    up: the page says so, and goes on when it is.
    """
    check_packages("view", NEEDED, "view")
    become(PROCESS, given)
