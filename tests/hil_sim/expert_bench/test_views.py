"""A drive through a home of three rooms: what is seen toward its frontiers, and what is kept."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from hil_sim.expert_bench import views
from hil_sim.expert_bench.bank import BankPlan
from hil_sim.expert_bench.seeing import BenchDetector
from hil_sim.expert_bench.views import (
    KINDS,
    HomeViews,
    make_views,
    read_views,
    views_of,
    write_views,
)
from hil_sim.ground_truth.labels import LABELLED
from hil_sim.scenes.format import ROOM_TYPES
from runtime.core.mapping import keyframes
from runtime.core.types import Detections
from runtime.errors import RfNavError
from tests.hil_sim.expert_bench.test_drive import Grey, scene

pytestmark = pytest.mark.slow  # a home is driven through

BED, TOILET = (LABELLED.index(name) for name in ("bed", "toilet"))


class Marked(Grey):
    """Each look leaves its number in the features."""

    rooms = ROOM_TYPES

    def __init__(self, sha256: str = "abc", parts: int = 2) -> None:
        self.looks, self.sha256, self.parts = 0, sha256, parts

    def detect(self, rgb: np.ndarray) -> Detections:
        self.looks += 1
        rooms = np.full(len(ROOM_TYPES), 1 / 7, np.float32)
        features = np.full((self.parts, 6, 8), self.looks, np.float32)
        return replace(super().detect(rgb), rooms=rooms, features=features)

    def features_of(self) -> tuple[str, ...]:
        return (self.sha256,) if self.sha256 else ()

    def close(self) -> None:
        pass


@pytest.fixture(scope="module")
def offered() -> list[np.ndarray]:
    """Poses that there was to choose among, of each frontier at each moment."""
    return []


def bench(models: Marked) -> BenchDetector:
    return BenchDetector(models, LABELLED, BenchDetector.settings())  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def seen(offered: list[np.ndarray]) -> list[HomeViews]:
    """One drive, as two detectors see it."""

    def best_frames(poses: np.ndarray, *told: object) -> tuple[int, ...]:
        offered.append(poses)
        return keyframes.best_frames(poses, *told)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(views, "open_scene", lambda name: scene())
        patch.setattr(views, "best_frames", best_frames)
        plan = BankPlan(starts=1, steps=40, moments=4, apart=4)
        return views_of("three", bench(Marked()), plan, [bench(Marked("other", 3))])


@pytest.fixture(scope="module")
def driven(seen: list[HomeViews]) -> HomeViews:
    return seen[0]


def test_every_view_is_of_a_frame_that_was_taken(driven: HomeViews):
    assert len(driven.frame) >= 4
    assert set(driven.frame) == set(range(len(driven.room)))  # none is kept for nothing
    looks = driven.features[:, 0, 0, 0]
    assert (np.diff(looks) > 0).all()
    assert ((driven.column >= 0) & (driven.column <= 1)).all()
    assert (driven.range_m < 6.0).all()
    assert (driven.depth[:, 1] > 0.9).any()


def test_there_is_a_choice_among_kept_keyframes_alone(driven: HomeViews, offered: list[np.ndarray]):
    assert driven.detector == "abc"
    assert max(len(poses) for poses in offered) > 6
    for poses in offered:
        gap = poses[:, None] - poses
        moved, turned = np.hypot(gap[..., 0], gap[..., 1]), np.abs(wrapped(gap[..., 2]))
        alike = (moved < keyframes.MOVED_M) & (turned < keyframes.TURNED_RAD)
        assert alike.sum() == len(poses)  # each with itself


def test_another_detector_sees_the_same_frames(seen: list[HomeViews]):
    first, other = seen
    assert other.detector == "other"
    assert other.features.shape == (len(first.features), 3, 6, 8)
    assert other.features[:, 0, 0, 0].tolist() == list(range(1, len(first.features) + 1))
    for one in set(KINDS) - {"features"}:
        np.testing.assert_array_equal(getattr(other, one), getattr(first, one))


def test_a_detector_that_tells_no_features_is_refused(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
):
    monkeypatch.setattr(BenchDetector, "open", lambda name: bench(Marked("" if name else "abc")))
    with pytest.raises(RfNavError, match=r"^mute\.onnx: does not tell what its backbone sees"):
        make_views({"": tmp_path / "a.npz", "mute.onnx": tmp_path / "b.npz"}, "three")
    assert not list(tmp_path.iterdir())


def wrapped(angle: np.ndarray) -> np.ndarray:
    return (angle + np.pi) % (2 * np.pi) - np.pi


def test_the_best_view_comes_first_and_once(driven: HomeViews):
    seen = {}
    for n in range(len(driven.frame)):
        key = driven.moment[n], driven.frontier[n]
        assert driven.best[n] == (key not in seen)
        seen[key] = n


def test_truth_goes_with_what_was_not_in_view(driven: HomeViews):
    assert not (driven.asked & driven.absent).any()
    assert np.isfinite(driven.onward_m[driven.asked]).all()
    assert np.isinf(driven.beyond_m[driven.absent]).all()
    assert (driven.beyond_m >= driven.onward_m - 1e-3).all()
    assert driven.asked[:, [BED, TOILET]].any()


def test_a_file_is_read_as_it_was_written(driven: HomeViews, tmp_path: Path):
    write_views(tmp_path / "three.npz", driven)
    again = read_views(tmp_path / "three.npz")
    for one in fields(HomeViews):
        np.testing.assert_array_equal(getattr(again, one.name), getattr(driven, one.name))


def test_another_file_is_refused(tmp_path: Path):
    (tmp_path / "broken.npz").write_bytes(b"PK nonsense")
    with pytest.raises(RfNavError, match=r"broken\.npz: not a home's views.*remove it"):
        read_views(tmp_path / "broken.npz")
    np.savez(tmp_path / "old.npz", format=0, categories=[], room_names=[])
    with pytest.raises(RfNavError, match="made by another version"):
        read_views(tmp_path / "old.npz")
