"""`rfnav config`: every key, its value, its unit and what it means, as TOML."""

import json
import math
import textwrap
from pathlib import Path

import click

from runtime.config import Config, known_keys, load
from runtime.core.keys import RESEARCH, Key

WIDTH = 100
HEADS = {
    "robot": "Keys of the robot and what it runs on. A file needs only those that differ.",
    RESEARCH: "Research: what methods and questions are compared by. No robot needs any of it, and "
    "its keys may come and go.",
}


@click.command(
    "config", epilog="Examples:  rfnav config --defaults   |   rfnav config --config robot.toml"
)
@click.option("--defaults", is_flag=True, help="Every key as it is when nothing sets it.")
@click.option(
    "--config", "path", type=click.Path(path_type=Path), help="Every key as this file has it."
)
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="Override one key.")
def config_command(defaults: bool, path: Path | None, settings: tuple[str, ...]) -> None:
    """Print the configuration: a TOML file with every key, its unit and what it means."""
    if defaults and (path or settings):
        raise click.UsageError("--defaults goes without --config and --set.")
    if not (defaults or path or settings):
        raise click.UsageError("Say --defaults, or --config FILE.")
    click.echo(as_toml(load(path, settings)), nl=False)


def as_toml(config: Config) -> str:
    """All keys of a configuration by table, each under its sentence; what `load` reads again."""
    lines: list[str] = []
    table = ""
    for key in known_keys().values():
        if key.table != table:
            table = key.table
            lines += ["", *_comment(HEADS[table]), ""] if table in HEADS else [""]
            lines.append(f"[{table}]")
        lines += [*sentence(key), line(key, config)]
    return "\n".join(lines[1:]) + "\n"


def sentence(key: Key) -> list[str]:
    """What a key means, and its unit, as lines of comment."""
    return _comment(f"{key.meaning} [{key.unit}]" if key.unit else key.meaning)


def line(key: Key, config: Config) -> str:
    """A key and its value."""
    return f"{key.name.removeprefix(key.table + '.')} = {value(key.value(config))}"


def value(found: object) -> str:
    """A value as TOML has it."""
    if isinstance(found, tuple):
        return f"[{', '.join(value(item) for item in found)}]"
    if isinstance(found, float) and math.isinf(found):
        return "inf" if found > 0 else "-inf"
    return json.dumps(found, ensure_ascii=False)


def _comment(text: str) -> list[str]:
    return [f"# {part}" for part in textwrap.wrap(text, WIDTH - 2)]
