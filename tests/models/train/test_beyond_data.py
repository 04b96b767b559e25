from pathlib import Path

import numpy as np
import pytest
from drawn_homes import CATEGORIES, CHANNELS, DETECTOR, draw_homes

from models.errors import ModelFileError
from models.train.beyond_data import Moments, feature_sample, read_homes


def test_homes_are_read_one_behind_the_other(tmp_path: Path):
    draw_homes(tmp_path, 2, seed=1)
    homes = read_homes(tmp_path, lambda features: features[:, :5])
    assert homes.features.shape == (48, 5, 6, 8)
    assert homes.categories == CATEGORIES
    assert homes.home.tolist() == [0] * 60 + [1] * 60
    assert homes.frame[60:].min() >= 24
    assert np.array_equal(np.unique(homes.moment), np.arange(20))
    assert feature_sample(tmp_path, np.random.default_rng(0)).shape == (48, CHANNELS, 6, 8)


def test_a_home_without_a_view_is_passed_over(tmp_path: Path):
    draw_homes(tmp_path, 3, seed=1)
    paths = sorted((tmp_path / "homes").glob("*.npz"))

    def empty(path: Path) -> None:
        with np.load(path) as file:
            kept = {name: file[name] for name in file}
        named = {name: kept.pop(name) for name in ("categories", "room_names", "detector")}
        none = {name: values[:0].reshape(-1) for name, values in kept.items()}
        np.savez(path, **none | named)

    empty(paths[0])
    homes = read_homes(tmp_path, lambda features: features[:, :5])
    assert homes.home.tolist() == [0] * 60 + [1] * 60
    assert len(homes.features) == len(feature_sample(tmp_path, np.random.default_rng(0))) == 48
    empty(paths[1])
    empty(paths[2])
    for read in (read_homes, lambda folder: feature_sample(folder, np.random.default_rng(0))):
        with pytest.raises(ModelFileError, match="no home has a view"):
            read(tmp_path)


def test_homes_of_another_detector_are_refused(tmp_path: Path):
    draw_homes(tmp_path, 2, seed=1)
    assert len(read_homes(tmp_path, detector=DETECTOR).frame) == 120
    with pytest.raises(ModelFileError, match=r"seen by detector dddddddddddd…, not by eeee.*anew"):
        read_homes(tmp_path, detector="e" * 64)
    path = sorted((tmp_path / "homes").glob("*.npz"))[1]
    with np.load(path) as file:
        np.savez(path, **{name: file[name] for name in file} | {"detector": "e" * 64})
    with pytest.raises(ModelFileError, match="seen by detector eeee"):
        read_homes(tmp_path)


def test_what_is_in_view_or_mapped_is_not_asked(tmp_path: Path):
    draw_homes(tmp_path, 1, seed=1)
    homes = read_homes(tmp_path)
    assert not (homes.known() & homes.in_view[homes.frame]).any()
    assert (homes.there() & homes.known()).any()


def test_moments_hold_each_view_of_each_frontier_the_best_first(tmp_path: Path):
    draw_homes(tmp_path, 1, seed=1)
    homes = read_homes(tmp_path)
    moments = Moments.of(homes)
    assert moments.rows.shape == (10, 3, 3)
    assert sorted(moments.rows[moments.rows >= 0]) == list(range(60))
    assert homes.best[moments.best()].all()
    for rows in moments.rows:
        assert (np.unique(homes.moment[rows[rows >= 0]])).size == 1
        for frontier, views in enumerate(rows):
            assert (homes.frontier[views[views >= 0]] == frontier).all()
    drawn = next(moments.draw(4, np.random.default_rng(0)))
    assert drawn.shape == (4, 3)
    assert (drawn >= 0).all()


def test_a_damaged_home_is_named(tmp_path: Path):
    with pytest.raises(ModelFileError, match="make some with `hil-sim beyond`"):
        read_homes(tmp_path)
    draw_homes(tmp_path, 1, seed=1)
    path = tmp_path / "homes" / "home-000.npz"
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(ModelFileError, match=r"home-000\.npz: cannot be read"):
        read_homes(tmp_path)
