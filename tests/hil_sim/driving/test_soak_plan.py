"""When what goes wrong in a soak."""

from hil_sim.driving.soak_plan import FIRST_S, LASTS_S, PROCESS, SENSED, STANDS, troubles
from hil_sim.simulation.faults import parse_faults

KINDS = {*SENSED, *PROCESS}


def test_one_comes_after_the_other_and_the_last_is_over_in_time():
    plan = troubles(180.0, 20.0, seed=1)
    assert [one.at_s for one in plan] == [FIRST_S + 20.0 * n for n in range(8)]
    assert all(LASTS_S[0] <= one.lasts_s <= LASTS_S[1] for one in plan)
    assert plan[-1].at_s + plan[-1].lasts_s <= 180.0


def test_each_kind_comes_before_any_comes_again():
    plan = troubles(FIRST_S + 20.0 * 2 * len(KINDS), 20.0, seed=3)
    names = [one.name for one in plan]
    assert set(names[: len(KINDS)]) == KINDS
    assert len(names) > len(KINDS)
    assert len(set(names[len(KINDS) :])) == len(names) - len(KINDS)


def test_a_seed_is_a_plan_and_what_is_left_out_does_not_come():
    assert troubles(300.0, 20.0, 1) == troubles(300.0, 20.0, 1) != troubles(300.0, 20.0, 2)
    assert "disk-full" not in {one.name for one in troubles(900.0, 20.0, 1, ("disk-full",))}


def test_a_robots_trouble_is_a_fault_as_it_would_be_typed():
    (one,) = (t for t in troubles(900.0, 60.0, 1) if t.name == "link-lost")
    assert one.fault() == parse_faults([one.fault().text])[0]


def test_what_the_base_stands_for_is_known():
    assert set(STANDS) < KINDS
