"""Grades, and what is put together of many findings."""

import tomllib

from runtime.doctor.diagnosis import bad, can_search, fitting, ok, unknown, verdict, warning


def test_only_what_is_bad_keeps_a_search_from_starting():
    found = [ok("a", "well"), unknown("b", "nobody says"), warning("c", "slow", "make it faster")]
    assert can_search(found)
    assert verdict(found) == "a search can start: 1 warning, 1 not known"
    assert not can_search([*found, bad("d", "gone", "bring it back")])
    assert verdict([bad("d", "gone", "back")]).startswith("NO SEARCH CAN START: 1 bad")
    assert verdict([ok("a", "well")]) == "a search can start: all is well"


def test_what_would_fit_is_a_file_and_the_first_to_say_something_is_heard():
    found = [
        bad("depth", "gone", "", ("bus.topics.depth", '"a/depth"'), ("camera.z_m", "0.5")),
        bad("color", "gone", "", ("bus.topics.color", '"a/rgb"'), ("camera.z_m", "0.7")),
    ]
    assert tomllib.loads(fitting(found)) == {
        "bus": {"topics": {"depth": "a/depth", "color": "a/rgb"}},
        "camera": {"z_m": 0.5},
    }
    assert fitting([ok("a", "well")]) == ""
