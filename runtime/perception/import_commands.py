"""`rfnav models import` and `add`: detectors of others; `try`: any model that sees or votes."""

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import click

from models.detection.detections import RawDetections
from models.detection.imported import Offer, describe, take_in
from models.detection.layouts import LAYOUTS
from models.detection.told import NORMALISE
from models.detection.trial import RENDERS, Limits, TrialReport, read_picture, tried
from models.errors import ModelFileError
from models.evaluation.sheet import draw_pictures
from models.evaluation.truth import HM3D, ROBOTHOR
from models.store import manifest
from models.words.class_maps import BUILT_IN
from models.words.vocabulary import load_vocabulary
from runtime.config import ModelsConfig
from runtime.perception.detection import MIN_SCORE
from runtime.perception.experts_trial import Voter
from runtime.perception.progress_bar import Bar

FILE = click.Path(path_type=Path)
GOALS = {"HM3D's goals": HM3D, "RoboTHOR's goals": ROBOTHOR}
Command = Callable[..., None]


def _limited(command: Command) -> Command:
    """With options for what a trial may take, given as `limits`."""
    default = Limits()
    for option, kind, usual, about in (
        ("--limit-s", click.FloatRange(1), default.seconds, "Seconds that its trial may take."),
        ("--limit-mb", click.IntRange(100), default.memory_mb, "MB that its trial may take."),
    ):
        told = click.option(option, type=kind, default=usual, show_default=True, help=about)
        command = told(command)
    return command


def _described(command: Command) -> Command:
    """With options for what a file does not say itself, as `Offer` has them."""
    for option, kind, about in (
        ("--normalise", click.Choice(list(NORMALISE)), "What its images are scaled by."),
        ("--layout", click.Choice(LAYOUTS), "Of its outputs, where their shapes do not tell."),
        (
            "--texts",
            str,
            "Embedded names (.npz) or text tower (.onnx, tokenizer.json beside it) of a prompted "
            "one.",
        ),
        (
            "--classes",
            str,
            f"Names of its list: a file with one a line, a map (.toml), or {', '.join(BUILT_IN)}.",
        ),
    ):
        command = click.option(option, type=kind, help=about)(command)
    return command


@click.command(
    "import",
    epilog="Examples:  rfnav models import yolov8n.onnx --as yolo   |   "
    "rfnav models import world.onnx --as world --texts clip/text.onnx",
)
@click.argument("file")
@click.option("--as", "name", required=True, help="Name it goes by from now on.")
@_described
@_limited
def import_model(file: str, name: str, limit_s: float, limit_mb: int, **told: str | None) -> None:
    """Take in an ONNX detector of a known contract: ours, prompted (images and texts in), or one
    with a fixed class list (of YOLO's, DETR's or NanoDet's kind). It is tried before it is kept."""
    _take_in(Offer(file, name, **_said(told)), Limits(limit_s, limit_mb))


@click.command(
    epilog="Example:  rfnav models add https://example.org/yolox_nano.onnx --classes coco "
    "--licence Apache-2.0"
)
@click.argument("url")
@click.option("--as", "name", default="", help="Name it goes by; default: the file's.")
@click.option("--licence", default=manifest.UNKNOWN, show_default=True, help="Its SPDX name.")
@click.option(
    "--accept-licence", default="", help="The licence's name, of one that is not permissive."
)
@_described
@_limited
def add(
    url: str, name: str, licence: str, accept_licence: str, limit_s: float, limit_mb: int,
    **told: str | None,
) -> None:  # fmt: skip
    """Fetch a detector, and take it in as `import` does. What arrives now is what its name stands
    for: anything else is refused later."""
    name = name or Path(unquote(urlsplit(url).path)).stem.lower()
    manifest.check_licence(name, licence, accept_licence, f"rfnav models add {url} …")
    _take_in(Offer(url, name, licence=licence, **_said(told)), Limits(limit_s, limit_mb))


