"""Embedded models -> meshes beside the scene."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from drawn import CUBE, MTL, ROOMS, WALLS, piece, save, xml

from hil_sim.scenes.format import Scene
from hil_sim.scenes.furniture.obj import read_obj
from hil_sim.scenes.furniture.soup import Soup
from hil_sim.scenes.sweethome.importer import Report, import_home

RED = (1.0, 0.0, 0.0)
FILES = {"0/cube.obj": CUBE.encode(), "0/cube.mtl": MTL.encode()}
TURN_LEFT = "0 0 -1 0 1 0 1 0 0"


def placed(
    tmp_path: Path, files: dict[str, bytes] = FILES, inner: str = "", **more: object
) -> tuple[Scene, Report, list[Soup]]:
    one = piece("Box", 200, 200, **{"model": "0/cube.obj", **more})
    one = one.replace("</pieceOfFurniture>", f"{inner}</pieceOfFurniture>")
    path = save(tmp_path / "home.sh3d", xml(WALLS, ROOMS, one), files)
    scene, report = import_home(path, tmp_path / "out")
    return scene, report, read_obj(tmp_path / "out" / scene.objects[0].mesh)


def middle(soups: list[Soup], colour: tuple[float, float, float]) -> np.ndarray:
    (found,) = [s for s in soups if s.material.colour == pytest.approx(colour, abs=0.01)]
    return found.corners.reshape(-1, 3).mean(axis=0)


def test_a_model_is_fitted_with_its_front_to_the_front(tmp_path: Path) -> None:
    _, report, soups = placed(tmp_path)
    corners = np.concatenate([s.corners.reshape(-1, 3) for s in soups])
    np.testing.assert_allclose(np.ptp(corners, axis=0), (1.0, 0.8, 0.5), atol=1e-4)
    np.testing.assert_allclose(middle(soups, RED), (0, 0, 0.25), atol=1e-4)  # Y up: z is -y
    assert report.notes == ["drawn but never labelled (not one of our categories): Box"]


def test_model_rotation_is_row_major(tmp_path: Path) -> None:
    _, _, soups = placed(tmp_path, modelRotation=TURN_LEFT)
    np.testing.assert_allclose(middle(soups, RED), (-0.5, 0, 0), atol=1e-4)


def test_a_mirrored_model_keeps_its_faces_outward(tmp_path: Path) -> None:
    for more in ({}, {"modelMirrored": "true"}):
        _, _, soups = placed(tmp_path, modelRotation=TURN_LEFT, **more)
        x = middle(soups, RED)[0]
        (front,) = [s for s in soups if s.material.colour == pytest.approx(RED, abs=0.01)]
        a, b, c = front.corners[0]
        assert np.cross(b - a, c - a)[0] * x > 0
        assert (x > 0) == bool(more)


def test_a_leaning_piece_is_as_wide_as_it_is_drawn(tmp_path: Path) -> None:
    scene, _, soups = placed(tmp_path, roll=np.pi / 2)
    assert scene.objects[0].size_m == pytest.approx((0.8, 0.5, 1.0), abs=1e-3)
    _, _, soups = placed(tmp_path, pitch=np.pi / 2)
    assert middle(soups, RED)[1] == pytest.approx(0.25, abs=1e-4)  # the front now looks up


def test_colours_chosen_in_the_drawing_replace_the_models(tmp_path: Path) -> None:
    _, _, soups = placed(tmp_path, color="FF00FF00")
    assert {s.material.colour for s in soups} == {(0.0, 1.0, 0.0)}
    _, _, soups = placed(tmp_path, inner='<material name="front" color="FF0000FF"/>')
    assert (0.0, 0.0, 1.0) in {s.material.colour for s in soups}
    blue = cv2.imencode(".png", np.full((9, 9, 3), (255, 0, 0), np.uint8))[1].tobytes()
    painted = '<texture name="t" image="7" width="1" height="1"/>'
    _, _, soups = placed(tmp_path, {**FILES, "7": blue}, painted)
    assert {s.material.colour for s in soups} == {(0.0, 0.0, 1.0)}


def test_a_texture_comes_along(tmp_path: Path) -> None:
    skin = cv2.imencode(".jpg", np.full((900, 90, 3), 99, np.uint8))[1].tobytes()
    mtl = MTL.replace("Kd 1 0 0", "Kd 1 0 0\nmap_Kd skin.jpg").encode()
    _, _, soups = placed(tmp_path, {**FILES, "0/cube.mtl": mtl, "0/skin.jpg": skin})
    (texture,) = [s.material.texture for s in soups if s.material.texture]
    assert texture.parent == tmp_path / "out" / "meshes"
    assert max(cv2.imread(str(texture)).shape) == 512


def test_one_model_is_written_once(tmp_path: Path) -> None:
    many = "".join(piece("Chair", 50 + 20 * i, 200, model="0/cube.obj") for i in range(5))
    path = save(tmp_path / "home.sh3d", xml(WALLS, ROOMS, many), FILES)
    scene, _ = import_home(path, tmp_path / "out")
    assert len({obj.mesh for obj in scene.objects}) == 1


@pytest.mark.parametrize(
    ("files", "why"),
    [
        ({"0/cube.obj": b"v 1 2\nv 3 4 5\nv 0 0 0\nf 1 2 3\n"}, "cannot be read"),
        ({"0/cube.obj": b"v nan 0 0\nv 3 4 5\nv 0 0 0\nf 1 2 3\n"}, "not finite"),
        ({"0/cube.obj": b"f 1 2 3\n"}, "cannot be read: model.obj:1: not an OBJ line"),
        ({"0/cube.obj": b"# empty\n"}, "nothing to be seen"),
        ({}, "its model is not in the file"),
    ],
)
def test_an_unreadable_model_becomes_a_box(
    tmp_path: Path, files: dict[str, bytes], why: str
) -> None:
    scene, report, soups = placed(tmp_path, files, color="FF336699")
    assert scene.objects[0].size_m == (1.0, 0.5, 0.8)
    assert {s.material.colour for s in soups} == {(0.2, 0.4, 0.6)}
    (line,) = [note for note in report.notes if "drawn as a box" in note]
    assert line.startswith("pieceOfFurniture[0] (Box): ")
    assert why in line


@pytest.mark.parametrize("suffix", ["dae", "3ds", "kmz", "lws"])
def test_other_formats_become_boxes(tmp_path: Path, suffix: str) -> None:
    name = f"0/chair.{suffix}"
    _, report, soups = placed(tmp_path, {name: b"\x00\x01 something"}, model=name)
    assert len(soups[0].corners) == 12
    assert any(f"its model is {suffix}, not OBJ" in note for note in report.notes)


def test_nothing_is_written_or_read_outside(tmp_path: Path) -> None:
    secret = tmp_path / "secret.png"
    cv2.imwrite(str(secret), np.zeros((4, 4, 3), np.uint8))
    obj = CUBE.replace("cube.mtl", "cube.mtl\nmtllib ../../../../../../etc/passwd").encode()
    mtl = f"newmtl body\nKd 1 1 1\nmap_Kd {secret}\nnewmtl front\nKd 1 0 0\n".encode()
    files = {
        "0/cube.obj": obj, "0/cube.mtl": mtl, "0/../../evil.txt": b"x", "0//evil2.txt": b"x",
        "0/..\\..\\evil3.txt": b"x", "/evil4.txt": b"x", "../evil5.txt": b"x",
    }  # fmt: skip
    _, _, soups = placed(tmp_path, files)
    assert all(s.material.texture is None for s in soups)
    written = {p.relative_to(tmp_path).parts[:2] for p in tmp_path.rglob("*") if p.is_file()}
    assert written == {("home.sh3d",), ("secret.png",), ("out", "meshes")}
