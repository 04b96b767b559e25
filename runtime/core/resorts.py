"""The last resorts of a search, in their order."""

from enum import IntEnum
from typing import Literal

LastLooks = Literal["afar", "closer"]


class Resort(IntEnum):
    """What is tried, one after the other, when no frontier is left to go to. CLOSER and AFAR are
    after the same: a search has one of them, until whole searches have judged which."""

    NONE = 0
    CLOSER = 1
    RETRY = 2
    TIGHT = 3
    AFAR = 4
    FAINT = 5

    @property
    def reason(self) -> str:
        """In words."""
        return _RESORTS[self]

    def next(self, looks: LastLooks) -> "Resort | None":
        """What comes after it, for who has these last looks; None after the last."""
        out = Resort.AFAR if looks == "closer" else Resort.CLOSER
        return next((one for one in Resort if one > self and one is not out), None)


_RESORTS = {
    Resort.NONE: "",
    Resort.CLOSER: "look closer at what was not seen finely enough",
    Resort.RETRY: "retry what was given up before",
    Resort.TIGHT: "go through gaps that look a little too tight",
    Resort.AFAR: "go to what was seen only from afar",
    Resort.FAINT: "look from near at what was faintly like it",
}
