"""A world that has been searched a little: walls, floor, a drop, an object with a past."""

import numpy as np

from runtime.core.mapping.keyframes import Keyframe
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.types import Pose
from runtime.core.world import World

EMBEDDING = np.array([0.6, 0.8], np.float32)


def lived_in(at: Pose = Pose(0.0, 0.0, 0.0)) -> World:  # noqa: B008 -- it is frozen
    """Floor 4 m by 2 m around where it began, a wall at its end; a red mug ahead to the left, that
    was seen."""
    world = World.begin("mug", ("mug", "sofa"), ("kitchen", "hall"), at, 0.18)
    grid, frame = world.map, world.map.frame
    row, col = frame.cell(at.x_m, at.y_m)
    floor = slice(row - 20, row + 20), slice(col - 40, col + 40)
    grid.evidence[floor] = -20
    grid.swept[floor] = grid.backed[floor] = True
    grid.evidence[row - 20 : row + 20, col + 40 : col + 42] = 20
    grid.bumped[row, col - 41] = True
    grid.drops[row - 24 : row - 22, col - 10 : col + 10] = 6
    grid.driven[row, col - 30 : col + 30] = 1
    grid.changed()
    world.semantic.rooms[0][floor] = 3.0
    cells = frame.centres(np.array([[row + 15, col + 20], [row + 15, col + 21]], np.int32))
    mug = Instance(
        1, {"mug": Evidence(3.0, backing=[at], near_m=1.0), "sofa": Evidence(-1.0, rejections=1)},
        (float(cells[0, 0]), float(cells[0, 1])), 0.5, cells, 0.4, 0.6, EMBEDDING.copy(), 0.9, 1.0,
        [at], [at],
    )  # fmt: skip
    world.semantic.instances[1] = mug
    world.semantic.next_id = 2
    world.keyframes.append(Keyframe(at, EMBEDDING.copy(), 2.0))
    return world
