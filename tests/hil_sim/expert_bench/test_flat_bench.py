"""Ways to elect, compared on the same searches."""

import pytest
from plan_of_rooms import three_rooms

from hil_sim.expert_bench import flat_bench
from hil_sim.expert_bench.flat_bench import BASE, CLEAN, ORACLE, FlatPlan, run, tables
from hil_sim.expert_bench.flat_search import FlatResult
from hil_sim.scenes.format import SceneError


@pytest.fixture
def one_home(monkeypatch: pytest.MonkeyPatch):
    def opened(name: str):
        if name.endswith("01"):
            raise SceneError(f"{name}: no good home")
        return three_rooms()

    monkeypatch.setattr(flat_bench, "open_scene", opened)


@pytest.mark.usefixtures("one_home")
def test_all_methods_search_the_same_tasks_and_no_way_is_shorter_than_the_shortest():
    homes = list(run(FlatPlan(homes=2, goals=1, rooms=1.0), (BASE, "prior")))
    assert len(homes) == 1  # the other could not be drawn
    _, rows = homes[0]
    conditions = [CLEAN, "o2f at random", "r2f at random", "sle at random"]
    assert set(rows) == {(ORACLE, CLEAN), (BASE, CLEAN), *(("prior", c) for c in conditions)}
    assert {len(results) for results in rows.values()} == {1}
    assert len({results[0].shortest_m for results in rows.values()}) == 1
    assert rows[ORACLE, CLEAN][0].spl >= flat_bench.FAIR


def test_the_table_tells_gains_and_what_one_at_random_leaves():
    def results(*spl: float) -> list[FlatResult]:
        return [FlatResult(True, 10.0, 10.0 * each, 3) for each in spl]

    rows = {
        (BASE, CLEAN): results(0.5, 0.5),
        ("prior", CLEAN): results(0.8, 0.8),
        ("prior", "o2f at random"): results(0.6, 0.6),
        ("prior", "r2f at random"): results(0.8, 0.8),
    }
    text = tables(rows).splitlines()
    assert text[2] == f"| {BASE} | 50.0 [50.0, 50.0] | – | – | 10.0 |"
    assert text[3].startswith("| prior | 80.0 [80.0, 80.0] | 30.0 [30.0, 30.0] | 20.0 [20.0, 20.0]")