@click.command(
    "try",
    epilog="Examples:  rfnav models try nanodet-g kitchen.jpg bath.png --sheet seen.png   |   "
    "rfnav models try smolvlm2-500m   |   rfnav models try experts",
)
@click.argument("name")
@click.argument("pictures", nargs=-1, type=FILE)
@click.option("--sheet", type=FILE, help="Draw what a detector sees here (PNG).")
@click.option("--projector", default="", help="The mmproj GGUF of a model that sees, a file.")
@click.option("--handler", default="", help="How llama-cpp-python talks to that.")
@click.option(
    "--threads", type=click.IntRange(1, 64), default=ModelsConfig().threads, show_default=True,
    help="Of a model that votes.",
)  # fmt: skip
@_limited
def try_model(
    name: str, pictures: tuple[Path, ...], sheet: Path | None, projector: str, handler: str,
    threads: int, limit_s: float, limit_mb: int,
) -> None:  # fmt: skip
    """Show what a model (a name, or a file) does with three renderings that come along and with
    PICTURES. A detector: what it sees in them, what a frame costs, and which goals it can serve. A
    language model or one that sees, or `experts`, all that vote by default: what they vote for, how
    long a vote takes on this machine, and which budget that needs."""
    manifest.fetch("minilm")
    shown = (*RENDERS, *pictures)
    voter = Voter.named(name, projector, handler, threads)
    if voter is None:
        _try_detector(name, shown, sheet, Limits(limit_s, limit_mb))
    elif sheet is not None:
        raise ModelFileError(f"{name}: votes, and finds no boxes; leave out --sheet")
    else:
        for line in voter.tried(shown):
            click.echo(line)


def _try_detector(name: str, shown: tuple[Path, ...], sheet: Path | None, limits: Limits) -> None:
    found = tried(manifest.located(name), limits, shown)
    click.echo(f"{name}:")
    for line in _goals(found.capabilities):
        click.echo(f"  {line}")
    _tell(found)
    classes = [names[0] for names in load_vocabulary().objects]
    for path, seen in zip(shown, found.seen, strict=True):
        click.echo(f"{path.name}: {_listed(seen, classes)}")
    if sheet is not None:
        draw_pictures([(p.name, read_picture(p)) for p in shown], found.seen, classes, sheet)
        click.echo(f"{sheet}: what {name} sees")


def _goals(capabilities: dict[str, Any]) -> list[str]:
    """What of two benchmarks' goals a detector can find, and by what."""
    lines = []
    for title, goals in GOALS.items():
        by = {goal: capabilities["matched"].get(goal, ()) for goal in goals}
        served = [g for g in goals if g not in capabilities["unseen"]]
        told = [f"{g} (by {', '.join(by[g])})" if set(by[g]) - {g} else g for g in served]
        lines.append(f"{title}: {len(served)} of {len(goals)}: {', '.join(told) or 'none'}")
        if missing := [g for g in goals if g not in served]:
            lines.append(f"  not seen: {', '.join(missing)}")
    return lines


def _listed(seen: RawDetections, classes: Sequence[str]) -> str:
    """What is seen surely enough for the robot, the surest first; of a class, how often."""
    sure = [int(k) for k in seen.labels[seen.scores >= MIN_SCORE]]
    often = Counter(sure)
    best = {label: seen.scores[seen.labels == label].max() for label in often}
    told = []
    for label in sorted(often, key=lambda label: -best[label]):
        more = f" (and {often[label] - 1} more)" if often[label] > 1 else ""
        told.append(f"{classes[label]} {best[label]:.2f}{more}")
    return ", ".join(told) or "nothing"


def _said(told: dict[str, str | None]) -> dict[str, str]:
    return {option: value for option, value in told.items() if value is not None}


def _take_in(offer: Offer, limits: Limits) -> None:
    manifest.fetch("minilm")
    with Bar() as bar:
        found = take_in(offer, limits, bar)
    click.echo(f"{offer.name}: {found.path}")
    for url, digest in found.pinned.items():
        click.echo(f"  {url}")
        click.echo(f"    pinned to sha256 {digest}: whatever else comes from there is refused")
    _tell(found.trial)
    click.echo(f'use it with models.detectors = ["{offer.name}"]')


def _tell(trial: TrialReport) -> None:
    for line in describe(trial.capabilities):
        click.echo(f"  {line}")
    click.echo(
        f"  a 640x480 frame: {trial.frame_ms:.0f} ms on one thread; memory: {trial.memory_mb:.0f} "
        "MB"
    )
