from pathlib import Path

import numpy as np
import pytest

from models.errors import ModelFileError
from models.train.compaction import Compaction


def test_what_varies_most_is_kept_with_deviation_one(tmp_path: Path):
    rng = np.random.default_rng(0)
    mixed = np.einsum("fkhw,kc->fchw", rng.normal(size=(20, 3, 6, 8)), rng.normal(size=(3, 10)))
    features = (mixed + 5 + 0.01 * rng.normal(size=mixed.shape)).astype(np.float32)
    made = Compaction.of(features, 3)
    made.save(tmp_path / "c.npz")
    told = Compaction.read(tmp_path / "c.npz")(features)
    assert told.shape == (20, 3, 6, 8)
    np.testing.assert_allclose(np.cov(np.moveaxis(told, 1, 0).reshape(3, -1)), np.eye(3), atol=0.02)
    assert np.abs(told.mean(axis=(0, 2, 3))).max() < 1e-3
    parts = np.moveaxis(features - features.mean(axis=(0, 2, 3), keepdims=True), 1, -1)
    back = np.linalg.lstsq(np.moveaxis(told, 1, -1).reshape(-1, 3), parts.reshape(-1, 10))[1]
    assert back.max() < 1.0  # squares of 960 parts


def test_another_file_is_none(tmp_path: Path):
    np.savez(tmp_path / "x.npz", weight=np.zeros(3))
    with pytest.raises(ModelFileError, match=r"no compaction .*models\.train\.beyond makes one"):
        Compaction.read(tmp_path / "x.npz")
