"""What others draw, as CDR: map, zones, path, frontiers, objects, what the detectors saw. In RViz
and Foxglove they appear as they are."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import get_types_from_msg

from runtime.core.mapping.grid import MapCopy
from runtime.core.mapping.zones import Zone
from runtime.core.types import F64, Detections, Frontier
from runtime.robot import wire

OCCUPANCY_GRID: Final = "nav_msgs/msg/OccupancyGrid"
PATH: Final = "nav_msgs/msg/Path"
MARKERS: Final = "visualization_msgs/msg/MarkerArray"
DETECTIONS: Final = "vision_msgs/msg/Detection2DArray"
POINTS_MOST: Final = 200  # of a path or a frontier: what has more is drawn coarser
FLOOR_Z_M: Final = 0.03  # of what lies on the floor: above the map
TEXT_M: Final = 0.15
_FREE, _OCCUPIED, _UNKNOWN = 0, 100, -1

# vision_msgs 4, of Humble and all after it; in our own words, for no package of types has them.
for _kind, _fields in (
    ("Point2D", "float64 x\nfloat64 y\n"),
    ("Pose2D", "vision_msgs/Point2D position\nfloat64 theta\n"),
    ("BoundingBox2D", "vision_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y\n"),
    ("ObjectHypothesis", "string class_id\nfloat64 score\n"),
    (
        "ObjectHypothesisWithPose",
        "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose\n",
    ),
    (
        "Detection2D",
        "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
        "vision_msgs/BoundingBox2D bbox\nstring id\n",
    ),
    ("Detection2DArray", "std_msgs/Header header\nvision_msgs/Detection2D[] detections\n"),
):
    wire.STORE.register(get_types_from_msg(_fields, f"vision_msgs/msg/{_kind}"))
_T: Final = wire.STORE.types


class _Shape(IntEnum):
    """Marker.type."""

    CUBE = 1
    LINE = 4
    POINTS = 8
    TEXT = 9


_ADD, _DELETE = 0, 2  # Marker.action
_ELECTED, _OTHER = (0.1, 0.9, 0.2, 1.0), (0.2, 0.5, 1.0, 0.9)  # red, green, blue, alpha
_KEPT_OUT, _AREA, _LINE_M = (1.0, 0.1, 0.1, 0.9), (0.1, 0.8, 1.0, 0.9), 0.04
_GOAL, _THING, _WORDS = (0.1, 0.9, 0.2, 0.6), (0.9, 0.6, 0.1, 0.4), (1.0, 1.0, 1.0, 1.0)


@dataclass(frozen=True)
class DrawnObject:
    """What of an object on the map is drawn. Map frame, m; `size_m`: along x, y, z."""

    id: int
    name: str
    confidence: float
    middle_m: tuple[float, float, float]
    size_m: tuple[float, float, float]


@dataclass(frozen=True)
class Stamp:
    """What stands in a header: when it was true, and in which frame; and where in that frame, m,
    the map begins that is drawn."""

    stamp_ns: int
    frame: str
    origin_xy: tuple[float, float] = (0.0, 0.0)

    def header(self) -> Any:
        return wire.header(self.stamp_ns, self.frame)


def encode_map(copy: MapCopy, at: Stamp) -> bytes:
    """A window of the map -> OccupancyGrid: 0 free, 100 an obstacle or no floor, -1 unknown."""
    frame = copy.frame
    data: NDArray[np.int8] = np.full(copy.free.shape, _UNKNOWN, np.int8)
    data[copy.free] = _FREE
    data[copy.occupied] = _OCCUPIED
    x_m = at.origin_xy[0] + frame.x0_m + frame.first_col * frame.resolution_m
    y_m = at.origin_xy[1] + frame.y0_m + frame.first_row * frame.resolution_m
    header = at.header()
    rows, cols = copy.free.shape[:2]
    info = _T["nav_msgs/msg/MapMetaData"](
        header.stamp, frame.resolution_m, cols, rows, _pose(x_m, y_m, 0.0)
    )
    return wire.encode(_T[OCCUPANCY_GRID](header, info, data.ravel()))


def encode_path(path_xy: F64, at: Stamp) -> bytes:
    """(N, 2) m -> Path; each pose looks to the next."""
    points, (x0_m, y0_m) = _coarser(path_xy), at.origin_xy
    steps = np.diff(points, axis=0, append=points[-1:]) if len(points) else points
    yaws = np.arctan2(steps[:, 1], steps[:, 0]) if len(points) else np.zeros(0)
    if len(yaws) > 1:
        yaws[-1] = yaws[-2]
    header = at.header()
    poses = [
        _T[wire.POSE_STAMPED](header, _pose(x0_m + float(x), y0_m + float(y), 0.0, float(yaw)))
        for (x, y), yaw in zip(points, yaws, strict=True)
    ]
    return wire.encode(_T[PATH](header, poses))


def encode_frontiers(
    frontiers: Sequence[Frontier], elected: int | None, gone: Iterable[int], at: Stamp
) -> bytes:
    """Frontiers -> MarkerArray: their cells, and what they are called; a marker has its frontier's
    id. `gone`: ids that were drawn before."""
    markers = []
    for one in frontiers:
        colour = _ELECTED if one.id == elected else _OTHER
        points = [_point(float(x), float(y), FLOOR_Z_M) for x, y in _coarser(one.cells_xy)]
        markers.append(
            _marker(at, "frontiers", one.id, _Shape.POINTS, (0.05, 0.05, 0.0), colour, points)
        )
        x, y = one.centre_xy
        away = f"{one.distance_m:.1f} m" if math.isfinite(one.distance_m) else "no way"
        markers.append(_text(at, "frontier names", one.id, (x, y, TEXT_M), f"{one.id}: {away}"))
    markers += _gone(at, ("frontiers", "frontier names"), gone)
    return wire.encode(_T[MARKERS](markers))


def encode_objects(
    objects: Sequence[DrawnObject], goal: str, gone: Iterable[int], at: Stamp
) -> bytes:
    """Objects -> MarkerArray: a box each, and its name; a marker has its object's id. `goal`: the
    name of what is looked for, which is another colour."""
    markers = []
    for one in objects:
        colour = _GOAL if one.name == goal else _THING
        shape = _Shape.CUBE
        markers.append(_marker(at, "objects", one.id, shape, one.size_m, colour, (), one.middle_m))
        x, y, z = one.middle_m
        told = f"{one.name} {one.id} ({one.confidence:.2f})"
        above = (x, y, z + one.size_m[2] / 2 + TEXT_M)
        markers.append(_text(at, "object names", one.id, above, told))
    markers += _gone(at, ("objects", "object names"), gone)
    return wire.encode(_T[MARKERS](markers))


def encode_zones(zones: Sequence[Zone], gone: Iterable[int], at: Stamp) -> bytes:
    """Zones -> MarkerArray: their outlines and names; a marker's id is the zone's place in the
    list. What is kept out of is red, the area of a search another colour."""
    markers = []
    for id, zone in enumerate(zones):
        corners = (*zone.corners_xy, zone.corners_xy[0])
        outline = [_point(x, y, FLOOR_Z_M) for x, y in corners]
        colour, width = _AREA if zone.area else _KEPT_OUT, (_LINE_M, 0.0, 0.0)
        markers.append(_marker(at, "zones", id, _Shape.LINE, width, colour, outline))
        markers.append(_text(at, "zone names", id, (*zone.middle_xy, TEXT_M), zone.name))
    markers += _gone(at, ("zones", "zone names"), gone)
    return wire.encode(_T[MARKERS](markers))


def encode_detections(seen: Detections, names: Sequence[str], at: Stamp) -> bytes:
    """What the detectors saw in an image -> Detection2DArray, boxes in its pixels. `names`: of the
    classes that its labels count."""
    header = at.header()
    nowhere = _T["geometry_msgs/msg/PoseWithCovariance"](_pose(0.0, 0.0, 0.0), np.zeros(36))
    found = []
    for box, score, label in zip(seen.boxes_px, seen.scores, seen.labels, strict=True):
        x0, y0, x1, y1 = (float(v) for v in box)
        middle = _T["vision_msgs/msg/Point2D"]((x0 + x1) / 2, (y0 + y1) / 2)
        centre = _T["vision_msgs/msg/Pose2D"](middle, 0.0)
        bbox = _T["vision_msgs/msg/BoundingBox2D"](centre, x1 - x0, y1 - y0)
        guess = _T["vision_msgs/msg/ObjectHypothesis"](names[int(label)], float(score))
        result = _T["vision_msgs/msg/ObjectHypothesisWithPose"](guess, nowhere)
        found.append(_T["vision_msgs/msg/Detection2D"](header, [result], bbox, ""))
    return wire.encode(_T[DETECTIONS](header, found))


def _coarser(points_xy: F64) -> F64:
    """At most POINTS_MOST of them, the last one among them."""
    step = max(1, -(-len(points_xy) // POINTS_MOST))
    last_first: F64 = points_xy[::-step]
    return last_first[::-1]


def _gone(at: Stamp, names: tuple[str, ...], ids: Iterable[int]) -> list[Any]:
    nothing: Mapping[str, Any] = {"action": _DELETE}
    return [
        _marker(at, name, id, _Shape.CUBE, (0.0, 0.0, 0.0), _WORDS, (), **nothing)
        for id in ids
        for name in names
    ]


def _text(
    at: Stamp, namespace: str, id: int, where_m: tuple[float, float, float], text: str
) -> Any:
    size = (0.0, 0.0, TEXT_M)
    return _marker(at, namespace, id, _Shape.TEXT, size, _WORDS, (), where_m, text)


def _marker(
    at: Stamp,
    namespace: str,
    id: int,
    shape: _Shape,
    scale_m: tuple[float, float, float],
    colour: tuple[float, float, float, float],
    points: Sequence[Any],
    where_m: tuple[float, float, float] = (0.0, 0.0, 0.0),
    text: str = "",
    action: int = _ADD,
) -> Any:
    for_ever = _T["builtin_interfaces/msg/Duration"](0, 0)
    none, no_texture = np.zeros(0, np.uint8), wire.header(0, "")
    return _T["visualization_msgs/msg/Marker"](
        header=at.header(),
        ns=namespace,
        id=id,
        type=int(shape),
        action=action,
        pose=_pose(where_m[0] + at.origin_xy[0], where_m[1] + at.origin_xy[1], where_m[2]),
        scale=_T["geometry_msgs/msg/Vector3"](*scale_m),
        color=_T["std_msgs/msg/ColorRGBA"](*colour),
        lifetime=for_ever,
        frame_locked=False,
        points=list(points),
        colors=[],
        texture_resource="",
        texture=_T[wire.COMPRESSED_IMAGE](no_texture, "", none),
        uv_coordinates=[],
        text=text,
        mesh_resource="",
        mesh_file=_T["visualization_msgs/msg/MeshFile"]("", none),
        mesh_use_embedded_materials=False,
    )


def _pose(x_m: float, y_m: float, z_m: float, yaw_rad: float = 0.0) -> Any:
    turn = _T["geometry_msgs/msg/Quaternion"](
        0.0, 0.0, math.sin(yaw_rad / 2), math.cos(yaw_rad / 2)
    )
    return _T["geometry_msgs/msg/Pose"](_point(x_m, y_m, z_m), turn)


def _point(x_m: float, y_m: float, z_m: float) -> Any:
    return _T["geometry_msgs/msg/Point"](x_m, y_m, z_m)
