"""`python -m models.train.features`: has a detector's file tell what its backbone saw, too.

The output `features` (1, C, h, w): of the coarsest level, what the backbone has of each place and
what the head is about to name there, averaged over POOLED x POOLED places. The other outputs stay
as they were, to the last bit. Experts that look at keyframes are taught from it.
"""

from pathlib import Path

import click
import numpy as np
import onnx
from onnx import helper, numpy_helper, shape_inference

from models.errors import ModelFileError, told
from models.onnx_session import open_session
from models.train.compaction import Compaction

OUTPUT = "features"
WHOLE = "/features/whole"
"""What is compacted."""
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
    return _saved(model, path, out)


def compact(path: Path, out: Path, compaction: Compaction) -> tuple[int, ...]:
    """Write the detector at `path`, which tells its features whole, to `out`, which tells them
    compacted; returns their shape. ModelFileError where it does not, or has them compacted."""
    model = onnx.load(str(path))
    graph = model.graph
    told = next((o for o in graph.output if o.name == OUTPUT), None)
    whole, kept = compaction.weight.shape
    dims = [d.dim_value for d in told.type.tensor_type.shape.dim] if told else []
    if told is None or dims[1:2] != [whole]:
        raise ModelFileError(
            f"{path}: {OUTPUT} {dims or 'missing'}; a compaction of {whole} channels needs a file "
            "of models.train.features"
        )
    for node in graph.node:
        node.output[:] = [WHOLE if name == OUTPUT else name for name in node.output]
    weight = np.ascontiguousarray(compaction.weight.T[:, :, None, None])
    for name, values in (("weight", weight), ("bias", compaction.bias)):
        graph.initializer.append(numpy_helper.from_array(values, f"/features/{name}"))
    inputs = [WHOLE, "/features/weight", "/features/bias"]
    graph.node.append(helper.make_node("Conv", inputs, [OUTPUT], kernel_shape=[1, 1]))
    told.type.tensor_type.shape.dim[1].dim_value = kept
    return _saved(model, path, out)


def _saved(model: onnx.ModelProto, path: Path, out: Path) -> tuple[int, ...]:
    """Write the file; its other outputs must be those of `path`, to the last bit."""
    onnx.checker.check_model(model)
    before = _answers(path)
    onnx.save(model, str(out))
    after = _answers(out)
    if any(not np.array_equal(before[name], after[name]) for name in before if name != OUTPUT):
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
@click.option("--compaction", type=click.Path(path_type=Path, exists=True),
              help="Of models.train.beyond: tell what is told in fewer numbers.")  # fmt: skip
def main(path: Path, out: Path | None, compaction: Path | None) -> None:
    """Have the detector's file at PATH tell what its backbone saw."""
    if compaction is None:
        shape = expose(path, out or path)
    else:
        shape = compact(path, out or path, Compaction.read(compaction))
    click.echo(f"{out or path}: {OUTPUT} {'x'.join(map(str, shape))}")


if __name__ == "__main__":
    told(main)
