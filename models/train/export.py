"""`python -m models.train.export`: a checkpoint's averaged weights as one ONNX file.

The graph ends after selection: boxes, objectness and word-space embeddings of the CANDIDATES most
objectlike locations, the scene's embedding, and (not in 8 bits) what the backbone saw of each part
of the image. Weights are stored in half precision and cast
when the file is loaded, or the file is in 8 bits. What torch and onnxruntime make of the same
images must agree, before rounding to 8 bits.
"""

import hashlib
import pickle
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np
import onnx
import torch
from torch import Tensor, nn

from models.errors import ModelFileError, told
from models.onnx_session import open_session
from models.train.data import FULL
from models.train.features import expose
from models.train.graph import constants, halve, parse_size, set_metadata, simplified
from models.train.network import Network
from models.train.quantise import quantise

CANDIDATES = 300
"""Some eight locations answer for one object: with 100, small things in full rooms are left out."""
OPSET = 17
FORMAT = "rf-nav-detector/1"
OUTPUTS = ("boxes", "objectness", "embeddings", "scene")
TOLERANCE = {"boxes": 2.0, "objectness": 0.02, "scene": 0.02}


class Selected(nn.Module):
    """The network with its selection, as the runtime sees it."""

    def __init__(self, network: Network) -> None:
        super().__init__()
        self.network = network

    def forward(self, image: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """(1, 3, H, W) -> (1, K, 4) px, (1, K) in 0..1, (1, K, 384), (1, 384)."""
        raw = self.network(image)
        best, where = raw.objectness.topk(CANDIDATES, dim=1)
        boxes = raw.boxes.gather(1, where[..., None].expand(-1, -1, 4))
        regions = raw.regions.gather(1, where[..., None].expand(-1, -1, raw.regions.shape[2]))
        return (
            boxes,
            best.sigmoid(),
            self.network.embed(regions),
            self.network.embed_scene(raw.summary),
        )


def load_network(checkpoint: Path) -> tuple[Network, dict[str, Any]]:
    """The averaged weights of a checkpoint, ready to run, and the checkpoint."""
    try:
        state: dict[str, Any] = torch.load(checkpoint, map_location="cpu", weights_only=True)
        network = Network()
        network.load_state_dict(state["average"])
    except (OSError, RuntimeError, KeyError, pickle.UnpicklingError) as error:
        reason = " ".join(str(error).split())[:120]
        raise ModelFileError(
            f"{checkpoint}: not a checkpoint of this trainer ({reason})"
        ) from error
    return network.eval(), state


def export(
    checkpoint: Path,
    out: Path,
    values: dict[str, float] | None = None,
    size: tuple[int, int] = FULL,
    calibrate: Sequence[Path] = (),
) -> None:
    """Write `out` and check that it computes what torch computes.

    `values` are further constants for the runtime, such as the calibration; `size` (width, height)
    px of the input, multiples of 32. With images to `calibrate` on, the file is in 8 bits, else its
    weights are in half precision and computing is in single.
    """
    if any(side % 32 or side <= 0 for side in size):
        raise ModelFileError(
            f"{out}: input {size[0]}x{size[1]}: both sides must be multiples of 32"
        )
    network, _ = load_network(checkpoint)
    selected = Selected(network).eval()
    out.parent.mkdir(parents=True, exist_ok=True)
    _trace(selected, out, size)
    learned = {
        "scale": float(network.log_scale.detach().exp()),
        "bias": float(network.bias.detach()),
        "room_scale": float(network.room_log_scale.detach().exp()),
        **(values or {}),
    }
    model = simplified(out)
    onnx.save(model, str(out))
    check_parity(selected, out, size)
    if calibrate:
        quantise(out, out, calibrate, size)
        model = onnx.load(str(out))
    halve(model)
    set_metadata(model, {**constants(learned), "format": FORMAT})
    onnx.save(model, str(out))
    if not calibrate:
        expose(out, out)


def _trace(selected: Selected, out: Path, size: tuple[int, int]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        torch.onnx.export(
            selected,
            (torch.zeros(1, 3, size[1], size[0]),),
            str(out),
            input_names=["image"],
            output_names=list(OUTPUTS),
            opset_version=OPSET,
            dynamo=False,
        )


def check_parity(selected: Selected, path: Path, size: tuple[int, int]) -> None:
    """Raise ModelFileError when the file and the network disagree on drawn images."""
    session = open_session(path, 1)
    rng = np.random.default_rng(0)
    for _ in range(3):
        coarse = rng.integers(0, 255, (1, 3, size[1] // 32, size[0] // 32)).astype(np.float32)
        image = coarse.repeat(32, 2).repeat(32, 3)
        with torch.no_grad():
            mine = dict(
                zip(OUTPUTS, (t.numpy() for t in selected(torch.from_numpy(image))), strict=True)
            )
        theirs = dict(zip(OUTPUTS, session.run(OUTPUTS, {"image": image}), strict=True))
        for name in ("objectness", "scene"):
            gap = float(np.abs(mine[name] - theirs[name]).max())
            if gap > TOLERANCE[name]:
                raise ModelFileError(
                    f"{path}: {name} differs from torch by {gap:.3f}; do not use it"
                )
        lone = float(np.abs(mine["boxes"][0, 0] - theirs["boxes"][0]).max(axis=1).min())
        if lone > TOLERANCE["boxes"]:
            raise ModelFileError(f"{path}: the best box differs from torch by {lone:.1f} px")


@click.command(
    epilog="Example:  python -m models.train.export --checkpoint out/finished.pt --size 512x384"
)
@click.option("--checkpoint", type=click.Path(path_type=Path), required=True)
@click.option(
    "--out", type=click.Path(path_type=Path), default=Path("models/weights/rfnav-det.onnx")
)
@click.option("--size", default=f"{FULL[0]}x{FULL[1]}", show_default=True, help="Of the input, px.")
@click.option(
    "--int8",
    type=click.Path(path_type=Path, exists=True),
    help="In 8 bits, with ranges from these training frames.",
)
@click.option(
    "--gain", default=1.0, show_default=True, help="Calibration, as rfnav models evaluate fits it."
)
@click.option("--shift", default=0.0, show_default=True)
def main(
    checkpoint: Path, out: Path, size: str, int8: Path | None, gain: float, shift: float
) -> None:
    """Export a checkpoint, check it against torch, and say what it weighs."""
    calibrate = sorted((int8 / "images").glob("*.jpg")) if int8 else ()
    if int8 and not calibrate:
        raise ModelFileError(f"{int8}: holds no images/*.jpg; render some with `hil-sim frames`")
    export(checkpoint, out, {"gain": gain, "shift": shift}, parse_size(size), calibrate)
    digest = hashlib.sha256(out.read_bytes()).hexdigest()
    click.echo(f"{out}: {out.stat().st_size} bytes, sha256 {digest}")


if __name__ == "__main__":
    told(main)
