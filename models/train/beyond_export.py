"""`python -m models.train.beyond_export`: a run of models.train.beyond as one ONNX file, and the
detector's file with its compaction. Weights are in half precision, computing is in single; what
torch and onnxruntime make of the same sights must agree."""

import json
import os
import warnings
from pathlib import Path

import click
import numpy as np
import onnx
import torch
from torch import Tensor, nn

from models.checksum import sha256
from models.errors import ModelFileError, told
from models.language.scene_layout import FORMAT, INPUTS, OUTPUTS, SILENT, TEMPLATES, SceneLayout
from models.store import manifest
from models.train.beyond import COMPACTION, LANGUAGE, encoder
from models.train.beyond_data import Homes, read_homes
from models.train.beyond_head import answers, fit_gain, pictures, plain_head
from models.train.beyond_language import mean_tokens
from models.train.beyond_network import TEXT_DIM, PlainHead, Projector
from models.train.beyond_words import LayoutWords, load_words
from models.train.compaction import Compaction
from models.train.export import OPSET
from models.train.features import compact
from models.train.graph import halve, set_metadata, simplified

TOLERANCE = 0.05
"""Of nats, and of a token's numbers, between torch and the file."""


class Whole(nn.Module):
    """Both networks as the runtime has them, evidence of what lies beyond above its mean over
    sights. What is in view is left as it is: of room types, some are seen more often."""

    def __init__(
        self, head: PlainHead, mean: Tensor, middle: Tensor, gain: float,
        projector: Projector | None = None, blank: Tensor | None = None,
    ) -> None:  # fmt: skip
        """`mean` (386,) of answers beyond and their `gain`; `middle` (384,) of names' rows. Without
        a projector nothing is made for a language model."""
        super().__init__()
        self.gain = gain
        self.head, self.projector = head, projector
        mean = mean.clone()
        mean[-1] = 0
        self.register_buffer("mean", mean)
        self.register_buffer("middle", middle)
        self.register_buffer("blank", blank)

    def forward(self, features: Tensor, depth: Tensor, way: Tensor) -> tuple[Tensor, ...]:
        """As SceneLayout's; the last are the tokens of no picture."""
        answer = self.head(features, depth, way)
        above = self._above(answer[0] - self.mean)
        beyond = torch.cat((self.gain * above[:, :-1], above[:, -1:]), 1)
        view = self._above(answer[1])
        if self.projector is None or self.blank is None:
            return beyond, view
        return beyond, view, self.projector(features, depth, way), self.blank + 0 * way.sum()

    def _above(self, answer: Tensor) -> Tensor:
        vector = answer[:, :TEXT_DIM]
        sure = answer[:, TEXT_DIM : TEXT_DIM + 1] - (vector @ self.middle)[:, None]
        return torch.cat((vector, sure, answer[:, -1:]), 1)


def whole(
    run: Path, homes: Homes, dev: Homes, words: LayoutWords, silent: bool = False
) -> Whole:  # fmt: skip
    """The networks of a run, with means over the sights of `homes` and a gain fitted on `dev`;
    the head alone, if `silent`."""
    head = plain_head(homes)
    head.load_state_dict(_weights(run / "head.pt"))
    head.eval()
    beyond, _ = answers(head, homes)
    mean = beyond[torch.from_numpy(homes.best)].mean(0)
    middle = words.canonical().mean(0)
    gain = fit_gain(head, dev, words)
    if silent:
        return Whole(head, mean, middle, gain).eval()
    learned = _weights(run / "projector.pt")
    projector = Projector(
        homes.features.shape[1], learned["start"], torch.zeros(TEXT_DIM, len(learned["start"]))
    )
    projector.load_state_dict(learned)
    blank = mean_tokens(projector.eval(), homes)
    return Whole(head, mean, middle, gain, projector, blank).eval()


