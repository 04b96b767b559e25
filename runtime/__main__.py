"""`rfnav`: the robot's command line."""

import os
import sys
from importlib import import_module
from typing import Final

import click

from runtime.errors import InternalError, RfNavError
from runtime.log import say
from runtime.loops.loading import LoadingEndedError, leave
from runtime.private_files import keep_to_owner

COMMANDS: Final = {
    "runtime.run": ("run",),
    "runtime.commands.bench": ("bench",),
    "runtime.commands.calibrate": ("calibrate",),
    "runtime.commands.check": ("check",),
    "runtime.commands.cloud": ("cloud",),
    "runtime.commands.config": ("config",),
    "runtime.commands.doctor": ("doctor",),
    "runtime.commands.find": ("find", "go"),
    "runtime.commands.goal_control": ("cancel", "pause", "resume", "ask"),
    "runtime.commands.guard": ("guard",),
    "runtime.commands.home": ("places", "place", "zone"),
    "runtime.commands.known": ("where", "things", "map"),
    "runtime.commands.mcp": ("mcp",),
    "runtime.commands.mqtt": ("mqtt",),
    "runtime.commands.replay": ("replay",),
    "runtime.commands.status": ("status",),
    "runtime.commands.view": ("view",),
    "runtime.commands.why": ("why",),
    "runtime.perception.models_command": ("models",),
    "runtime.perception.understand_command": ("understand",),
}
"""By module: NAME is its NAME_command."""
MODULES: Final = {name: module for module, names in COMMANDS.items() for name in names}


class Lazily(click.Group):
    """Of COMMANDS, each imported when it is asked for: who asks a service needs no models."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted(MODULES)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in MODULES:
            return None
        command = getattr(import_module(MODULES[cmd_name]), f"{cmd_name}_command")
        assert isinstance(command, click.Command)
        return command


@click.group(cls=Lazily, epilog="Exit status: 0 done, 1 the thing attempted failed, 2 an error.")
def cli() -> None:
    """RF-NAV: finds things with a robot."""


def main() -> None:
    """Run the command line; every foreseeable error is one line and exit status 2."""
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")
    keep_to_owner()
    try:
        cli(prog_name="rfnav", standalone_mode=False)
    except click.UsageError as error:
        error.show()
        sys.exit(2)
    except InternalError as error:
        click.echo(f"rfnav: {error}", err=True)
        sys.exit(1)
    except LoadingEndedError as error:
        say(str(error))
        leave(error.status)
    except RfNavError as error:
        click.echo(f"rfnav: {error}", err=True)
        sys.exit(2)
    except click.exceptions.Abort:
        sys.exit(130)


if __name__ == "__main__":
    main()
