"""The picture of an episode: what lies close together stays readable."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from hil_sim.evaluation.map_picture import JOURNAL_FILE, draw_map
from runtime.journal import Journal, write_map


def thing(name: str, x: float, confidence: float) -> dict[str, object]:
    cells = [[x, 1.0], [x + 0.05, 1.0]]
    return {"name": name, "xy": [x, 1.0], "confidence": confidence, "rejections": 0,
            "cells_xy": cells}  # fmt: skip


def run_folder(folder: Path) -> Path:
    """A room of 6 by 2 m; the toilet was found, and stands close to a towel and a bathtub."""
    free = np.ones((40, 120), bool)
    arrays = {"free": free, "occupied": ~free, "rooms": np.zeros((0, 40, 120)),
              "path_xy": np.array([[0.5, 0.5], [1.5, 0.5]])}  # fmt: skip
    objects = [thing("towel", 2.1, 0.99), thing("toilet", 2.0, 0.9), thing("bathtub", 2.2, 0.95),
               thing("sink", 5.0, 0.7), thing("vase", 1.0, 0.3)]  # fmt: skip
    write_map(folder, arrays, {
        "frame": {"x0_m": 0.0, "y0_m": 0.0, "resolution_m": 0.05}, "goal": "toilet",
        "objects": objects, "frontiers": [], "room_names": [], "elected": None,
        "stopped_at": [2.0, 1.0],
    })  # fmt: skip
    return folder


def test_the_goal_is_named_and_no_name_covers_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    named: list[str] = []
    real = Axes.annotate
    monkeypatch.setattr(Axes, "annotate", lambda axes, text, *rest, **more: (
        named.append(text), real(axes, text, *rest, **more))[1])  # fmt: skip
    draw_map(run_folder(tmp_path), tmp_path / "map.png")
    assert named[0] == "toilet"
    assert "towel" in named  # above the toilet's name, which stands below the star
    assert "bathtub" not in named  # would cover the towel's
    assert "sink" in named
    assert "vase" not in named  # not sure enough


def test_the_picture_has_the_shape_of_what_is_known(tmp_path: Path) -> None:
    out = draw_map(run_folder(tmp_path), tmp_path / "map.png")
    height, width = cv2.imread(str(out)).shape[:2]
    assert width > 2 * height


def expecting(folder: Path, *believed: dict[str, float]) -> Path:
    """Decisions that tell where the goal was expected: p by x, m."""
    with Journal(folder / JOURNAL_FILE) as journal:
        for step, told in enumerate(believed):
            places = [{"xy": [float(x), 1.0], "p": p} for x, p in told.items()]
            belief = {"places": places, "others": 0.1} if told else None
            journal.write("decision", step=step, belief=belief)
    return folder


def test_discs_show_where_the_goal_was_expected_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    discs: list[tuple[float, float]] = []
    real = Axes.add_patch

    def add_patch(axes: Axes, patch: Any) -> Any:
        if isinstance(patch, Circle):
            discs.append((patch.center[0], patch.radius))
        return real(axes, patch)

    monkeypatch.setattr(Axes, "add_patch", add_patch)
    folder = expecting(run_folder(tmp_path), {"1": 0.9}, {"4": 0.64, "5": 0.16, "3": 0.01}, {})
    draw_map(folder, tmp_path / "map.png")
    (first, wide), (second, narrow) = discs
    assert (first, second) == (4.0, 5.0)
    assert wide == pytest.approx(2 * narrow)  # four times the area for four times the chance


def test_a_journal_without_expectations_has_no_discs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Axes, "add_patch", lambda axes, patch: pytest.fail(str(patch)))
    draw_map(expecting(run_folder(tmp_path), {}), tmp_path / "map.png")


def test_the_title_names_the_method(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    titles: list[str] = []
    real = Axes.set_title
    monkeypatch.setattr(Axes, "set_title", lambda axes, text, **more: (
        titles.append(text), real(axes, text, **more))[1])  # fmt: skip
    folder = run_folder(tmp_path)
    told = {"scene": "maple", "method": "closest", "success": True, "ended": "stop"}
    (folder / "summary.json").write_text(json.dumps(told))
    draw_map(folder, tmp_path / "map.png")
    assert titles == ["find a toilet in maple by closest: success (stop)"]
