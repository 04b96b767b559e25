"""Furniture files as people publish them -> meshes the simulator can draw."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.furniture.catalog import Catalog, CatalogError, parse_properties
from hil_sim.scenes.furniture.meshes import convert
from hil_sim.scenes.furniture.shapes.named import SHAPES

CUBE = """\
mtllib cube.mtl
v 0 0 0
v 2 0 0
v 2 0 4
v 0 0 4
v 0 6 0
v 2 6 0
v 2 6 4
v 0 6 4
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl red
f 1 2 3 4
f -4 -3 -2 -1
usemtl picture
f 1/1 2/2 6/3 5/4
usemtl invisible
f 3 4 8
"""
MTL = """\
newmtl red
Kd 0.8 0.1 0.1
newmtl picture
Kd 1 1 1
map_Kd skin.png
newmtl invisible
d 0.0
"""


@pytest.fixture
def cube(tmp_path: Path) -> Path:
    (tmp_path / "cube.obj").write_text(CUBE)
    (tmp_path / "cube.mtl").write_text(MTL)
    cv2.imwrite(str(tmp_path / "skin.png"), np.full((700, 301, 3), 90, np.uint8))
    return tmp_path / "cube.obj"


def vertices(obj: Path) -> np.ndarray:
    rows = [line.split()[1:] for line in obj.read_text().splitlines() if line.startswith("v ")]
    return np.array(rows, float)


def test_y_up_becomes_z_up_with_the_origin_under_the_middle(cube: Path, tmp_path: Path):
    mesh = convert(cube, None, None, tmp_path / "store")
    assert mesh.size_m == pytest.approx((2.0, 4.0, 6.0))
    points = np.concatenate([vertices(p.obj) for p in mesh.parts])
    assert points.min(axis=0) == pytest.approx([-1, -2, 0])
    assert points.max(axis=0) == pytest.approx([1, 2, 6])


def test_a_size_is_fitted_and_a_rotation_comes_first(cube: Path, tmp_path: Path):
    quarter = (0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0)  # about the vertical: x <-> z
    mesh = convert(cube, quarter, (0.4, 0.2, 0.3), tmp_path / "store")
    assert mesh.size_m == pytest.approx((0.4, 0.2, 0.3))
    plain = convert(cube, quarter, None, tmp_path / "store")
    assert plain.size_m == pytest.approx((4.0, 2.0, 6.0))


def test_textures_are_small_with_rows_of_whole_words(cube: Path, tmp_path: Path):
    mesh = convert(cube, None, None, tmp_path / "store")
    assert len(mesh.parts) == 2  # the plain colours together, and the picture
    for part in mesh.parts:
        image = cv2.imread(str(part.texture))
        assert max(image.shape[:2]) <= 256
        assert image.shape[1] % 4 == 0
    palette = cv2.imread(str(mesh.parts[0].texture))
    assert [204, 26, 26] in palette[..., ::-1].reshape(-1, 3).tolist()


def test_the_second_time_it_comes_from_the_cache(cube: Path, tmp_path: Path):
    store = tmp_path / "store"
    mesh = convert(cube, None, None, store)
    stamp = mesh.parts[0].obj.stat().st_mtime_ns
    assert convert(cube, None, None, store) == mesh
    assert mesh.parts[0].obj.stat().st_mtime_ns == stamp
    assert len(list(store.iterdir())) == 1


def test_an_empty_obj_is_refused(tmp_path: Path):
    path = tmp_path / "empty.obj"
    path.write_text("# nothing\n")
    with pytest.raises(CatalogError, match="holds no triangles"):
        convert(path, None, None, tmp_path / "store")


@pytest.mark.parametrize("name", sorted(SHAPES))
def test_every_builtin_stands_on_the_floor(name: str, tmp_path: Path):
    mesh = Assets(tmp_path).mesh(f"builtin:{name}")
    points = np.concatenate([vertices(p.obj) for p in mesh.parts])
    assert points[:, 2].min() == pytest.approx(0.0, abs=1e-6)
    assert np.ptp(points, axis=0) == pytest.approx(mesh.size_m, abs=1e-4)


def test_unknown_meshes_say_what_there_is(tmp_path: Path):
    with pytest.raises(CatalogError, match=r"builtin:throne: unknown; known are .*television"):
        Assets(tmp_path).mesh("builtin:throne")
    with pytest.raises(CatalogError, match="run `hil-sim assets pull`"):
        Assets(tmp_path).mesh("Scopia#sofa")
    with pytest.raises(CatalogError, match=r"none\.obj: no such mesh"):
        Assets(tmp_path).mesh("none.obj", tmp_path)


def test_properties_files_follow_java():
    table = parse_properties(
        "# comment\n! another\nname#1=Fauteuil \\u00e9l\\u00e9gant\n"
        "tags#1=a,\\\n   b\nempty=\nkey = with = sign\n"
    )
    assert table == {
        "name#1": "Fauteuil élégant",
        "tags#1": "a,b",
        "empty": "",
        "key": "with = sign",
    }


def test_a_catalogue_gives_sizes_in_metres_and_who_made_it(tmp_path: Path):
    folder = tmp_path / "KatorLegaz"
    folder.mkdir()
    (folder / "PluginFurnitureCatalog.properties").write_text(
        "id=x\nname=Kator Legaz\nid#1=K#chair\nname#1=Chair\nmodel#1=/a/chair.obj\nwidth#1=45\n"
        "depth#1=50.5\nheight#1=90\ncreator#1=Kator\nmodelRotation#1=0 0 1 0 1 0 -1 0 0\n"
        "id#2=K#dae\nname#2=Other\nmodel#2=/a/other.dae\nwidth#2=1\ndepth#2=1\nheight#2=1\n",
        encoding="latin-1",
    )
    catalog = Catalog(tmp_path)
    assert list(catalog.models) == ["K#chair"]
    chair = catalog.model("K#chair")
    assert chair.size_m == pytest.approx((0.45, 0.505, 0.9))
    assert chair.rotation == (0, 0, 1, 0, 1, 0, -1, 0, 0)
    assert catalog.attribution(["K#chair", "builtin:rug", "K#chair"]) == (
        "- Chair (`K#chair`), by Kator, Kator Legaz: CC BY 3.0"
    )
    with pytest.raises(CatalogError, match="K#sofa: no such model"):
        catalog.model("K#sofa")
