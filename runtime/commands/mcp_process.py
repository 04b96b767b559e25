"""The process of `rfnav mcp`, which loads what agents need and no more."""

import json
import logging
import os
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import anyio
import click
import cv2

from runtime.agents.robot import AgentParts, AgentRobot
from runtime.agents.server import AgentServer
from runtime.agents.stdio import serve_stdio
from runtime.agents.tools import AgentLimits
from runtime.commands.map_picture import picture
from runtime.commands.running import running
from runtime.config import load
from runtime.errors import ConfigError, RfNavError
from runtime.private_files import keep_to_owner

NICE = 10  # the robot's own work goes before it


@dataclass(frozen=True)
class McpOptions:
    """As `rfnav mcp` has them; files by their names."""

    transport: str = "stdio"
    listen: str = "127.0.0.1:8090"
    token_file: str | None = None
    time_s: float = AgentLimits.time_s
    distance_m: float = AgentLimits.distance_m
    money_usd: float | None = None
    area_room: str | None = None
    area_place: str | None = None
    look: bool = False
    queue: int = AgentLimits.queue
    path: str | None = None
    settings: Sequence[str] = ()


def serve_agents(options: McpOptions) -> None:
    """Until the client hangs up, SIGTERM or Ctrl-C. RfNavError, one line, for what cannot be
    served."""
    cv2.setNumThreads(1)
    logging.getLogger("mcp").setLevel(logging.ERROR)  # what clients do wrong is told to them
    limits = agent_limits(options)
    config = load(Path(options.path) if options.path is not None else None, options.settings)
    robot = AgentRobot(AgentParts(partial(running, config.bus), config.bus, picture, limits))
    server = AgentServer(robot, limits).server(_version())
    try:
        if options.transport == "stdio":
            anyio.run(serve_stdio, server)
        else:
            _serve_http(server, options)
    finally:
        robot.close()


def agent_limits(options: McpOptions) -> AgentLimits:
    """ConfigError for two areas."""
    area = {"room": options.area_room, "place": options.area_place}
    named = {kind: name for kind, name in area.items() if name}
    if len(named) > 1:
        raise ConfigError("--area-room and --area-place: give one of them")
    amounts = options.time_s, options.distance_m, options.money_usd
    return AgentLimits(*amounts, named, options.look, options.queue)


def _version() -> str:
    try:
        return version("rf-nav")
    except PackageNotFoundError:  # a checkout that is not installed
        return ""


def _serve_http(server: Any, options: McpOptions) -> None:
    from runtime.agents.http import PATH, agent_access, serve_http

    token = Path(options.token_file) if options.token_file is not None else None
    allowed = agent_access(options.listen, token)
    shown = f"[{allowed.host}]" if ":" in allowed.host else allowed.host
    told = f"clients connect to http://{shown}:{allowed.port}{PATH}   (Ctrl-C ends it)"
    serve_http(server, allowed, partial(click.echo, told))


def main() -> None:
    """The options come as JSON, of `rfnav mcp`."""
    keep_to_owner()
    with suppress(OSError):
        os.nice(NICE)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        serve_agents(McpOptions(**json.loads(sys.argv[1])))
    except KeyboardInterrupt:
        sys.exit(0)
    except RfNavError as error:
        click.echo(f"rfnav: {error}", err=True)
        sys.exit(2)


if __name__ == "__main__":
    main()
