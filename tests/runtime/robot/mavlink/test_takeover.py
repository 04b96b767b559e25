"""Who has the vehicle: mode, arming, and a hand on the sticks."""

import pytest
from mavlink_messages import (
    ARDUPILOT,
    GUIDED,
    HOLD,
    MANUAL,
    OFFBOARD,
    POSCTL,
    PX4,
    PX4_HOLD,
    heartbeat,
)

from runtime.robot.mavlink.takeover import (
    ANSWER_S,
    ARM,
    MODE,
    STAND_S,
    STREAM_S,
    TRIES,
    TRY_S,
    Takeover,
)
from runtime.robot.mavlink.vehicle import Vehicle

ACCEPTED, DENIED, IN_PROGRESS = 0, 2, 5


class Held:
    """A vehicle that says what a test has it say, and a takeover of it."""

    def __init__(self, may_arm: bool, autopilot: int = ARDUPILOT, mode: int = MANUAL) -> None:
        self.autopilot, self.now_s = autopilot, 100.0
        self.vehicle, self.takeover = Vehicle(), Takeover(may_arm)
        self.says(mode)

    def says(self, mode: int, armed: bool = False) -> None:
        self.vehicle.hear(heartbeat(mode, armed, self.autopilot), self.now_s)
        self.takeover.heard(self.vehicle)

    def due(self, after_s: float = 0.0):
        self.now_s += after_s
        return self.takeover.due(self.vehicle, self.now_s)

    def lacks(self) -> str:
        return self.takeover.lacks(self.vehicle)


def test_without_leave_nothing_is_asked_for_and_a_person_is_told_what_to_do():
    held = Held(may_arm=False)
    held.takeover.begin(held.now_s)
    assert held.lacks() == "mode MANUAL: switch it to GUIDED, or run with --arm"
    assert [held.due(1.0) for _ in range(20)] == [None] * 20
    held.says(GUIDED)
    assert held.lacks() == "not armed: arm it, or run with --arm"
    assert [held.due(1.0) for _ in range(20)] == [None] * 20
    held.says(GUIDED, armed=True)
    assert held.lacks() == ""


def test_without_a_search_nothing_is_asked_for():
    held = Held(may_arm=True)
    assert [held.due(1.0) for _ in range(20)] == [None] * 20


def test_with_leave_mode_then_arming_are_asked_for_when_a_search_begins():
    held = Held(may_arm=True)
    held.takeover.begin(held.now_s)
    assert held.due() == (MODE, (1.0, 15.0, 0.0), 0)
    assert held.lacks() == "mode MANUAL: GUIDED is asked for"
    held.takeover.acked(MODE, ACCEPTED, "")
    assert held.due(0.1) is None
    held.says(GUIDED)
    assert held.due(0.1) == (ARM, (1.0, 0.0), 0)  # the second parameter would force it
    assert held.lacks() == "not armed: that is asked for"
    held.takeover.acked(ARM, ACCEPTED, "")
    held.says(GUIDED, armed=True)
    assert held.lacks() == ""
    assert held.takeover.idle


def test_what_somebody_drives_when_a_search_begins_is_not_taken_from_him():
    held = Held(may_arm=True)
    held.says(MANUAL, armed=True)
    held.takeover.begin(held.now_s)
    assert [held.due(1.0) for _ in range(20)] == [None] * 20
    assert held.lacks() == "mode MANUAL, and armed: somebody drives it; switch it to GUIDED"
    held.says(HOLD, armed=True)  # it is stopped, and not handed over
    assert [held.due(1.0) for _ in range(20)] == [None] * 20
    assert held.lacks() == "mode HOLD: switch it to GUIDED"
    held.says(GUIDED, armed=True)
    assert held.lacks() == ""


@pytest.mark.parametrize(("autopilot", "mode"), [(ARDUPILOT, HOLD), (PX4, PX4_HOLD)])
def test_what_stands_armed_on_hold_is_asked_for(autopilot: int, mode: int):
    held = Held(True, autopilot, mode)
    held.says(mode, armed=True)
    held.takeover.begin(held.now_s)
    assert held.due(2 * STREAM_S) is not None


