"""Weights that lie in other files are refused, wherever in the graph they are named."""

from pathlib import Path

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper

from models.errors import ModelFileError
from models.onnx_file import refuse_external_data
from models.store import manifest


def graph_with(place: str, tensor: TensorProto) -> onnx.ModelProto:
    """A model that has the tensor as a weight, in an attribute, or in a graph within an `If`."""
    out = helper.make_tensor_value_info("y", TensorProto.FLOAT, [2])
    inner = helper.make_graph(
        [helper.make_node("Identity", ["w"], ["y"])], "g", [], [out], [tensor]
    )
    if place == "weight":
        return helper.make_model(inner)
    if place == "attribute":
        node = helper.make_node("Constant", [], ["y"], value=tensor)
        return helper.make_model(helper.make_graph([node], "g", [], [out]))
    yes = numpy_helper.from_array(np.array(True), "yes")
    node = helper.make_node("If", ["yes"], ["y"], then_branch=inner, else_branch=inner)
    return helper.make_model(helper.make_graph([node], "g", [], [out], [yes]))


@pytest.mark.parametrize("place", ["weight", "attribute", "branch"])
@pytest.mark.parametrize("location", ["weights.bin", "../../etc/passwd", ""])
def test_external_data_are_refused(place: str, location: str, tmp_path: Path) -> None:
    path, tensor = tmp_path / "net.onnx", numpy_helper.from_array(np.ones(2, np.float32), "w")
    onnx.save(graph_with(place, tensor), str(path))
    refuse_external_data(path)
    tensor.ClearField("raw_data")
    if location:
        tensor.data_location = TensorProto.EXTERNAL
        tensor.external_data.add(key="location", value=location)
    path.write_bytes(graph_with(place, tensor).SerializeToString())
    if location:
        with pytest.raises(
            ModelFileError, match=r"net\.onnx: keeps weights in other files"
        ) as told:
            refuse_external_data(path)
        assert "\n" not in str(told.value)
    else:
        refuse_external_data(path)


def test_what_is_no_onnx_file(tmp_path: Path) -> None:
    whole = (manifest.PACKAGE / "weights" / "nanodet-g.onnx").read_bytes()
    for content in (b"", b"not a model", whole[: len(whole) // 2], b"\x3a\xff\xff\xff\xff\x7f"):
        path = tmp_path / "net.onnx"
        path.write_bytes(content)
        with pytest.raises(ModelFileError, match="not a usable ONNX file"):
            refuse_external_data(path)
