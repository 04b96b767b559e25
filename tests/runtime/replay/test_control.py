"""The control loop of a replay: ticks of then, whatever came between them."""

from collections import deque
from typing import Any

from runtime.config import load
from runtime.core.motion.contact import Contact, Felt, Met, Touch
from runtime.core.motion.courses import STILL, ControlConfig, Spin
from runtime.core.motion.safety import Odometry
from runtime.core.types import Pose, SearchState, Twist
from runtime.loops.plans import Plan, Tick
from runtime.recording.exact import exact
from runtime.replay.control import FilmControl
from runtime.replay.differences import Differences
from runtime.replay.script import Turn
from runtime.robot.base import WELL, BaseCondition
from runtime.tracing.budgets import read_budgets
from runtime.tracing.tracer import Tracer


class Film:
    """One turn, in which the loop plans to spin."""

    def __init__(self, **made: list[Any]) -> None:
        self.turn = Turn(1, "frame", 0.0, made=made, heard={"asked_mps": deque([0.25])})
        self.told: list[tuple[str, object]] = []

    def heard(self, name: str) -> Any:
        return self.turn.heard[name].popleft()

    def made(self, kind: str) -> int:
        return sum(told == kind for told, _ in self.told)

    def given(self, name: str) -> Any:
        values = self.turn.heard.get(name)
        return values.popleft() if values else None

    def record(self, kind: str, value: object) -> None:
        self.told.append((kind, value))


def tick(now_s: float, sent: Twist | None, plan: int = 4, halt: str = "", **more: Any) -> tuple:
    odometry = Odometry(Pose(0.0, 0.0, 0.0), round(now_s * 1e9), now_s)
    known = Tick(now_s, 0.01, odometry, now_s, plan, False, False, sent, halt, sent, WELL)
    return "tick", {**exact(known), **more}


def driven(*controls: tuple[str, Any]) -> tuple[Differences, FilmControl]:
    film, differences = Film(plan=[{"number": 4, "frame_s": 9.9}]), Differences()
    tracer = Tracer(read_budgets(None), lambda: 0.0)
    control = FilmControl(film, load(None), tracer, differences)  # type: ignore[arg-type]
    control.follow(Plan(Spin(0.5), 0.0, 0.2, ControlConfig()))
    film.turn.controls.extend(controls)
    control.drive(film.turn)
    return differences, control


ACCELERATED = Twist(0.0, 3.0 * 0.0625)  # rad/s^2, s


def test_the_same_ticks_send_the_same():
    differences, control = driven(tick(10.0, STILL), tick(10.0625, ACCELERATED))
    assert [d.in_words() for d in differences.found] == []
    assert differences.compared == {"tick": 2}
    assert control.asked_mps() == 0.25


def test_whether_the_base_was_held_is_as_it_was_and_not_told_by_recordings_from_before():
    _, control = driven(tick(10.0, STILL))
    assert control.held() is False
    control._film.turn.heard["held"] = deque([True])
    assert control.held() is True
    assert control.held() is False


def test_what_is_sent_otherwise_is_told():
    differences, _ = driven(tick(10.0, STILL), tick(10.0625, Twist(0.0, 0.1)))
    assert [d.what for d in differences.found] == ["tick.asked.w_radps", "tick.sent.w_radps"]


def test_what_control_was_too_late_for_holds_the_base_again():
    differences, _ = driven(tick(10.0, STILL), tick(20.0, STILL, halt="overrun"))
    assert [d.in_words() for d in differences.found] == []


def test_what_was_doubted_and_what_depth_forbade_holds_the_base_again():
    stop = {"kind": "stop", "reason": "stopped by hand"}
    stopped = tick(10.0625, STILL, halt="stop", doubt=stop)
    differences, _ = driven(tick(10.0, STILL), stopped)
    assert [d.in_words() for d in differences.found] == []
    ahead = {"kind": "obstacle", "reason": "a leg", "most_mps": 0.0, "most_radps": 0.0}
    stopped = tick(10.0625, STILL, halt="obstacle", caution=ahead)
    differences, _ = driven(tick(10.0, STILL), stopped)
    assert [d.in_words() for d in differences.found] == []


