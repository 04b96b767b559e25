"""What a step is spent on: the few purposes by which a search's steps are counted."""

from collections.abc import Mapping
from enum import StrEnum
from typing import Final

from runtime.core.resorts import Resort
from runtime.core.world import AimKind, Command, Mode, World


class Purpose(StrEnum):
    """Why a step is made, in the order in which shares are told."""

    EXPLORING = "exploring"  # on the way to what is unknown
    LOOKING_CLOSER = "looking closer"  # at what was not seen finely enough for the goal
    APPROACHING = "approaching"  # what may be the goal
    CONFIRMING = "confirming"  # that it is: from another side, or by facing it
    LOOKING_AROUND = "looking around"  # before the first decision
    LAST_RESORTS = "last resorts"  # nothing is left to explore
    OTHER = "other"  # where it was said to be, a place, the way back, the stop


_BY_MODE: Final[Mapping[str, Purpose]] = {
    Mode.FRONTIER: Purpose.EXPLORING,
    Mode.CLOSER: Purpose.LOOKING_CLOSER,
    Mode.TARGET: Purpose.APPROACHING,
    Mode.FACE: Purpose.CONFIRMING,
    Mode.LOOK: Purpose.LOOKING_AROUND,
}
_BY_AIM: Final[Mapping[AimKind, Purpose]] = {
    AimKind.SIDE: Purpose.CONFIRMING,
    AimKind.NEAR: Purpose.OTHER,
    AimKind.PLACE: Purpose.OTHER,
    AimKind.WAY: Purpose.LAST_RESORTS,
}
_LED_BY_AIM: Final = (Purpose.EXPLORING, Purpose.APPROACHING, Purpose.CONFIRMING)
_RESORTED: Final = (Purpose.EXPLORING, Purpose.LOOKING_AROUND)


def purpose_of(world: World, command: Command) -> Purpose:
    """What the step that was just decided is spent on."""
    purpose = _BY_MODE.get(command.mode, Purpose.OTHER)
    if purpose in _LED_BY_AIM:
        purpose = _BY_AIM.get(world.pursuit.aim.kind, purpose)
    if purpose in _RESORTED and world.explored.resort is not Resort.NONE:
        return Purpose.LAST_RESORTS
    return purpose
