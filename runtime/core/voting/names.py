"""How experts, what answers for them, and rules are called for a person: on the page, in
`rfnav why` and in a demo alike."""

from collections.abc import Sequence
from typing import Final

WHO: Final = {
    "o2f": "objects near by",
    "r2f": "kind of room",
    "sle": "look of the view",
    "both": "objects and rooms",
}
ANSWERED_BY: Final = {
    "local": "the model on the robot",
    "cloud": "the model in the cloud",
    "language": "the model on the robot, which was shown the views",
    "head": "a network that was taught what lies beyond a view",
    "embedding": "the likeness of words, without a language model",
    "counts": "what was counted in homes",
    "local+counts": "the model on the robot and what was counted in homes",
    "told": "the harness, over the bus",
}
_NOBODY: Final = "nobody's word decided"
_GEOMETRY: Final = f"the most unknown behind it for the way there: {_NOBODY}"
_RULES: Final = {
    "all": "all that voted name it",
    "pairs": "two of them name it",
    "lone": "one alone voted, and here one voice counts",
    "weighted": "the least way, shortened by the weighed evidence of all",
    "best": "the surest of them names it",
    "majority": "it came most often in samples of what one of them holds likely",
    "closest": f"it is the closest: {_NOBODY}",
    "ratio": _GEOMETRY,  # in journals of before
    "gain": _GEOMETRY,
    "geometry": _GEOMETRY,
    "ahead": f"most of the unknown is seen soonest by looking there first: {_NOBODY}",
    "prior": "the most to find for the way there, by the unknown and what all say",
    "prior, planned": "the thing is found soonest in the mean by looking there first, by the "
    "unknown and what all say",
}


def who(expert: str) -> str:
    """ "objects near by"."""
    return WHO.get(expert, expert)


def introduced(expert: str) -> str:
    """ "objects near by (o2f)", as whom logs and settings know it."""
    return f"{WHO[expert]} ({expert})" if expert in WHO else expert


def rule_said(rule: str, planned: bool = False) -> str:
    """Why a frontier was taken, by `Decision.rule`; `planned`: of an order of several."""
    name = f"{rule}, planned" if planned else rule
    return _RULES.get(name) or _RULES.get(rule) or rule.replace("_", " ")


def listed(names: Sequence[str]) -> str:
    """ "a, b and c"."""
    return " and ".join([", ".join(names[:-1]), names[-1]]) if len(names) > 1 else names[0]
