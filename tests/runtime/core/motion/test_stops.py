"""Why the base was held, for a person."""

from runtime.core.motion.safety import HaltKind
from runtime.core.motion.stops import BY_ITSELF, HALTS, BaseStop, stop_in_full

ODOMETRY = BaseStop(3, "held", "odometry", "no odometry for 1.2 s", 10.0)


def test_what_goes_on_says_since_when_and_what_to_do():
    assert stop_in_full(ODOMETRY, 13.25) == (
        "Stop 3 (held, odometry): it does not know where it is now: odometry has stopped coming, "
        "or is late.",
        "What was noticed: no odometry for 1.2 s.",
        "It began 3.2 s ago; it goes on, 3.2 s by now.",
        "What to do: Look whether the base's driver runs: rfnav status, rfnav doctor.",
    )


def test_what_is_over_says_how_long_it_lasted_and_what_came_then():
    over = BaseStop(4, "held", "plan", "the plan is 2.1 s old", 10.0, 12.5, "searching")
    assert stop_in_full(over, 20.0)[2:] == (
        "It began 10.0 s ago; it lasted 2.5 s, then: searching.",
    )  # nothing is to be done
    assert "BY_ITSELF" not in "".join(stop_in_full(over, 20.0))


def test_of_a_journal_the_clock_is_nobodys():
    assert stop_in_full(ODOMETRY, None)[2] == "It began at 10.0 s; it goes on."
    over = BaseStop(1, "held", "odometry", "", 1.0, 2.0)
    lines = stop_in_full(over, None)
    assert lines[1:3] == (
        "What was noticed: nothing more.", "It began at 1.0 s; it lasted 1.0 s."
    )  # fmt: skip
    assert lines[3].startswith("What to do: Look")


def test_every_kind_has_words_and_what_is_none_too():
    assert set(HALTS) == set(HaltKind)
    assert all(words.remedy.startswith(BY_ITSELF) or words.remedy for words in HALTS.values())
    fault = stop_in_full(BaseStop(1, "fault", "", "internal error", 0.0), 1.0)
    assert fault[0] == "Stop 1 (fault): rfnav met a mistake of its own and ends."
    other = stop_in_full(BaseStop(1, "paused", "", "paused", 0.0), 1.0)
    assert other[-1] == "What to do: Ask it to go on: rfnav resume."
