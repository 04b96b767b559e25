"""What a decision is made on, taken from the world in a moment and worked out wherever it is asked
for: what the experts are told takes longer than a frame may."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from runtime.core.belief import SeenSurface
from runtime.core.distances.terrain import Terrain
from runtime.core.geometry import GridFrame
from runtime.core.mapping import keyframes
from runtime.core.mapping.grid import MapCopy
from runtime.core.mapping.keyframes import Keyframe
from runtime.core.mapping.windows import Window, widened
from runtime.core.types import Brief, Decision, Frontier, Pose
from runtime.core.voting import brief, search_order
from runtime.core.voting.brief import SemanticCopy
from runtime.core.world import Snapshot

WORTH_M2 = 0.1  # unknown behind a frontier; those with less are gone to last
AROUND_M = 5.5  # the frontiers: farther is no object that is told, and no image of them


@dataclass(frozen=True)
class Outlook:
    """Copies that nobody changes: the map and the objects around the reachable frontiers, the
    keyframes. `terrain` is there, and `standing`, the decision before, where frontiers
    are ranked by geometry; `plans`: their order is planned. `patches`: surfaces that
    were not seen finely enough. What is a `Snapshot`'s is worked out
    when it is asked for."""

    goal: str
    stamp_ns: int
    why: str
    candidates: tuple[Frontier, ...]
    map: MapCopy
    semantic: SemanticCopy
    frames: tuple[Keyframe, ...]
    pose: Pose
    terrain: Terrain | None
    standing: Decision | None
    plans: bool = False
    patches: tuple[SeenSurface, ...] = ()

    @property
    def brief(self) -> Brief:
        """What the experts are told."""
        return self.snapshot.brief

    @property
    def frontiers(self) -> tuple[Frontier, ...]:
        """What they choose from."""
        return self.snapshot.frontiers

    @cached_property
    def snapshot(self) -> Snapshot:
        """What the decision is made on."""
        found = self.candidates
        views = keyframes.best_views(self.frames, {f.id: f.cells_xy for f in found}, self.map)
        told = brief.compose(self.goal, self.stamp_ns, self.map, self.semantic, found, views)
        told = brief.worthwhile(told, WORTH_M2)
        unknown_m2 = {f.id: f.unknown_m2 for f in told.frontiers}
        kept = tuple(f for f in found if f.id in unknown_m2)
        if self.terrain is not None:
            told = self._ranked(told, kept, unknown_m2, self.terrain)
        return Snapshot(told, kept, self.stamp_ns, self.why)

    def _ranked(
        self,
        told: Brief,
        kept: tuple[Frontier, ...],
        unknown_m2: dict[int, float],
        terrain: Terrain,
    ) -> Brief:
        """With the order in which the frontiers are gone to where nobody's word decides."""
        ahead = search_order.looked_ahead(
            kept, unknown_m2, terrain, self.pose, self.standing, self.plans, self.patches
        )
        if ahead is None:
            return told
        return replace(told, order=search_order.ordered(ahead, {}), ahead=ahead)


def around(frontiers: tuple[Frontier, ...], frame: GridFrame) -> Window:
    """The window of the grid that holds all that is told of these frontiers."""
    if not frontiers:
        return slice(0, 0), slice(0, 0)
    cells = frame.cells(np.concatenate([f.cells_xy for f in frontiers]))
    (top, left), (bottom, right) = cells.min(axis=0).tolist(), cells.max(axis=0).tolist()
    held = slice(top, bottom + 1), slice(left, right + 1)
    return widened(held, round(AROUND_M / frame.resolution_m), frame)
