"""Photographs of rooms, as a detector whose word is given sees them."""

import json
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from hil_sim.expert_bench.photographs import load_photographs
from hil_sim.expert_bench.seeing import BenchDetector
from hil_sim.scenes.format import ROOM_TYPES
from runtime.core.types import U8
from runtime.errors import RfNavError

RED = (255, 0, 0)


class Colours:
    """Sees how red, green and blue an image is."""

    def detect(self, rgb: U8) -> SimpleNamespace:
        mean = rgb.reshape(-1, 3).mean(axis=0)
        return SimpleNamespace(
            features=np.tile(mean[:, None, None], (1, 2, 4)), scene=mean, rooms=np.eye(7)[1]
        )

    def close(self) -> None: ...


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(BenchDetector, "open", lambda: SimpleNamespace(models=Colours()))
    (tmp_path / "images").mkdir()
    for name in ("a.png", "b.png", "c.png"):
        cv2.imwrite(str(tmp_path / "images" / name), np.full((6, 8, 3), RED[::-1], np.uint8))
    told = [("a.png", "bathroom"), ("b.png", "garage"), ("c.png", "kitchen")]
    images = [{"file_name": name, "room": room} for name, room in told]
    (tmp_path / "annotations.json").write_text(json.dumps({"images": images}))
    return tmp_path


def test_rooms_that_homes_have_are_asked_about(folder: Path) -> None:
    sights, rooms = load_photographs(folder)
    assert [ROOM_TYPES[r] for r in rooms] == ["bathroom", "kitchen"]
    assert sights.home == ("a.png", "c.png")
    assert sights.features.shape == (2, 3, 2, 4)
    assert sights.features[0, :, 0, 0].tolist() == list(RED)  # RGB
    assert sights.depth.shape == (2, 2, 2, 4)
    assert not sights.depth.any()
    assert len(sights.column) == len(sights.range_m) == len(sights.scene) == len(sights) == 2


def test_what_cannot_be_used_is_named(folder: Path) -> None:
    (folder / "images" / "c.png").unlink()
    with pytest.raises(RfNavError, match=r"c\.png: no such photograph"):
        load_photographs(folder)
    (folder / "annotations.json").write_text('{"images": [{"file_name": "b.png", "room": "x"}]}')
    with pytest.raises(RfNavError, match="no photograph of a room"):
        load_photographs(folder)
    (folder / "annotations.json").write_text('{"images": [{"file_name": "b.png"}]}')
    with pytest.raises(RfNavError, match="not a table of photographs with rooms"):
        load_photographs(folder)
