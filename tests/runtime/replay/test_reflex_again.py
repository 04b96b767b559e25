"""An obstacle before the camera of a recorded drive, which the real reflex sees in its depth images
and the real control loop heeds, at the times of then."""

import pytest
from places import TESTS

from runtime.replay import reflex_again
from runtime.replay.drive import replay
from runtime.replay.reflex_again import FALSE_SHARE, RESUME_S, HeldAccount, ReflexAgain
from runtime.replay.script import Script

REFERENCE = TESTS / "refs/realtime.mcap"


def held() -> HeldAccount:
    script = Script.open(REFERENCE)
    reflex = ReflexAgain(script.config())
    replayed = replay(script, reflex=reflex)
    assert not replayed.stopped
    return reflex.account


def test_the_base_stands_as_long_as_it_is_there_and_only_so_long():
    account = held()
    assert account.held > 50
    assert account.stood == account.held
    assert len(account.resumed_s) >= 2
    assert max(account.resumed_s) <= RESUME_S == 0.3
    assert account.free > 100
    assert account.false <= FALSE_SHARE * account.free
    assert FALSE_SHARE == 0.01
    assert account.well
    assert held() == account  # nothing of it is chance


def test_what_is_held_out_of_its_way_holds_nothing(monkeypatch: pytest.MonkeyPatch):
    """So the turns that stand do so for the obstacle."""
    monkeypatch.setattr(reflex_again, "_obstructed", lambda depth_m, ahead_m: depth_m)
    account = held()
    assert account.held > 50
    assert account.stood <= FALSE_SHARE * account.held
    assert not account.well


@pytest.mark.parametrize(
    ("account", "well"),
    [
        (HeldAccount(100, 100, 200, 2, [0.05, 0.3]), True),
        (HeldAccount(100, 99, 200, 0, [0.05]), False),
        (HeldAccount(100, 100, 200, 3, [0.05]), False),
        (HeldAccount(100, 100, 200, 0, [0.05, 0.31]), False),
        (HeldAccount(0, 0, 200, 0, []), False),
    ],
)
def test_what_counts_as_well(account: HeldAccount, well: bool):
    assert account.well is well


def test_it_is_told_in_words():
    words = HeldAccount(100, 99, 200, 1, [0.05, 0.1, 0.2]).in_words()
    assert "stood in 99 of 100 turns" in words
    assert "on again after 0.10 s, 0.20 s at most" in words
    assert "false stops: 1 of 200" in words
    assert "never on again" in HeldAccount(100, 100, 200).in_words()
    assert "did not drive" in HeldAccount().in_words()
