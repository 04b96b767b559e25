"""`rfnav understand`: what a goal would be looked for as, and why."""

import json
import sys
from pathlib import Path

import click

from models.store import manifest
from models.words.text_encoder import TextEncoder
from models.words.vocabulary import load_vocabulary
from runtime.config import Config, load
from runtime.errors import ConfigError
from runtime.perception.heard_goal import Heard, hear, with_labels, words_of
from runtime.perception.loaded_models import TEXT_MODEL
from runtime.perception.model_errors import models_told


@click.command("understand", epilog='Example:  rfnav understand "the mug on the kitchen table"')
@click.argument("text")
@click.option("--config", "path", type=click.Path(path_type=Path), help="The robot's TOML file.")
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="Override one key.")
@click.option("--json", "as_json", is_flag=True, help="As one JSON object.")
def understand_command(
    text: str, path: Path | None, settings: tuple[str, ...], as_json: bool
) -> None:
    """Print what a goal would be looked for as, and why; exit status 1 when it would be refused."""
    config = load(path, settings)
    try:
        heard = _heard(text, config)
    except ConfigError as error:
        click.echo(json.dumps({"goal": text, "refused": str(error)}) if as_json else str(error))
        sys.exit(1)
    click.echo(json.dumps(told(heard), ensure_ascii=False) if as_json else heard.goal.how)


@models_told()
def _heard(text: str, config: Config) -> Heard:
    """As the runtime hears it under this configuration."""
    vocabulary = config.models.vocabulary
    words = words_of(load_vocabulary(Path(vocabulary)) if vocabulary else load_vocabulary())
    encoder = TextEncoder(manifest.fetch(TEXT_MODEL), config.models.threads)
    return hear(text, with_labels(words, config.detector.labels), encoder.embed)


def told(heard: Heard) -> dict[str, object]:
    """As JSON: the class that counts as found, all its names, where it is looked for first, and
    what else was said beside it, none of which the search uses."""
    phrase = heard.left
    return {
        "goal": heard.goal.text,
        "name": heard.goal.name,
        "names": heard.goal.names,
        "how": heard.goal.how,
        "own_class": heard.goal.strange,
        "first": {"near": heard.goal.near, "rooms": heard.goal.rooms},
        "not_used": {
            "near": phrase.near,
            "rooms": phrase.rooms,
            "traits": phrase.traits,
            "unlike": phrase.unlike,
            "other": phrase.other,
        },
    }
