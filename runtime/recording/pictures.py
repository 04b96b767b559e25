"""What a person wants to see of a search, as ROS 2 messages that Foxglove and its like draw: the
map, the way, frontiers and objects, and where the camera is. Nothing here is replayed."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import cv2
import numpy as np

from runtime.core.geometry import GridFrame, optical_to_base
from runtime.core.types import F64, U8, Mask, Mount, Pose
from runtime.core.world import World
from runtime.recording.schemas import MARKERS, OCCUPANCY_GRID, PATH
from runtime.robot import wire

FREE, OCCUPIED, UNKNOWN = 0, 100, -1  # of an OccupancyGrid
DELETE_ALL: Final = 3  # of markers
SPHERE, TEXT = 2, 9
GREY, GREEN, ORANGE = (0.6, 0.6, 0.6), (0.1, 0.8, 0.2), (1.0, 0.6, 0.1)
MARGIN: Final = 4  # unknown cells around what is known of the map
_T: Final = wire.STORE.types


@dataclass(frozen=True)
class Mark:
    """A ball with a word above it, in the map frame."""

    xy: tuple[float, float]
    text: str
    color: tuple[float, float, float]


@dataclass(frozen=True)
class Picture:
    """A world as it is drawn: nothing of it changes when the world does."""

    stamp_ns: int
    frame: GridFrame
    free: Mask
    occupied: Mask
    path_xy: F64  # (N, 2) m
    marks: tuple[Mark, ...]

    @classmethod
    def of(cls, world: World) -> "Picture":
        """Of what is known of the map, a copy: its masks are updated in place."""
        decision, last = world.standing.decision, world.body.last
        elected = decision.frontier if decision else None
        frontiers = [
            Mark(f.goal_xy, str(f.id), GREEN if f.id == elected else GREY) for f in world.frontiers
        ]
        objects = [
            Mark(i.xy, f"{i.name} {i.confidence:.2f}", ORANGE)
            for i in world.semantic.instances.values()
        ]
        path_xy = last.path_xy if last is not None else np.zeros((0, 2))
        grid, marks = world.map, (*frontiers, *objects)
        rows, cols = window = grid.known_window(MARGIN)
        frame, side_m = grid.frame, grid.frame.resolution_m
        x0_m, y0_m = frame.x0_m + cols.start * side_m, frame.y0_m + rows.start * side_m
        shape = rows.stop - rows.start, cols.stop - cols.start
        frame = GridFrame(x0_m, y0_m, side_m, *shape)
        free, occupied = grid.free[window].copy(), grid.occupied[window].copy()
        return cls(world.stamp_ns, frame, free, occupied, path_xy, marks)


def drawn(picture: Picture, frame: str) -> Iterator[tuple[str, str, bytes]]:
    """Topic, type and CDR of each message; `frame`: how tf calls the map frame."""
    header = wire.header(picture.stamp_ns, frame)
    for topic, kind, message in (
        ("map", OCCUPANCY_GRID, _grid(picture, header)),
        ("path", PATH, _path(picture, header)),
        ("scene", MARKERS, _scene(picture, header)),
    ):
        yield topic, kind, wire.encode(message)


def transforms(pose: Pose, mount: Mount, stamp_ns: int, frames: tuple[str, str, str]) -> bytes:
    """TFMessage: the base in the map frame, the camera's optical frame in the base's. `frames`:
    their names, the map's first."""
    over, base, camera = frames
    turn = 0.0, 0.0, math.sin(pose.yaw_rad / 2), math.cos(pose.yaw_rad / 2)
    at = mount.x_m, mount.y_m, mount.z_m
    placed = [
        _transform(over, base, stamp_ns, (pose.x_m, pose.y_m, 0.0), turn),
        _transform(base, camera, stamp_ns, at, _quaternion(optical_to_base(mount))),
    ]
    return wire.encode(_T[wire.TF_MESSAGE](placed))


