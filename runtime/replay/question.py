"""Another question to a recorded drive: what of it would have been found on this way, and when. The
robot cannot be sent anywhere: it is told what it would have gone to."""

import functools
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from runtime.config import Config
from runtime.core.objects import candidates
from runtime.core.objects.verdict import confirmed
from runtime.core.world import World
from runtime.errors import RecordingError
from runtime.loops.goal_request import Terms
from runtime.loops.order import SearchModels, understand
from runtime.loops.search import Search, seen
from runtime.replay.script import Script, Turn, observed


@dataclass(frozen=True)
class Finding:
    """A thing that would have been gone to. Times are since the recording began, s; `believed_s`:
    None when the views of this drive do not suffice for that."""

    id: int
    name: str
    xy: tuple[float, float]
    noticed_s: float
    believed_s: float | None
    confidence: float  # at the end
    near_m: float  # range of the nearest view that spoke for it

    def in_words(self) -> str:
        x_m, y_m = self.xy
        told = f"{self.name} {self.id} at ({x_m:.1f}, {y_m:.1f}): gone to from {self.noticed_s:.1f}"
        told += " s on, "
        told += (
            "not believed" if self.believed_s is None else f"believed at {self.believed_s:.1f} s"
        )
        return f"{told}, p {self.confidence:.2f}, seen from {self.near_m:.1f} m at the nearest"


def asked(
    script: Script, goal: str, models: SearchModels, config: Config
) -> tuple[str, list[Finding]]:
    """How the goal is understood, and what would have been found, the first noticed first.
    RecordingError without images to look at."""
    with tempfile.TemporaryDirectory() as folder:
        terms = Terms(directory=lambda: Path(folder))
        order = understand({"goal": goal}, models, lambda more: config, terms)
        search = Search.begin(order)
        try:
            found = _found(script, search, models)
        finally:
            search.journal.close()
    return order.goal.how, sorted(found.values(), key=lambda finding: finding.noticed_s)


def _found(script: Script, search: Search, models: SearchModels) -> dict[int, Finding]:
    """By id, what was noticed on the way."""
    found: dict[int, Finding] = {}
    source = search.config.detector.source
    labels = _Labels(script if source != "model" else None)
    for turn in _frames(script, coloured=source != "topic"):
        obs = search.prepared(observed(turn))
        detections = seen(search, obs, models, labels, 0.0)
        if detections is None:  # labels came too late then
            search.survey(obs)
            continue
        world = search.perceive(obs, detections, models)
        for now in _noticed(world, turn.at_s):
            before = found.get(now.id, now)
            believed_s = now.believed_s if before.believed_s is None else before.believed_s
            found[now.id] = replace(now, noticed_s=before.noticed_s, believed_s=believed_s)
    return found


class _Labels:
    """What a detector elsewhere said then, by stamp; of no script: nothing."""

    def __init__(self, script: Script | None) -> None:
        told = script.heard("labels") if script is not None else ()
        self._told = {labels["stamp_ns"]: labels for labels in told if labels is not None}
        if script is not None and not self._told:
            what = "has no labels: nothing was seen elsewhere"
            raise RecordingError(f"{script.recording.path}: {what}")

    def labels(self, stamp_ns: int, timeout_s: float) -> dict[str, Any] | None:
        return self._told.get(stamp_ns)


def _frames(script: Script, coloured: bool) -> Iterator[Turn]:
    looked_at = False
    for turn in script.turns():
        if turn.kind != "frame":
            continue
        if coloured and not turn.color:
            raise RecordingError(
                f"{script.recording.path}: has no colour: nothing can be looked at"
            )
        looked_at = True
        yield turn
    if not looked_at:
        raise RecordingError(f"{script.recording.path}: no frame is in it")


def _noticed(world: World, now_s: float) -> Iterator[Finding]:
    """What is worth going to now."""
    goal, away = world.goal, functools.partial(candidates.on_foot_m, world.reach)
    for thing in candidates.ranked(world.semantic, goal, away):
        yield Finding(
            thing.id,
            goal,
            thing.xy,
            now_s,
            now_s if confirmed(thing, goal) else None,
            thing.confidence_of(goal),
            thing.evidence[goal].near_m,
        )
