"""The loop over real Zenoh: goals, observations, actions, what is left behind, and bad input."""

import math
import threading
from collections.abc import Sequence
from pathlib import Path

import pytest
import zenoh
from apartment import TWO_ROOMS, Apartment
from fake_models import FakeModels, Wordy, broken, farthest
from lockstep_double import Peer, begin, home, running

from runtime.clock import Deadline
from runtime.core.types import Action, Brief, Intrinsics, Missing, Pose, SearchState, Vote
from runtime.core.world import Command, Mode
from runtime.errors import SensorError
from runtime.journal import read_journal, read_map
from runtime.robot import wire


def test_an_episode_from_goal_to_stop_leaves_everything_behind(tmp_path: Path):
    there = home()
    there.things = {"toilet": (7.4, 2.2, 0.3)}
    with running(FakeModels(there)) as (peer, ended):
        assert peer.ask("status", {})["state"] == "ready"
        assert begin(peer, tmp_path)["accepted"]
        assert peer.ask("status", {})["state"] == "searching"
        actions = []
        for _ in range(60):
            action = peer.show(there)
            assert action is not None
            actions.append(action)
            if action == "stop":
                break
            there.apply(Action(action))
        reply = peer.ask("cancel", {"reason": "stop"})
    assert not ended
    assert actions[-1] == "stop"
    assert reply["steps"] == len(actions)
    assert math.hypot(there.pose.x_m - 7.4, there.pose.y_m - 2.2) < 1.3
    kinds = [line["kind"] for line in read_journal(tmp_path / "decisions.jsonl")]
    assert kinds[0] == "goal"
    assert kinds[-1] == "end"
    assert kinds.count("step") == len(actions)
    arrays, meta = read_map(tmp_path)
    assert arrays["free"].any()
    assert meta["stopped_at"] is not None
    (toilet,) = meta["objects"]
    assert toilet["name"] == "toilet"
    assert toilet["names"] == {"toilet": 1.0}
    assert math.dist(toilet["look_from_xy"], toilet["xy"]) < 1.3
    assert all(0 < side < 1.5 for side in toilet["size_m"])


def test_a_harness_votes_for_an_expert_by_where_the_frontiers_are(tmp_path: Path):
    there = home()
    told = "research.told_experts=['r2f', 'sle']"
    with running(FakeModels(there, o2f=farthest), told) as (peer, ended):

        def answer(sample: zenoh.Sample) -> None:
            question = wire.decode_json(sample.payload.to_bytes(), "question")
            near = min(question["frontiers"], key=lambda f: math.hypot(*f["goal_xy"]))
            shares = [[f["id"], f is near] for f in question["frontiers"]]
            vote = {"expert": "r2f", "frontiers": [near["id"]], "probabilities": shares}
            vote["reason"] = "near the start"
            told = {"stamp_ns": question["stamp_ns"], "votes": [vote]}
            peer.session.put("rfnav/votes", wire.encode_json(told))

        asked = peer.session.declare_subscriber("rfnav/question", answer)
        begin(peer, tmp_path)
        for _ in range(13):
            there.apply(Action(peer.show(there)))
        peer.ask("cancel", {})
        asked.undeclare()
    assert not ended
    (first, *_) = [d for d in read_journal(tmp_path / "decisions.jsonl") if d["kind"] == "decision"]
    assert [(vote["expert"], vote["rung"]) for vote in first["votes"]] == [
        ("o2f", "local"), ("r2f", "told"),
    ]  # fmt: skip
    nearest = min(first["frontiers"], key=lambda f: math.hypot(*f["goal_xy"]))
    assert first["votes"][1]["frontiers"] == [nearest["id"]]
    assert first["missing"] == [{"expert": "sle", "cause": "no evidence"}]


def test_a_broken_expert_is_an_abstention_with_its_cause(tmp_path: Path):
    there = home()
    with running(FakeModels(there, o2f=broken, r2f=farthest)) as (peer, ended):
        begin(peer, tmp_path)
        for _ in range(13):
            there.apply(Action(peer.show(there)))
        peer.ask("cancel", {})
    assert not ended
    decision = next(
        line for line in read_journal(tmp_path / "decisions.jsonl") if line["kind"] == "decision"
    )
    assert decision["missing"] == [{"expert": "o2f", "cause": "error: the model fell over"}]
    assert decision["rule"] == "prior"
    assert decision["frontier"] == decision["without"]["r2f"]  # one alone steers nobody


