"""Options that all commands have in common that ask the running service."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from runtime.commands.running import Running, running
from runtime.config import load
from runtime.errors import BusError

Command = TypeVar("Command", bound=Callable[..., Any])


def service_options(command: Command) -> Command:
    """`path` and `settings`: whom to ask."""
    for option in (
        click.option("--set", "settings", multiple=True, metavar="KEY=VALUE",
                     help="Override one key."),
        click.option("--config", "path", type=click.Path(path_type=Path),
                     help="The robot's TOML file."),
    ):  # fmt: skip
        command = option(command)
    return command


def json_option(command: Command) -> Command:
    """`as_json`: for programs."""
    return click.option("--json", "as_json", is_flag=True, help="The answer, as JSON.")(command)


def asked(
    path: Path | None, settings: tuple[str, ...], kind: str, body: dict[str, object]
) -> dict[str, Any]:
    """What the service answers; BusError, one line, where it refuses or nobody answers."""
    with running(load(path, settings).bus) as runtime:
        return taken(runtime, kind, body)


def taken(runtime: Running, kind: str, body: dict[str, object]) -> dict[str, Any]:
    """The same of a service that was found already."""
    answer = runtime.ask(kind, body)
    if answer.get("accepted") is False:
        raise BusError(str(answer.get("error") or "it was refused"))
    return answer
