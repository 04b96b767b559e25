"""`rfnav mcp`: goals and what is known, for language-model agents."""

import sys
from pathlib import Path
from typing import Any

import click

from runtime.commands.options import service_options
from runtime.commands.own_process import become, check_packages
from runtime.errors import ConfigError
from runtime.service.goal_queue import WAITING
from runtime.service.limits import MOST

NEEDED = ("mcp", "starlette", "uvicorn")
PROCESS = "runtime.commands.mcp_process"


@click.command(
    "mcp",
    epilog="Examples:  rfnav mcp   |   rfnav mcp --transport http --token-file token   |   "
    "rfnav mcp --limit-time 300 --area-room kitchen --look",
)
@click.option("--transport", type=click.Choice(("stdio", "http")), default="stdio",
              show_default=True)  # fmt: skip
@click.option("--listen", default="127.0.0.1:8090", show_default=True, metavar="HOST:PORT",
              help="Of this computer, for http.")  # fmt: skip
@click.option("--token-file", type=click.Path(path_type=Path, dir_okay=False),
              help="What clients over http must show stands in it.")  # fmt: skip
@click.option("--limit-time", "time_s", type=click.FloatRange(1, MOST["time_s"]), default=900.0,
              show_default=True, metavar="S",
              help="Seconds that a goal may take at most.")  # fmt: skip
@click.option("--limit-distance", "distance_m", type=click.FloatRange(0.1, MOST["distance_m"]),
              default=200.0, show_default=True, metavar="M",
              help="Metres that a goal may take at most.")  # fmt: skip
@click.option("--limit-money", "money_usd", type=click.FloatRange(0, MOST["money_usd"]),
              metavar="USD", help="What a goal may cost in a cloud at most.")  # fmt: skip
@click.option("--limit-queue", "queue", type=click.IntRange(0, WAITING), default=4,
              show_default=True, metavar="N", help="Goals that may wait at most.")  # fmt: skip
@click.option("--area-room", metavar="ROOM", help="Only into rooms of that type, and to no place.")
@click.option("--area-place", metavar="PLACE", help="Only within 3 m of that place.")
@click.option("--look", is_flag=True, help="Clients may see what the camera sees.")
@service_options
def mcp_command(**given: Any) -> None:
    """Offer the robot to a language-model agent by the Model Context Protocol: goals, and what is
    known of the home. No velocities; what is set here, and the robot's own limits, no client can
    raise.

    A client starts it and speaks to it on stdin, or it listens on this computer (http).
    """
    check_packages("mcp", NEEDED, "agents")
    if given["transport"] == "stdio" and sys.stdin.isatty():
        raise ConfigError(
            "rfnav mcp: a client starts it and speaks to it on stdin (docs/agents.md); "
            "--transport http listens for one"
        )
    become(PROCESS, given)
