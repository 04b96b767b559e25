"""The same drive within ever larger known maps."""

import numpy as np

from hil_sim.benchmarks import drive
from runtime.config import Config
from runtime.core.mapping.windows import widened
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.world import World

STREET = 24  # cells between two homes
FURNITURE = 40  # objects of a home that is known already


def surrounded(explored: World, side: int, config: Config) -> World:
    """A world before the first observation, in a map of `side` cells or more that is known already,
    but for the home: around it stands the same home again and again, each closed, along streets."""
    world = drive.begin(config)
    resolution, grid = world.map.frame.resolution_m, world.map
    margin_m = config.navigate.map.max_depth_m + 1.0
    world.grow(max(margin_m, side * resolution / 2))
    grid = world.map
    home = explored.map.known_window(margin=1)
    free = explored.map.free[home]
    block = np.full((free.shape[0] + STREET, free.shape[1] + STREET), -6, np.int16)
    block[: free.shape[0], : free.shape[1]] = np.where(free, -6, 8)
    middle = grid.frame.cell(0.0, 0.0)
    held = tuple(slice(at - side // 2, at - side // 2 + side) for at in middle)
    window = widened((held[0], held[1]), 0, grid.frame)
    rows, cols = window[0].stop - window[0].start, window[1].stop - window[1].start
    times = rows // block.shape[0] + 1, cols // block.shape[1] + 1
    grid.evidence[window] = np.tile(block, times)[:rows, :cols]
    for edge in (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]):
        grid.evidence[window][edge] = 8  # no frontier out there
    own = _own_window(explored, world)
    grid.evidence[own] = 8  # its outer walls, so that no frontier leads out
    inner = widened(own, -1, grid.frame)
    grid.evidence[inner] = 0
    grid.changed()
    grid.drive_over(drive.START, config.navigate.robot.radius_m)
    _furnish(explored, world, window, block.shape)
    return world


def _own_window(explored: World, world: World) -> tuple[slice, slice]:
    """Where the home lies in the other map, and two cells around it."""
    home, frame = explored.map.known_window(margin=2), explored.map.frame
    x, y = frame.x0_m + frame.resolution_m / 2, frame.y0_m + frame.resolution_m / 2
    down, right = world.map.frame.cell(x, y)
    rows, cols = home
    shifted = (
        slice(rows.start + down, rows.stop + down),
        slice(cols.start + right, cols.stop + right),
    )
    return widened(shifted, 0, world.map.frame)


def _furnish(
    explored: World, world: World, window: tuple[slice, slice], block: tuple[int, ...]
) -> None:
    """The home's objects again in every other home: most of what is known is elsewhere."""
    frame = world.map.frame
    things = [i for i in explored.semantic.instances.values() if i.confidence > 0.5]
    for row in range(window[0].start, window[0].stop - block[0], block[0]):
        for col in range(window[1].start, window[1].stop - block[1], block[1]):
            corner = frame.centres(np.array([row, col], np.int32))
            if float(np.abs(corner).max()) < 20.0:
                continue  # where the drive is
            for thing in things[:FURNITURE]:
                _put(world, thing.name, corner, thing.xy, thing.cells_xy)


def _put(
    world: World,
    name: str,
    corner: np.ndarray,
    xy: tuple[float, float],
    cells_xy: np.ndarray,
) -> None:
    semantic = world.semantic
    place = float(corner[0] + xy[0]), float(corner[1] + xy[1])
    one = Instance(semantic.next_id, {name: Evidence(2.0)}, place, 0.4, cells_xy + corner)
    semantic.instances[one.id] = one
    semantic.next_id += 1


def megabytes(world: World) -> float:
    """What the map's arrays hold, MB, as if all of it were written to."""
    grid, explored = world.map, world.explored
    arrays = (grid.evidence, grid.swept, grid.bumped, grid.driven, grid.dead_end, grid.drops,
              grid.backed, grid.doubtful, grid.free,
              grid.occupied, grid.unknown, explored.given_up, explored.looked,
              explored.boundary.edge, world.semantic.rooms)  # fmt: skip
    terrain = 9 * grid.evidence.size  # clearance, speed, whether the body fits
    return (sum(array.nbytes for array in arrays) + terrain) / 1e6