def test_a_plan_that_was_withdrawn_in_the_midst_of_a_tick():
    withdrawn = tick(10.0625, STILL, withdrawn=True)
    differences, _ = driven(tick(10.0, STILL), withdrawn, tick(10.125, STILL, plan=0))
    assert [d.in_words() for d in differences.found] == []


def test_rest_comes_between_the_ticks_where_it_came():
    rest = "rest", {"state": SearchState.FOUND.value}
    differences, _ = driven(
        tick(10.0, STILL), tick(10.0625, ACCELERATED), rest, tick(10.125, STILL, plan=0)
    )
    assert [d.in_words() for d in differences.found] == []


def test_what_the_body_felt_and_who_had_the_sticks_is_as_it_was():
    felt = Felt((Contact(Touch.BUMPER, "bumper", 0.0, 10.05, True),), True)
    touched = tick(10.0625, STILL, halt="bumper", felt=exact(felt))
    hand = exact(BaseCondition(hand="cmd_vel_teleop", battery_percent=55.0))
    led = tick(10.125, None, halt="hand", felt=exact(felt), base=hand, asked=exact(STILL))
    differences, _ = driven(tick(10.0, STILL), touched, led)
    assert [d.in_words() for d in differences.found] == []
    differences, _ = driven(tick(10.0, STILL), tick(10.0625, STILL, halt="bumper"))
    assert "tick.halt" in [d.what for d in differences.found]


def test_what_was_told_to_the_thread_that_plans_is_told_again():
    _, control = driven()
    assert (control.condition(), control.met()) == (WELL, ())
    told = BaseCondition(hand="cmd_vel_teleop", battery_percent=7.5)
    met = Met(Touch.CLIFF, Pose(1.0, 2.0, 0.5), -0.3)
    heard = control._film.turn.heard
    heard["condition"], heard["met"] = deque([exact(told)]), deque([exact((met,))])
    assert (control.condition(), control.met()) == (told, (met,))


def test_ticks_of_a_plan_that_is_not_known_are_left_out():
    differences, _ = driven(tick(10.0, STILL, plan=3), tick(10.0625, STILL))
    assert differences.compared == {"tick": 1}


def test_what_the_base_sent_otherwise_than_asked_it_sends_again():
    slower = Twist(0.0, 0.1)
    cut = tick(10.0625, slower, asked=exact(ACCELERATED))
    onward = Twist(0.0, 0.1 + 3.0 * 0.0625)  # from what was sent, not from what was asked
    differences, _ = driven(tick(10.0, STILL), cut, tick(10.125, onward))
    assert [d.in_words() for d in differences.found] == []
    silent = tick(10.0625, None, asked=exact(ACCELERATED))
    differences, _ = driven(tick(10.0, STILL), silent, tick(10.125, Twist(0.0, 3.0 * 0.0625)))
    assert [d.in_words() for d in differences.found] == []


def test_a_base_that_said_why_it_cannot_be_driven_says_it_again():
    held = {"base": exact(BaseCondition(hand="mode MANUAL"))}
    silent = tick(10.0625, None, halt="hand", asked=exact(STILL), **held)
    differences, _ = driven(tick(10.0, STILL), silent)
    assert [d.in_words() for d in differences.found] == []
    without = tick(10.0625, STILL, halt="hand")
    differences, _ = driven(tick(10.0, STILL), without)
    assert {d.what for d in differences.found} >= {"tick.halt"}


def test_ticks_from_before_bases_said_anything_are_compared_without():
    kind, old = tick(10.0625, ACCELERATED)
    for name in ("asked", "base"):
        del old[name]
    differences, _ = driven(tick(10.0, STILL), (kind, old))
    assert [d.in_words() for d in differences.found] == []
