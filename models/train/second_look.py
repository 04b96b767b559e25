"""`python -m models.train.second_look --dev FRAMES`: makes the classifier of second looks from the
ImageNet weights that the detector was trained from. Nothing of the network is trained. What its
classes look like in the mean comes from all places of the frames, whatever they show; what evidence
is worth from trained categories, each as if the detector had no word for it, that are as rare as
what one is asked for once."""

import ast
import base64
import json
import os
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path

import click
import numpy as np
import onnx
import torch
from torch import Tensor, nn
from torch.nn import functional as F

from models.checksum import sha256
from models.detection.detector import OpenDetector, open_detector
from models.detection.second_look import FITTED, FORMAT, LOOKS, SecondLook
from models.errors import ModelFileError, told
from models.evaluation.judged import fit_odds, verdicts
from models.evaluation.sightings import Places, Sightings, look_at_all, sightings
from models.evaluation.truth import FrameTruth, NameLists, read_truth, read_words
from models.store import manifest
from models.train.export import OPSET
from models.train.graph import constants, halve, simplified, write_metadata
from models.train.network import Backbone, SameConv, fold
from models.words.text_encoder import TextEncoder

SIZE = 224
MEAN, DEVIATION = 127.0, 128.0
"""Of the classifier's input, as it was trained."""
CHOICES = {"margin": 1.15, "alike": 0.5, "spread": 0.05}
RARE = (3, 25)
"""So many objects in the frames, of 1,000, have the categories that evidence is fitted on."""
LIST = "_IMAGENET_CATEGORIES"


class Classifier(nn.Module):
    """EfficientNet-Lite0 whole, as published."""

    def __init__(self, state: dict[str, Tensor]) -> None:
        super().__init__()
        self.backbone, self.head = Backbone(), SameConv(320, 1280, 1)
        self.backbone.load_imagenet(state)
        fold(self.head, state, "_conv_head", "_bn1")
        self.answer = nn.Linear(1280, len(state["_fc.bias"]))
        self.answer.load_state_dict({"weight": state["_fc.weight"], "bias": state["_fc.bias"]})

    def forward(self, crops: Tensor) -> Tensor:
        """(N, 3, 224, 224) RGB 0..255 -> (N, 1000)."""
        top = self.backbone((crops - MEAN) / DEVIATION)[-1]
        pooled: Tensor = F.relu6(self.head(top)).mean((2, 3))
        logits: Tensor = self.answer(pooled)
        return logits


def read_names(path: Path) -> tuple[str, ...]:
    """The 1,000 names in a module's list; the module is read, not run."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == LIST:
            return tuple(ast.literal_eval(node.value))
    raise ModelFileError(f"{path}: holds no {LIST}")


def build(out: Path, weights: Path, names: tuple[str, ...]) -> None:
    """Write the classifier, not calibrated."""
    network = Classifier(torch.load(weights, map_location="cpu", weights_only=True)).eval()
    out.parent.mkdir(parents=True, exist_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        torch.onnx.export(
            network, (torch.zeros(1, 3, SIZE, SIZE),), str(out), input_names=["crops"],
            output_names=["logits"], opset_version=OPSET, dynamo=False,
            dynamic_axes={"crops": {0: "n"}, "logits": {0: "n"}},
        )  # fmt: skip
    model = simplified(out)
    halve(model)
    onnx.save(model, str(out))
    table = {"format": FORMAT, "names": json.dumps(names), "usual": json.dumps([1] * len(names))}
    write_metadata(out, table | _values(CHOICES | dict.fromkeys(FITTED, 1.0)))


def _values(values: Mapping[str, float]) -> dict[str, str]:
    return constants({key: round(value, 6) for key, value in values.items()})


def rows(names: Sequence[str], encoder: TextEncoder) -> str:
    """The names' embeddings, as the file holds them."""
    return base64.b64encode(encoder.embed(names).astype(np.float16).tobytes()).decode()


def usual(looked: Sequence[Places]) -> list[float]:
    """The mean probability of each class over all places."""
    mean = np.concatenate([part.classes for part in looked]).astype(np.float64).mean(axis=0)
    return [float(f"{value:.4g}") for value in mean]


def rarely_seen(truth: FrameTruth, words: NameLists) -> tuple[str, ...]:
    """The trained categories of which the frames have few objects that count."""
    kinds = np.concatenate([marks.kinds[~marks.crowd] for marks in truth.marks])
    count = np.bincount(kinds, minlength=len(truth.categories)) * 1000 / len(truth.marks)
    return tuple(
        name
        for name, objects in zip(truth.categories, count, strict=True)
        if name in words.trained and RARE[0] <= objects <= RARE[1]
    )


def fit(told: Sequence[Sightings], truth: FrameTruth, second: SecondLook) -> dict[str, float]:
    """What evidence is worth: the log odds of being right."""
    evidence, right = [], []
    for part, marks in zip(told, truth.marks, strict=True):
        seen, order = part.scored(second)
        rows = np.stack(part.evidence, axis=1)[order]
        for row, verdict in zip(rows, verdicts(seen, marks), strict=True):
            if verdict is not None:
                evidence.append(row)
                right.append(verdict)
    start = np.array([1.0, 1.0, 1.0, 0.0])
    weights = fit_odds(np.array(evidence, np.float64), np.array(right, bool), start)
    return dict(zip(FITTED, weights.tolist(), strict=True))


@click.command(epilog="Example:  python -m models.train.second_look --dev frames/dev")
@click.option("--dev", type=click.Path(path_type=Path), required=True, help="Frames to fit on.")
@click.option(
    "--out", type=click.Path(path_type=Path), default=Path("models/weights/second-look.onnx")
)
@click.option("--detector", "path", type=click.Path(path_type=Path), help="Default: the project's.")
@click.option("--threads", default=2, show_default=True)
def main(dev: Path, out: Path, path: Path | None, threads: int) -> None:
    """Make the classifier of second looks."""
    truth, words = read_truth(dev), read_words()
    rare = rarely_seen(truth, words)
    if not rare:
        raise ModelFileError(
            f"{dev}: no trained category has {RARE[0]} to {RARE[1]} objects in 1,000 "
            "frames; evidence is fitted on such: give more frames"
        )
    encoder, names = (
        TextEncoder(manifest.fetch("minilm")),
        read_names(manifest.fetch("imagenet-names")),
    )
    detector = open_detector(path or manifest.fetch("rfnav-det"), "rfnav", encoder, threads)
    assert isinstance(detector, OpenDetector)
    partial = out.with_suffix(".partial.onnx")
    build(partial, manifest.fetch("efficientnet-lite0"), names)
    write_metadata(partial, {"rows": rows(names, encoder)})
    looked = look_at_all(detector, SecondLook(partial, encoder, threads), truth, words)
    write_metadata(partial, {"usual": json.dumps(usual(looked))})
    second = SecondLook(partial, encoder, threads)
    asked = {name: [name] for name in rare}
    fitted = fit(sightings(looked, second, truth, words, asked, LOOKS), truth, second)
    write_metadata(partial, _values(fitted))
    os.replace(partial, out)
    digest = sha256(out)
    worth = ", ".join(f"{key} {value:.2f}" for key, value in fitted.items())
    click.echo(
        f"{out}: {worth}, fitted on {', '.join(rare)}; {out.stat().st_size} bytes, sha256 {digest}"
    )


if __name__ == "__main__":
    told(main)
