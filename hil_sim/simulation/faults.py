"""What goes wrong on purpose: `--fault camera-freeze:at=30,for=10`. One table, a few lines each.

`at` is the observation (`30`) or the simulated second (`12s`) at which it begins, `for` how long it
lasts, `size` how bad it is. Faults on the camera, the odometry and the clock change what the
runtime is told; in lockstep a frame that is dropped is not sent, and the robot stands still.
"""

import math
import re
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from runtime.core.types import Pose
from runtime.errors import ConfigError


@dataclass(frozen=True)
class Sensed:
    """What the runtime is about to be told. `rgb` (H, W, 3), `depth_m` (H, W); `odometry` in the
    runtime's map frame."""

    rgb: NDArray[np.uint8]
    depth_m: NDArray[np.float32]
    odometry: Pose
    stamp_ns: int


Spoil = Callable[[Sensed, Sensed, float], Sensed | None]
"""What is sensed now, what was sensed when the fault began, its size -> what is sent, if it is."""


def _shifted(pose: Pose, size_m: float) -> Pose:
    return Pose(pose.x_m + size_m, pose.y_m, pose.yaw_rad)


@dataclass(frozen=True)
class Kind:
    """`means`: what `size` is; "" when there is none. `timed`: has a beginning and an end.
    `realtime`: there is no such thing in lockstep.
    `model`: what is wrong with the runtime's models (see `faulty_runtime`); `settings`: `--set`
    values that go with it."""

    what: str
    means: str = ""
    size: float = 0.0
    lasts: float = 10
    spoil: Spoil | None = None
    timed: bool = True
    realtime: bool = False
    model: str = ""
    settings: tuple[str, ...] = ()


BUDGET = ("research.budget_in_lockstep=true",)
"""Else a decision in lockstep waits for whatever hangs."""
ASKED = "research.word_evidence=language"
"""Else what was counted answers, and a language model is asked for little."""
KINDS: dict[str, Kind] = {
    "camera-freeze": Kind(
        "the same colour and depth image again and again, with new stamps",
        spoil=lambda now, then, _: replace(now, rgb=then.rgb, depth_m=then.depth_m),
    ),
    "camera-drop": Kind("no frames come", spoil=lambda now, then, _: None),
    "depth-blank": Kind(
        "no depth reading in any pixel",
        spoil=lambda now, then, _: replace(now, depth_m=np.zeros_like(now.depth_m)),
    ),
    "odometry-jump": Kind(
        "the reported position jumps, for good unless `for` says otherwise",
        "metres along the map's x",
        0.5,
        math.inf,
        lambda now, then, size: replace(now, odometry=_shifted(now.odometry, size)),
    ),
    "odometry-stop": Kind(
        "the reported pose no longer changes; in real time none is reported",
        spoil=lambda now, then, _: replace(now, odometry=then.odometry),
    ),
    "clock-step": Kind(
        "stamps jump",
        "seconds; in lockstep only forward",
        60.0,
        math.inf,
        lambda now, then, size: replace(now, stamp_ns=now.stamp_ns + round(size * 1e9)),
    ),
    "link-lost": Kind(
        "the Zenoh session closes, and opens again", spoil=lambda now, then, _: None
    ),
    "base-deaf": Kind("the base ignores its commands"),
    "person": Kind(
        "a person walks through the home", "metres per second", 0.8, math.inf
    ),
    "hand": Kind(
        "a hand takes the sticks, turns and drives ahead; in real time",
        "metres per second", 0.3, 6, realtime=True,
    ),
    "battery-low": Kind(
        "the battery holds no more than that; in real time", "percent", 10.0, math.inf,
        realtime=True,
    ),
    "door-closes": Kind(
        "the doorway nearest the robot is closed, and opened again", lasts=math.inf
    ),
    "person-stands": Kind(
        "a person stands in the doorway nearest the robot, and goes on", lasts=math.inf
    ),
    "stairwell": Kind(
        "the floor opens in the robot's way, 2.2 m ahead, where there is room", lasts=math.inf
    ),
    "llm-hang": Kind(
        "the language model never answers", timed=False, model="hang", settings=(*BUDGET, ASKED)
    ),
    "llm-nonsense": Kind(
        "the language model answers nonsense", timed=False, model="nonsense", settings=(ASKED,)
    ),
    "cloud-down": Kind(
        "there is a cloud model to ask, but it refuses or never answers",
        timed=False, model="cloud-down", settings=BUDGET,
    ),
}  # fmt: skip
HELP = (
    f"What goes wrong on purpose: {', '.join(KINDS)}. KEY: `at` and `for`, in observations (30) or "
    "simulated seconds (12s), and `size`; each fault has its own defaults."
)
"""Of the option of every command that takes faults."""
AT = 20.0
_LENGTH = re.compile(r"(\d+(?:\.\d+)?)(s?)")


@dataclass(frozen=True)
class When:
    """A moment: observations count from 1, simulated seconds from 0."""

    step: int
    now_s: float


@dataclass(frozen=True)
class Span:
    """A number of observations or of simulated seconds."""

    value: float
    seconds: bool = False

    def of(self, when: When) -> float:
        return when.now_s if self.seconds else float(when.step)


@dataclass(frozen=True)
class Fault:
    """One fault as it was asked for."""

    name: str
    at: Span
    lasts: Span
    size: float
    text: str

    @property
    def kind(self) -> Kind:
        return KINDS[self.name]


def parse_faults(texts: Iterable[str]) -> tuple[Fault, ...]:
    """`NAME[:key=value,...]` each; ConfigError, one line, names the known ones."""
    return tuple(_parse(text) for text in texts)


def _parse(text: str) -> Fault:
    name, _, rest = text.partition(":")
    if name not in KINDS:
        raise ConfigError(f"fault {name}: unknown; known: {', '.join(KINDS)}")
    kind = KINDS[name]
    known = (["at", "for"] if kind.timed else []) + (["size"] if kind.means else [])
    given: dict[str, str] = {}
    for part in rest.split(",") if rest else ():
        key, _, value = (word.strip() for word in part.partition("="))
        if key not in known:
            takes = ", ".join(known) or "none"
            raise ConfigError(f"fault {name}: parameter {key!r}: unknown; it takes {takes}")
        given[key] = value
    return Fault(
        name,
        _span(name, "at", given["at"]) if "at" in given else Span(AT),
        _span(name, "for", given["for"]) if "for" in given else Span(kind.lasts),
        _size(name, given["size"], kind) if "size" in given else kind.size,
        text,
    )


def _span(name: str, key: str, text: str) -> Span:
    found = _LENGTH.fullmatch(text)
    if found is None:
        raise ConfigError(
            f"fault {name}: {key}={text}: must be a number of observations (30) or seconds (12s)"
        )
    return Span(float(found[1]), found[2] == "s")


def _size(name: str, text: str, kind: Kind) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or (name in ("person", "hand") and value <= 0):
        raise ConfigError(f"fault {name}: size={text}: must be a number ({kind.means})")
    return value


def model_fault(
    faults: Iterable[Fault], mode: tuple[str, ...] = ("--lockstep",)
) -> tuple[list[str] | None, tuple[str, ...]]:
    """The command that starts a runtime whose models are at fault (None: the usual one), and the
    `--set` values it needs."""
    for fault in faults:
        if fault.kind.model:
            module = [sys.executable, "-m", "hil_sim.driving.faulty_runtime", fault.kind.model]
            return [*module, "run", "--harness", *mode], fault.kind.settings
    return None, ()