def _weights(path: Path) -> dict[str, Tensor]:
    if not path.exists():
        silent = ", or give --silent" if path.name == "projector.pt" else ""
        raise ModelFileError(f"{path}: missing; let models.train.beyond finish{silent}")
    found: dict[str, Tensor] = torch.load(path, map_location="cpu", weights_only=True)
    return found


def export(network: Whole, out: Path, entries: dict[str, str], sights: list[Tensor]) -> None:
    """Write `out` and check that it says of some sights what torch says. Raises ModelFileError."""
    partial = out.with_suffix(".partial.onnx")
    outputs = SILENT if network.projector is None else OUTPUTS
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        torch.onnx.export(
            network, tuple(x[:3] for x in sights), str(partial),
            input_names=list(INPUTS), output_names=list(outputs), opset_version=OPSET, dynamo=False,
            dynamic_axes={name: {0: "n"} for name in (*INPUTS, *OUTPUTS[:-1])},
        )  # fmt: skip
    model = simplified(partial)
    halve(model)
    set_metadata(model, {**entries, "format": FORMAT})
    onnx.save(model, str(partial))
    told = SceneLayout(partial)
    theirs = (*told.look(*(x.numpy() for x in sights)), told.blank)[: len(outputs)]
    with torch.no_grad():
        mine = [x.numpy() for x in network(*sights)]
    for name, a, b in zip(outputs, mine, theirs, strict=True):
        gap = float(np.abs(a - b).mean() / max(1e-6, np.abs(a).mean()))
        if gap > TOLERANCE:
            raise ModelFileError(f"{out}: {name} differs from torch by {gap:.1%}; do not use it")
    os.replace(partial, out)


@click.command(
    epilog="Example:  python -m models.train.beyond_export --run run --data beyond/train "
    "--dev beyond/dev"
)
@click.option("--run", type=click.Path(path_type=Path, exists=True), required=True)
@click.option("--data", type=click.Path(path_type=Path, exists=True), required=True,
              help="The homes that it was taught with.")  # fmt: skip
@click.option("--dev", type=click.Path(path_type=Path, exists=True), required=True)
@click.option("--detector", type=click.Path(path_type=Path, exists=True),
              default=Path("models/weights/rfnav-det.onnx"), show_default=True,
              help="Whose features the homes have; it will tell them compacted.")  # fmt: skip
@click.option("--detector-out", type=click.Path(path_type=Path), help="Default: the same.")
@click.option("--out", type=click.Path(path_type=Path),
              default=Path("models/weights/scene-layout.onnx"), show_default=True)  # fmt: skip
@click.option("--silent", is_flag=True,
              help="Nothing for a language model: of a run with --steps 0.")  # fmt: skip
def main(
    run: Path, data: Path, dev: Path, detector: Path, detector_out: Path | None, out: Path,
    silent: bool,
) -> None:  # fmt: skip
    """Write the scene-layout expert, and the detector that tells what it is shown."""
    torch.set_num_threads(1)
    compaction = Compaction.read(run / COMPACTION) if (run / COMPACTION).exists() else None
    by = sha256(detector)
    homes, others = (read_homes(folder, compaction, by) for folder in (data, dev))
    words = load_words(homes.categories, homes.room_names, encoder().embed)
    detector_out = detector_out or detector
    if compaction is not None:
        compact(detector, detector_out, compaction)
    texts = dict(words.texts)
    network = whole(run, homes, others, words, silent)
    entries = {
        "detector": sha256(detector_out),
        "language": "" if silent else sha256(manifest.fetch(LANGUAGE)),
        "text": texts["thing"],
        "templates": json.dumps({key: texts[key] for key in TEMPLATES}),
    }
    sights = pictures(homes, homes.frame[:64], homes.way()[:64])
    export(network, out, entries, sights)
    click.echo(f"gain {network.gain:g}")
    for path in (detector_out, out):
        click.echo(f"{path}: {path.stat().st_size} bytes, sha256 {sha256(path)}")


if __name__ == "__main__":
    told(main)