@pytest.mark.slow
def test_a_late_expert_is_left_behind_and_the_loop_goes_on(tmp_path: Path):
    there, release = home(), threading.Event()

    def hanging(brief: Brief, by: Deadline) -> Vote | Missing:
        release.wait(30.0)
        return farthest(brief, by)

    budget = ("research.budget_in_lockstep=true", "panel.decide_budget_s=1.0")
    models = FakeModels(there, o2f=farthest, r2f=hanging, sle=farthest)
    with running(models, *budget) as (peer, ended):
        begin(peer, tmp_path)
        for _ in range(13):
            there.apply(Action(peer.show(there)))
        peer.ask("cancel", {})
        release.set()
    assert not ended
    decision = next(
        line for line in read_journal(tmp_path / "decisions.jsonl") if line["kind"] == "decision"
    )
    assert decision["missing"] == [{"expert": "r2f", "cause": "late"}]
    assert decision["rule"] == "prior"  # of those that voted in time


def test_two_experts_that_agree_are_followed_where_sets_decide(tmp_path: Path):
    there = home()
    sets = "research.consensus_mode=strict"
    with running(FakeModels(there, o2f=farthest, r2f=farthest), sets) as (peer, _):
        begin(peer, tmp_path)
        for _ in range(13):
            there.apply(Action(peer.show(there)))
        peer.ask("cancel", {})
    decision = next(
        line for line in read_journal(tmp_path / "decisions.jsonl") if line["kind"] == "decision"
    )
    assert decision["rule"] == "all"
    assert [v["expert"] for v in decision["votes"]] == ["o2f", "r2f"]
    assert decision["votes"][0]["frontiers"] == [decision["frontier"]]


def drive(peer: Peer, there: Apartment, limit: int, ended: Sequence[BaseException] = ()) -> None:
    """Obey until it stops, or `limit` steps."""
    for _ in range(limit):
        action = peer.show(there, ended=ended)
        assert action is not None, ended
        if action == "stop":
            return
        there.apply(Action(action))


def steps_of(log: Path) -> list[dict]:
    return [line for line in read_journal(log / "decisions.jsonl") if line["kind"] == "step"]


def with_beanbag() -> Apartment:
    there = Apartment.of(TWO_ROOMS, Pose(5.0, 3.2, 0.0))
    there.things = {"beanbag": (7.4, 2.2, 0.3)}
    return there


KEEP = {"settings": ["goal.keep_map=true"]}


def test_a_goal_that_was_seen_before_is_driven_to_from_memory_and_looked_at_again(tmp_path: Path):
    there = with_beanbag()
    with running(Wordy(there)) as (peer, ended):
        begin(peer, tmp_path / "a", "vase")
        drive(peer, there, 14, ended)
        peer.ask("cancel", {})
        peer.ask("goal", {"goal": "beanbag", "log_dir": str(tmp_path / "b"), **KEEP})
        drive(peer, there, 40, ended)
        peer.ask("cancel", {})
    assert not ended
    objects = read_map(tmp_path / "a")[1]["objects"]
    assert [thing["name"] for thing in objects] == ["sofa"]
    memory = next(
        line
        for line in read_journal(tmp_path / "b" / "decisions.jsonl")
        if line["kind"] == "memory"
    )
    assert memory["renamed"] == [objects[0]["id"]]
    assert 0.5 < memory["goal"][0]["p"] < 0.9
    steps = steps_of(tmp_path / "b")
    assert steps[0]["mode"] == "target"  # no look around, nothing explored
    assert {step["mode"] for step in steps} <= {"target", "face", "stop"}
    assert steps[0]["reason"].startswith("inspect")
    assert steps[-1]["reason"].startswith("found beanbag")
    assert math.hypot(there.pose.x_m - 7.4, there.pose.y_m - 2.2) < 1.3


@pytest.mark.slow
def test_what_is_remembered_and_not_there_any_more_is_not_stopped_at(tmp_path: Path):
    there = with_beanbag()
    with running(Wordy(there)) as (peer, ended):
        begin(peer, tmp_path / "a", "vase")
        drive(peer, there, 14, ended)
        peer.ask("cancel", {})
        there.things = {}
        peer.ask("goal", {"goal": "beanbag", "log_dir": str(tmp_path / "b"), **KEEP})
        drive(peer, there, 40, ended)
        peer.ask("cancel", {})
    assert not ended
    steps = steps_of(tmp_path / "b")
    assert steps[0]["mode"] == "target"
    assert any(step["mode"] == "frontier" for step in steps)  # given up, and explored on
    assert not any(step["reason"].startswith("found") for step in steps)


def test_without_keep_map_nothing_is_remembered(tmp_path: Path):
    there = with_beanbag()
    with running(Wordy(there)) as (peer, ended):
        begin(peer, tmp_path / "a", "vase")
        drive(peer, there, 14, ended)
        begin(peer, tmp_path / "b", "beanbag")  # the search before is preempted
        drive(peer, there, 2, ended)
        peer.ask("cancel", {})
    assert [step["mode"] for step in steps_of(tmp_path / "b")] == ["look", "look"]
    assert read_map(tmp_path / "a")[1]["objects"]


