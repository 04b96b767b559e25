"""The methods that are compared: how the runtime is set for each, and the two bounds.

A method is a row of the results' table. All but `oracle-goal` are the same runtime with other
settings; a name that begins with `oracle-perception/` gives it true labels instead of a detector.
"""

from dataclasses import dataclass, replace
from typing import Literal

from hil_sim.ground_truth.labels import LABELLED
from runtime.errors import ConfigError

ORACLE = "oracle-perception"
CLOSEST = 'research.consensus_fallback="closest"'


@dataclass(frozen=True)
class Method:
    """`settings` are the runtime's `--set` values; `labels`: the harness publishes true labels;
    `driver` "shortest" follows the shortest path without any runtime."""

    settings: tuple[str, ...] = ()
    labels: bool = False
    driver: Literal["runtime", "shortest"] = "runtime"


def _experts(*names: str) -> str:
    return f"panel.experts=[{', '.join(repr(name) for name in names)}]"


def _alone(expert: str) -> Method:
    """One expert's word is law; the closest frontier when it abstains."""
    return Method((_experts(expert), 'research.consensus_mode="lenient"', CLOSEST))


def _majority(k: int) -> Method:
    """The combined expert, sampled k times from its softmax at temperature 1; most votes win."""
    mode = f'research.consensus_mode="majority-{k}"'
    surest = "research.experts_temperature=1.0", "research.experts_bar=0.0"
    return Method((_experts("both"), mode, *surest, CLOSEST))


def _labelled(method: Method) -> Method:
    names = ", ".join(repr(name) for name in LABELLED)
    told = ('research.detector_source="topic"', f"research.detector_labels=[{names}]")
    return replace(method, settings=(*method.settings, *told), labels=True)


SINGLE: dict[str, Method] = {
    "rfnav": Method(),
    "paper": Method((CLOSEST,)),
    "closest": Method((_experts(), CLOSEST)),
    "geometry": Method((_experts(),)),
    "single-llm": Method((_experts("both"), 'research.consensus_mode="best"', CLOSEST)),
    "majority-k3": _majority(3),
    "majority-k5": _majority(5),
    "o2f": _alone("o2f"),
    "r2f": _alone("r2f"),
    "sle": _alone("sle"),
    "o2f+r2f": Method((_experts("o2f", "r2f"), CLOSEST)),
    "o2f+sle": Method((_experts("o2f", "sle"), CLOSEST)),
    "r2f+sle": Method((_experts("r2f", "sle"), CLOSEST)),
}
"""`rfnav` is the runtime as it is: where experts do not agree it goes by information gain. `paper`
and all that the paper compares with fall back on the closest frontier."""
METHODS: dict[str, Method] = {
    **SINGLE,
    ORACLE: _labelled(SINGLE["rfnav"]),
    **{f"{ORACLE}/{name}": _labelled(method) for name, method in SINGLE.items()},
    "oracle-goal": Method(driver="shortest"),
}


def method_named(name: str) -> Method:
    """A method by name; ConfigError lists the known ones."""
    if name not in METHODS:
        known = ", ".join([*SINGLE, ORACLE, f"{ORACLE}/METHOD", "oracle-goal"])
        raise ConfigError(f"method {name}: unknown; known: {known}")
    return METHODS[name]
