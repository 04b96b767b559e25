"""What steps are counted as: by mode, aim, and how far the search has come."""

import pytest

from runtime.core.purpose import Purpose, purpose_of
from runtime.core.resorts import Resort
from runtime.core.types import Action, Pose
from runtime.core.world import Aim, AimKind, Command, Mode, World


def spent_on(mode: Mode, aim: AimKind = AimKind.NONE, resort: Resort = Resort.NONE) -> Purpose:
    world = World.begin("bed", ("bed",), ("bedroom",), Pose(0.0, 0.0, 0.0), 0.2)
    world.pursuit.aim, world.explored.resort = Aim(aim, 1), resort
    return purpose_of(world, Command(Action.MOVE_FORWARD, mode, None, ""))


@pytest.mark.parametrize(
    ("mode", "aim", "purpose"),
    [
        (Mode.LOOK, AimKind.NONE, Purpose.LOOKING_AROUND),
        (Mode.FRONTIER, AimKind.FRONTIER, Purpose.EXPLORING),
        (Mode.FRONTIER, AimKind.NEAR, Purpose.OTHER),
        (Mode.FRONTIER, AimKind.WAY, Purpose.LAST_RESORTS),
        (Mode.TARGET, AimKind.TARGET, Purpose.APPROACHING),
        (Mode.TARGET, AimKind.SIDE, Purpose.CONFIRMING),
        (Mode.FACE, AimKind.FACE, Purpose.CONFIRMING),
        (Mode.FACE, AimKind.WAY, Purpose.LAST_RESORTS),
        (Mode.RETURN, AimKind.START, Purpose.OTHER),
        (Mode.STOP, AimKind.FACE, Purpose.OTHER),
    ],
)
def test_a_step_is_counted_by_its_mode_and_aim(mode: Mode, aim: AimKind, purpose: Purpose) -> None:
    assert spent_on(mode, aim) is purpose


def test_what_comes_after_the_last_frontier_is_a_last_resort_unless_something_was_seen() -> None:
    assert spent_on(Mode.FRONTIER, AimKind.FRONTIER, Resort.TIGHT) is Purpose.LAST_RESORTS
    assert spent_on(Mode.LOOK, resort=Resort.RETRY) is Purpose.LAST_RESORTS
    assert spent_on(Mode.TARGET, AimKind.TARGET, Resort.FAINT) is Purpose.APPROACHING


def test_every_mode_has_one() -> None:
    told = {mode: spent_on(mode) for mode in Mode}
    others = {mode for mode, purpose in told.items() if purpose is Purpose.OTHER}
    assert others == {Mode.RETURN, Mode.PLACE, Mode.LEAVE, Mode.STOP}
