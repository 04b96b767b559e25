"""`python -m models.train.restore`: a checkpoint from an exported file, to train on from.

In the file, batch norms are folded into the convolutions before them. Here they get the statistics
that the frames have behind those convolutions, and the gain and shift that undo them: what the
network computes stays the same, and it can be trained.
"""

import re
from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np
import onnx
import torch
from onnx import numpy_helper
from torch import Tensor, nn

from models.errors import ModelFileError, told
from models.onnx_session import image_size, open_session
from models.train.data import batches
from models.train.export import FORMAT, Selected, check_parity
from models.train.graph import read_metadata
from models.train.labelled import Labelled, read_frames
from models.train.memory import keep_memory
from models.train.names import load_names
from models.train.network import STRIDES, Network
from models.train.trainer import save

BATCH, BATCHES = 8, 25
FOLDED = re.compile(r"/network/(pyramid|head)/.*((?:down|up|where|what)\.\d)\.1/Conv")
"""Nodes of convolutions with a batch norm folded in: part, and path within it."""


def restore(path: Path) -> Network:
    """The network of an exported file in eval mode; batch norms do nothing but add the shift.
    Raises ModelFileError for a file that `models.train.export` did not write."""
    model = onnx.load(str(path))
    table = read_metadata(model)
    if table.get("format") != FORMAT:
        raise ModelFileError(
            f"{path}: not a file of models.train.export; give one such as rfnav-det"
        )
    values = {
        t.name.removesuffix(".half"): torch.from_numpy(
            numpy_helper.to_array(t).astype(np.float32, copy=True)
        )
        for t in model.graph.initializer
    }
    state = Network().state_dict()
    found = {
        name.removeprefix("network."): value
        for name, value in values.items()
        if name.removeprefix("network.") in state
    }
    for node in model.graph.node:
        fold = FOLDED.fullmatch(node.name)
        if fold:
            weight, bias = (values[name] for name in node.input[1:])
            found |= _split(f"{fold[1]}.{fold[2]}", weight, bias)
        elif node.op_type == "Gemm" and node.name.startswith("/region/region."):
            found[f"region.{node.name[15]}.weight"] = values[node.input[1]].T
    found |= _boxes(model, values)
    found["log_scale"] = torch.tensor(float(table["value.scale"])).log()
    found["bias"] = torch.tensor(float(table["value.bias"]))
    found["room_log_scale"] = torch.tensor(float(table["value.room_scale"])).log()
    missing = sorted(state.keys() - found.keys())
    if missing:
        raise ModelFileError(f"{path}: holds no {missing[0]} that could be read; is it in 8 bits?")
    network = Network()
    network.load_state_dict(found)
    return network.eval()


def _split(at: str, weight: Tensor, bias: Tensor) -> dict[str, Tensor]:
    """A convolution and a batch norm behind it that only adds `bias`."""
    one = torch.ones_like(bias)
    return {
        f"{at}.1.weight": weight,
        f"{at}.2.weight": one,
        f"{at}.2.bias": bias,
        f"{at}.2.running_mean": torch.zeros_like(bias),
        f"{at}.2.running_var": one - nn.BatchNorm2d(1).eps,
        f"{at}.2.num_batches_tracked": torch.tensor(0),
    }


def _boxes(model: onnx.ModelProto, values: dict[str, Tensor]) -> dict[str, Tensor]:
    """The head for boxes, of which the file has a copy for each level, times the level's scale."""
    copies = []
    for level in range(len(STRIDES)):
        ending = f"_{level}" if level else ""
        node = next(n for n in model.graph.node if n.name == f"/network/head/box{ending}/Conv")
        copies.append([values[name] for name in node.input[1:]])
    weight, bias = copies[0]
    scale = torch.stack([(w * weight).sum() / (weight * weight).sum() for w, _ in copies])
    return {"head.box.weight": weight, "head.box.bias": bias, "head.scale": scale}


@torch.no_grad()
def measure_norms(network: Network, frames: Sequence[Labelled], rooms: Sequence[str]) -> None:
    """Give every batch norm the statistics of these frames, and the gain and shift that leave what
    it computes as it was."""
    norms = [m for m in network.modules() if isinstance(m, nn.BatchNorm2d)]
    before = [norm.bias.clone() for norm in norms]
    sums: dict[nn.Module, list[Tensor]] = {norm: [] for norm in norms}
    hooks = [
        norm.register_forward_pre_hook(
            lambda norm, x: sums[norm].append(
                torch.stack((x[0].mean((0, 2, 3)), (x[0] ** 2).mean((0, 2, 3))))
            )
        )
        for norm in norms
    ]
    rng = np.random.default_rng(0)
    for batch in batches(frames[: BATCH * BATCHES], rooms, BATCH, rng):
        network(batch.image)
    for hook in hooks:
        hook.remove()
    for norm, shift in zip(norms, before, strict=True):
        mean, square = torch.stack(sums[norm]).mean(0)
        norm.running_mean.copy_(mean)  # type: ignore[union-attr]
        norm.running_var.copy_(square - mean**2)  # type: ignore[union-attr]
        norm.weight.copy_(torch.sqrt(square - mean**2 + norm.eps))
        norm.bias.copy_(shift + mean)


@click.command(
    epilog="Example:  python -m models.train.restore --data frames/train --out out/restored.pt"
)
@click.option(
    "--detector",
    type=click.Path(path_type=Path, exists=True),
    default=Path("models/weights/rfnav-det.onnx"),
    show_default=True,
)
@click.option("--data", type=click.Path(path_type=Path, exists=True), required=True)
@click.option("--out", type=click.Path(path_type=Path), required=True)
def main(detector: Path, data: Path, out: Path) -> None:
    """Write OUT, which `--start` of models.train takes, from an exported file and some frames."""
    names = load_names(lambda texts: np.zeros((len(texts), 384), np.float32))
    network = restore(detector)
    frames = read_frames(data, names.categories, names.held_out)
    order = np.random.default_rng(0).permutation(len(frames))
    measure_norms(network, [frames[i] for i in order], names.rooms)
    height, width = image_size(open_session(detector, 1).get_inputs()[0].shape, detector)
    check_parity(Selected(network).eval(), detector, (width, height))
    out.parent.mkdir(parents=True, exist_ok=True)
    save(out, {"average": network.state_dict()})
    click.echo(f"{out}: what {detector} computes, to be trained on")


if __name__ == "__main__":
    keep_memory()
    told(main)
