"""A model that votes, tried: what it says of views that come along, how long a vote takes here, and
which budget that needs. Asked as the runtime asks it, of frontiers that are pictures: what our own
detectors see in them is what is known near each."""

import math
import os
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np

from models.detection.trial import read_picture
from models.errors import ModelFileError
from models.store import manifest
from runtime.clock import Deadline, SystemClock
from runtime.config import Config, load
from runtime.core.mapping.framing import jpeg
from runtime.core.mapping.sights import halved
from runtime.core.types import (
    Absence,
    Brief,
    Detections,
    FrontierBrief,
    InImage,
    Missing,
    NearbyObject,
    Sight,
    Vote,
)
from runtime.experts.panel import RESERVE_S, PanelConfig
from runtime.experts.seating import LOCAL, LOCAL_SHARE
from runtime.perception.loaded_models import GGUF, LoadedModels

DEFAULT = "experts"  # all that vote where nothing is configured
VOTERS = {"language": ("o2f", "r2f"), "vision": ("sle",)}
"""Which experts a model of a task is asked for."""
ASKED = ("toilet", "bed", "television")
TIMED = "mug"
FRONTIERS = 8
WIDTH_PX = 320
RANGE_M, NEAR_M = 2.0, 1.0  # how far each frontier, and the things near it, are said to be
SURE = 0.4  # a thing that is said to be there
BUDGET_STEP_S = 0.5
BUSY = 0.5  # load per processor, before anything is tried


@dataclass(frozen=True)
class Voter:
    """A model by its name, or two files, as a configuration has it."""

    name: str
    experts: tuple[str, ...]
    settings: tuple[str, ...]

    @classmethod
    def named(cls, name: str, projector: str, handler: str, threads: int) -> "Voter | None":
        """None when it is a detector. Raises ModelFileError where it is neither."""
        settings = [f"models.threads={threads}"]
        known = manifest.load_manifest().get(name)
        task = known.task if known is not None else ""
        if name.endswith(GGUF):
            task = "vision" if projector else "language"
        if name == DEFAULT:
            return cls(name, PanelConfig().experts, tuple(settings))
        if task in ("", "detector"):
            return None
        if task not in VOTERS:
            raise ModelFileError(f"{name}: is a model for {task}, and neither sees nor votes")
        settings.append(f"models.{task}={_toml(name)}")
        for key, value in (("projector", projector), ("handler", handler)):
            if value:
                settings.append(f"models.vision_{key}={_toml(value)}")
        if task == "vision":
            settings.append(f"keyframes.image_width_px={WIDTH_PX}")
        return cls(name, VOTERS[task], tuple(settings))

    def tried(self, pictures: Sequence[Path]) -> Iterator[str]:
        """What is to be told of it, line by line. Raises RfNavError."""
        clock = SystemClock()
        with tempfile.TemporaryDirectory() as folder:
            scores = _toml(str(Path(folder) / "scores.sqlite"))
            experts = ", ".join(_toml(name) for name in self.experts)
            own = (f"research.score_file={scores}", f"panel.experts=[{experts}]")
            config = load(None, (*self.settings, *own))
            busy, began_s = _busy(), time.perf_counter()
            with LoadedModels(config, clock) as models:
                models.seated(config)
                loaded_s = time.perf_counter() - began_s
                yield f"{self.name}: votes as {', '.join(self.experts)}; loaded in {loaded_s:.1f} s"
                if busy:
                    yield busy
                trial = _Trial(models, config, clock, [_View.of(p) for p in pictures])
                yield from trial.answers()
                yield from trial.times()
        for setting in self.settings:
            if not setting.startswith("models.threads"):
                yield f"use it with {setting}"


@dataclass(frozen=True)
class _View:
    """A picture, (H, W, 3) RGB, and its file as the robot would keep it."""

    name: str
    rgb: np.ndarray[tuple[int, int, int], np.dtype[np.uint8]]
    kept: bytes

    @classmethod
    def of(cls, path: Path) -> "_View":
        rgb = np.asarray(read_picture(path), np.uint8)
        size = WIDTH_PX, max(1, round(rgb.shape[0] * WIDTH_PX / rgb.shape[1]))
        small = cv2.resize(rgb, size, interpolation=cv2.INTER_AREA)
        return cls(path.name, rgb, jpeg(np.asarray(small, np.uint8)))