def test_an_empty_goal_is_refused_and_the_loop_lives_on(tmp_path: Path):
    models = FakeModels(home())
    with running(models) as (peer, ended):
        reply = begin(peer, tmp_path, goal="")
        assert reply == {"accepted": False, "code": 4720, "error": "goal: is empty"}
        assert (
            peer.ask("goal", {"goal": 3})["error"]
            == "goal request: goal: must be text, or a list of 16 at most"
        )
        told = peer.ask("goal", {"goal": "toilet", "log_dir": 3})["error"]
        assert told == "goal request: log_dir: must be text"
        assert models.asked == []  # it goes on looking for what it looked for
        assert peer.ask("status", {})["state"] == "ready"
    assert not ended


@pytest.mark.slow
def test_a_camera_without_intrinsics_ends_the_run_with_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("runtime.robot.camera_info.SENSOR_TIMEOUT_S", 0.2)
    there = home()
    with running(FakeModels(there)) as (peer, ended):
        begin(peer, tmp_path)
        peer.show(there, None, ended)
    assert isinstance(ended[0], SensorError)
    assert "camera/color/camera_info: no intrinsics" in str(ended[0])


@pytest.mark.slow
def test_depth_of_another_size_than_its_intrinsics_ends_the_run_with_one_line(tmp_path: Path):
    there = home()
    wrong = Intrinsics(97.0, 97.0, 160.0, 120.0, 320, 240)
    with running(FakeModels(there)) as (peer, ended):
        begin(peer, tmp_path)
        peer.show(there, wrong, ended)
    assert isinstance(ended[0], SensorError)
    assert "160x120" in str(ended[0])
    assert "320x240" in str(ended[0])


def test_a_goal_brings_settings_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("runtime.core.world.FIRST_LOOKS", 2)
    there = home()
    with running(FakeModels(there, r2f=farthest)) as (peer, ended):
        refused = peer.ask(
            "goal", {"goal": "toilet", "log_dir": str(tmp_path), "settings": ["consensus.mod=1"]}
        )
        assert "consensus.mod" in refused["error"]
        assert peer.ask(
            "goal",
            {
                "goal": "toilet",
                "log_dir": str(tmp_path),
                "settings": ["research.consensus_mode=lenient"],
            },
        )["accepted"]
        for _ in range(4):
            there.apply(Action(peer.show(there)))
        peer.ask("cancel", {})
    assert not ended
    decision = next(
        line for line in read_journal(tmp_path / "decisions.jsonl") if line["kind"] == "decision"
    )
    assert decision["step"] == 2
    assert decision["rule"] == "lone"


def test_in_velocity_mode_the_answer_is_a_twist(tmp_path: Path):
    there = home()
    with running(FakeModels(there), 'research.control_mode="velocity"') as (peer, ended):
        begin(peer, tmp_path)
        for _ in range(3):
            assert peer.show(there) == "turn_left"
            there.pose = Pose(4.0, 3.0, there.pose.yaw_rad + 0.06)
        peer.ask("cancel", {})
    assert not ended
    assert {"stamp_ns", "action", "v_mps", "w_radps"} == set(peer.answers[-1])
    assert peer.answers[-1]["v_mps"] == 0
    assert 0 < peer.answers[-1]["w_radps"] <= 0.6


def test_the_end_of_an_episode_says_what_came_of_its_goal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    unreachable = Command(
        Action.STOP, Mode.STOP, (1.0, 2.0), "no way leads there", ended=SearchState.UNREACHABLE
    )
    with running(FakeModels(home())) as (peer, ended):
        begin(peer, tmp_path / "a")
        assert peer.ask("cancel", {"reason": "enough"})["code"] == 4703
        begin(peer, tmp_path / "b")
        monkeypatch.setattr("runtime.navigate.act", lambda world, cfg: unreachable)
        assert peer.show(home()) == "stop"
        summary = peer.ask("cancel", {"reason": "stop"})
        for more in ({"limits": {"time_s": 3}}, {"afterwards": "return"}, {"goal": ["a", "b"]}):
            refused = peer.ask("goal", {"goal": "toilet", **more})
            assert (refused["code"], refused["error"][:22]) == (4720, "goal request: one goal")
    assert not ended
    assert (summary["result"], summary["code"]) == ("unreachable", 4702)
    ends = [list(read_journal(tmp_path / d / "decisions.jsonl"))[-1] for d in "ab"]
    assert [(end["reason"], end["result"]) for end in ends] == [
        ("enough", "cancelled"), ("stop", "unreachable"),
    ]  # fmt: skip
