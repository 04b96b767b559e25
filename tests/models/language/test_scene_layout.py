"""The reader of the scene-layout expert's file, by a file drawn here."""

from pathlib import Path

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper

from models.errors import ModelFileError
from models.language.scene_layout import FORMAT, SceneLayout
from models.onnx_session import open_session
from models.store import manifest

TOLD = {
    "format": FORMAT, "detector": "abc", "language": "def", "text": "a {}",
    "templates": '{"beyond": " Beyond: a", "view": " Here: a", "room": " A"}',
}  # fmt: skip


def draw(
    path: Path,
    told: dict[str, str],
    outputs: tuple[str, ...] = (),
    parts: tuple[int | str, ...] = (5, 2, 4),
) -> Path:
    """A file whose `beyond` is (way's column, its range, 1, 2); 2 tokens of 3 numbers."""
    more = np.tile(np.array([[1.0, 2.0]], np.float32), (1, 1))
    nodes = [
        helper.make_node("ReduceMean", ["features"], ["mean"], axes=[1, 2, 3], keepdims=0),
        helper.make_node("ReduceMean", ["depth"], ["deep"], axes=[1, 2, 3], keepdims=0),
        helper.make_node("Mul", ["way", "none"], ["zero"]),
        helper.make_node("Add", ["zero", "more"], ["tail"]),
        helper.make_node("Concat", ["way", "tail"], ["beyond"], axis=1),
        helper.make_node("Neg", ["beyond"], ["view"]),
        helper.make_node("Concat", ["way", "way", "way"], ["six"], axis=1),
        helper.make_node("Reshape", ["six", "shape"], ["tokens"]),
        helper.make_node("Identity", ["kept"], ["blank"]),
    ]
    constants = [
        numpy_helper.from_array(np.zeros((1, 2), np.float32), "none"),
        numpy_helper.from_array(more, "more"),
        numpy_helper.from_array(np.array([-1, 2, 3], np.int64), "shape"),
        numpy_helper.from_array(np.full((2, 3), 7, np.float32), "kept"),
    ]
    shapes = {"features": ["n", *parts], "depth": ["n", 2, 2, 4], "way": ["n", 2]}
    given = [helper.make_tensor_value_info(k, TensorProto.FLOAT, v) for k, v in shapes.items()]
    names = outputs or ("beyond", "view", "tokens", "blank")
    ends = [helper.make_tensor_value_info(k, TensorProto.FLOAT, None) for k in names]
    graph = helper.make_graph(nodes, "drawn", given, ends, constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    helper.set_model_props(model, told)
    onnx.save(model, str(path))
    return path


def test_a_file_looks_and_its_answers_are_compared_with_a_row(tmp_path: Path):
    layout = SceneLayout(draw(tmp_path / "a.onnx", TOLD))
    assert (layout.detector, layout.language, layout.text) == ("abc", "def", "a {}")
    assert layout.template == " Beyond: a"
    assert layout.grid == (5, 2, 4)
    np.testing.assert_array_equal(layout.blank, np.full((2, 3), 7))
    way = np.array([[0.25, 0.5], [0.75, 1.0], [0.5, 0.0]], np.float32)
    looked = layout.look(np.zeros((3, 5, 2, 4)), np.zeros((3, 2, 2, 4)), way)
    assert looked.tokens.shape == (3, 2, 3)
    row = np.array([2.0, -1.0], np.float32)
    np.testing.assert_allclose(layout.evidence(looked.beyond, row), [1.0, 1.5, 2.0])
    np.testing.assert_allclose(layout.evidence(looked.view, row), [-1.0, -1.5, -2.0])


def test_a_file_may_have_nothing_to_show_to_a_language_model(tmp_path: Path):
    told = {key: value for key, value in TOLD.items() if key != "language"}
    layout = SceneLayout(draw(tmp_path / "a.onnx", told, ("beyond", "view")))
    assert (layout.speaks, layout.language, layout.blank.size) == (False, "", 0)
    looked = layout.look(np.zeros((3, 5, 2, 4)), np.zeros((3, 2, 2, 4)), np.ones((3, 2)))
    assert looked.beyond.shape == (3, 4)
    assert looked.tokens.shape == (3, 0, 0)


def test_another_shape_is_refused_in_one_line(tmp_path: Path):
    layout = SceneLayout(draw(tmp_path / "a.onnx", TOLD))
    with pytest.raises(ModelFileError, match="does not run on features"):
        layout.look(np.zeros((1, 6, 2, 4)), np.zeros((1, 2, 2, 4)), np.zeros((1, 2)))


def test_other_files_are_refused_in_one_line(tmp_path: Path):
    with pytest.raises(ModelFileError, match="no such model file"):
        SceneLayout(tmp_path / "none.onnx")
    with pytest.raises(ModelFileError, match="no scene-layout expert"):
        SceneLayout(draw(tmp_path / "b.onnx", TOLD | {"format": "rf-nav-detector/1"}))
    with pytest.raises(ModelFileError, match="outputs beyond, tokens; expected"):
        SceneLayout(draw(tmp_path / "c.onnx", TOLD, ("beyond", "tokens")))
    for wrong in ("{", "[]", '{"beyond": "x"}'):
        with pytest.raises(ModelFileError, match="its metadata lack"):
            SceneLayout(draw(tmp_path / "d.onnx", TOLD | {"templates": wrong}))
    told = {k: v for k, v in TOLD.items() if k != "language"}
    with pytest.raises(ModelFileError, match="its metadata lack 'language'"):
        SceneLayout(draw(tmp_path / "e.onnx", told))


@pytest.mark.parametrize("parts", [(5, "rows", "columns"), (None, 2, 4)])
def test_parts_of_no_fixed_number_are_refused_in_one_line(tmp_path: Path, parts):
    with pytest.raises(ModelFileError, match="not three numbers: channels, rows, columns"):
        SceneLayout(draw(tmp_path / "a.onnx", TOLD, parts=parts))


@pytest.mark.parametrize(
    ("name", "language"), [("scene-layout", "smollm2-135m"), ("scene-layout-clean", "")]
)
def test_the_shipped_files_belong_to_the_shipped_models(name: str, language: str):
    layout, beside = SceneLayout(manifest.locate(name)), manifest.entry(name).beside
    assert layout.detector == manifest.entry(beside).files[0].sha256
    assert layout.language == (manifest.entry(language).files[0].sha256 if language else "")
    assert manifest.entry(name).size < 15e6
    detector = open_session(manifest.locate(beside))
    told = next(o for o in detector.get_outputs() if o.name == "features")
    assert tuple(told.shape[1:]) == layout.grid
    rng = np.random.default_rng(0)
    sights = rng.normal(size=(4, *layout.grid)), rng.uniform(0, 3, (4, 2, *layout.grid[1:]))
    looked = layout.look(*sights, np.array([[0.1, 0.4], [0.5, 0.4], [0.9, 0.4], [0.5, 1.0]]))
    assert all(np.isfinite(part).all() for part in looked)
    assert looked.beyond.shape == looked.view.shape == (4, 386)
    tokens = (8, 576) if language else (0, 0)
    assert looked.tokens.shape == (4, *layout.blank.shape) == (4, *tokens)
    assert len({row.tobytes() for row in looked.beyond}) == 4
