"""What the three kinds of the expert ask, of models whose answers are given."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from layout_graph import write_layout

from hil_sim.expert_bench.view_questions import SightRows
from models.language.scene_layout import SceneLooks
from models.store import manifest
from runtime.core.types import F32
from runtime.core.voting.likelihood_experts import VIEW_SCALE
from runtime.core.voting.sight_experts import SIGHT_REFERENCES
from runtime.errors import ModelError
from runtime.perception.beholders import (
    BATCH,
    ByEmbedding,
    ByHead,
    ByLanguage,
    looked,
    open_beholders,
)
from runtime.perception.scene_layout import MODEL

WORDS = ("bed", "mug", "kitchen")


def embed(texts: list[str]) -> F32:
    """By the word that a text ends with."""
    return np.array([np.eye(3)[WORDS.index(t.split()[-1])] for t in texts], np.float32)


def sights(rows: int = 3) -> SightRows:
    """Row n shows, in its features, n; its embedding is the n-th word's."""
    features = np.zeros((rows, 2, 1, 1), np.float16)
    features[:, 0, 0, 0] = np.arange(rows)
    return SightRows(features, np.zeros((rows, 2, 1, 1), np.float16),
                     np.eye(3, dtype=np.float16)[np.arange(rows) % 3], np.zeros((rows, 7)),
                     np.full(rows, 0.25), np.full(rows, 2.5), ("a",) * rows)  # fmt: skip


class Copies:
    """A projector that hands on what it is shown: the feature into `beyond`, the way into `view`,
    both into the tokens."""

    text = "the {}"
    templates: ClassVar = {"beyond": " Beyond is a", "view": " Here is a", "room": " It is a"}
    blank = np.zeros((1, 3), np.float32)
    grid = (2, 1, 1)

    def __init__(self) -> None:
        self.batches = list[int]()

    def look(self, features: F32, depth: F32, way: F32) -> SceneLooks:
        assert features.dtype == depth.dtype == way.dtype == np.float32
        self.batches.append(len(features))
        shown = np.repeat(features[:, 0, 0], 3, axis=1)
        told = np.column_stack((way, way[:, 0]))
        return SceneLooks(shown, told, np.concatenate((shown[:, None, :1], told[:, None, :2]), 2))

    def evidence(self, seen: F32, row: F32) -> F32:
        return np.asarray(seen @ row, np.float32)


def test_a_view_is_like_the_word_that_its_embedding_is_of() -> None:
    found = ByEmbedding(embed).evidence("view", sights(), ["bed", "mug"])
    assert found.tolist() == [[VIEW_SCALE, 0.0], [0.0, VIEW_SCALE], [0.0, 0.0]]
    rooms = ByEmbedding(embed).evidence("room", sights(), ["kitchen"])
    assert rooms.argmax() == 2


def test_the_head_has_one_answer_beyond_and_one_in_view() -> None:
    head = ByHead(Copies(), embed)
    assert head.evidence("beyond", sights(), ["bed", "mug"]).tolist() == [[n, n] for n in range(3)]
    assert head.evidence("view", sights(), ["bed", "mug"]).tolist() == [[0.25, 0.5]] * 3
    assert head.evidence("room", sights(), ["kitchen"]).tolist() == [[0.25]] * 3


def test_the_way_is_told_in_parts_of_what_is_far() -> None:
    assert looked(Copies(), sights()).view[0].tolist() == [0.25, 0.5, 0.25]


def test_another_detectors_views_are_refused() -> None:
    projector = Copies()
    projector.grid = (96, 1, 1)
    with pytest.raises(ModelError, match="views have 2 x 1 x 1 features, the projector takes 96 x"):
        looked(projector, sights())


def test_large_numbers_go_through_a_few_at_a_time() -> None:
    projector = Copies()
    seen = looked(projector, sights(BATCH + 1))
    assert projector.batches == [BATCH, 1]
    assert seen.beyond[:, 0].tolist() == list(range(BATCH + 1))


class Says:
    """A language model that likes "bed" as much as the picture shows, all words alike by what is
    said, and "mug" always."""

    def __init__(self) -> None:
        self.texts = set[str]()

    def score(self, tokens: F32, text: str, words: Sequence[str]) -> list[float]:
        self.texts.add(text)
        assert all(word.startswith(" ") for word in words)
        own = {" bed": float(tokens[0, 0]), " mug": 3.0}
        return [own.get(word, 0.0) - len(text) - 5 * float(tokens[0, 1]) for word in words]


def test_what_all_words_have_in_common_is_no_evidence() -> None:
    says = Says()
    expert = ByLanguage(Copies(), says.score)
    found = expert.evidence("beyond", sights(), ["bed", "mug"])
    # a reference that the picture speaks for speaks against all others
    spoken = 1.0 - 1.0 / len(SIGHT_REFERENCES) if "bed" in SIGHT_REFERENCES else 1.0
    assert found[:, 0].tolist() == pytest.approx([n * spoken for n in range(3)])
    assert found[:, 1].tolist() == pytest.approx([n * (spoken - 1.0) for n in range(3)])
    assert says.texts == {" Beyond is a"}


def test_nothing_is_asked_about_no_names() -> None:
    for kind in (ByEmbedding(embed), ByHead(Copies(), embed), ByLanguage(Copies(), Says().score)):
        assert kind.evidence("view", sights(), []).shape == (3, 0)


def test_no_language_model_is_asked_where_the_file_has_nothing_to_show_to_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "layout.onnx"
    write_layout(path, (2, 1, 1), "detector", "", speaks=False)
    located = manifest.located
    monkeypatch.setattr(manifest, "located", lambda name: path if name == MODEL else located(name))
    assert set(open_beholders(("head", "embedding")).kinds) == {"head", "embedding"}
    with pytest.raises(ModelError, match="leave out --kind language"):
        open_beholders(("head", "language"))


def test_the_default_models_are_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "layout.onnx"
    write_layout(path, (2, 1, 1), "detector", "language")
    located = manifest.located
    monkeypatch.setattr(manifest, "located", lambda name: path if name == MODEL else located(name))
    kinds, embed, detector = open_beholders(("language", "head", "embedding"))
    assert detector == "detector"
    shown = sights()
    shown = replace(shown, scene=np.tile(embed(["a room with a bed"]), (3, 1)))
    nats = {kind: asked.evidence("beyond", shown, WORDS) for kind, asked in kinds.items()}
    assert {kind: rows.shape for kind, rows in nats.items()} == dict.fromkeys(kinds, (3, 3))
    # it is blind to the first view, whose features are none; the further ones are as it were louder
    assert nats["language"][0] == pytest.approx([0.0] * 3, abs=1e-4)
    assert nats["head"][2] == pytest.approx(2 * nats["head"][1], rel=1e-3)
    assert nats["embedding"][:, 0] == pytest.approx([VIEW_SCALE] * 3, rel=1e-3)
    assert not np.allclose(nats["language"][1], nats["language"][2])