def test_what_is_not_answered_is_sent_again_a_few_times():
    held = Held(may_arm=True)
    held.takeover.begin(held.now_s)
    sent = [held.due(TRY_S) for _ in range(10)]
    assert [c.sent for c in sent if c] == list(range(TRIES))  # the confirmation of a COMMAND_LONG
    assert held.lacks() == "GUIDED: is not answered; see to it, then give the goal again"
    held.takeover.begin(held.now_s)
    assert held.due() is not None


def test_a_refusal_is_told_with_its_reason_and_not_asked_again_before_the_next_search():
    held = Held(may_arm=True, mode=GUIDED)
    held.takeover.begin(held.now_s)
    assert held.due().number == ARM
    held.takeover.acked(MODE, DENIED, "")  # of somebody else's request
    assert "asked for" in held.lacks()
    held.takeover.acked(ARM, IN_PROGRESS, "")
    assert "asked for" in held.lacks()
    held.takeover.acked(ARM, DENIED, "Arm: GPS 1: Bad fix")
    why = "arming: denied (Arm: GPS 1: Bad fix); see to it, then give the goal again"
    assert held.lacks() == why
    assert [held.due(1.0) for _ in range(20)] == [None] * 20
    held.takeover.end(held.vehicle, held.now_s)
    held.takeover.begin(held.now_s)
    assert held.due().number == ARM


def test_what_was_accepted_and_does_not_come_is_told():
    held = Held(may_arm=True, mode=GUIDED)
    held.takeover.begin(held.now_s)
    held.due()
    held.takeover.acked(ARM, ACCEPTED, "")
    assert [held.due(TRY_S) for _ in range(10)] == [None] * 10
    assert held.lacks().startswith("arming: was accepted, but does not come")


@pytest.mark.parametrize("may_arm", [False, True])
@pytest.mark.parametrize("mode", [MANUAL, HOLD])
def test_who_changes_the_mode_has_the_sticks_until_it_is_given_back(may_arm: bool, mode: int):
    held = Held(may_arm, mode=GUIDED)
    held.takeover.begin(held.now_s)
    held.says(GUIDED, armed=True)
    held.says(mode, armed=True)
    assert held.takeover.hand == f"mode {held.vehicle.mode_name()}"
    assert [held.due(1.0) for _ in range(20)] == [None] * 20
    held.takeover.end(held.vehicle, held.now_s)
    held.takeover.begin(held.now_s)  # not even for another search
    assert [held.due(1.0) for _ in range(20)] == [None] * 20
    held.says(GUIDED, armed=True)
    assert (held.takeover.hand, held.lacks()) == ("", "")


def test_what_was_disarmed_in_a_search_is_not_armed_again():
    held = Held(may_arm=True, mode=GUIDED)
    held.takeover.begin(held.now_s)
    held.due()
    held.says(GUIDED, armed=True)
    held.says(GUIDED)
    assert [held.due(1.0) for _ in range(20)] == [None] * 20
    assert held.lacks() == "was disarmed: arm it, or give the goal again"
    held.takeover.end(held.vehicle, held.now_s)
    held.takeover.begin(held.now_s)
    assert held.due().number == ARM


def test_px4_gets_a_stream_first_and_is_put_on_hold_at_the_end():
    held = Held(may_arm=True, autopilot=PX4, mode=POSCTL)
    held.takeover.begin(held.now_s)
    assert held.due() is None
    assert held.due(STREAM_S - 0.1) is None
    assert held.due(0.2) == (MODE, (1.0, 6.0, 0.0), 0)
    held.says(OFFBOARD)
    assert held.due().number == ARM
    held.says(OFFBOARD, armed=True)
    assert held.lacks() == ""
    held.takeover.end(held.vehicle, held.now_s)
    assert held.due() == (MODE, (1.0, 4.0, 3.0), 0)
    held.says(OFFBOARD, armed=True)
    assert not held.takeover.idle
    held.says(PX4_HOLD, armed=True)
    assert held.takeover.hand == ""  # it was us
    assert not held.takeover.idle
    assert held.due(STAND_S) == (ARM, (0.0, 0.0), 0)
    held.says(PX4_HOLD)
    assert held.takeover.idle
    held.takeover.begin(held.now_s)
    assert held.due(STREAM_S).number == MODE


