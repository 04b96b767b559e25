from pathlib import Path

import numpy as np
import pytest

from models.errors import ModelFileError
from models.onnx_session import open_session
from models.store import manifest
from models.train.compaction import Compaction
from models.train.features import compact, expose

WEIGHTS = Path(manifest.__file__).parents[1] / "weights"


def test_a_file_tells_what_its_backbone_saw_and_the_rest_as_before(tmp_path: Path):
    plain = WEIGHTS / "rfnav-det-photos.onnx"
    assert expose(plain, tmp_path / "more.onnx") == (1, 416, 6, 8)
    image = np.random.default_rng(1).integers(0, 255, (1, 3, 384, 512)).astype(np.float32)
    before, after = (
        open_session(path, 1).run(None, {"image": image})
        for path in (plain, tmp_path / "more.onnx")
    )
    for old, new in zip(before, after, strict=False):
        np.testing.assert_array_equal(old, new)
    features = after[4]
    assert features.std(axis=(2, 3)).max() > 0.1  # each part has its own


def test_nothing_is_exposed_twice(tmp_path: Path):
    with pytest.raises(ModelFileError, match="has the output features already"):
        expose(WEIGHTS / "rfnav-det.onnx", tmp_path / "twice.onnx")


def test_a_file_tells_its_features_compacted_once(tmp_path: Path):
    whole, fewer = tmp_path / "whole.onnx", tmp_path / "fewer.onnx"
    expose(WEIGHTS / "rfnav-det-photos.onnx", whole)
    rng = np.random.default_rng(0)
    weight = rng.normal(size=(416, 7)).astype(np.float32)
    made = Compaction(weight, rng.normal(size=7).astype(np.float32))
    assert compact(whole, fewer, made) == (1, 7, 6, 8)
    image = rng.integers(0, 255, (1, 3, 384, 512)).astype(np.float32)
    before, after = (
        dict(zip(["boxes", "objectness", "embeddings", "scene", "features"],
                 open_session(path, 1).run(None, {"image": image}), strict=True))
        for path in (whole, fewer)
    )  # fmt: skip
    np.testing.assert_allclose(after["features"], made(before["features"]), rtol=1e-3, atol=1e-2)
    np.testing.assert_array_equal(after["scene"], before["scene"])
    with pytest.raises(ModelFileError, match="a compaction of 416 channels needs a file of"):
        compact(fewer, tmp_path / "twice.onnx", made)


def test_another_graph_is_refused(tmp_path: Path):
    with pytest.raises(ModelFileError, match=r"has no /network.*models\.train\.export"):
        expose(WEIGHTS / "second-look.onnx", tmp_path / "other.onnx")
