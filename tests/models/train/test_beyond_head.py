"""The plain head learns what lies beyond, and goes on where it was stopped."""

from pathlib import Path

import numpy as np
import pytest
from drawn_homes import draw_homes

torch = pytest.importorskip("torch")

from models.train import beyond_head  # noqa: E402
from models.train.beyond_data import read_homes  # noqa: E402
from models.train.beyond_head import Lesson, Photographs, examine, teach_head, varied  # noqa: E402
from models.train.beyond_words import load_words  # noqa: E402
from models.words.text_encoder import TextEncoder  # noqa: E402


@pytest.fixture
def lesson(tmp_path: Path, encoder: TextEncoder, monkeypatch: pytest.MonkeyPatch) -> Lesson:
    monkeypatch.setattr(beyond_head, "MOMENTS", 8)
    monkeypatch.setattr(beyond_head, "FRAMES", 24)
    for name, seed in (("train", 1), ("dev", 2)):
        draw_homes(tmp_path / name, 4, seed)
    train, dev = (read_homes(tmp_path / name) for name in ("train", "dev"))
    words = load_words(train.categories, train.room_names, encoder.embed)
    return Lesson(train, dev, words)


def test_the_head_learns_and_resumes(lesson: Lesson, tmp_path: Path) -> None:
    torch.set_num_threads(1)
    told: list[str] = []
    teach_head(lesson, tmp_path, 30, 1, told.append, every=30)
    assert (tmp_path / "head.csv").read_text().startswith("step,")
    head = teach_head(lesson, tmp_path, 45, 1, told.append, every=30)
    assert "head: resumed at step 30" in told
    scores = examine(head, lesson, lesson.dev)
    assert scores.beyond > 0.85
    assert scores.onward > 0.4
    assert scores.room > 0.4
    assert scores.view > 0.7


def test_photographs_have_no_depth_and_are_taught(lesson: Lesson, tmp_path: Path) -> None:
    seen = torch.from_numpy(lesson.dev.features.astype(np.float32))
    given = Photographs(seen, torch.from_numpy(lesson.dev.room.astype(np.int64)))
    trainer = beyond_head.HeadTrainer(
        Lesson(lesson.train, lesson.dev, lesson.words, given), 10, seed=1
    )
    rng = np.random.default_rng(0)
    rows = next(trainer.moments.draw(4, rng))
    first = trainer.learn(rng, rows)["photographs"]
    for _ in range(9):
        last = trainer.learn(rng, rows)["photographs"]
    assert last < first


def test_a_mirrored_picture_has_its_way_on_the_other_side() -> None:
    features = torch.zeros(400, 1, 6, 8)
    features[..., 6] = 100.0
    depth = torch.ones(400, 2, 6, 8)
    way = torch.tensor([[6.5 / 8, 0.4]]).repeat(400, 1)
    seen, deep, toward = varied([features, depth, way], np.random.default_rng(0))
    at = (toward[:, 0] * 8 - 0.5).round().long().clamp(0, 7)
    assert {1, 6} <= set(at.tolist())
    bright = seen[:, 0, 0].argmax(1)
    assert float((bright - at).abs().float().mean()) < 0.5
    assert 0.02 < float((deep.sum((1, 2, 3)) == 0).float().mean()) < 0.4