def test_a_hold_of_ours_that_comes_when_the_next_search_has_begun_is_no_hand():
    held = Held(may_arm=True, autopilot=PX4, mode=OFFBOARD)
    held.takeover.begin(held.now_s)
    held.says(OFFBOARD, armed=True)
    held.takeover.end(held.vehicle, held.now_s)
    assert held.due().number == MODE
    held.takeover.begin(held.now_s)
    held.says(OFFBOARD, armed=True)  # from before
    held.says(PX4_HOLD, armed=True)
    assert held.takeover.hand == ""
    assert held.due(STREAM_S) == (MODE, (1.0, 6.0, 0.0), 0)
    held.says(OFFBOARD, armed=True)
    held.says(PX4_HOLD, armed=True)
    assert held.takeover.hand == "mode HOLD"  # that was somebody


def armed_for_a_search() -> Held:
    held = Held(may_arm=True, mode=GUIDED)
    held.takeover.begin(held.now_s)
    assert held.due().number == ARM
    held.says(GUIDED, armed=True)
    return held


def test_what_was_armed_for_a_search_is_disarmed_when_it_stands():
    held = armed_for_a_search()
    held.takeover.end(held.vehicle, held.now_s)
    assert held.due(STAND_S - 0.1) is None
    assert not held.takeover.idle
    assert held.due(0.2) == (ARM, (0.0, 0.0), 0)
    held.says(GUIDED, armed=True)
    assert held.due(TRY_S) == (ARM, (0.0, 0.0), 1)
    held.says(GUIDED)
    assert held.takeover.idle
    assert [held.due(1.0) for _ in range(20)] == [None] * 20


def test_another_search_goes_on_with_what_was_armed_for_the_one_before():
    held = armed_for_a_search()
    held.takeover.end(held.vehicle, held.now_s)
    held.takeover.begin(held.now_s)
    held.says(GUIDED, armed=True)
    assert [held.due(1.0) for _ in range(20)] == [None] * 20
    assert held.lacks() == ""
    held.takeover.end(held.vehicle, held.now_s)
    assert held.due(STAND_S) == (ARM, (0.0, 0.0), 0)


def test_a_disarming_of_ours_that_shows_when_the_next_search_has_begun_is_nobody_s():
    held = armed_for_a_search()
    held.takeover.end(held.vehicle, held.now_s)
    assert held.due(STAND_S) == (ARM, (0.0, 0.0), 0)
    held.takeover.begin(held.now_s)
    held.says(GUIDED, armed=True)  # from before
    held.says(GUIDED)
    assert held.due() == (ARM, (1.0, 0.0), 0)


def test_who_has_the_sticks_at_the_end_is_not_disarmed_nor_is_an_open_request_sent_on():
    held = armed_for_a_search()
    held.says(MANUAL, armed=True)
    held.takeover.end(held.vehicle, held.now_s)
    assert [held.due(1.0) for _ in range(20)] == [None] * 20
    held = armed_for_a_search()
    held.takeover.end(held.vehicle, held.now_s)
    assert held.due(STAND_S).number == ARM
    held.says(MANUAL, armed=True)
    assert [held.due(1.0) for _ in range(20)] == [None] * 20


def test_what_a_person_has_armed_stays_armed_at_the_end():
    held = Held(may_arm=True, mode=GUIDED)
    held.says(GUIDED, armed=True)
    held.takeover.begin(held.now_s)
    held.says(GUIDED, armed=True)
    held.takeover.end(held.vehicle, held.now_s)
    assert [held.due(1.0) for _ in range(20)] == [None] * 20


# -- to the number ---------------------------------------------------------------------------------


