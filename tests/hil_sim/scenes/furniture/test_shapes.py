"""Meshes of simple geometry: all stand, all are light, no two are the same; and the list of
furniture that they and the catalogues make up."""

import json
from pathlib import Path

import numpy as np
import pytest

from hil_sim.ground_truth.goals import BROAD, GOALS, SYNONYMS, categories_of
from hil_sim.scenes.format import CATEGORIES
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.furniture.boxes import furniture
from hil_sim.scenes.furniture.meshes import builtin
from hil_sim.scenes.furniture.shapes.named import BUILTINS, OWN, SHAPES, VARIANTS
from hil_sim.scenes.furniture.shapes.primitives import ball, box, cylinder, lathe, slab, tube
from hil_sim.scenes.furniture.soup import Soup

MOST_TRIANGLES, MOST_OF_OWN = 800, 4000  # the latter before it is thinned out
ROBOTHOR = {
    "alarm clock", "apple", "baseball bat", "basketball", "bowl", "trash can", "plant", "laptop",
    "mug", "spray bottle", "television", "vase",
}  # fmt: skip
FLAT = 0.001
LISTED = [(category, mesh) for category, meshes in furniture().items() for mesh in meshes]


def corners(parts: list[Soup]) -> np.ndarray:
    return np.concatenate([part.corners for part in parts])


def volume(part: Soup) -> float:
    """Signed: positive when a closed part is wound outward."""
    a, b, c = (part.corners[:, i] for i in range(3))
    return float(np.sum(a * np.cross(b, c)) / 6)


@pytest.mark.parametrize(
    ("part", "expected"),
    [
        (box((2, 3, 4), (5, 5, 5), (1, 1, 1)), 24.0),
        (cylinder(1.0, 1.0, 2.0, (1, 1, 1), 64), 2 * np.pi),
        (lathe([(0, 0), (1, 0), (0, 3)], (1, 1, 1), 64), np.pi),
        (ball((2, 2, 2), (3, 0, 0), (1, 1, 1), 40, 64), 4 / 3 * np.pi),
        (tube([(0, 0, 0), (0, 0, 1), (0, 0, 3)], 1.0, (1, 1, 1), 64), 3 * np.pi),
        (tube([(0, 0, 0), (4, 0, 0)], 0.5, (1, 1, 1), 64), np.pi),
        (slab([(0, 0), (2, 0), (2, 1), (0, 1)], 3.0, (1, 1, 1)), 6.0),
    ],
)
def test_solids_are_closed_and_wound_outward(part: Soup, expected: float):
    assert volume(part) == pytest.approx(expected, rel=0.01)
    moved = Soup(part.material, part.corners + 7.0, part.uv)
    assert volume(moved) == pytest.approx(volume(part), rel=1e-6)  # only if closed


@pytest.mark.parametrize("name", sorted(SHAPES))
def test_a_shape_is_light_and_of_a_size_that_fits_a_home(name: str):
    for k in range(OWN.get(name, VARIANTS)):
        points = corners(SHAPES[name](k))
        assert np.isfinite(points).all()
        assert 12 <= len(points) <= (MOST_OF_OWN if name in OWN else MOST_TRIANGLES)
        size = np.ptp(points.reshape(-1, 3), axis=0)
        assert 0.05 <= size.max() <= 2.6
        assert size.min() >= FLAT


@pytest.mark.parametrize("name", sorted(SHAPES))
def test_variants_differ(name: str):
    made = [SHAPES[name](k) for k in range(OWN.get(name, VARIANTS))]
    looks = {
        (tuple(p.material.colour for p in parts), corners(parts).round(4).tobytes())
        for parts in made
    }
    assert len(looks) == len(made)


def test_the_plain_name_is_the_first_variant(tmp_path: Path):
    assert builtin("mug", tmp_path) == builtin("mug.0", tmp_path)
    assert builtin("mug", tmp_path) != builtin("mug.1", tmp_path)


def test_every_category_has_meshes_to_train_on():
    for category in set(CATEGORIES) - {"other", "door"}:
        meshes = furniture()[category]
        assert any(m.split == "train" for m in meshes), category
        if len(meshes) >= 3:
            assert any(m.split == "val" for m in meshes), category
    assert len(CATEGORIES) >= 70
    assert set(furniture()) <= set(CATEGORIES)


def test_the_goals_of_robothor_come_in_several_meshes():
    for category in ROBOTHOR:
        meshes = furniture()[category]
        assert sum(m.split == "train" for m in meshes) >= 4, category


def test_only_varied_homes_and_replicas_have_what_is_theirs():
    theirs = {m.id: m.split for _, m in LISTED if m.split.endswith("varied")}
    assert set(theirs) == {f"builtin:{name}.{k}" for name, n in OWN.items() for k in range(n)}
    assert {m.split for _, m in LISTED} == {"train", "val", "varied", "val varied"}
    for name, count in OWN.items():
        held_out = [theirs[f"builtin:{name}.{k}"] for k in range(count)].count("val varied")
        assert held_out == 0 or 0.2 <= held_out / count <= 0.4, name


def test_between_a_tenth_and_two_fifths_is_held_out():
    for category, meshes in furniture().items():
        if len(meshes) >= 3 and category != "other":
            usual = [m for m in meshes if m.split in ("train", "val")]
            share = sum(m.split == "val" for m in usual) / len(usual)
            assert 0.1 <= share <= 0.4, category


def test_a_mesh_belongs_to_one_category():
    ids = [mesh.id for _, mesh in LISTED]
    assert len(ids) == len(set(ids))
    keys = {key for rows in json.loads(_list()).values() for row in rows.values() for key in row}
    assert keys <= {"size_m", "z_m", "top", "split"}


def test_listed_shapes_have_their_true_size():
    for _, mesh in LISTED:
        if mesh.id.startswith("builtin:"):
            points = corners(BUILTINS[mesh.id.removeprefix("builtin:")]()).reshape(-1, 3)
            assert mesh.size_m == pytest.approx(np.ptp(points, axis=0), abs=0.0011), mesh.id


@pytest.mark.skipif(not Assets().present, reason="the furniture has not been pulled")
def test_listed_models_are_in_the_catalogues_with_an_author_and_a_licence():
    ids = [mesh.id for _, mesh in LISTED if not mesh.id.startswith("builtin:")]
    lines = Assets().catalog.attribution(ids).splitlines()
    assert len(lines) == len(ids)
    assert all(line.endswith((": CC0 1.0", ": CC BY 3.0")) for line in lines)


def test_words_of_goals_are_categories_once():
    assert set(SYNONYMS) <= set(CATEGORIES)
    words = [word for text in SYNONYMS.values() for word in text.split(", ")]
    assert len(words) == len(set(words))
    assert not set(words) & (set(CATEGORIES) | set(BROAD))
    assert {c for categories in GOALS.values() for c in categories} <= set(CATEGORIES)


@pytest.mark.parametrize(
    ("goal", "category"),
    [("  Telly ", "television"), ("settee", "sofa"), ("wastebasket", "trash can"),
     ("cushion", "pillow"), ("house plant", "plant"), ("mug", "mug"), ("the loo", "toilet")],
)  # fmt: skip
def test_synonyms_are_understood(goal: str, category: str):
    assert categories_of(goal) == (category,)


def test_a_lamp_is_any_lamp():
    assert set(categories_of("lamp")) == {"lamp", "desk lamp", "floor lamp"}


def _list() -> str:
    import hil_sim

    return (Path(hil_sim.__file__).parent / "scenes" / "furniture" / "furniture.json").read_text(
        encoding="utf-8"
    )
