"""The methods that are compared: how the runtime is set for each, and the two bounds.

A method is a row of the results' table. All but `oracle-goal` are the same runtime with other
settings. A name that begins with `oracle-perception/` gives it true labels instead of a detector:
boxes, names, how far each thing is and which room this is, and no view. One that begins with
`labels/` gives it true boxes and names alone: rooms, views and features are its own detector's.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

from hil_sim.driving.needed_models import CLIP, CLIP_WITH_RELEVANCE, MDETR, Needed
from hil_sim.driving.told_votes import Casts, How
from hil_sim.ground_truth.labels import LABELLED
from runtime.errors import ConfigError

ORACLE, LABELS = "oracle-perception", "labels"
OURS = "rfnav-det"
CLOSEST = 'research.consensus_fallback="closest"'
STRICT = 'research.consensus_mode="strict"'
LENIENT = 'research.consensus_mode="lenient"'
AHEAD = 'research.consensus_fallback="ahead"'
GEOMETRY = STRICT, 'research.consensus_fallback="geometry"'
LANGUAGE = 'research.word_evidence="language"'
PRIOR = 'research.consensus_mode="prior"', AHEAD
ONE_STEP = PRIOR[0], GEOMETRY[1]


@dataclass(frozen=True)
class Method:
    """`settings` are the runtime's `--set` values; `labels`: what of the true labels the harness
    publishes, "boxes" being boxes and names alone; `driver` "shortest" follows the shortest path
    without any runtime; `detector`, which somebody has to import, looks instead of the one that is
    configured; `casts`: the experts whose votes are the harness's."""

    settings: tuple[str, ...] = ()
    labels: Literal["", "all", "boxes"] = ""
    driver: Literal["runtime", "shortest"] = "runtime"
    detector: Needed | None = None
    casts: Casts = ()

    @property
    def eyes(self) -> str:
        """The detector that looks, and no other; "" for those that are configured."""
        if self.detector is not None:
            return self.detector.name
        return OURS if self.labels == "boxes" else ""

    @property
    def start(self) -> tuple[str, ...]:
        """Settings that a runtime must have been started with, beside its own."""
        return (f'models.detectors=["{self.eyes}"]',) if self.eyes else ()


def _experts(*names: str) -> str:
    return f"panel.experts=[{', '.join(repr(name) for name in names)}]"


def _alone(expert: str) -> Method:
    """One expert's word is law; the closest frontier when it abstains."""
    return Method((_experts(expert), LENIENT, CLOSEST))


def _majority(k: int) -> Method:
    """The combined expert, sampled k times from its softmax at temperature 1; most votes win."""
    mode = f'research.consensus_mode="majority-{k}"'
    surest = "research.experts_temperature=1.0", "research.experts_bar=0.0"
    return Method((_experts("both"), mode, *surest, CLOSEST))


def _cow(detector: Needed, *settings: str) -> Method:
    """CLIP on Wheels (Gadre et al., CVPR 2023): the closest frontier until the goal is seen."""
    return Method((_experts(), CLOSEST, *settings), detector=detector)


def _cast(*casts: tuple[str, How], settings: tuple[str, ...] = ()) -> Method:
    """These experts' votes come from the harness, the others' as ever."""
    told = ", ".join(repr(expert) for expert, _ in casts)
    return Method((*settings, f"research.told_experts=[{told}]"), casts=casts)


def _labelled(method: Method) -> Method:
    return replace(method, settings=(*method.settings, *_source("topic")), labels="all")


def _boxed(method: Method) -> Method:
    return replace(method, settings=(*method.settings, *_source("both")), labels="boxes")


def _source(source: str) -> tuple[str, str]:
    names = ", ".join(repr(name) for name in LABELLED)
    return f'research.detector_source="{source}"', f"research.detector_labels=[{names}]"


