"""Real time over real Zenoh, against a robot that keeps moving while the runtime thinks."""

import math
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from apartment import TWO_ROOMS, Apartment
from fake_models import FakeModels, farthest
from full_disk import largest_file
from robot_double import RobotDouble
from run_process import process

from hil_sim.driving.link import free_port
from runtime.clock import Deadline, SystemClock
from runtime.commands.record import RecordOptions, recording
from runtime.config import Config, load
from runtime.core import local_policy
from runtime.core.types import Brief, Detections, Missing, Pose, Twist, Vote
from runtime.core.voting import brief
from runtime.experts.panel import Panel
from runtime.journal import read_journal, read_map
from runtime.loops.control_loop import ControlLoop
from runtime.loops.detector_worker import DetectorWorker
from runtime.loops.goal_request import Terms
from runtime.loops.goals import Custom
from runtime.loops.process import Garbage
from runtime.loops.realtime import RealTime
from runtime.perception.goal_words import Goal
from runtime.record import Record, unrecorded
from runtime.replay.drive import replay
from runtime.replay.script import Script
from runtime.robot.base import WELL, BaseCondition
from runtime.robot.bus import Bus
from runtime.robot.session import BusConfig
from runtime.tracing.budgets import read_budgets
from runtime.tracing.tracer import Tracer

QUICK = ("control.look_radps=1.0", "safety.plan_stale_s=5.0")
# A busy machine must not decide a test: what is not under test may be late.
PATIENT = ("safety.odom_stale_s=2.0", "safety.frame_stale_s=4.0")


