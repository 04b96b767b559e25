"""What one process of a training does. Apart from the command, for processes import it by name."""

from collections.abc import Sequence
from pathlib import Path

import click
import cv2
import torch

from models.store import manifest
from models.train.labelled import Portion
from models.train.team import Team
from models.train.trainer import Recipe, train
from models.words.text_encoder import TextEncoder


def take_part(
    data: Sequence[Portion], out: Path, recipe: Recipe, start: Path | None, team: Team
) -> None:
    """Train on one core, as a member of a team; its leader says how it goes."""
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    backbone = torch.load(
        manifest.fetch("efficientnet-lite0"), map_location="cpu", weights_only=True
    )
    encoder = TextEncoder(manifest.fetch("minilm"))
    say = click.echo if team.leads else _nothing
    train(data, out, backbone, encoder.embed, recipe, say, start, team)


def _nothing(_: str) -> None:
    """What the others say."""
