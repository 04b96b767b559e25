"""`rfnav view`: the operator's page, served by a process of its own."""

from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import click

from runtime.commands.running import running
from runtime.commands.status import LIVELY
from runtime.commands.status_screen import wrong
from runtime.config import Config, load
from runtime.errors import ConfigError
from runtime.robot.heard_topics import heard_topics
from runtime.tracing.budgets import read_budgets

if TYPE_CHECKING:  # of the extra `view`
    from runtime.view.live import LiveFeed

NEEDED = ("starlette", "uvicorn", "websockets")


@click.command(
    "view",
    epilog="Examples:  rfnav view   |   rfnav view --replay drives/rfnav-20261129-063438.mcap",
)
@click.option("--config", "path", type=click.Path(path_type=Path), help="The robot's TOML file.")
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
    help="Its first line is what people must show.",
)
def view_command(
    path: Path | None,
    settings: tuple[str, ...],
    listen: str,
    names: tuple[str, ...],
    replay: Path | None,
    certificate: Path | None,
    key: Path | None,
    token_file: Path | None,
) -> None:
    """Show what the robot sees, knows and does in a browser, and take goals, zones and a stop from
    there, until Ctrl-C.

    On this computer alone, unless it is given a certificate and a token. The service need not be
    up: the page says so, and goes on when it is.
    """
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise ConfigError(f"rfnav view: needs {', '.join(missing)}: pip install 'rf-nav[view]'")
    from runtime.view.access import access
    from runtime.view.feed import Feed
    from runtime.view.server import serve_page

    allowed = access(listen, certificate, key, token_file, names)
    config = load(path, settings)
    feed: Feed
    if replay is not None:
        from runtime.view.replay import ReplayFeed

        feed = ReplayFeed(replay, read_budgets())
    else:
        feed = _live(config)
    shown = f"[{allowed.host}]" if ":" in allowed.host else allowed.host
    serve_page(
        allowed, feed, lambda: click.echo(f"open {allowed.scheme}://{shown}:{allowed.port}/")
    )


def _live(config: Config) -> "LiveFeed":
    from runtime.view.live import LiveFeed, LiveParts

    topics = heard_topics(config.bus)
    needed = tuple(topics[name].name for name in LIVELY)
    parts = LiveParts(
        partial(running, config.bus), config, read_budgets(), lambda status: wrong(status, needed)
    )
    return LiveFeed(parts)