@pytest.fixture(autouse=True)
def short_look_around(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("runtime.core.world.FIRST_LOOKS", 1)


@contextmanager
def running(
    models: FakeModels, *settings: str, record: Record = unrecorded
) -> Iterator[tuple[RobotDouble, list[BaseException]]]:
    """The loop and its control, and a robot linked to them."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    robot = RobotDouble(models.home, BusConfig(listen=(endpoint,)))
    given = (*QUICK, *settings, f"bus.connect=['{endpoint}']", 'research.control_mode="velocity"')
    config, clock = load(None, given), SystemClock()
    ending, ended = threading.Event(), []
    bus = Bus(config.bus, clock, record=record)
    budgets = read_budgets()
    tracer, garbage = Tracer(budgets, clock.now_s), Garbage(clock)
    rates = config.safety, config.realtime
    control = ControlLoop(bus, bus, clock, *rates, tracer, ending.is_set, record=record)

    def serve() -> None:
        try:
            loop = RealTime(
                bus,
                control,
                models,
                lambda more: load(None, (*given, *more)),
                clock,
                tracer,
                budgets,
                garbage,
                record,
                custom=Custom(Terms(harness=True)),
            )
            loop.run(ending.is_set)
        except BaseException as error:  # noqa: BLE001 -- handed to the test
            ended.append(error)

    control.start()
    thread = threading.Thread(target=serve)
    thread.start()
    robot.start()
    try:
        robot.ask("status")
        yield robot, ended
    finally:
        ending.set()
        thread.join(timeout=20.0)
        control.close()
        models.panel.close()
        bus.close()
        robot.close()
        assert not thread.is_alive()


def home(x: float = 5.2, y: float = 2.4) -> Apartment:
    there = Apartment.of(TWO_ROOMS, Pose(x, y, -0.5))
    assert there.fits(x, y)
    return there


def begin(robot: RobotDouble, log: Path, goal: str = "toilet") -> dict:
    reply = robot.ask("goal", {"goal": goal, "log_dir": str(log)})
    assert reply["accepted"], reply
    return reply


def moving(robot: RobotDouble) -> bool:
    return robot.twist.v_mps > 0.1


def reason(robot: RobotDouble) -> str:
    """The reason that feedback gave last: it and the state are heard one after the other."""
    return robot.feedback[-1]["reason"] if robot.feedback else ""


def test_a_search_from_goal_to_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    there = home()
    there.things = {"toilet": (7.4, 2.2, 0.3)}

    def twice(*args: object) -> None:
        raise AssertionError("in real time only the control loop steers")

    monkeypatch.setattr(local_policy.velocity_policy, "steer", twice)
    with running(FakeModels(there), *PATIENT) as (robot, ended):
        assert robot.ask("status")["state"] == "ready"
        begin(robot, tmp_path)
        robot.until(lambda: robot.state().get("state") in ("found", "not_found") or ended)
        robot.until(lambda: robot.twist.v_mps == robot.twist.w_radps == 0)
        assert robot.ask("status")["state"] == "found"
        summary = robot.ask("cancel")
    assert not ended
    state = robot.state()
    assert state["mode"] == "stop"
    assert math.dist(state["toward_xy"], (7.4, 2.2)) < 0.5
    assert math.hypot(there.pose.x_m - 7.4, there.pose.y_m - 2.2) < 1.3
    assert there.collisions == 0
    assert summary["state"] == "found"
    assert summary["steps"] > 5
    assert summary["reliance"]["weights"] == {"o2f": 0.0, "r2f": 0.0, "sle": 0.0}  # nobody voted
    lines = list(read_journal(tmp_path / "decisions.jsonl"))
    assert [lines[0]["kind"], lines[-1]["kind"]] == ["goal", "end"]
    steps = [line for line in lines if line["kind"] == "step"]
    assert len(steps) == summary["steps"]
    sent = {(round(t.v_mps, 4), round(t.w_radps, 4)) for t in (Twist(), *robot.commands)}
    assert {(step["v_mps"], step["w_radps"]) for step in steps} <= sent
    assert len({step["v_mps"] for step in steps}) > 1  # not only standing still
    arrays, meta = read_map(tmp_path)
    assert arrays["free"].any()
    assert meta["stopped_at"] is not None
    assert robot.feedback[-1]["state"] == "found"
    assert robot.feedback[-1]["driven_m"] > 0.3


CUPBOARD = """
##########
#        #
#        #
#        #
#        #
#        #
#        #
##########
"""


def test_a_search_ends_as_not_found_though_the_detectors_never_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("runtime.loops.shedding.RESTS", (0.0,))

    class Slow(FakeModels):
        def detect(self, rgb: np.ndarray, window: object = None) -> Detections:
            threading.Event().wait(1.0)  # some frames pass meanwhile
            return super().detect(rgb)

    with running(Slow(Apartment.of(CUPBOARD, Pose(1.2, 1.0, 0.0))), *PATIENT) as (robot, ended):
        begin(robot, tmp_path)
        robot.until(lambda: robot.state().get("state") == "not_found" or ended, 100.0)
        summary = robot.ask("cancel")
    assert not ended
    assert summary["state"] == "not_found"
    end = list(read_journal(tmp_path / "decisions.jsonl"))[-1]
    assert end["reason"] == "no toilet found and nothing left to explore"


def test_a_refused_goal_takes_nothing_from_the_search_under_way(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    begins, begin_looks = [], DetectorWorker.begin

    def counted(worker: DetectorWorker, newest_only: bool) -> None:
        begins.append(newest_only)
        begin_looks(worker, newest_only)

    monkeypatch.setattr(DetectorWorker, "begin", counted)
    with running(FakeModels(home(4.0, 3.0)), *PATIENT) as (robot, ended):
        begin(robot, tmp_path / "a")
        assert not robot.ask("goal", {"goal": "", "log_dir": str(tmp_path / "b")})["accepted"]
        assert begins == [False]  # what was looked at, what waits and what was seen are kept
        stages = robot.ask("status")["stages"]
        looks = stages.get("seen", {}).get("n", 0)
        robot.until(lambda: robot.ask("status")["stages"].get("seen", {}).get("n", 0) > looks)
        begin(robot, tmp_path / "b")
    assert not ended
    assert begins == [False, False]


def test_the_robot_drives_while_the_vote_is_out_and_then_follows_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    release, compose, threads = threading.Event(), brief.compose, []

    def composed(*told: object) -> Brief:
        threads.append(threading.current_thread().name)
        return compose(*told)

    monkeypatch.setattr(brief, "compose", composed)

    def slow(told: Brief, by: Deadline) -> Vote | Missing:
        release.wait(60.0)
        return farthest(told, by)

    there = home(4.0, 3.0)
    models = FakeModels(there, o2f=slow, r2f=farthest)
    with running(models, *PATIENT, "panel.decide_budget_s=300.0") as (robot, ended):
        begin(robot, tmp_path)
        robot.until(lambda: moving(robot) or ended)
        robot.until(lambda: robot.state().get("mode") == "frontier" or ended)
        assert robot.decisions == []
        release.set()
        robot.until(lambda: robot.decisions or ended)
        robot.ask("cancel")
    assert not ended
    assert robot.decisions[0]["rule"] == "prior"
    assert set(threads) == {"decisions"}  # what experts are told is not for the loop to work out


@pytest.mark.slow
def test_the_next_decision_is_rehearsed_on_the_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("runtime.core.voting.rehearsal.SLOW_S", 0.0)
    models = FakeModels(home(4.0, 3.0), o2f=farthest, r2f=farthest)
    rehearse, rehearsed = models.panel.rehearse, []

    def spied(brief: Brief, by: Deadline, wanted):
        rehearsed.append(brief)
        return rehearse(brief, by, wanted)

    models.panel.rehearse = spied  # type: ignore[method-assign]
    with running(models, *PATIENT) as (robot, ended):
        begin(robot, tmp_path)
        robot.until(lambda: rehearsed or ended)
        summary = robot.ask("cancel")
    assert not ended
    elected = [d["frontier"] for d in robot.decisions]
    assert any(e not in {f.id for f in rehearsed[0].frontiers} for e in elected)
    assert summary["rehearsals"].keys() == {"used", "missed"}


def test_a_late_vote_is_left_behind(tmp_path: Path):
    release = threading.Event()

    def hanging(brief: Brief, by: Deadline) -> Vote | Missing:
        release.wait(60.0)
        return farthest(brief, by)

    models = FakeModels(home(4.0, 3.0), o2f=farthest, r2f=farthest, sle=hanging)
    with running(models, *PATIENT, "panel.decide_budget_s=0.5") as (robot, ended):
        begin(robot, tmp_path)
        robot.until(lambda: robot.decisions or ended)
        robot.ask("cancel")
        release.set()
    assert not ended
    assert {"expert": "sle", "cause": "late"} in robot.decisions[0]["missing"]


@pytest.mark.slow
def test_cancel_stops_the_base_and_a_second_goal_preempts(tmp_path: Path):
    with running(FakeModels(home(4.0, 3.0)), *PATIENT) as (robot, ended):
        begin(robot, tmp_path / "a")
        robot.until(lambda: moving(robot) or ended)
        begin(robot, tmp_path / "b", "bed")
        robot.until(lambda: moving(robot) or ended)
        summary = robot.ask("cancel", {"reason": "enough"})
        robot.until(lambda: robot.twist.v_mps == robot.twist.w_radps == 0)
        robot.until(lambda: robot.state().get("state") == "cancelled")
        heard = len(robot.commands)
        threading.Event().wait(0.5)
        assert all(t.v_mps == t.w_radps == 0 for t in robot.commands[heard:])
    assert not ended
    assert summary["ended"]
    ends = [list(read_journal(tmp_path / d / "decisions.jsonl"))[-1] for d in "ab"]
    assert [end["reason"] for end in ends] == ["preempted", "enough"]


@pytest.mark.slow
def test_what_goes_stale_stops_the_robot_and_what_comes_back_resumes_it(tmp_path: Path):
    with running(FakeModels(home(4.0, 3.0))) as (robot, ended):
        begin(robot, tmp_path)
        for stream, kind in (("odom", "odometry"), ("frames", "frame")):
            robot.until(lambda: moving(robot) or ended)
            before = robot.state()["halts"].get(kind, 0)
            robot.sending.discard(stream)
            robot.until(lambda k=kind, n=before: robot.state()["halts"].get(k, 0) > n or ended)
            robot.until(lambda: robot.twist.v_mps == robot.twist.w_radps == 0)
            robot.sending.add(stream)
        for aside_m in (3.0, 0.0, 3.0, 0.0, 3.0):  # a robot that only brakes is not halted by one
            robot.until(lambda: moving(robot) or ended)
            robot.bend = lambda pose, m=aside_m: replace(pose, x_m=pose.x_m + m)
            if robot.hears(lambda: "jump" in robot.state()["halts"] or ended, 5.0):
                break
        robot.until(lambda: "jump" in robot.state()["halts"] or ended)
        robot.bend, robot.clock_ns = lambda pose: pose, -3600 * 10**9
        robot.until(lambda: "clock" in robot.state()["halts"] or ended)
        robot.until(lambda: moving(robot) or ended)
        robot.ask("cancel")
    assert not ended
    halts = [line for line in read_journal(tmp_path / "decisions.jsonl") if line["kind"] == "halt"]
    assert {"odometry", "frame", "jump", "clock"} <= set(halts[-1]["halts"])


@contextmanager
def recorded(
    models: FakeModels, where: Path, *settings: str
) -> Iterator[tuple[RobotDouble, list[BaseException]]]:
    """The same; what was recorded of it comes out of a replay to the last bit."""
    config = load(None, (*QUICK, *settings, 'research.control_mode="velocity"'))
    with (
        recording(config, RecordOptions(where, 0.0, False), False, True) as record,
        running(models, *settings, record=record) as parts,
    ):
        yield parts
    (path,) = where.iterdir()
    again = replay(Script.open(path))
    assert again.equal, [again.stopped, *(d.in_words() for d in again.differences.found[:3])]
    assert again.differences.compared["tick"] > 20


def lines(log: Path, kind: str) -> list[dict]:
    return [line for line in read_journal(log / "decisions.jsonl") if line["kind"] == kind]


def test_a_replay_knows_the_name_that_a_goal_was_cancelled_by(tmp_path: Path):
    models = FakeModels(home(4.0, 3.0))
    with recorded(models, tmp_path / "recorded", *PATIENT) as (robot, ended):
        id = robot.ask("goal", {"goal": "toilet", "log_dir": str(tmp_path / "a")})["id"]
        robot.until(lambda: moving(robot) or ended)
        assert robot.ask("cancel", {"id": id})["ended"]
        begin(robot, tmp_path / "b", "bed")
        robot.until(lambda: moving(robot) or ended)
        robot.ask("cancel")
    assert not ended


def test_a_hand_takes_over_in_mid_search_and_gives_back(tmp_path: Path):
    there = home()
    there.things = {"toilet": (7.4, 2.2, 0.3)}
    with recorded(FakeModels(there), tmp_path / "recorded", *PATIENT) as (robot, ended):
        begin(robot, tmp_path)
        robot.until(lambda: moving(robot) or ended)
        robot.hand = Twist(0.0, 1.0)
        robot.until(lambda: robot.state()["base"]["hand"] == "cmd_vel_teleop" or ended)
        robot.hears(lambda: False, 0.3)  # what was under way when it took over
        sent, before = len(robot.commands), there.pose
        robot.hears(lambda: False, 1.5)
        robot.hand = Twist(0.4, 0.1)
        robot.hears(lambda: False, 2.0)
        assert len(robot.commands) == sent
        left = there.pose
        robot.hand = None
        robot.until(lambda: moving(robot) or ended)
        robot.until(lambda: robot.state().get("state") in ("found", "not_found") or ended)
        summary = robot.ask("cancel")
    assert not ended
    assert math.dist((before.x_m, before.y_m), (left.x_m, left.y_m)) > 0.3
    assert summary["state"] == "found"
    assert summary["halts"].get("jump", 0) == 0
    assert summary["frozen_frames"] == 0
    taken, given = lines(tmp_path, "hand")
    assert (taken["who"], given["who"]) == ("cmd_vel_teleop", "")
    assert math.dist((given["pose"]["x_m"], given["pose"]["y_m"]), (left.x_m, left.y_m)) < 0.3


def test_a_camera_that_freezes_holds_the_base_until_it_lives(tmp_path: Path):
    there = home()
    there.things = {"toilet": (7.4, 2.2, 0.3)}
    with recorded(FakeModels(there), tmp_path / "recorded", *PATIENT) as (robot, ended):
        begin(robot, tmp_path)
        robot.until(lambda: moving(robot) or ended)
        see, still = there.observe, there.observe()
        there.observe = lambda: replace(see(), rgb=still.rgb, depth_m=still.depth_m)
        robot.until(lambda: "repeated itself" in robot.state()["halt"] or ended)
        robot.until(lambda: robot.twist.v_mps == robot.twist.w_radps == 0)
        there.observe = see
        robot.until(lambda: robot.state().get("state") in ("found", "not_found") or ended)
        summary = robot.ask("cancel")
    assert not ended
    assert summary["state"] == "found"
    assert summary["frozen_frames"] > 0


def test_a_base_that_nobody_has_armed_yet_costs_the_search_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    there, armed = home(), threading.Event()
    there.things = {"toilet": (7.4, 2.2, 0.3)}
    waits = BaseCondition(held="not armed: arm it, or run with --arm")
    monkeypatch.setattr(Bus, "condition", lambda bus: WELL if armed.is_set() else waits)
    with recorded(FakeModels(there), tmp_path / "recorded", *PATIENT) as (robot, ended):
        begin(robot, tmp_path)
        robot.until(lambda: robot.state().get("halt", "").startswith("base: not armed") or ended)
        robot.hears(lambda: False, 3.0)
        assert robot.state()["mode"] == "wait"
        assert not robot.decisions
        armed.set()
        robot.until(lambda: moving(robot) or ended)
        robot.until(lambda: robot.state().get("state") in ("found", "not_found") or ended)
        summary = robot.ask("cancel")
    assert not ended
    assert summary["state"] == "found"
    began, over = lines(tmp_path, "held")
    assert (began["who"], over["who"]) == (waits.held, "")


def test_what_no_camera_sees_is_touched_mapped_and_gone_round(tmp_path: Path):
    there = home()
    there.things = {"toilet": (7.4, 2.2, 0.3)}
    there.heights[105:118, 305:311] = 0.05  # lower than what counts as an obstacle
    with recorded(FakeModels(there), tmp_path / "recorded", *PATIENT) as (robot, ended):
        robot.sending.add("bumper")
        begin(robot, tmp_path)
        robot.until(lambda: robot.state().get("halts", {}).get("bumper") or ended)
        robot.until(lambda: min(t.v_mps for t in robot.commands) < 0 or ended)
        robot.until(lambda: robot.state().get("state") in ("found", "not_found") or ended)
        summary = robot.ask("cancel")
    assert not ended
    assert summary["state"] == "found"
    assert lines(tmp_path, "met")[0]["touch"] == "bumper"
    assert summary["collisions"] >= 1
    assert there.pose.x_m > 6.4


def test_with_a_low_battery_a_search_goes_back_to_where_it_began_and_none_is_begun(tmp_path: Path):
    there = home(4.0, 3.0)
    low = "battery.low_percent=20"
    with recorded(FakeModels(there), tmp_path / "recorded", *PATIENT, low) as (robot, ended):
        robot.sending.add("battery")
        begin(robot, tmp_path)
        start = there.pose
        robot.until(lambda: math.dist((there.pose.x_m, there.pose.y_m), start.xy) > 0.8 or ended)
        robot.percent = 12.0
        robot.until(lambda: robot.state().get("mode") == "return" or ended)
        robot.until(lambda: robot.state().get("state") == "failed" or ended)
        assert math.dist((there.pose.x_m, there.pose.y_m), start.xy) < 0.5
        why = "battery: 12 % is left, battery.low_percent is 20"
        assert robot.state()["reason"] == f"{why}; it is back where it began"
        refused = robot.ask("goal", {"goal": "toilet", "log_dir": str(tmp_path / "b")})
        assert refused == {"accepted": False, "code": 4723, "error": why}
        last = robot.ask("status")["last"]
        assert (last["result"], last["cause"], last["returned"]) == ("failed", "battery", True)
        assert robot.ask("status")["base"]["battery_percent"] == pytest.approx(12.0)
    assert not ended
    assert lines(tmp_path, "battery")[0]["then"] == "return"


def test_a_search_may_end_where_the_battery_runs_low(tmp_path: Path):
    low = "battery.low_percent=20", "battery.when_low='end'"
    with running(FakeModels(home(4.0, 3.0)), *PATIENT, *low) as (robot, ended):
        robot.sending.add("battery")
        begin(robot, tmp_path)
        robot.until(lambda: moving(robot) or ended)
        robot.percent = 5.0
        robot.until(lambda: robot.state().get("state") == "failed" or ended)
        robot.until(lambda: robot.twist.v_mps == robot.twist.w_radps == 0)
        why = "battery: 5 % is left, battery.low_percent is 20"
        robot.until(lambda: reason(robot) == why or ended)
    assert not ended


def test_a_driver_that_begins_with_0_refuses_no_goal_and_an_empty_battery_ends_what_it_began(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Also where a search under way is let go on: this one would not have been begun."""
    for name in ("UNSURE_S", "LOW_S"):
        monkeypatch.setattr(f"runtime.robot.battery.{name}", 2.0)
    low = "battery.low_percent=20", "battery.when_low='refuse'"
    with running(FakeModels(home(4.0, 3.0)), *PATIENT, *low) as (robot, ended):
        robot.percent = 0.0
        robot.sending.add("battery")
        robot.hears(lambda: False, 0.5)
        begin(robot, tmp_path)
        robot.until(lambda: robot.state().get("state") == "failed" or ended)
        why = "battery: 0 % is left, battery.low_percent is 20"
        robot.until(lambda: reason(robot) == why or ended)
        refused = robot.ask("goal", {"goal": "toilet", "log_dir": str(tmp_path / "b")})
        assert not refused["accepted"]
        robot.percent = 60.0
        robot.until(lambda: (robot.ask("status")["base"]["battery_percent"] or 0.0) > 59.0)
        begin(robot, tmp_path)
        robot.until(lambda: moving(robot) or ended)
        robot.percent = 10.0  # in mid-search
        robot.hears(lambda: False, 4.0)
        assert robot.state()["state"] == "searching"
    assert not ended


@pytest.mark.slow
def test_the_map_is_kept_for_the_next_goal_when_that_is_wished(tmp_path: Path):
    with running(FakeModels(home(4.0, 3.0)), *PATIENT, "goal.keep_map=true") as (robot, ended):
        begin(robot, tmp_path / "a")
        robot.until(lambda: moving(robot) or ended)
        begin(robot, tmp_path / "b", "bed")
        robot.until(lambda: moving(robot) or ended)
        robot.ask("cancel")
    assert not ended
    steps = [r for r in read_journal(tmp_path / "b" / "decisions.jsonl") if r["kind"] == "step"]
    assert all(step["mode"] != "look" for step in steps)
    before, after = (read_map(tmp_path / d)[0]["free"].sum() for d in "ab")
    assert after >= 0.8 * before


# -- the process -----------------------------------------------------------------------------------


def wrong(said: str) -> list[str]:
    """What was said, but for what the system does not grant, how the runtime stood, what its
    watchdog did, and how goals began and ended."""
    usual = ("no SCHED_FIFO", "not locked", " -> ", "rfnav guard: ", 'rfnav: goal "')
    usual += ("rfnav: ended: ", "rfnav: failed: ")
    return [line for line in said.splitlines() if not any(what in line for what in usual)]


@pytest.mark.slow
def test_an_error_in_perception_stops_the_base_then_ends_the_process(tmp_path: Path):
    with process(home(4.0, 3.0), 16, *QUICK, *PATIENT) as (child, robot):
        robot.ask("status")
        begin(robot, tmp_path)
        robot.until(lambda: robot.twist.v_mps > 0 or child.poll() is not None)
        _, said = child.communicate(timeout=60)
    assert child.returncode == 1
    (line,) = wrong(said)
    assert line.startswith("rfnav: internal error: KeyError('what the camera saw') at ")
    assert robot.twist.v_mps == robot.twist.w_radps == 0
    end = list(read_journal(tmp_path / "decisions.jsonl"))[-1]
    assert end["kind"] == "end"
    assert "Traceback" in end["traceback"]


@pytest.mark.slow
def test_sigterm_stops_the_base_and_keeps_what_was_found_out(tmp_path: Path):
    with process(home(4.0, 3.0), 10_000, *QUICK, *PATIENT) as (child, robot):
        robot.ask("status")
        begin(robot, tmp_path)
        robot.until(lambda: moving(robot) or child.poll() is not None)
        child.send_signal(signal.SIGTERM)
        _, said = child.communicate(timeout=60)
    assert child.returncode == 0, said
    assert wrong(said) == []
    assert robot.twist.v_mps == robot.twist.w_radps == 0
    assert read_map(tmp_path)[0]["free"].any()


def test_odometry_of_beyond_reason_holds_the_base_and_the_search_goes_on(tmp_path: Path):
    told = "odometry tells (1000.0, 1000.0) m, farther off than a map reaches"
    with running(FakeModels(home(4.0, 3.0)), *PATIENT) as (robot, ended):
        begin(robot, tmp_path)
        for away_m in (1e9, 1e300, 1000.0):
            robot.until(lambda: moving(robot) or ended)
            robot.bend = lambda pose, m=away_m: Pose(m, m, pose.yaw_rad)
            robot.until(lambda: robot.twist.v_mps == robot.twist.w_radps == 0 or ended)
            if away_m == 1000.0:  # it stays there, and so is believed: but the map is not there
                robot.until(lambda: reason(robot) == told or ended)
            robot.bend = lambda pose: pose
        robot.until(lambda: moving(robot) or ended)
        robot.ask("cancel")
        streams = robot.ask("status")["streams"]
    assert not ended
    assert streams["odom"]["bad"] > 0
    assert lines(tmp_path, "astray")[0]["reason"] == told
    assert max(read_map(tmp_path)[0]["free"].shape) < 1000


@pytest.mark.parametrize("error", [RecursionError("too deep"), ValueError("embedded null byte")])
def test_a_goal_that_meets_a_mistake_of_ours_is_answered_and_ends_no_more_than_the_search(
    tmp_path: Path, error: Exception, capsys: pytest.CaptureFixture[str]
):
    models = FakeModels(home(4.0, 3.0))
    accept = models.accept

    def mistaken(goal: str, config: Config) -> tuple[Goal, Panel]:
        if goal == "grenade":
            raise error
        return accept(goal, config)

    with running(models, *PATIENT) as (robot, ended):
        begin(robot, tmp_path / "a")
        robot.until(lambda: moving(robot) or ended)
        models.accept = mistaken
        answer = robot.ask("goal", {"goal": "grenade", "log_dir": str(tmp_path / "b")})
        assert answer == {"accepted": False, "error": f"internal error: {error!r}"}
        robot.until(lambda: robot.twist.v_mps == robot.twist.w_radps == 0)
        assert robot.ask("status")["state"] == "ended"
        begin(robot, tmp_path / "c")
        robot.until(lambda: moving(robot) or ended)
    assert not ended
    assert list(read_journal(tmp_path / "a" / "decisions.jsonl"))[-1]["kind"] == "end"
    assert "Traceback" in capsys.readouterr().err


def test_a_search_goes_on_where_its_journal_and_map_cannot_be_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    there = home()
    there.things = {"toilet": (7.4, 2.2, 0.3)}
    with running(FakeModels(there), *PATIENT) as (robot, ended), largest_file(2000):
        begin(robot, tmp_path)
        robot.until(lambda: robot.state().get("state") in ("found", "not_found") or ended)
        lost = robot.ask("status")["journal_lost"]
        summary = robot.ask("cancel")
    assert not ended
    assert summary["state"] == "found"
    assert "decisions.jsonl: cannot be written (No space left on device)" in lost
    assert lost == summary["journal_lost"]
    assert "the map cannot be written (File too large)" in summary["map_lost"]
    said = capsys.readouterr().err
    assert (said.count(lost), said.count(summary["map_lost"])) == (1, 1)
    assert [path.name for path in tmp_path.iterdir()] == ["decisions.jsonl"]


def test_why_it_goes_there_and_why_it_stood_is_told_on_asking(tmp_path: Path):
    with running(FakeModels(home(), o2f=farthest, r2f=farthest)) as (robot, ended):
        assert robot.ask("why") == {"now": "no search", "decision": None, "stop": None}
        begin(robot, tmp_path)
        robot.until(lambda: moving(robot) and robot.decisions)
        robot.sending.discard("odom")
        robot.until(lambda: robot.state()["runtime"]["state"] == "held")
        robot.sending.add("odom")
        robot.until(lambda: robot.state()["runtime"]["state"] != "held")
        robot.until(lambda: robot.ask("why")["stop"]["ended_s"] is not None)
        answer = robot.ask("why")
        first = robot.ask("why", {"decision": 1})["decision"]
        unknown = robot.ask("why", {"decision": 999})
        status = robot.ask("status")
    assert not ended
    assert first["in_words"][0].startswith('Decision 1 of the search for "toilet", ')
    elected = robot.decisions[0]["frontier"]
    assert first["in_words"][2].startswith(f"Taken: frontier {elected}, at (")
    assert any(line.startswith("Objects near by (o2f): votes for ") for line in first["in_words"])
    assert answer["stop"]["kind"] in ("odometry", "plan")
    assert answer["stop"]["in_words"][2].startswith("It began ")
    assert unknown["error"].startswith("why: decision 999: there is none yet; the last is ")
    assert status["votes"]["o2f"]["local"] >= 1
    assert status["journal"] == str(tmp_path / "decisions.jsonl")
    assert status["elapsed_s"] > 0
    assert status["memory_mb"] > 10
