"""`rfnav guard`: the watchdog of `rfnav run`, for who starts it by itself."""

import os
import sys

import click

from runtime import guard

ANY = {"ignore_unknown_options": True, "help_option_names": []}


@click.command("guard", context_settings=ANY, short_help="The watchdog of a control loop.")
@click.argument("words", nargs=-1, type=click.UNPROCESSED)
def guard_command(words: tuple[str, ...]) -> None:
    """Command zero when the control loop of `rfnav run --guard PATH` gives no sign any more."""
    # In place of this process: what was imported to come here does not stay in memory.
    os.execv(sys.executable, [sys.executable, "-m", guard.__name__, *words])
