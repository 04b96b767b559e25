"""`rfnav models`: fetch, check, list and judge models; import_commands.py has those of others."""

import json
from collections import Counter
from pathlib import Path
from typing import Any

import click
import cv2

from models.detection.domain import DomainSetting
from models.detection.fusion import DOMAINS
from models.errors import ModelFileError
from models.evaluation.report import markdown
from models.evaluation.truth import read_words
from models.store import manifest
from models.words.text_encoder import TextEncoder
from runtime.config import ModelsConfig
from runtime.errors import ConfigError
from runtime.perception.import_commands import add, import_model, try_model
from runtime.perception.model_errors import models_told
from runtime.perception.progress_bar import Bar
from runtime.perception.word_verdicts import by_default, word_verdicts

FILE = click.Path(path_type=Path)
TRAINED_FROM = ("backbone", "names")
"""Tasks of models that a robot has no need of."""


class ModelsGroup(click.Group):
    """Commands that open models: a fault of a model is one of the runtime's errors."""

    @models_told()
    def invoke(self, ctx: click.Context) -> Any:
        return super().invoke(ctx)


@click.group("models", cls=ModelsGroup)
def models_command() -> None:
    """Fetch, check, list, take in, try and judge the models the robot runs on."""


def _chosen(names: tuple[str, ...], everything: bool) -> list[manifest.Entry]:
    if names:
        return [manifest.entry(name) for name in names]
    return [
        e
        for e in manifest.load_manifest().values()
        if e.default or (everything and e.task in TRAINED_FROM)
    ]


@models_command.command(epilog="Examples:  rfnav models pull   |   rfnav models pull smollm2-135m")
@click.argument("names", nargs=-1)
@click.option("--all", "everything", is_flag=True, help="Also what only training needs.")
@click.option(
    "--accept-licence", default="", help="The licence's name, of one that is not permissive."
)
def pull(names: tuple[str, ...], everything: bool, accept_licence: str) -> None:
    """Fetch models into the cache; without NAMES, all that a robot needs."""
    for model in _chosen(names, everything):
        with Bar() as bar:
            path = manifest.fetch(model.name, bar, accepted=accept_licence)
        click.echo(f"{model.name}: {path}")


@models_command.command(epilog="Example:  rfnav models verify")
@click.argument("names", nargs=-1)
def verify(names: tuple[str, ...]) -> None:
    """Compare files with the manifest's checksums; exit status 1 if one is missing or damaged."""
    wrong = 0
    for model in _chosen(names, False):
        try:
            manifest.verify(model.name)
            click.echo(f"{model.name}: ok")
        except ModelFileError as error:
            wrong += 1
            click.echo(f"{model.name}: {error}")
    if wrong:
        raise SystemExit(1)


@models_command.command("list", epilog="Example:  rfnav models list")
def list_models() -> None:
    """Show every model of the manifest and whether it is here."""
    for model in manifest.load_manifest().values():
        try:
            state = str(manifest.locate(model.name))
        except ModelFileError:
            state = "not here or damaged"
        size = f"{model.size / 1e6:.1f} MB" if model.size else "size ?"
        click.echo(f"{model.name:20} {model.task:12} {size:>9}  {model.licence:11} {state}")


@models_command.command(epilog="Example:  rfnav models evaluate --data frames/val --dev frames/dev")
@click.option("--data", type=FILE, required=True, help="Frames to judge on.")
@click.option("--dev", type=FILE, help="Frames to fit calibration and threshold on.")
@click.option(
    "--detector",
    "detectors",
    multiple=True,
    help="A model's name or an ONNX file; several are judged as one. Default: the project's.",
)
@click.option("--second-look", type=FILE, help="Its classifier; default: the project's.")
@click.option(
    "--domain",
    type=click.Choice(["auto", *DOMAINS]),
    default="auto",
    show_default=True,
    help="Of the frames, for several detectors.",
)
@click.option("--limit", type=click.IntRange(1), help="Only as many frames of each directory.")
@click.option("--threads", default=2, show_default=True)
@click.option("--cost/--no-cost", default=True, show_default=True, help="Time it, too.")
@click.option("--synonyms/--no-synonyms", default=True, show_default=True)
@click.option("--sheet", type=FILE, help="Draw detections of some frames here (PNG), and no more.")
@click.option("--json", "json_file", type=FILE, help="Write the figures here.")
def evaluate(
    data: Path, dev: Path | None, detectors: tuple[str, ...], second_look: Path | None,
    domain: DomainSetting, limit: int | None, threads: int, cost: bool, synonyms: bool,
    sheet: Path | None, json_file: Path | None,
) -> None:  # fmt: skip
    """Measure detectors on labelled frames, asked as the runtime asks them."""
    try:  # a robot has no need of what judges models
        from runtime.perception import evaluation
    except ModuleNotFoundError as error:
        package = str(error.name).partition(".")[0]
        raise ConfigError(
            f"models evaluate: {package} is not installed; it comes with the extra `train`"
        ) from error
    cv2.setNumThreads(1)
    encoder = TextEncoder(manifest.fetch("minilm"))
    detectors = detectors or ModelsConfig().detectors
    if sheet is not None:
        evaluation.contact_sheet(detectors, data, sheet, encoder, limit=limit, threads=threads)
        click.echo(f"{sheet}: detections of {', '.join(Path(n).name for n in detectors)} on {data}")
        return
    looks = second_look or manifest.fetch("second-look")
    report = evaluation.evaluate(
        detectors, looks, data, dev, encoder,
        limit=limit, threads=threads, cost=cost, synonyms=synonyms, domain=domain,
    )  # fmt: skip
    click.echo(markdown(report))
    if json_file:
        json_file.write_text(json.dumps(report, indent=1, sort_keys=True) + "\n")


@models_command.command(epilog="Example:  rfnav models words --asked")
@click.option("--names", is_flag=True, help="By the names of training alone, not the word list.")
@click.option("--senses/--no-senses", default=True, show_default=True, help="With WordNet.")
@click.option("--listed/--not-listed", default=True, show_default=True, help="With more names.")
@click.option("--asked", is_flag=True, help="Names of models/evaluation/asked.toml.")
def words(names: bool, senses: bool, listed: bool, asked: bool) -> None:
    """Print at which class each name that training never saw ends."""
    encoder, lists = TextEncoder(manifest.fetch("minilm")), read_words()
    classes = tuple(lists.trained.values()) if names else None
    understood = by_default(encoder, classes, senses, listed)
    rows = word_verdicts(lists, understood, lists.asked if asked else lists.unseen)
    for row in sorted(rows, key=lambda row: row.verdict):
        click.echo(f"{row.verdict:36} {row.category:18} {row.how}")
    for verdict, count in Counter(row.verdict for row in rows).most_common():
        click.echo(f"{count:4} of {len(rows)}: {verdict}")


for command in (import_model, add, try_model):
    models_command.add_command(command)