SINGLE: dict[str, Method] = {
    "rfnav": Method(),
    "sets": Method(GEOMETRY),
    "paper": Method((STRICT, CLOSEST, LANGUAGE)),
    "closest": Method((_experts(), CLOSEST)),
    "geometry": Method((_experts(), *GEOMETRY)),
    "geometry-ahead": Method((_experts(), STRICT, AHEAD)),
    "prior": Method(PRIOR),
    "prior-one-step": Method(ONE_STEP),
    "single-llm": Method((_experts("both"), 'research.consensus_mode="best"', CLOSEST, LANGUAGE)),
    "majority-k3": _majority(3),
    "majority-k5": _majority(5),
    "o2f": _alone("o2f"),
    "r2f": _alone("r2f"),
    "sle": _alone("sle"),
    "o2f+r2f": Method((_experts("o2f", "r2f"), STRICT, CLOSEST, LANGUAGE)),
    "o2f+sle": Method((_experts("o2f", "sle"), STRICT, CLOSEST, LANGUAGE)),
    "r2f+sle": Method((_experts("r2f", "sle"), STRICT, CLOSEST, LANGUAGE)),
    "without-o2f": Method((_experts("r2f", "sle"),)),
    "without-r2f": Method((_experts("o2f", "sle"),)),
    "without-sle": Method((_experts("o2f", "r2f"),)),
    "spoilt-o2f": _cast(("o2f", "random")),
    "spoilt-r2f": _cast(("r2f", "random")),
    "spoilt-sle": _cast(("sle", "random")),
}
"""`rfnav` is the runtime as it is; `sets` asks that two experts agree, and goes by information gain
where they do not; `without` one of the runtime's experts, or with one `spoilt`, whose votes are
drawn at random. `paper` and all that the paper compares with fall back on the closest frontier, and
a language model answers for their experts of words."""
ROOMS: tuple[str, How] = ("r2f", "rooms")
OBJECTS: tuple[str, How] = ("o2f", "objects")
BEYOND: tuple[str, How] = ("sle", "beyond")
BOUNDS: dict[str, Method] = {
    "rooms-known": _cast(ROOMS),
    "objects-known": _cast(OBJECTS),
    "beyond-known": _cast(BEYOND),
    "all-known": _cast(ROOMS, OBJECTS, BEYOND),
    "beyond-alone": _cast(BEYOND, settings=(_experts("sle"), LENIENT)),
    "prior-rooms-known": _cast(ROOMS, settings=PRIOR),
    "prior-objects-known": _cast(OBJECTS, settings=PRIOR),
    "prior-beyond-known": _cast(BEYOND, settings=PRIOR),
    "prior-all-known": _cast(ROOMS, OBJECTS, BEYOND, settings=PRIOR),
}
"""What a vote could bring, under true boxes: experts who know the truth (`oracle_votes`), elected
by the same rule as ever, or by `prior`'s; `beyond-alone`: one's word is law."""
COW: dict[str, Method] = {
    "cow-clip-patch": _cow(CLIP, 'research.clip_way="patch"'),
    "cow-clip-ref": _cow(CLIP, 'research.clip_way="reference"'),
    "cow-clip-grad": _cow(CLIP_WITH_RELEVANCE, 'research.clip_way="grad"'),
    "cow-mdetr": _cow(MDETR),
}
"""What the paper compares with that looks with other eyes: `closest`, with an imported detector."""
METHODS: dict[str, Method] = {
    **SINGLE,
    **COW,
    ORACLE: _labelled(SINGLE["rfnav"]),
    **{f"{ORACLE}/{name}": _labelled(method) for name, method in SINGLE.items()},
    **{f"{LABELS}/{name}": _boxed(method) for name, method in (SINGLE | BOUNDS).items()},
    "oracle-goal": Method(driver="shortest"),
}


KNOWN = ", ".join(
    [*SINGLE, *COW, ORACLE, f"{ORACLE}/METHOD", f"{LABELS}/METHOD",
     *(f"{LABELS}/{name}" for name in BOUNDS), "oracle-goal"]
)  # fmt: skip


def method_named(name: str) -> Method:
    """A method by name; ConfigError lists the known ones."""
    if name not in METHODS:
        raise ConfigError(f"method {name}: unknown; known: {KNOWN}")
    return METHODS[name]


def needed_models(names: Iterable[str]) -> dict[str, str]:
    """Imported models that methods look with -> what their files' content is known by. ConfigError
    for the first method that misses one."""
    found = {}
    for name in names:
        detector = method_named(name).detector
        if detector is not None:
            found[detector.name] = detector.identity(name)
    return found
