"""Experts on plans: what they have counted, and what they make of it."""

from plan_of_rooms import three_rooms

from hil_sim.expert_bench.flat_home import flat_home
from hil_sim.expert_bench.flat_search import drive, task_in
from hil_sim.expert_bench.flat_voices import FlatVoices, recognised
from hil_sim.scenes.format import ROOM_TYPES
from runtime.core.types import Ballot, Decision, Missing, Vote
from runtime.perception.counted import counted_in_homes

HOME = flat_home(three_rooms())
COUNTS = counted_in_homes()


def asked(spoilt: str = "") -> list[list[Vote | Missing]]:
    voices, said = FlatVoices(COUNTS, HOME.rooms, HOME.rooms, spoilt), []

    def decide(search, frontiers, unknown_m2):
        said.append(voices.ask(search, frontiers, unknown_m2))
        best = min(frontiers, key=lambda f: f.distance_m)
        return Decision(best.id, "closest", (), best.id, Ballot(), 0, "")

    task = task_in(HOME, "toilet", 1)
    assert task is not None
    drive(HOME, task, decide)
    return said


def test_each_is_heard_with_its_evidence():
    said = asked()
    assert all([each.expert for each in round] == ["o2f", "r2f", "sle"] for round in said)
    assert any(each.nats for round in said for each in round)


def test_who_is_spoilt_always_votes_for_one_or_two_blindly():
    votes = [each for round in asked("r2f") for each in round if each.expert == "r2f"]
    assert all(isinstance(each, Vote) and len(each.frontiers) in (1, 2) for each in votes)
    assert len({each.frontiers for each in votes}) > 1


def test_rooms_are_taken_for_what_they_are_or_for_others():
    assert (recognised(HOME, 1.0, "x") == HOME.rooms).all()
    none = recognised(HOME, 0.0, "x")
    inside = HOME.rooms >= 0
    assert (none[inside] != HOME.rooms[inside]).all()
    assert none.max() < len(ROOM_TYPES)
    assert (none[~inside] == -1).all()
