from pathlib import Path

import numpy as np
import pytest

from models.errors import ModelFileError
from models.onnx_session import open_session
from models.store import manifest
from models.train.features import expose

WEIGHTS = Path(manifest.__file__).parents[1] / "weights"


def test_a_file_tells_what_its_backbone_saw_and_the_rest_as_before(tmp_path: Path):
    plain = WEIGHTS / "rfnav-det-clean.onnx"
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


def test_another_graph_is_refused(tmp_path: Path):
    with pytest.raises(ModelFileError, match=r"has no /network.*models\.train\.export"):
        expose(WEIGHTS / "second-look.onnx", tmp_path / "other.onnx")
