"""`python -m runtime.bench.agents`: what `rfnav mcp` costs beside a search, where its client
waits for its end, with progress every second, and where it asks for all that there is."""

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Final

import click

from runtime.bench import synthetic
from runtime.bench.beside import ServerCost, served
from runtime.bench.measure import Subject, free_port, measured
from runtime.config import load

GOAL: Final = "toilet"
DOES: Final = ("waits", "floods")


@contextmanager
def agent_beside(does: str, costs: list[ServerCost], endpoint: str) -> Iterator[None]:
    """A client that does this, of the runtime on that bus; what its server cost in the end."""
    address = f"127.0.0.1:{free_port()}"
    bus = [f'bus.connect=["{endpoint}"]', 'bus.mode="client"']
    options = json.dumps({"transport": "http", "listen": address, "look": True, "settings": bus})
    server = [sys.executable, "-m", "runtime.commands.mcp_process", options]
    client = [sys.executable, "-m", "runtime.bench.agent_client", f"http://{address}/mcp", does]
    with served(server, client, costs):
        yield


@click.command("agents")
@click.option("--seconds", type=click.FloatRange(5.0), default=60.0, show_default=True)
def agents_command(seconds: float) -> None:
    """Print what the server took of a core and of memory, for each."""
    config = load(None)
    for does in DOES:
        costs = list[ServerCost]()
        drive = synthetic.drive(seconds, config.bus.topics, config.camera)
        measured(
            Subject(), (GOAL,), drive, config.bus.topics, config.realtime.control_hz,
            partial(agent_beside, does, costs),
        )  # fmt: skip
        (cost,) = costs
        click.echo(f"{does:>8}: {100 * cost.share:.1f} % of a core, {cost.memory_mb:.0f} MB")


if __name__ == "__main__":
    agents_command()
