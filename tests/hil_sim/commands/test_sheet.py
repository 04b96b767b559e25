"""The sheet of goals: a page a goal, and a line for what is seen from nowhere."""

import json
from pathlib import Path

import cv2
import pytest
from click.testing import CliRunner
from places import TESTS

from hil_sim.__main__ import cli
from hil_sim.commands.sheet import CAPTION_PX, COLUMNS, TILE_PX
from hil_sim.scenes.format import Room, Scene, SceneError, SceneObject, Wall
from hil_sim.scenes.scene_file import scene_to_json

CORNERS = ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0))


@pytest.mark.slow
def test_goals_are_drawn_and_what_is_hidden_is_told(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    things = [
        SceneObject("mug-1", "mug", "builtin:mug", (2.0, 2.0, 0.5), 0.0, (0.12, 0.09, 0.1)),
        SceneObject("mug-2", "mug", "builtin:mug", (0.3, 0.3, 0.1), 0.0, (0.12, 0.09, 0.1)),
        SceneObject("crate", "other", "builtin:box", (0.3, 0.3, 0.0), 0.0, (0.5, 0.5, 1.5)),
    ]
    ends = zip(CORNERS, CORNERS[1:] + CORNERS[:1], strict=True)
    walls = tuple(Wall(a, b) for a, b in ends)
    home = Scene("home", walls, (), (Room("all", "kitchen", CORNERS),), tuple(things))
    file = tmp_path / "home.json"
    file.write_text(json.dumps(scene_to_json(home)))
    args = ["sheet", str(file), "--goal", "mug", "--workers", "1", "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(cli, args, catch_exceptions=False)
    assert done.exit_code == 0
    assert "mug-2: seen from nowhere" in done.output
    assert "mug-1" not in done.output
    page = cv2.imread(str(tmp_path / "out" / "mug-1.png"))
    assert page is not None
    assert page.shape == (TILE_PX[1] + CAPTION_PX, TILE_PX[0] * COLUMNS, 3)
    seen, hidden = page[CAPTION_PX:, : TILE_PX[0]], page[CAPTION_PX:, TILE_PX[0] : 2 * TILE_PX[0]]
    assert seen.std() > 5 > hidden.std()


@pytest.mark.parametrize(
    ("name", "told"),
    [("oak", "scene oak: unknown"), (str(TESTS / "refs/flat.json"), "size_m: missing")],
)
def test_a_home_that_cannot_be_drawn_is_told_before_any_is(name, told, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=told):
        CliRunner().invoke(cli, ["sheet", name, "--out", str(tmp_path)], catch_exceptions=False)
    assert not list(tmp_path.iterdir())