def test_before_any_search_nothing_was_asked_for_or_refused():
    for may_arm, mode, lacks in (
        (True, MANUAL, "mode MANUAL: GUIDED is asked for"),
        (False, MANUAL, "mode MANUAL: switch it to GUIDED, or run with --arm"),
        (True, GUIDED, "not armed: that is asked for"),
        (False, GUIDED, "not armed: arm it, or run with --arm"),
    ):
        held = Held(may_arm, mode=mode)
        assert (held.lacks(), held.takeover.hand, held.takeover.idle) == (lacks, "", True)
        held.takeover.acked(ARM, DENIED, "")  # of nobody's request
        assert held.lacks() == lacks
    held = Held(False, PX4, POSCTL)
    assert held.lacks() == "mode POSCTL: switch it to OFFBOARD, or run with --arm"


def test_of_a_vehicle_that_was_not_heard_nothing_is_asked():
    takeover = Takeover(may_arm=True)
    assert takeover.idle
    takeover.begin(100.0)
    assert takeover.due(Vehicle(), 110.0) is None


class Armed(Held):
    """What was armed when it was heard first."""

    def says(self, mode: int, armed: bool = True) -> None:
        super().says(mode, armed)


def test_what_was_armed_when_it_was_met_stays_armed_and_is_not_armed_again():
    held = Armed(may_arm=True, mode=GUIDED)
    held.takeover.begin(held.now_s)
    held.says(GUIDED)
    held.takeover.end(held.vehicle, held.now_s)
    assert [held.due(1.0) for _ in range(20)] == [None] * 20
    held.takeover.begin(held.now_s)
    held.says(GUIDED)
    held.says(GUIDED, armed=False)
    assert held.lacks() == "was disarmed: arm it, or give the goal again"


def test_a_hold_that_nobody_asked_for_is_a_hand():
    held = Held(True, PX4, OFFBOARD)
    held.says(PX4_HOLD)
    assert (held.takeover.hand, held.lacks()) == ("mode HOLD", "")


@pytest.mark.parametrize("modes", [(OFFBOARD, POSCTL), (POSCTL,)])
def test_what_is_left_while_it_is_put_on_hold_is_no_hand_whatever_comes(modes: tuple[int, ...]):
    held = Held(True, PX4, OFFBOARD)
    held.takeover.begin(held.now_s)
    held.says(OFFBOARD, armed=True)
    held.takeover.end(held.vehicle, held.now_s)
    for mode in modes:
        held.says(mode, armed=True)
    assert (held.takeover.hand, held.takeover.idle) == ("", True)


def test_another_mode_than_hold_is_a_hand_also_when_hold_was_asked_for():
    held = Held(True, PX4, OFFBOARD)
    held.takeover.begin(held.now_s)
    held.says(OFFBOARD, armed=True)
    held.takeover.end(held.vehicle, held.now_s)
    held.takeover.begin(held.now_s)
    held.says(OFFBOARD, armed=True)
    held.says(POSCTL, armed=True)
    assert held.takeover.hand == "mode POSCTL"


def test_only_px4_in_offboard_is_put_on_hold():
    for autopilot, mode in ((PX4, POSCTL), (ARDUPILOT, GUIDED), (ARDUPILOT, MANUAL)):
        held = Held(True, autopilot, mode)
        held.takeover.begin(held.now_s)
        held.takeover.end(held.vehicle, held.now_s)
        assert (held.takeover.idle, held.due()) == (True, None)


@pytest.mark.parametrize(("autopilot", "mode"), [(ARDUPILOT, GUIDED), (PX4, OFFBOARD)])
def test_what_somebody_else_drives_at_the_end_is_left_as_it_is(autopilot: int, mode: int):
    held = Held(True, autopilot, mode)
    held.takeover.begin(held.now_s)
    assert held.due().number == ARM
    held.says(mode, armed=True)
    held.takeover.end(held.vehicle, held.now_s, by_hand=True)
    assert held.takeover.idle
    assert [held.due(1.0) for _ in range(20)] == [None] * 20
    assert held.lacks() == ""


