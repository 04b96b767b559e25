"""What is asked about views, from the files that hold them."""

from pathlib import Path
from typing import IO

import numpy as np
import pytest
from looked import BED, DETECTOR, MUG, home_views, write_homes

from hil_sim.expert_bench.bank import HOMES
from hil_sim.expert_bench.view_questions import AHEAD, BEYOND_M, load_views
from hil_sim.expert_bench.views import KINDS, HomeViews, write_views
from runtime.errors import RfNavError


def test_only_the_runtimes_own_choice_is_asked_about(tmp_path: Path) -> None:
    bank = load_views(write_homes(tmp_path, homes=2, rows=24))
    assert (len(bank.beyond.sights), len(bank.in_view.sights), bank.homes) == (24, 48, 2)
    views = home_views(24, 0)
    assert bank.beyond.sights.column[:12].tolist() == views.column[::2].tolist()
    assert set(bank.beyond.sights.home) == {"val-300000", "val-300001"}
    assert (bank.room[:24] == views.room).all()


def test_what_is_in_view_is_no_question_beyond(tmp_path: Path) -> None:
    bank = load_views(write_homes(tmp_path, homes=1))
    there = home_views().in_view[::2, BED]
    assert (bank.beyond.asked[:, BED] == ~there).all()
    assert bank.beyond.asked[:, MUG].all()  # absent: asked, and the answer is no
    assert not bank.beyond.true[:, MUG].any()
    assert (bank.in_view.true[:, BED] == home_views().in_view[:, BED]).all()
    assert bank.in_view.asked.all()


def test_beyond_ends_somewhere(tmp_path: Path) -> None:
    bank = load_views(write_homes(tmp_path, homes=1))
    metres = home_views().beyond_m[::2, BED]
    assert set(metres.tolist()) == {4.5, 5.5}
    assert (bank.beyond.true[:, BED] == (metres <= BEYOND_M)).all()


def test_in_view_is_asked_straight_ahead(tmp_path: Path) -> None:
    sights = load_views(write_homes(tmp_path, homes=1)).in_view.sights
    assert (set(sights.column.tolist()), set(sights.range_m.tolist())) == ({AHEAD[0]}, {AHEAD[1]})


def test_some_are_drawn_by_the_seed(tmp_path: Path) -> None:
    folder = write_homes(tmp_path, homes=2)
    few = load_views(folder, most=5, seed=1)
    assert (len(few.beyond.sights), len(few.in_view.sights)) == (12, 10)  # two rows a moment
    again, other = (load_views(folder, most=5, seed=seed) for seed in (1, 2))
    assert (few.beyond.sights.column == again.beyond.sights.column).all()
    assert not np.array_equal(few.beyond.sights.column, other.beyond.sights.column)
    assert (np.diff(few.beyond.sights.column[:6]) > 0).all()  # in their order
    assert np.bincount(few.ways.moment).tolist().count(2) == 6  # whole moments


def test_moments_of_two_homes_are_not_one(tmp_path: Path) -> None:
    ways = load_views(write_homes(tmp_path, homes=2)).ways
    assert np.bincount(ways.moment).tolist() == [2] * 12
    assert (ways.onward_m[:12, BED] == home_views().onward_m[::2, BED]).all()
    assert len(ways.unknown_m2) == 24


def test_what_a_table_needs_is_read_without_pictures(tmp_path: Path) -> None:
    folder = write_homes(tmp_path, homes=2)
    bare, whole = load_views(folder, sighted=False), load_views(folder)
    assert bare.beyond.sights.features.size == 0 < whole.beyond.sights.features.size
    assert (bare.beyond.sights.rooms == whole.beyond.sights.rooms).all()
    assert (bare.beyond.asked == whole.beyond.asked).all()


def test_layouts_of_replicas_are_one(tmp_path: Path) -> None:
    (tmp_path / HOMES).mkdir()
    for name in ("FloorPlan_Train3_1", "FloorPlan_Train3_5"):
        write_views(tmp_path / HOMES / f"{name}.npz", home_views())
    assert set(load_views(tmp_path).beyond.sights.home) == {"FloorPlan_Train3"}


def test_a_write_that_was_cut_short_is_no_home(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write_homes(tmp_path, homes=1)

    def killed(file: IO[bytes], **arrays: object) -> None:
        file.write(b"PK half a home")
        raise KeyboardInterrupt

    monkeypatch.setattr(np, "savez", killed)
    with pytest.raises(KeyboardInterrupt):
        write_views(folder / HOMES / "val-300001.npz", home_views())
    assert load_views(folder).homes == 1


def test_a_home_without_a_view_is_passed_over(tmp_path: Path) -> None:
    folder = write_homes(tmp_path, homes=2)
    columns = {name: np.array([], kind) for name, kind in KINDS.items()}  # all (0,)
    empty = HomeViews(**columns, detector="")
    write_views(folder / HOMES / "val-300000.npz", empty)
    bank = load_views(folder)
    assert bank.homes == 1
    assert set(bank.in_view.sights.home) == {"val-300001"}
    write_views(folder / HOMES / "val-300001.npz", empty)
    with pytest.raises(RfNavError, match="no views"):
        load_views(folder)


def test_homes_of_two_detectors_are_not_mixed(tmp_path: Path) -> None:
    folder = write_homes(tmp_path, homes=2)
    assert load_views(folder).detector == DETECTOR
    write_views(folder / HOMES / "val-300001.npz", home_views(detector="another"))
    with pytest.raises(RfNavError, match=r"val-300001\.npz: seen by another detector.*remove it"):
        load_views(folder)


def test_a_folder_without_views_says_how_to_make_them(tmp_path: Path) -> None:
    with pytest.raises(RfNavError, match="no views; make them: hil-sim beyond"):
        load_views(tmp_path)
