"""Whether a home can be lived in and driven through: `problems(scene)` says what is wrong.

What generated homes are held to; a home drawn by hand may break a rule and be a good one. Looks at
the scene as data, furniture as boxes, and knows nothing of how it was placed.
"""

import functools
import itertools
import math

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.format import Polygon, Scene, SceneObject, contains, on_wall
from hil_sim.scenes.furniture.boxes import Box, box_of, hits, mesh_named
from hil_sim.scenes.furniture.surfaces import lies_on, resting_place
from hil_sim.scenes.generated.floorplan import OUTER_M
from hil_sim.scenes.generated.passage import CELL_M, door_zone, pieces_of

RADIUS_M, MARGIN_M = 0.18, 0.02
"""The robot's body, and what is kept besides; half a cell is lost to the grid."""
BODY_M = (0.05, 0.88)
THIN_M = 0.03
DOOR_M, OPENING_M = (0.8, 1.0), (1.3, 2.6)
CLEAR_M = 0.6
"""To either side of a door nothing stands."""
REACH_M = 1.0
"""From floor that the robot can be on to anything it may be sent for."""
SIZE = (0.55, 1.8)
"""How far an object's sides may be from its mesh's own, as factors."""
LEAST_FLOOR_M2 = 0.4
HANGS_M = 0.06


def problems(scene: Scene) -> list[str]:
    """One line each for what is wrong; [] for a good home. Objects must carry their size."""
    unsized = [f"{obj.id}: has no size" for obj in scene.objects if obj.size_m is None]
    if unsized:
        return unsized
    return [*_doors(scene), *_sizes(scene), *_placement(scene), *_overlaps(scene), *_ways(scene)]


def _doors(scene: Scene) -> list[str]:
    found = []
    boxes = [(obj.id, box_of(obj)) for obj in scene.objects]
    for i, door in enumerate(scene.doors):
        width = math.dist(door.start, door.end)
        if not any(on_wall(door, wall) for wall in scene.walls):
            found.append(f"doors[{i}]: lies on no wall")
        if not any(low - 0.002 <= width <= high + 0.002 for low, high in (DOOR_M, OPENING_M)):
            found.append(f"doors[{i}]: is {width:.2f} m wide, must be 0.8-1.0 or 1.3-2.6")
        zone = door_zone(door, CLEAR_M)
        found += [
            f"doors[{i}]: {name} stands in the way"
            for name, box in boxes
            if box.z1 > THIN_M and box.overlaps(zone)
        ]
    return found


def _sizes(scene: Scene) -> list[str]:
    found = []
    for obj in scene.objects:
        mesh = mesh_named(obj.mesh)
        if mesh is None or obj.size_m is None:
            found.append(f"{obj.id}: mesh {obj.mesh} is not in the furniture list")
            continue
        ratios = [mine / own for mine, own in zip(obj.size_m, mesh.size_m, strict=True)]
        if not all(SIZE[0] <= ratio <= SIZE[1] for ratio in ratios):
            found.append(f"{obj.id}: is {obj.size_m} m, its mesh {obj.mesh} {mesh.size_m} m")
        if obj.position_m[2] + obj.size_m[2] > scene.wall_height_m + 1e-6:
            found.append(f"{obj.id}: is higher than the room")
    return found


def _placement(scene: Scene) -> list[str]:
    """Indoors, not in a wall, and standing, resting or hanging on something."""
    found = []
    walls = [piece for wall in scene.walls for piece in pieces_of(wall, scene.doors)]
    polygons = [room.polygon for room in scene.rooms]
    places = [place for obj in scene.objects if (place := resting_place(obj))]
    for obj in scene.objects:
        box = box_of(obj)
        if not any(all(contains(p, x, y) for x, y in box.outline) for p in polygons):
            found.append(f"{obj.id}: is not inside one room")
        if hits(box, walls):
            found.append(f"{obj.id}: cuts into a wall")
        held = box.z0 < 1e-6 or any(lies_on(box, place) for place in places)
        if not held and not _hung(box, walls):
            found.append(f"{obj.id}: hangs in the air, or over an edge")
    return found


def _hung(box: Box, walls: list[Box]) -> bool:
    """Whether a wall is within a few centimetres of its back, which is local +y."""
    back = Box(*box.at(0.0, HANGS_M), box.width, box.depth, box.yaw, box.z0, box.z1)
    return hits(back, walls)