def test_after_a_search_its_refusal_is_over():
    held = Held(may_arm=True, mode=GUIDED)
    held.takeover.begin(held.now_s)
    held.due()
    held.takeover.acked(ARM, 99, "")
    assert held.lacks() == "arming: result 99; see to it, then give the goal again"
    held.takeover.end(held.vehicle, held.now_s)
    assert held.lacks() == "not armed: that is asked for"


@pytest.mark.parametrize(
    ("result", "why"),
    [(1, "rejected for now"), (2, "denied"), (3, "unsupported"), (4, "failed"), (6, "cancelled")],
)
def test_a_refusal_in_words(result: int, why: str):
    held = Held(may_arm=True)
    held.takeover.begin(held.now_s)
    held.due()
    held.takeover.acked(MODE, result, "")
    assert held.lacks() == f"GUIDED: {why}; see to it, then give the goal again"


def test_what_was_accepted_and_does_not_come_is_told_in_whole():
    held = Held(may_arm=True, mode=GUIDED)
    held.takeover.begin(held.now_s)
    held.due()
    held.takeover.acked(ARM, ACCEPTED, "")
    for _ in range(TRIES):
        held.due(TRY_S)
    why = "arming: was accepted, but does not come; see to it, then give the goal again"
    assert held.lacks() == why


def test_px4_is_asked_after_just_a_second_and_a_half_of_stream():
    for after_s, number in ((STREAM_S - 0.001, None), (STREAM_S, MODE)):
        held = Held(True, PX4, POSCTL)
        held.takeover.begin(held.now_s)
        due = held.due(after_s)
        assert (due and due.number) == number


@pytest.mark.parametrize(("after_s", "again"), [(ANSWER_S, True), (ANSWER_S + 0.125, False)])
def test_a_disarming_of_ours_may_show_for_four_seconds(after_s: float, again: bool):
    """Armed after that, it was armed for this search."""
    held = armed_for_a_search()
    held.takeover.end(held.vehicle, held.now_s)
    assert held.due(STAND_S).number == ARM
    held.takeover.begin(held.now_s)
    assert held.takeover.idle
    held.now_s += after_s
    held.says(GUIDED, armed=True)
    held.says(GUIDED)
    assert bool(held.due()) is again


def test_a_search_that_comes_before_it_is_disarmed_keeps_it_armed_and_nothing_is_open():
    held = armed_for_a_search()
    held.takeover.end(held.vehicle, held.now_s)
    assert not held.takeover.idle
    held.takeover.begin(held.now_s)
    assert held.takeover.idle


def test_hold_is_asked_for_again_while_it_is_not_there():
    held = Held(True, PX4, OFFBOARD)
    held.takeover.begin(held.now_s)
    held.says(OFFBOARD, armed=True)
    held.takeover.end(held.vehicle, held.now_s)
    assert held.due() == (MODE, (1.0, 4.0, 3.0), 0)
    held.says(OFFBOARD, armed=True)
    assert held.due(TRY_S) == (MODE, (1.0, 4.0, 3.0), 1)
    held.says(PX4_HOLD, armed=True)
    assert held.takeover.idle
    assert held.due(TRY_S) is None


def test_a_request_is_not_sent_again_at_once():
    held = Held(may_arm=True)
    held.takeover.begin(held.now_s)
    assert held.due() == (MODE, (1.0, 15.0, 0.0), 0)
    assert held.due() is None
    assert held.due(TRY_S - 0.25) is None
    assert held.due(0.25) == (MODE, (1.0, 15.0, 0.0), 1)


def test_arming_is_asked_for_once_a_search_though_a_hand_came_between():
    held = Held(may_arm=True, mode=GUIDED)
    held.takeover.begin(held.now_s)
    assert held.due().number == ARM
    held.says(MANUAL)
    held.says(GUIDED)
    assert [held.due(1.0) for _ in range(20)] == [None] * 20


def test_a_disarming_that_is_refused_is_told_as_that():
    held = armed_for_a_search()
    held.takeover.end(held.vehicle, held.now_s)
    assert held.due(STAND_S).number == ARM
    held.takeover.acked(ARM, DENIED, "")
    held.says(GUIDED)
    assert held.lacks() == "disarming: denied; see to it, then give the goal again"
