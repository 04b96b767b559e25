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
from runtime.journal import Journal, read_map, write_map
from runtime.map_look import COLOURS, room_tint


def thing(name: str, x: float, confidence: float) -> dict[str, object]:
    cells = [[x, 1.0], [x + 0.05, 1.0]]
    return {"name": name, "xy": [x, 1.0], "confidence": confidence, "rejections": 0,
            "cells_xy": cells}  # fmt: skip


def run_folder(folder: Path) -> Path:
    """A room of 6 by 2 m; the toilet was found, and stands close to a towel and a bathtub."""
    free = np.ones((40, 120), bool)
    arrays = {"free": free, "occupied": ~free, "rooms": np.zeros((0, 40, 120)),
              "path_xy": np.array([[0.5, 0.5], [1.5, 0.5]])}  # fmt: skip
    crowd = [thing(f"towel {n}", 2.1, 0.95 - n / 100) for n in range(8)]
    objects = [*crowd, thing("toilet", 2.0, 0.9), thing("sink", 5.0, 0.7),
               thing("vase", 1.0, 0.3)]  # fmt: skip
    write_map(folder, arrays, {
        "frame": {"x0_m": 0.0, "y0_m": 0.0, "resolution_m": 0.05}, "goal": "toilet",
        "objects": objects, "frontiers": [], "room_names": [], "elected": None,
        "stopped_at": [2.0, 1.0],
    })  # fmt: skip
    return folder


@pytest.fixture
def named(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is written on things and discs."""
    words: list[str] = []
    real = Axes.annotate
    monkeypatch.setattr(Axes, "annotate", lambda axes, text, *rest, **more: (
        words.append(text), real(axes, text, *rest, **more))[1])  # fmt: skip
    return words


def test_the_goal_is_named_and_no_name_covers_another(tmp_path: Path, named: list[str]) -> None:
    draw_map(run_folder(tmp_path), tmp_path / "map.png")
    assert named[0] == "toilet"
    assert "towel 0" in named
    assert "towel 7" not in named  # would cover the others'
    assert "sink" in named
    assert "vase" not in named  # not sure enough


def test_things_are_grey_and_none_is_without_a_name(
    tmp_path: Path, named: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    outlines: list[str] = []
    real = Axes.fill

    def fill(axes: Axes, *points: Any, **look: Any) -> Any:
        if "ec" in look:
            outlines.append(look["ec"])
        return real(axes, *points, **look)

    monkeypatch.setattr(Axes, "fill", fill)
    draw_map(run_folder(tmp_path), tmp_path / "map.png")
    assert outlines == [COLOURS["goal"], *[COLOURS["thing"]] * (len(named) - 1)]


def legend_of(run: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    told: list[str] = []
    real = Axes.legend

    def legend(axes: Axes, handles: list[Any], **how: Any) -> Any:
        told.extend(handle.get_label() for handle in handles)
        return real(axes, handles=handles, **how)

    monkeypatch.setattr(Axes, "legend", legend)
    draw_map(run, run / "map.png")
    return told


def test_the_legend_has_what_is_drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told = legend_of(run_folder(tmp_path), monkeypatch)
    assert told == ["start", "path and end", "target", "thing", "sought thing", "unknown"]


def test_frontiers_and_rooms_have_the_colours_of_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_folder(tmp_path)
    arrays, meta = read_map(tmp_path)
    arrays["rooms"] = np.full((1, *arrays["free"].shape), 3.0)
    meta |= {"room_names": ["bathroom"], "objects": [], "elected": 4, "frontiers": [
        {"id": 4, "distance_m": 1.0, "cells_xy": [[3.0, 0.5], [3.0, 0.55], [3.0, 1.5]]},
        {"id": 5, "distance_m": None, "cells_xy": [[4.0, 0.5]]},
    ]}  # fmt: skip
    write_map(tmp_path, arrays, meta)
    ids: dict[str, tuple[float, float]] = {}
    real = Axes.text
    monkeypatch.setattr(Axes, "text", lambda axes, x, y, text, **how: (
        ids.update({text: (x, y)}), real(axes, x, y, text, **how))[1])  # fmt: skip
    told = legend_of(tmp_path, monkeypatch)
    assert "elected frontier" in told
    assert "frontier (id)" not in told  # no way leads to the other
    assert told[-1] == "bathroom"
    assert ids["4"] == (3.0, 0.55)  # a dot of it, where the middle is on none
    image = cv2.imread(str(tmp_path / "map.png"))[..., ::-1].reshape(-1, 3)
    assert (image == room_tint("bathroom")).all(axis=1).sum() > len(image) / 4


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


def test_the_number_is_on_the_three_likeliest_alone(tmp_path: Path, named: list[str]) -> None:
    places = {"1": 0.1, "2.9": 0.3, "4": 0.25, "5.5": 0.2, "3.6": 0.05}
    draw_map(expecting(run_folder(tmp_path), places), tmp_path / "map.png")
    assert [word for word in named if "%" in word] == ["30 %", "25 %", "20 %"]


def test_a_journal_without_expectations_has_no_discs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = Axes.add_patch

    def add_patch(axes: Axes, patch: Any) -> Any:
        assert not isinstance(patch, Circle)
        return real(axes, patch)

    monkeypatch.setattr(Axes, "add_patch", add_patch)
    assert "expected (p)" not in legend_of(expecting(run_folder(tmp_path), {}), monkeypatch)


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
