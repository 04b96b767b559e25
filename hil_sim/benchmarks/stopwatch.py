"""How long the stages of a frame take, each beside a fixed piece of work that is done in turn.

Times are the thread's own, so that what else runs on the machine counts as little as it can.
"""

import functools
import importlib
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import thread_time
from typing import Any

import cv2
import numpy as np

STAGES: Mapping[str, tuple[str, ...]] = {
    "integrate": ("runtime.core.mapping.grid.integrate",),
    "terrain and distances": ("runtime.core.distances.planner.look_around",),
    "of that, terrain": ("runtime.core.distances.terrain.TerrainSurvey.update",),
    "frontiers": (
        "runtime.core.mapping.frontiers.Boundary.update",
        "runtime.core.mapping.frontiers.identify",
    ),
    "semantic layer": ("runtime.core.objects.semantic_map.place",),
    "keyframe": ("runtime.core.mapping.keyframes.consider",),
}
"""By stage the functions that it calls, found where their callers look them up."""


@dataclass
class StageTimes:
    """Seconds by stage, one entry for each frame that had it."""

    seconds: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    _frame: dict[str, float] = field(default_factory=dict)

    def timed(self, stage: str, call: Callable[..., Any]) -> Callable[..., Any]:
        """The function, with the time of its calls booked."""

        @functools.wraps(call)
        def wrapper(*args: Any, **kwargs: Any) -> Any:
            began_s = thread_time()
            try:
                return call(*args, **kwargs)
            finally:
                self._book(stage, thread_time() - began_s)

        return wrapper

    def timed_by(self, stage_of: Callable[[Any], str], call: Callable[..., Any]) -> Any:
        """The same, where what comes out says of which stage it was."""

        @functools.wraps(call)
        def wrapper(*args: Any, **kwargs: Any) -> Any:
            began_s = thread_time()
            found = call(*args, **kwargs)
            took_s = thread_time() - began_s
            self._book(stage_of(found), took_s)
            return found

        return wrapper

    def _book(self, stage: str, took_s: float) -> None:
        self._frame[stage] = self._frame.get(stage, 0.0) + took_s

    def next_frame(self) -> None:
        """Keep what this frame took."""
        for stage, seconds in self._frame.items():
            self.seconds[stage].append(seconds)
        self._frame = {}

    @contextmanager
    def watching(self) -> Iterator[None]:
        """The stages' own functions are timed meanwhile."""
        before = []
        for stage, paths in STAGES.items():
            for path in paths:
                place, name = _found(path)
                call = getattr(place, name)
                before.append((place, name, call))
                setattr(place, name, self.timed(stage, call))
        try:
            yield
        finally:
            for place, name, call in before:
                setattr(place, name, call)

    def median_ms(self, stage: str) -> float:
        """NaN for a stage that never was."""
        return 1000 * float(np.median(self.seconds.get(stage, [np.nan])))

    def p99_ms(self, stage: str) -> float:
        """NaN for a stage that never was."""
        return 1000 * float(np.percentile(self.seconds.get(stage, [np.nan]), 99))


class ReferenceWork:
    """About half a millisecond of what the core is made of, the same on every machine and at every
    commit: sorting, a distance transform, a loop in Python."""

    def __init__(self) -> None:
        rng = np.random.default_rng(0)
        self._numbers = rng.random(8000)
        self._mask = (rng.random((192, 192)) > 0.02).view(np.uint8)

    def __call__(self) -> None:
        """Do it."""
        np.sort(self._numbers)
        cv2.distanceTransform(self._mask, cv2.DIST_L2, cv2.DIST_MASK_5)
        total = 0
        for n in range(6000):
            total += n & 3


def _found(path: str) -> tuple[Any, str]:
    """Where a function is looked up, a module or a class of one, and its name."""
    owner, name = path.rsplit(".", 1)
    module, _, last = owner.rpartition(".")
    if last[0].isupper():
        return getattr(importlib.import_module(module), last), name
    return importlib.import_module(owner), name
