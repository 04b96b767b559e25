"""What a planned order of frontiers costs a decision: `python -m runtime.bench.orders`."""

from collections.abc import Callable, Iterator
from typing import Final

import cv2
import numpy as np

from runtime.bench.own_time import print_stages
from runtime.core.belief import Ahead
from runtime.core.distances.terrain import Terrain
from runtime.core.geometry import GridFrame
from runtime.core.kernels import marching
from runtime.core.types import Ballot, Frontier, Pose, Vote
from runtime.core.voting import prior
from runtime.core.voting.search_order import looked_ahead, with_ways

CELL_M: Final = 0.05
HOME_M: Final = 15.0, 12.0
WALLS_M: Final = (5.0, 10.0), (6.0,)  # across the home, and along it: two rows of three rooms
DOOR_M, THICK_M, BODY_M = 0.9, 0.1, 0.2
EXPERTS: Final = ("o2f", "r2f", "sle")
ROBOT: Final = Pose(2.5, 3.0, 0.0)
PLACES: Final = (
    (1.0, 1.0), (4.0, 5.0), (7.5, 1.0), (7.5, 5.0),
    (12.5, 3.0), (2.5, 11.0), (7.5, 9.0), (14.0, 11.0),
)  # fmt: skip


def home() -> Terrain:
    """Six rooms with a door between any two that lie side by side."""
    frame = GridFrame(0.0, 0.0, CELL_M, *(round(side / CELL_M) for side in reversed(HOME_M)))
    y, x = (CELL_M * (np.indices(frame.shape) + 0.5)).astype(np.float32)
    across, along = WALLS_M
    in_door_x = np.abs(np.mod(x, across[0]) - across[0] / 2) < DOOR_M / 2
    in_door_y = np.abs(np.mod(y, along[0]) - along[0] / 2) < DOOR_M / 2
    wall = np.zeros(frame.shape, bool)
    for at_m in across:
        wall |= (np.abs(x - at_m) < THICK_M / 2) & ~in_door_y
    for at_m in along:
        wall |= (np.abs(y - at_m) < THICK_M / 2) & ~in_door_x
    bare = np.pad(~wall, 1).astype(np.uint8)  # walls round it, too
    away = cv2.distanceTransform(bare, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    clear_m = (away * CELL_M).astype(np.float32)
    fits = clear_m > BODY_M
    return Terrain(frame, clear_m, fits, fits.astype(np.float32))


def frontiers(terrain: Terrain) -> tuple[Frontier, ...]:
    """At PLACES, as far as they are on foot from the robot."""
    arrival = np.full(terrain.frame.shape, np.inf)
    arrival[terrain.frame.cell(ROBOT.x_m, ROBOT.y_m)] = 0.0
    marching.march(arrival, terrain.traversable, CELL_M)
    return tuple(
        Frontier(id, np.array([xy]), xy, float(arrival[terrain.frame.cell(*xy)]))
        for id, xy in enumerate(PLACES)
    )


def stages() -> Iterator[tuple[str, Callable[[], object]]]:
    """Of a decision on as many frontiers as are ordered, by three experts that all know of each."""
    terrain = home()
    found, rng = frontiers(terrain), np.random.default_rng(0)
    areas = {f.id: 1.0 + f.id % 3 for f in found}
    plain = _ahead(found, areas, terrain, plans=False)
    planned = _ahead(found, areas, terrain, plans=True)
    said = {e: tuple(enumerate(rng.normal(size=len(found)).tolist())) for e in EXPERTS}
    ballot = Ballot(tuple(Vote(e, (0,), (), "", nats=nats) for e, nats in said.items()))
    yield f"ways between {len(found)} frontiers", lambda: with_ways(plain, terrain)
    yield "order, and without each expert", lambda: prior.elect(ballot, planned, 0, 0, "", "ahead")


def _ahead(
    found: tuple[Frontier, ...], areas: dict[int, float], terrain: Terrain, plans: bool
) -> Ahead:
    ahead = looked_ahead(found, areas, terrain, ROBOT, None, plans)
    assert ahead is not None  # there are frontiers
    return ahead


if __name__ == "__main__":
    cv2.setNumThreads(1)
    print_stages(stages())
