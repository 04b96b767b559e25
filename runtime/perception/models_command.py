"""`rfnav models`: fetch, check, list and import models."""

from pathlib import Path
from typing import Any

import click
from tqdm import tqdm

from models.detection.imported import describe, import_detector
from models.errors import ModelFileError
from models.store import manifest
from models.words.text_encoder import TextEncoder


@click.group("models")
def models_command() -> None:
    """Fetch, check, list and import the models the robot runs on."""


def _chosen(names: tuple[str, ...], everything: bool) -> list[manifest.Entry]:
    if names:
        return [manifest.entry(name) for name in names]
    return [e for e in manifest.load_manifest().values() if everything or e.default]


@models_command.command(epilog="Examples:  rfnav models pull   |   rfnav models pull smollm2-135m")
@click.argument("names", nargs=-1)
@click.option("--all", "everything", is_flag=True, help="Also what only training needs.")
def pull(names: tuple[str, ...], everything: bool) -> None:
    """Fetch models into the cache; without NAMES, all that a robot needs."""
    for model in _chosen(names, everything):
        with _Bar() as bar:
            path = manifest.fetch(model.name, bar)
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
        size = f"{model.size / 1e6:.1f} MB"
        click.echo(f"{model.name:20} {model.task:9} {size:>9}  {model.licence:11} {state}")


@models_command.command(
    "import",
    epilog="Examples:  rfnav models import yolov8n.onnx --as yolo   |   "
    "rfnav models import world.onnx --as world --texts clip/text.onnx",
)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--as", "name", required=True, help="Name it goes by from now on.")
@click.option("--classes", type=click.Path(path_type=Path), help="Names of its list, one a line.")
@click.option(
    "--texts",
    type=click.Path(path_type=Path),
    help="Embedded names (.npz) or text tower (.onnx, tokenizer.json beside it) of a prompted one.",
)
def import_model(file: Path, name: str, classes: Path | None, texts: Path | None) -> None:
    """Take in an ONNX detector of a known contract: ours, prompted (images and texts in), or YOLO
    with a fixed class list (v5, v8 and X layouts). It is tried before it is kept."""
    encoder = TextEncoder(manifest.fetch("minilm"))
    found = import_detector(file, name, encoder, classes, texts)
    click.echo(f"{name}: {found.path}")
    for line in describe(found.capabilities):
        click.echo(f"  {line}")
    click.echo(f"  a 640x480 frame: {found.frame_ms:.0f} ms on one thread")
    click.echo(f'use it with models.detector = "{name}"')


class _Bar:
    """A tqdm bar (on a terminal only) that follows the store's progress reports."""

    def __init__(self) -> None:
        self._bar: Any = None
        self._what = ""

    def __enter__(self) -> "_Bar":
        return self

    def __exit__(self, *_: object) -> None:
        self._close()

    def __call__(self, what: str, done: int, total: int) -> None:
        if what != self._what:
            self._close()
            self._bar = tqdm(desc=what, unit="B", unit_scale=True, disable=None, leave=False)
            self._what = what
        self._bar.total = max(total, done) or None
        self._bar.update(done - self._bar.n)

    def _close(self) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar, self._what = None, ""
