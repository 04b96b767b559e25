"""Walls: the committed ones against official paths; the search on a home whose walls are known."""

import gzip
import json
import math
from pathlib import Path

import numpy as np
import places
import pytest
from click.testing import CliRunner
from hypothesis import assume, given
from hypothesis import strategies as st

from hil_sim.scenes.robothor import evidence, walls
from hil_sim.scenes.robothor.evidence import OUTER
from hil_sim.scenes.robothor.inference import infer
from hil_sim.scenes.robothor.metadata import APARTMENTS, MetadataError, layout_of
from hil_sim.scenes.robothor.walls import GIVEN, HUNG, INFERRED, agreement, clearance, layouts

pytestmark = pytest.mark.slow  # all layouts are inferred

HERE = Path(__file__).parent
SHARED = places.SHARED / "robothor/episodes"
coordinate = st.integers(-40, 40).map(lambda n: n / 10)


def bundled() -> list[tuple[str, np.ndarray]]:
    rows = json.loads((HERE / "paths.json").read_text())["paths"]
    return [(layout_of(row["id"]), np.array(row["path"])) for row in rows]


def test_every_layout_has_a_row_and_says_where_it_is_from():
    table = layouts()
    assert set(table) == {layout_of(name) for name in APARTMENTS}
    sources = {name: row.source for name, row in table.items()}
    assert {sources["Val1"], sources["Val2"]} == {GIVEN}
    assert sources["Val3"] == HUNG
    assert all(sources[f"Train{i}"] == INFERRED for i in range(1, 13))


def test_walls_are_straight_and_inside():
    x0, y0, x1, y1 = OUTER
    for row in layouts().values():
        for (ax, ay), (bx, by) in row.walls:
            assert (ax == bx) != (ay == by)
            assert min(ax, bx) >= x0
            assert max(ax, bx) <= x1
            assert min(ay, by) >= y0
            assert max(ay, by) <= y1


def test_no_bundled_path_comes_near_a_wall():
    for layout, path in bundled():
        assert clearance(layouts()[layout].walls, [path]) > 0.13, layout
    assert len({layout for layout, _ in bundled()}) == 14


@pytest.mark.skipif(not SHARED.is_dir(), reason="the official episodes are not here")
@pytest.mark.parametrize("layout", [n for n, row in layouts().items() if row.source != HUNG])
def test_no_official_path_comes_nearer_than_the_file_says(layout):
    [file] = SHARED.rglob(f"FloorPlan_{layout}_2.json.gz")
    assert clearance(layouts()[layout].walls, evidence.read_paths(file)) >= 0.13
    assert layouts()[layout].clearance_m > 0.13


@given(st.tuples(*[coordinate] * 8))
def test_clearance_is_the_distance_of_segments(numbers):
    a, b, p, q = (np.array(numbers[i : i + 2]) for i in (0, 2, 4, 6))
    assume(math.dist(a, b) > 0.05)
    t = np.linspace(0, 1, 400)[:, None]
    ours = clearance([((a[0], a[1]), (b[0], b[1]))], [np.array([p, q])])
    first, second = a + t * (b - a), p + t * (q - p)
    sampled = np.hypot(*(first[:, None] - second[None]).transpose(2, 0, 1)).min()
    assert ours <= sampled + 1e-9
    assert ours >= sampled - 0.03


def test_agreement_counts_length():
    one, two = ((0.0, 0.0), (2.0, 0.0)), ((0.0, 0.0), (0.0, 2.0))
    assert agreement([one], [one]) == (1.0, 1.0)
    precision, recall = agreement([one, two], [one])
    assert precision == pytest.approx(0.5, abs=0.06)
    assert recall == 1.0
    assert agreement([((0.0, 0.2), (2.0, 0.2))], [one]) == (0.0, 0.0)


def write_paths(folder: Path, paths: list[list[tuple[float, float]]]) -> Path:
    file = folder / "FloorPlan_Train1_1.json.gz"
    rows = [{"shortest_path": [{"x": x, "y": 0.0, "z": y} for x, y in path]} for path in paths]
    with gzip.open(file, "wt") as out:
        json.dump(rows, out)
    return file


def test_a_wall_that_paths_go_round_is_found(tmp_path, monkeypatch):
    """Without furniture or paintings: a wall down from the upper edge, at x = 5."""
    monkeypatch.setattr(evidence, "apartment", lambda name: ())
    tip = -3.0
    rng = np.random.default_rng(1)
    paths = []
    for _ in range(1500):
        (ax, ay), (bx, by) = rng.uniform((1.2, -4.7), (9.6, -1.2), (2, 2)).tolist()
        if min(abs(ax - 5), abs(bx - 5)) < 0.22:
            continue
        at = ay + (by - ay) * (5 - ax) / (bx - ax) if (ax < 5) != (bx < 5) else -9.0
        ends = [(ax, ay), (bx, by)]
        if at > tip - 0.2:  # round the tip at 0.2 m
            side = -1 if ax < 5 else 1
            ends[1:1] = [(5 + side * 0.2, tip), (5 + side * 0.1, tip - 0.2),
                         (5 - side * 0.1, tip - 0.2), (5 - side * 0.2, tip)]  # fmt: skip
        paths.append(ends)
    found = [
        run.segment for run in infer(evidence.gather("Train1", [write_paths(tmp_path, paths)]))
    ]
    precision, recall = agreement(found, [((5.0, -1.01), (5.0, tip))])
    assert precision > 0.9
    assert recall > 0.9


def test_open_floor_has_no_walls(tmp_path, monkeypatch):
    monkeypatch.setattr(evidence, "apartment", lambda name: ())
    ends = np.random.default_rng(1).uniform((1.2, -4.7), (9.6, -1.2), (600, 2, 2))
    file = write_paths(tmp_path, [[tuple(a), tuple(b)] for a, b in ends.tolist()])
    assert infer(evidence.gather("Train1", [file])) == ()


def test_bad_folders_and_files_are_named_in_a_line(tmp_path, monkeypatch):
    monkeypatch.setattr(walls, "apartment", lambda name: ())
    with pytest.raises(MetadataError, match="holds no FloorPlan_"):
        walls.build(tmp_path, {})
    (tmp_path / "FloorPlan_Train1_1.json.gz").write_bytes(b"no gzip")
    with pytest.raises(MetadataError, match=r"FloorPlan_Train1_1.json.gz: not a gzipped JSON"):
        walls.build(tmp_path, {})
    bad = tmp_path / "walls.json"
    bad.write_text('{"layouts": {"Train1": {}}}')
    with pytest.raises(MetadataError, match=r"walls.json: not a file of walls"):
        layouts(bad)


def test_program_writes_what_it_read(tmp_path, monkeypatch):
    monkeypatch.setattr(evidence, "apartment", lambda name: ())
    monkeypatch.setattr(walls, "apartment", lambda name: ())
    write_paths(tmp_path, [[(2.0, -2.0), (8.0, -2.0)]])
    out = tmp_path / "w.json"
    done = CliRunner().invoke(walls.main, ["--episodes", str(tmp_path), "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert "Train1: 0 walls inferred, 1 paths" in done.output
    assert layouts(out)["Val1"].walls == layouts()["Val1"].walls
