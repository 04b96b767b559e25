"""OBJ files as people publish them, and as we write them."""

from pathlib import Path

import numpy as np
import pytest

from hil_sim.scenes.furniture.catalog import CatalogError
from hil_sim.scenes.furniture.obj import read_geometry, read_obj
from hil_sim.simulation.shell import Surface

SHEET = """\
mtllib sheet.mtl
v 0 0 0
v 2 0 0
v 2 0 4
v 0 0 4
vt 0 0
vt 1 0 0
usemtl red
f 1 2 3 4
f -4/1 -3/-1 -2//1
usemtl glass
f 1 2 3
"""
MTL = """\
newmtl red
Kd 0.8 0.1 2
map_Kd none.png
newmtl glass
Tr 0.95
"""


@pytest.fixture
def sheet(tmp_path: Path) -> Path:
    (tmp_path / "sheet.obj").write_text(SHEET)
    (tmp_path / "sheet.mtl").write_text(MTL)
    return tmp_path / "sheet.obj"


def test_polygons_and_negative_indices_are_understood(sheet: Path) -> None:
    geometry = read_geometry(sheet)
    assert geometry.points.shape == (4, 3)
    assert geometry.uv.tolist() == [[0, 0], [1, 0]]
    red = geometry.faces["red"]
    assert red[..., 0].tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 2]]
    assert red[..., 1].tolist() == [[-1, -1, -1], [-1, -1, -1], [0, 1, -1]]
    assert geometry.corners.shape == (4, 3, 2)
    assert geometry.triangles[1].tolist() == [[0, 0, 0], [2, 0, 4], [0, 0, 4]]


def test_soups_have_a_material_each_and_glass_is_left_out(sheet: Path) -> None:
    (soup,) = read_obj(sheet)
    assert soup.material.colour == (0.8, 0.1, 1.0)
    assert soup.material.texture is None  # it is not there
    assert soup.uv[2].tolist() == [[0, 0], [1, 0], [0, 0]]


def test_what_we_write_is_read_as_it_was(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    triangles, uv = rng.normal(size=(5, 3, 3)).round(4), rng.random((5, 3, 2)).round(4)
    Surface(triangles, uv).write(tmp_path / "a.obj", tmp_path / "a.png")
    geometry = read_geometry(tmp_path / "a.obj")
    assert np.array_equal(geometry.triangles, triangles)
    assert np.array_equal(geometry.uv[geometry.corners[..., 1]], uv)
    assert [path.name for path in geometry.libraries] == ["a.mtl"]


@pytest.mark.parametrize("line", ["f 1 2 99", "v 1 two 3", "f a b c"])
def test_a_damaged_obj_is_named_with_its_line(tmp_path: Path, line: str) -> None:
    path = tmp_path / "bad.obj"
    path.write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{line}\n")
    with pytest.raises(CatalogError, match=r"bad\.obj:4: not an OBJ line"):
        read_obj(path)


def test_a_damaged_mtl_is_named_with_its_line(sheet: Path) -> None:
    sheet.with_suffix(".mtl").write_text("newmtl red\nKd 1 x 0\n")
    with pytest.raises(CatalogError, match=r"sheet\.mtl:2: not an MTL line: 'Kd 1 x 0'"):
        read_obj(sheet)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(CatalogError, match=r"none\.obj: cannot be read"):
        read_geometry(tmp_path / "none.obj")
