import numpy as np
import pytest

torch = pytest.importorskip("torch")

from models.errors import ModelFileError  # noqa: E402
from models.train.beyond_words import load_words  # noqa: E402
from models.words.text_encoder import TextEncoder  # noqa: E402


def test_names_never_taught_are_known_and_marked(encoder: TextEncoder) -> None:
    words = load_words(("bed", "bathtub", "guitar"), ("kitchen", "study"), encoder.embed)
    assert words.taught.tolist() == [True, False, False]
    assert words.called[0][0] == "bed"
    assert "double bed" in words.called[0]
    assert words.canonical().shape == (3, encoder.dimension)
    row = encoder.embed([words.texts["thing"].format("bed")])[0]
    np.testing.assert_allclose(words.canonical()[0].numpy(), row, atol=1e-6)
    drawn = {words.draw(np.random.default_rng(seed))[0].numpy().tobytes() for seed in range(20)}
    assert len(drawn) > 1


def test_a_category_without_names_is_refused(encoder: TextEncoder) -> None:
    with pytest.raises(ModelFileError, match="category 'spaceship' has no names"):
        load_words(("bed", "spaceship"), ("kitchen",), encoder.embed)