def _overlaps(scene: Scene) -> list[str]:
    rows = [(box_of(obj), obj) for obj in scene.objects]
    solid = sorted((row for row in rows if row[0].z1 > THIN_M), key=lambda row: row[0].span[0])
    found = []
    for i, (box, obj) in enumerate(solid):
        for other, beside in itertools.islice(solid, i + 1, None):
            if other.span[0] >= box.span[2]:
                break
            if box.overlaps(other, 0.006) and not _within(box, obj, other, beside):
                found.append(f"{obj.id} and {beside.id}: cut into each other")
    return found


def _within(a: Box, obj_a: SceneObject, b: Box, obj_b: SceneObject) -> bool:
    """Whether one lies on the other's seat: a pillow is within the box of its sofa."""
    places = (b, resting_place(obj_a)), (a, resting_place(obj_b))
    return any(place is not None and lies_on(thing, place) for thing, place in places)


def _ways(scene: Scene) -> list[str]:
    """Every room and door reachable from every other, and everything within reach."""
    floor = _floor(scene)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(floor.astype(np.uint8), connectivity=4)
    if len(stats) < 2:
        return ["no floor is left for the robot"]
    main = labels == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    low = _origin(scene)
    found = []
    for i, door in enumerate(scene.doors):
        x, y = (door.start[0] + door.end[0]) / 2, (door.start[1] + door.end[1]) / 2
        if not main[int((y - low[1]) / CELL_M), int((x - low[0]) / CELL_M)]:
            found.append(f"doors[{i}]: cannot be reached")
    for room in scene.rooms:
        area = np.count_nonzero(main & _filled(room.polygon, main.shape, low)) * CELL_M**2
        if area < LEAST_FLOOR_M2:
            found.append(f"room {room.name}: the robot reaches only {area:.1f} m² of it")
    far = cv2.distanceTransform((~main).astype(np.uint8), cv2.DIST_L2, 5) * CELL_M
    for obj in scene.objects:
        box = box_of(obj)
        if obj.category != "other" and _distance(far, box, low) > REACH_M:
            found.append(f"{obj.id}: more than {REACH_M:g} m from where the robot can be")
    return found


@functools.lru_cache(maxsize=2)
def _origin(scene: Scene) -> tuple[float, float]:
    points = [p for wall in scene.walls for p in (wall.start, wall.end)]
    return min(x for x, _ in points) - OUTER_M, min(y for _, y in points) - OUTER_M


def _floor(scene: Scene) -> NDArray[np.bool_]:
    """(H, W) where the robot's centre can be; the cell (0, 0) is at `_origin`."""
    low = _origin(scene)
    points = [p for wall in scene.walls for p in (wall.start, wall.end)]
    high = max(x for x, _ in points) + OUTER_M, max(y for _, y in points) + OUTER_M
    shape = (math.ceil((high[1] - low[1]) / CELL_M), math.ceil((high[0] - low[0]) / CELL_M))
    open_ = np.zeros(shape, np.uint8)
    for room in scene.rooms:
        open_ |= _filled(room.polygon, shape, low).astype(np.uint8)
    walls = [piece for wall in scene.walls for piece in pieces_of(wall, scene.doors)]
    for box in [*walls, *(box_of(obj) for obj in scene.objects)]:
        if box.z0 < BODY_M[1] and box.z1 > BODY_M[0]:
            open_[_filled(box.outline, shape, low)] = 0
    far = cv2.distanceTransform(open_, cv2.DIST_L2, 5) * CELL_M
    return np.asarray(far > RADIUS_M + MARGIN_M)


def _filled(
    polygon: Polygon, shape: tuple[int, int], low: tuple[float, float]
) -> NDArray[np.bool_]:
    grid = np.zeros(shape, np.uint8)
    cells = (np.array(polygon) - low) / CELL_M - 0.5
    cv2.fillPoly(grid, [np.round(cells).astype(np.int32)], 1)
    return grid > 0


def _distance(far: NDArray[np.float32], box: Box, low: tuple[float, float]) -> float:
    """From the box's footprint to the nearest cell the robot reaches, m."""
    x0, y0, x1, y1 = box.span
    rows = slice(max(0, int((y0 - low[1]) / CELL_M)), int((y1 - low[1]) / CELL_M) + 1)
    cols = slice(max(0, int((x0 - low[0]) / CELL_M)), int((x1 - low[0]) / CELL_M) + 1)
    return float(far[rows, cols].min())
