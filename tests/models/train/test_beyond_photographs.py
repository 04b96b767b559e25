"""Photographs are seen by the detector once, and kept."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

torch = pytest.importorskip("torch")

from models.errors import ModelFileError  # noqa: E402
from models.store import manifest  # noqa: E402
from models.train import beyond_photographs  # noqa: E402
from models.train.beyond_photographs import read_photographs  # noqa: E402

WEIGHTS = Path(manifest.__file__).parents[1] / "weights"
ROOMS = ("kitchen", "bathroom")


def draw(folder: Path) -> None:
    (folder / "images").mkdir(parents=True)
    rng = np.random.default_rng(0)
    rows = []
    for at, room in enumerate(("bathroom", "kitchen", "garage")):
        image = rng.integers(0, 255, (64, 64, 3)).astype(np.uint8)
        cv2.imwrite(str(folder / "images" / f"{at}.jpg"), image)
        rows.append({"id": at, "file_name": f"{at}.jpg", "width": 64, "height": 64, "room": room})
    table = {"images": rows, "annotations": [], "categories": [], "info": {"labelled": []}}
    (folder / "annotations.json").write_text(json.dumps(table))


def test_photographs_of_known_rooms_are_seen_once(tmp_path: Path) -> None:
    draw(tmp_path / "photos")
    given = (tmp_path / "photos", WEIGHTS / "rfnav-det.onnx", tmp_path / "kept.npz", ROOMS)
    seen = read_photographs(*given, None, print)
    assert seen.room.tolist() == [1, 0]
    assert seen.features.shape[0] == 2
    (tmp_path / "photos" / "annotations.json").unlink()
    again = read_photographs(*given, lambda features: features[:, :3], print)
    torch.testing.assert_close(again.features, seen.features[:, :3])


def test_another_detector_looks_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    draw(tmp_path / "photos")

    def look(detector: Path, images: list[Path], say: object) -> np.ndarray:
        return np.full((len(images), 4, 6, 8), float(detector.read_text()), np.float16)

    monkeypatch.setattr(beyond_photographs, "look", look)
    kept, detector = tmp_path / "kept.npz", tmp_path / "detector.onnx"
    np.savez(kept, features=np.zeros((1, 4, 6, 8)), room=["kitchen"])  # nobody knows by whom
    for told in ("1", "2", "1"):
        detector.write_text(told)
        seen = read_photographs(tmp_path / "photos", detector, kept, ROOMS, None, print)
        assert seen.features.unique().tolist() == [float(told)]
        assert seen.room.tolist() == [1, 0]


def test_a_detector_that_does_not_tell_is_refused(tmp_path: Path) -> None:
    draw(tmp_path / "photos")
    plain = WEIGHTS / "rfnav-det-photos.onnx"
    with pytest.raises(ModelFileError, match="has no output features"):
        read_photographs(tmp_path / "photos", plain, tmp_path / "k.npz", ROOMS, None, print)
