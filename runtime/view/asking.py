"""What a page may ask the service for: what it is for, and nothing else of what the bus takes."""

from collections.abc import Mapping
from typing import Any, Final

GOAL: Final = ("goal", "go_to", "area", "limits", "if_busy", "several", "afterwards")
ASKED: Final[Mapping[str, tuple[str, ...]]] = {
    "goal": GOAL,
    "cancel": ("id",),
    "pause": (),
    "resume": (),
    "stop": (),
    "release": (),
    "zones": ("add", "polygon", "remove"),
    "places": ("name", "at", "remove", "i_am_at"),
    "why": ("decision", "stop"),
    "where": ("name",),
}
"""By what is asked, which is a query on `rfnav/WHAT`: what may be in it. Settings of a search,
`forget` and `clear` are asked where the robot is (`rfnav ask`)."""
WORD: Final = 40  # letters of a word that is told back


def asked(what: str, body: object) -> dict[str, Any]:
    """The query's body; ValueError, one line, for what a page may not ask."""
    names = ASKED.get(what)
    if names is None:
        raise ValueError(f"{what[:WORD]!r}: a page asks {', '.join(ASKED)}")
    if not isinstance(body, Mapping):
        raise ValueError(f"{what}: body must be a JSON object")
    for name in body:
        if name not in names:
            known = ", ".join(names) or "nothing"
            raise ValueError(f"{what}: {str(name)[:WORD]!r}: may have {known}")
    if what in ("zones", "places") and not body:
        raise ValueError(f"{what}: must have one of {', '.join(names)}")
    return dict(body)
