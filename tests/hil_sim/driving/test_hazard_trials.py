"""What trials are made, and which have to end well."""

import pytest

from hil_sim.driving.hazard_trials import SEEN_PX, HazardTrial, HazardTrials, halting_m


def trial(**other):
    told = {"kind": "box", "ahead_m": 1.0, "high_m": 0.9, "v_mps": 0.4, "pixels": 5000}
    return HazardTrial(**(told | other))


def test_the_kind_that_was_tried_least_is_next_until_all_are_done():
    trials, kinds = HazardTrials(2, ("box", "leg"), 0), []
    while (kind := trials.next_kind()) is not None:
        kinds.append(kind)
        trials.done.append(trial(kind=kind))
    assert kinds == ["box", "leg", "box", "leg"]


def test_the_way_to_a_halt_is_that_until_it_brakes_and_that_of_braking():
    assert halting_m(0.4, 0.5) == pytest.approx(0.4 * 0.3 + 0.16)
    assert halting_m(0.4, 0.5, 0.1) == pytest.approx(0.4 * 0.1 + 0.16)
    assert halting_m(-0.4, 0.5) == 0.0


def test_only_what_is_seen_and_can_be_braked_for_has_to_be_avoided():
    assert trial().avoidable(0.5)
    assert not trial(pixels=SEEN_PX - 1).avoidable(0.5)
    assert not trial(ahead_m=0.25).avoidable(0.5)
    assert trial(ahead_m=0.25, v_mps=0.2).avoidable(0.5)
