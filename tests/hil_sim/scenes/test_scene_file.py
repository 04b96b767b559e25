import json
from pathlib import Path
from typing import Any

import pytest

from hil_sim.scenes.format import SceneError
from hil_sim.scenes.scene_file import FORMAT, load_scene, parse_scene, save_scene


def small() -> dict[str, Any]:
    return {
        "format": FORMAT,
        "name": "small",
        "walls": [{"from": [0, 0], "to": [4, 0], "kind": "outer"}],
        "doors": [{"from": [1, 0], "to": [2, 0]}],
        "rooms": [{"name": "room", "type": "kitchen", "polygon": [[0, 0], [4, 0], [4, 3], [0, 3]]}],
        "objects": [
            {"id": "a", "category": "chair", "mesh": "Scopia#chair", "position_m": [1, 1, 0]}
        ],
    }


def broken(**changes: Any) -> dict[str, Any]:
    return {**small(), **changes}


CASES = [
    (broken(format="rf-nav-scene/9"), "format: is 'rf-nav-scene/9'"),
    (broken(wals=[]), "wals: unknown key; did you mean 'walls'?"),
    (broken(walls=[{"from": [1, 1], "to": [1, 1]}]), "walls[0]: a wall of zero length at (1, 1)"),
    (
        broken(rooms=[{"name": "r", "type": "kitchen", "polygon": [[0, 0], [1, 0]]}]),
        "rooms[0].polygon: a polygon needs at least 3 points",
    ),
    (
        broken(rooms=[{"name": "r", "type": "kichen", "polygon": [[0, 0], [1, 0], [1, 1]]}]),
        "rooms[0].type: unknown 'kichen'; did you mean 'kitchen'?",
    ),
    (broken(doors=[{"from": [1, 1], "to": [2, 1]}]), "doors[0]: lies on no wall's centre line"),
    (
        broken(objects=[{"id": "a", "category": "chair", "mesh": "m", "position_m": [1, 1]}]),
        "objects[0].position_m: is [1, 1], not 3 finite numbers",
    ),
    (
        broken(objects=[{"id": "a", "category": "tolet", "mesh": "m", "position_m": [1, 1, 0]}]),
        "objects[0].category: unknown 'tolet'; did you mean 'toilet'?",
    ),
    (
        broken(objects=small()["objects"] * 2),
        "objects[1]: 'a' is used twice",
    ),
    (
        broken(holes=[{"polygon": [[1, 1], [2, 1], [2, 2]], "depth_m": 0}]),
        "holes[0].depth_m: is 0, must be more than 0",
    ),
    (broken(holes=[{"polygon": [[1, 1], [2, 1], [2, 2]]}]), "holes[0].depth_m: missing"),
    (
        broken(
            holes=[{"polygon": [[1, 1], [3, 1], [3, 2], [2, 1.2]], "depth_m": 1, "stairs_rad": 0.0}]
        ),
        "holes[0].stairs_rad: only a convex polygon can have stairs",
    ),
    (
        broken(holes=[{"polygon": [[1, 1], [2, 1], [2, 2]], "depth_m": 1}] * 2),
        "holes[0]: lies over another hole",
    ),
    ([], "scene: is list, not an object"),
]


@pytest.mark.parametrize(("data", "message"), CASES)
def test_a_bad_scene_names_its_file_and_place(data: Any, message: str) -> None:
    with pytest.raises(SceneError) as error:
        parse_scene(data, "home.json")
    assert str(error.value).startswith(f"home.json: {message}")
    assert "\n" not in str(error.value)


def test_an_unknown_mesh_is_refused_with_the_nearest_known_one() -> None:
    with pytest.raises(SceneError, match=r"objects\[0\] \(a\): unknown mesh 'Scopia#chair'; did"):
        parse_scene(small(), "home.json", meshes={"Scopia#chair3"})


def test_an_unknown_scene_lists_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="scene oak: unknown; known: cedar, dais, landing, maple"):
        load_scene("oak")
    with pytest.raises(SceneError, match=r"none\.json: no such scene file"):
        load_scene(tmp_path / "none.json")


def test_a_file_that_is_not_json_names_the_line(tmp_path: Path) -> None:
    (tmp_path / "home.json").write_text('{\n "format": \n}')
    with pytest.raises(SceneError, match=r"home\.json:3: not JSON"):
        load_scene(tmp_path / "home.json")


def test_a_scene_survives_saving(tmp_path: Path) -> None:
    scene = parse_scene(small(), "home.json")
    save_scene(scene, tmp_path / "home.json")
    assert load_scene(tmp_path / "home.json") == scene
    assert json.loads((tmp_path / "home.json").read_text())["format"] == FORMAT