def compressed(image: U8, stamp_ns: int, frame: str) -> bytes:
    """(H, W, 3) RGB -> CompressedImage, a JPEG."""
    bgr = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    _, jpeg = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, 90])
    data = np.asarray(jpeg, np.uint8).ravel()
    return wire.encode(_T[wire.COMPRESSED_IMAGE](wire.header(stamp_ns, frame), "jpeg", data))


def _grid(picture: Picture, header: Any) -> Any:
    cells = np.where(picture.free, FREE, UNKNOWN).astype(np.int8)
    cells[picture.occupied] = OCCUPIED
    frame = picture.frame
    origin = _pose(frame.x0_m, frame.y0_m)
    size = frame.resolution_m, frame.cols, frame.rows
    info = _T["nav_msgs/msg/MapMetaData"](header.stamp, *size, origin)
    return _T[OCCUPANCY_GRID](header, info, cells.ravel())


def _path(picture: Picture, header: Any) -> Any:
    stamped = _T[wire.POSE_STAMPED]
    return _T[PATH](
        header, [stamped(header, _pose(float(x), float(y))) for x, y in picture.path_xy]
    )


def _scene(picture: Picture, header: Any) -> Any:
    markers = [_marker(header, 0, SPHERE, Mark((0.0, 0.0), "", GREY), DELETE_ALL)]
    for n, mark in enumerate(picture.marks):
        markers.append(_marker(header, 2 * n + 1, SPHERE, mark))
        markers.append(_marker(header, 2 * n + 2, TEXT, mark))
    return _T[MARKERS](markers)


def _marker(header: Any, id: int, kind: int, mark: Mark, action: int = 0) -> Any:
    color, vector = _T["std_msgs/msg/ColorRGBA"], _T["geometry_msgs/msg/Vector3"]
    high_m = 0.5 if kind == TEXT else 0.2
    return _T["visualization_msgs/msg/Marker"](
        header=header,
        ns="rfnav",
        id=id,
        type=kind,
        action=action,
        pose=_pose(*mark.xy, high_m),
        scale=vector(0.15, 0.15, 0.15),
        color=color(*mark.color, 1.0),
        lifetime=_T["builtin_interfaces/msg/Duration"](0, 0),
        frame_locked=False,
        points=[],
        colors=[],
        texture_resource="",
        texture=_T[wire.COMPRESSED_IMAGE](header, "", np.zeros(0, np.uint8)),
        uv_coordinates=[],
        text=mark.text if kind == TEXT else "",
        mesh_resource="",
        mesh_file=_T["visualization_msgs/msg/MeshFile"]("", np.zeros(0, np.uint8)),
        mesh_use_embedded_materials=False,
    )


def _pose(x_m: float, y_m: float, z_m: float = 0.0) -> Any:
    point, turn = _T["geometry_msgs/msg/Point"], _T["geometry_msgs/msg/Quaternion"]
    return _T["geometry_msgs/msg/Pose"](point(x_m, y_m, z_m), turn(0.0, 0.0, 0.0, 1.0))


def _transform(
    over: str, below: str, stamp_ns: int, at: tuple[float, ...], turn: tuple[float, ...]
) -> Any:
    moved = _T["geometry_msgs/msg/Transform"](
        _T["geometry_msgs/msg/Vector3"](*at), _T["geometry_msgs/msg/Quaternion"](*turn)
    )
    return _T["geometry_msgs/msg/TransformStamped"](wire.header(stamp_ns, over), below, moved)


def _quaternion(rotation: F64) -> tuple[float, float, float, float]:
    """(3, 3) -> x, y, z, w."""
    turn = cv2.Rodrigues(rotation)[0].ravel()
    angle = float(np.linalg.norm(turn))
    if angle < 1e-9:
        return 0.0, 0.0, 0.0, 1.0
    x, y, z = (math.sin(angle / 2) * turn / angle).tolist()
    return x, y, z, math.cos(angle / 2)
