"""The text encoder ranks household words as people would."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from models.errors import ModelFileError
from models.words import text_encoder
from models.words.text_encoder import TextEncoder


def test_rows_are_unit_and_in_order(encoder: TextEncoder) -> None:
    rows = encoder.embed(["sofa", "toilet", "sofa"])
    assert rows.shape == (3, 384)
    assert rows.dtype == np.float32
    np.testing.assert_allclose(np.linalg.norm(rows, axis=1), 1, atol=1e-5)
    np.testing.assert_array_equal(rows[0], rows[2])
    assert encoder.embed([]).shape == (0, 384)


def test_synonyms_are_nearer_than_other_furniture(encoder: TextEncoder) -> None:
    sofa, couch, toilet, engine = encoder.embed(["sofa", "couch", "toilet", "car engine"])
    assert sofa @ couch > 0.7
    assert sofa @ couch > sofa @ toilet > sofa @ engine


def test_a_text_does_not_depend_on_its_company(encoder: TextEncoder) -> None:
    alone = encoder.embed(["tv monitor"])[0]
    among = encoder.embed(["a very long sentence about the weather of the day", "tv monitor"])[1]
    np.testing.assert_array_equal(alone, among)


def test_missing_and_damaged_files(tmp_path: Path) -> None:
    with pytest.raises(ModelFileError, match="no such model file"):
        TextEncoder(tmp_path)
    (tmp_path / "model.onnx").write_bytes(b"\x00" * 100)
    with pytest.raises(ModelFileError, match="not a usable ONNX file") as error:
        TextEncoder(tmp_path)
    assert "\n" not in str(error.value)


def test_threads_may_share_an_encoder_whose_memo_is_full(
    encoder: TextEncoder, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(text_encoder, "MEMO", 1)
    words = ["sofa", "bed", "sink", "stove"] * 5
    alone = {word: encoder.embed([word])[0].tolist() for word in set(words)}
    with ThreadPoolExecutor(4) as pool:
        rows = list(pool.map(lambda word: encoder.embed([word])[0].tolist(), words))
    assert rows == [alone[word] for word in words]