@dataclass
class _Trial:
    """The experts, loaded, and what they are shown."""

    models: LoadedModels
    config: Config
    clock: SystemClock
    views: list[_View]
    seen: list[FrontierBrief] = field(default_factory=list)

    def answers(self) -> Iterator[str]:
        """What each expert says of the views, for a few goals."""
        goal, _ = self.models.accept(ASKED[0], self.config)
        classes = [names[0] for names in goal.classes]
        self.seen = [self._frontier(view, classes) for view in self.views]
        for text in ASKED:
            named = self._accepted(text)
            votes = self._asked(named, len(self.views), self.config)
            for name, outcome in votes.items():
                yield f"  {name}, {text}: {self._told(outcome)}{self._shy(name, outcome, named)}"

    def times(self) -> Iterator[str]:
        """How long votes take, and which budget holds them."""
        pictures = self.models.health().get("pictures")
        if isinstance(pictures, dict):
            yield f"a picture is encoded in {pictures['last_s']:.2f} s, when its keyframe is kept"
        first_s, again_s = self._timed(), self._timed()
        yield (
            f"a vote on {FRONTIERS} frontiers: {first_s:.2f} s where nothing was asked before, "
            f"{again_s:.2f} s where all was"
        )
        usual_s = self.config.panel.decide_budget_s
        needed_s = first_s / LOCAL_SHARE + RESERVE_S
        if needed_s <= usual_s:
            yield f"panel.decide_budget_s: {usual_s:g}, the default, holds it"
        else:
            budget_s = math.ceil(needed_s / BUDGET_STEP_S) * BUDGET_STEP_S
            yield f"panel.decide_budget_s: {budget_s:g} would hold it; {usual_s:g} is the default"

    def _timed(self) -> float:
        goal = self._accepted(TIMED)
        began_s = time.perf_counter()
        self._asked(goal, FRONTIERS, self.config)
        return time.perf_counter() - began_s

    def _accepted(self, text: str) -> str:
        """The goal's name, once all that is scored for it before a vote is."""
        goal, _ = self.models.accept(text, self.config)
        self.models.settle(Deadline.never(self.clock))
        return goal.name

    def _asked(
        self, goal: str, count: int, config: Config, experts: Sequence[str] = ()
    ) -> dict[str, Vote | Missing]:
        """On so many frontiers: the views, again and again, and each time another place in them.
        One expert after the other: on few cores they take that long at once, too. `experts`: of
        these alone, where any are named."""
        rounds = math.ceil(count / len(self.seen))
        frontiers = tuple(
            replace(
                self.seen[n % len(self.seen)], id=n + 1, in_image=_at(n // len(self.seen), rounds)
            )
            for n in range(count)
        )
        brief, never = Brief(goal, 0, frontiers), Deadline.never(self.clock)
        seats = self.models.seated(config).items()
        return {name: ask(brief, never) for name, ask in seats if not experts or name in experts}

    def _frontier(self, view: _View, classes: Sequence[str]) -> FrontierBrief:
        found = self._seen(view)
        pairs = zip(found.labels.tolist(), found.scores.tolist(), strict=True)
        sure = sorted({(classes[k], round(p, 2)) for k, p in pairs if p >= SURE})
        rooms = zip(self.models.rooms, found.rooms.tolist(), strict=bool(found.rooms.size))
        return FrontierBrief(
            0,
            RANGE_M,
            tuple(NearbyObject(name, p, NEAR_M) for name, p in sure),
            tuple(rooms),
            found.scene,
            view.kept,
            unknown_m2=1.0,
            sight=_sight(found),
        )

    def _seen(self, view: _View) -> Detections:
        """By the detector that tells most of the whole: they look in turn."""
        looks = [self.models.detect(view.rgb) for _ in self.config.models.detectors]
        return max(looks, key=lambda seen: (seen.features.size, seen.scene.size))

    def _told(self, outcome: Vote | Missing) -> str:
        if isinstance(outcome, Missing):
            shy = outcome.why is Absence.NO_PREFERENCE
            return outcome.why.value if shy else outcome.cause
        each = ", ".join(f"{self.views[id - 1].name} {p:.2f}" for id, p in outcome.probabilities)
        by = "" if outcome.rung == LOCAL else f" (by {outcome.rung})"
        return f"{each}{by}"

    def _shy(self, name: str, outcome: Vote | Missing, goal: str) -> str:
        """ ": a.jpg 0.36, b.jpg 0.33": what one that prefers none makes of the views all the same;
        else ""."""
        if isinstance(outcome, Vote) or outcome.why is not Absence.NO_PREFERENCE:
            return ""
        config = replace(self.config, experts=replace(self.config.experts, bar=0.0))
        every = self._asked(goal, len(self.views), config, (name,))
        return f": {self._told(every[name])}"


def _busy() -> str:
    """What to say where others are at work: times are told as they are."""
    load, processors = os.getloadavg()[0], len(os.sched_getaffinity(0))
    if load < BUSY * processors:
        return ""
    return f"  the machine is busy (load {load:.1f}, processors {processors}): it is faster alone"


def _at(side: int, sides: int) -> InImage:
    return InImage((side + 0.5) / sides, 0.8, RANGE_M)


def _sight(found: Detections) -> Sight | None:
    """Without depth, of which a picture tells nothing."""
    if not found.features.size:
        return None
    nothing = np.zeros((2, *found.features.shape[1:]), np.float16)
    return Sight(halved(found.features), nothing, 0.5, RANGE_M)


def _toml(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
