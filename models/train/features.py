"""`python -m models.train.features`: has a detector's file tell what its backbone saw, too.

The output `features` (1, C, h, w): of the coarsest level, what the backbone has of each place and
what the head is about to name there, averaged over POOLED x POOLED places. The other outputs stay
as they were, to the last bit. Experts that look at keyframes are taught from it.
"""

from pathlib import Path

import click
import numpy as np
import onnx
from onnx import helper, shape_inference

from models.errors import ModelFileError, told
from models.onnx_session import open_session

OUTPUT = "features"
POOLED = 2
BACKBONE = "/network/backbone/blocks.15/project/Conv_output_0"
NAMED = "/network/head/what/what.1/what.1.3_2/Relu_output_0"


def expose(path: Path, out: Path) -> tuple[int, ...]:
    """Write the detector at `path` with that output to `out`; returns its shape. ModelFileError
    when it is no detector of this trainer's, or has it, or would say something else by it."""
    model = onnx.load(str(path))
    graph = model.graph
    if OUTPUT in {o.name for o in graph.output}:
        raise ModelFileError(f"{path}: has the output {OUTPUT} already")
    known = {name for node in graph.node for name in node.output}
    if missing := sorted({BACKBONE, NAMED} - known):
        raise ModelFileError(f"{path}: has no {missing[0]}; give a file of models.train.export")
    joined = helper.make_node("Concat", [BACKBONE, NAMED], ["/features/joined"], axis=1)
    pooled = helper.make_node(
        "AveragePool", ["/features/joined"], [OUTPUT], kernel_shape=[POOLED] * 2,
        strides=[POOLED] * 2,
    )  # fmt: skip
    graph.node.extend([joined, pooled])
    shapes = {v.name: v for v in shape_inference.infer_shapes(model).graph.value_info}
    if OUTPUT not in shapes:
        raise ModelFileError(f"{path}: its input has no fixed size; export it with one")
    graph.output.append(shapes[OUTPUT])
    onnx.checker.check_model(model)
    before = _answers(path)
    onnx.save(model, str(out))
    after = _answers(out)
    if any(not np.array_equal(before[name], after[name]) for name in before):
        raise ModelFileError(f"{out}: answers otherwise than {path} did")
    return after[OUTPUT].shape


def _answers(path: Path) -> dict[str, np.ndarray]:
    """What the file makes of one drawn image, by output."""
    session = open_session(path, 1)
    own = session.get_inputs()[0]
    image = np.random.default_rng(0).integers(0, 255, own.shape).astype(np.float32)
    names = [o.name for o in session.get_outputs()]
    return dict(zip(names, session.run(None, {own.name: image}), strict=True))


@click.command(epilog="Example:  python -m models.train.features detector.onnx")
@click.argument("path", type=click.Path(path_type=Path, exists=True))
@click.option("--out", type=click.Path(path_type=Path), help="Another file; else the same.")
def main(path: Path, out: Path | None) -> None:
    """Have the detector's file at PATH tell what its backbone saw."""
    shape = expose(path, out or path)
    click.echo(f"{out or path}: {OUTPUT} {'x'.join(map(str, shape))}")


if __name__ == "__main__":
    told(main)
