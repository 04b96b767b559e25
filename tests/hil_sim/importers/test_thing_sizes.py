"""The table of sizes is that of the furniture as it is."""

import math

import pytest

from hil_sim.importers.thing_sizes import ABOVE, looks_m, on_floor, table
from models.words.sizes import PATH


def test_the_file_is_up_to_date():
    assert PATH.read_text(encoding="utf-8") == table()


def test_of_what_is_flat_some_of_the_top_is_seen():
    assert looks_m((1.0, 1.0, 1.0)) == pytest.approx(math.sqrt(1.0 + ABOVE))
    assert looks_m((0.2, 0.1, 0.0)) == pytest.approx(math.sqrt(ABOVE) * 0.15)


def test_shares_are_counted_by_how_many_things_there_are():
    one = {"present": 1.0, "mean": 1.0, "on": {"table": 1.0}}
    many = {"present": 0.5, "mean": 6.0, "on": {"floor": 1.0}}
    found = dict(on_floor({"kitchen": {"ball": one}, "bedroom": {"ball": many}}))
    assert found == {"ball": 0.75}
