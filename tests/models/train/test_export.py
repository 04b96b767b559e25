"""From a checkpoint to a file: any size, paddings fused, 8 bits that answer nearly the same."""

from pathlib import Path

import numpy as np
import onnx
import pytest
from click.testing import CliRunner

torch = pytest.importorskip("torch")

from drawn_shapes import SHAPES, draw_frames  # noqa: E402
from onnx import TensorProto, helper, numpy_helper  # noqa: E402

from models.detection.detector import OpenDetector, open_detector  # noqa: E402
from models.errors import ModelFileError  # noqa: E402
from models.onnx_session import open_session  # noqa: E402
from models.train import graph  # noqa: E402
from models.train.data import batches  # noqa: E402
from models.train.export import export, load_network  # noqa: E402
from models.train.labelled import read_frames  # noqa: E402
from models.train.network import Network  # noqa: E402
from models.train.restore import main, restore  # noqa: E402
from models.train.trainer import save  # noqa: E402
from models.words.text_encoder import TextEncoder  # noqa: E402

SIZE = (160, 128)


@pytest.fixture(scope="module")
def checkpoint(tmp_path_factory: pytest.TempPathFactory) -> Path:
    torch.manual_seed(0)
    path = tmp_path_factory.mktemp("run") / "checkpoint.pt"
    torch.save({"average": Network().state_dict()}, path)
    return path


def test_eight_bits_answer_nearly_the_same(
    checkpoint: Path, tmp_path: Path, encoder: TextEncoder
) -> None:
    draw_frames(tmp_path / "frames", 4, seed=1)
    images = sorted((tmp_path / "frames" / "images").iterdir())
    export(checkpoint, tmp_path / "f.onnx", {"gain": 2.0}, SIZE)
    export(checkpoint, tmp_path / "q.onnx", {"gain": 2.0}, SIZE, images)
    plain, small = (onnx.load(str(tmp_path / name)) for name in ("f.onnx", "q.onnx"))
    assert not [n for n in plain.graph.node if n.op_type == "Pad"]
    assert len([n for n in small.graph.node if n.op_type == "QuantizeLinear"]) > 50
    sizes = [(tmp_path / name).stat().st_size for name in ("f.onnx", "q.onnx")]
    assert sizes[1] < 0.75 * sizes[0] < 9e6
    frame = np.random.default_rng(0).integers(0, 255, (480, 640, 3), dtype=np.uint8)
    views = []
    for name in ("f.onnx", "q.onnx"):
        detector = open_detector(tmp_path / name, "auto", encoder)
        assert isinstance(detector, OpenDetector)
        assert detector.size == (SIZE[1], SIZE[0])
        assert detector.gain == 2
        views.append(detector.look(frame))
    assert float(views[0].scene @ views[1].scene) > 0.9
    assert np.abs(views[0].objectness - views[1].objectness).max() < 0.05


def test_sizes() -> None:
    assert graph.parse_size("512x384") == (512, 384)
    with pytest.raises(ModelFileError, match="write WIDTHxHEIGHT"):
        graph.parse_size("512")


def test_a_size_of_no_whole_cells_is_refused(checkpoint: Path, tmp_path: Path) -> None:
    with pytest.raises(ModelFileError, match="must be multiples of 32"):
        export(checkpoint, tmp_path / "x.onnx", None, (400, 300))


@pytest.mark.parametrize("value", [0.0, 1.0])
def test_only_paddings_with_zeros_are_fused(value: float, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    weights = rng.normal(size=(4, 3, 3, 3)).astype(np.float32)
    constants = [
        numpy_helper.from_array(weights, "w"),
        numpy_helper.from_array(np.array([0, 0, 0, 1, 0, 0, 1, 2], np.int64), "around"),
        numpy_helper.from_array(np.float32(value), "value"),
    ]
    nodes = [
        helper.make_node("Pad", ["x", "around", "value"], ["padded"]),
        helper.make_node("Conv", ["padded", "w"], ["y"], pads=[1, 0, 0, 0], strides=[2, 2]),
    ]
    ends = [helper.make_tensor_value_info(name, TensorProto.FLOAT, None) for name in ("x", "y")]
    ends[0] = helper.make_tensor_value_info("x", TensorProto.FLOAT, [1, 3, 9, 12])
    model = helper.make_model(
        helper.make_graph(nodes, "pad", [ends[0]], [ends[1]], constants),
        opset_imports=[helper.make_opsetid("", 17)],
        ir_version=8,
    )
    onnx.save(model, str(tmp_path / "before.onnx"))
    assert graph.fuse_pads(model) == (value == 0)
    onnx.save(model, str(tmp_path / "after.onnx"))
    x = rng.normal(size=(1, 3, 9, 12)).astype(np.float32)
    before, after = (
        open_session(tmp_path / name).run(None, {"x": x})[0]
        for name in ("before.onnx", "after.onnx")
    )
    np.testing.assert_allclose(before, after, atol=1e-5)


def test_a_file_can_be_trained_on_from(tmp_path: Path) -> None:
    torch.manual_seed(1)
    network = Network()
    for norm in [m for m in network.modules() if isinstance(m, torch.nn.BatchNorm2d)]:
        norm.running_mean.normal_()
        norm.running_var.uniform_(0.5, 2)
    with torch.no_grad():
        network.head.scale.copy_(torch.tensor([1.0, 0.9, 1.2]))
    save(tmp_path / "run.pt", {"average": network.state_dict()})
    export(tmp_path / "run.pt", tmp_path / "file.onnx", None, SIZE)
    draw_frames(tmp_path / "frames", 16, seed=1)
    places = {"detector": "file.onnx", "data": "frames", "out": "back.pt"}
    options = [f"--{name}={tmp_path / place}" for name, place in places.items()]
    result = CliRunner().invoke(main, options)
    assert result.exit_code == 0, result.output
    back, _ = load_network(tmp_path / "back.pt")
    image = torch.rand(8, 3, 128, 160) * 255
    with torch.no_grad():
        told, again = network.eval()(image), back(image)
    for mine, theirs in zip(told, again, strict=True):
        np.testing.assert_allclose(theirs.numpy(), mine.numpy(), rtol=0.05, atol=0.05)
    # Statistics of frames: in training, what follows a norm is about what it is in use.
    norm = back.pyramid.down[0][2]
    seen = []
    norm.register_forward_hook(lambda _, x, y: seen.append((x[0], y.clone())))
    frames = read_frames(tmp_path / "frames", tuple(SHAPES))
    (batch, *_) = batches(frames, ("kitchen",), 8, np.random.default_rng(0))
    with torch.no_grad():
        back(batch.image)
        used = seen[-1][1]
        learned = norm.train()(seen[-1][0])
    gap = (used - learned).abs().mean() / used.abs().mean()
    assert float(gap) < 0.5


def test_no_other_file_is_restored(tmp_path: Path) -> None:
    node = helper.make_node("Identity", ["x"], ["y"])
    ends = [helper.make_tensor_value_info(n, TensorProto.FLOAT, [1]) for n in "xy"]
    path = tmp_path / "other.onnx"
    onnx.save(helper.make_model(helper.make_graph([node], "g", [ends[0]], [ends[1]])), str(path))
    with pytest.raises(ModelFileError, match=r"not a file of models\.train\.export"):
        restore(path)
