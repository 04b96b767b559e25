"""The semantic map: object instances with fused evidence, and room types per cell."""

import math
from collections.abc import Container, Sequence
from dataclasses import dataclass, field

import numpy as np

from runtime.core.geometry import (
    GridFrame,
    base_to_map,
    map_to_optical,
    project,
    rays,
)
from runtime.core.mapping.grid import NavigationMap, polygon_mask
from runtime.core.objects.depth_segments import EDGE_M, FLOOR_M, attached, distance_m, segment
from runtime.core.objects.instances import (
    Instance,
    Sighting,
    called,
    fuse,
    uncalled,
)
from runtime.core.types import F32, F64, Detections, Mount, Observation, Pose

STRIDE = 4  # every n-th pixel of a box is projected
CLUSTER_M = 0.35  # points this close in depth to the core belong to the object
BEFORE_SHARE = 0.5
"""Toward the camera no further than half as far as the box is wide, and only what hangs together
with it: what is nearer stands before it."""
BEFORE_M = 0.1  # at least
MIN_POINTS = 6  # of an object, else its box gives none
MISS_RANGE_M = (1.2, 4.0)  # where not seeing an object means something
ROOM_CREDIT_M = 3.0  # a view's room type is credited to cells this close
EDGE_PX = 2.0
"""A box that ends so near to the image's edge is cut off by it."""


@dataclass
class SemanticMap:
    """Instances by id and room evidence (R, rows, cols) over the navigation map's frame."""

    names: tuple[str, ...]
    room_names: tuple[str, ...]
    rooms: F32
    instances: dict[int, Instance] = field(default_factory=dict)
    next_id: int = 1

    @classmethod
    def empty(
        cls, names: Sequence[str], room_names: Sequence[str], frame: GridFrame
    ) -> "SemanticMap":
        """No instance, no room evidence."""
        return cls(
            tuple(names), tuple(room_names), np.zeros((len(room_names), *frame.shape), np.float32)
        )

    def room_around(self, frame: GridFrame, xy: tuple[float, float], range_m: float) -> str:
        """The room type with most evidence in the square around a point; "" when there is none."""
        row, col = frame.cell(*xy)
        n = math.ceil(range_m / frame.resolution_m)
        window = slice(max(0, row - n), row + n + 1), slice(max(0, col - n), col + n + 1)
        evidence = self.rooms[:, *window].sum(axis=(1, 2))
        return self.room_names[int(evidence.argmax())] if evidence.any() else ""

    def grow(self, padding: tuple[int, int, int, int]) -> None:
        """Follow `NavigationMap.grow`."""
        top, bottom, left, right = padding
        self.rooms = np.pad(self.rooms, ((0, 0), (top, bottom), (left, right)))


def locate(
    obs: Observation,
    detections: Detections,
    names: Sequence[str],
    mount: Mount,
) -> list[Sighting]:
    """Project each box through depth. A box without usable depth gives none."""
    table = rays(obs.intrinsics, mount, STRIDE)
    offset, focal_px = STRIDE // 2, obs.intrinsics.fx
    depth = np.nan_to_num(obs.depth_m[offset::STRIDE, offset::STRIDE], posinf=0.0)
    offset_m = np.array([mount.x_m, mount.y_m, mount.z_m])
    label, size = segment(depth, depth * table.up + np.float32(mount.z_m))
    found = []
    for i in np.argsort(-detections.scores, kind="stable"):
        box = (detections.boxes_px[i] - offset) / STRIDE
        x0, y0, x1, y1 = (int(v) for v in (*np.floor(box[:2]), *np.ceil(box[2:])))
        rows, cols = slice(max(0, y0), max(0, y1) + 1), slice(max(0, x0), max(0, x1) + 1)
        patch = depth[rows, cols]
        known = float(detections.depths_m[i]) if detections.depths_m.size else None
        own = label[rows, cols]
        near = distance_m(patch, own, size) if known is None else known
        width_m = float(detections.boxes_px[i, 2] - detections.boxes_px[i, 0]) * near / focal_px
        before_m = min(CLUSTER_M, max(BEFORE_M, BEFORE_SHARE * width_m))
        keep = (patch > 0) & (patch > near - before_m) & (patch < near + CLUSTER_M)
        keep &= (patch > near - EDGE_M) | attached(patch, own, near)
        if int(keep.sum()) < MIN_POINTS:
            continue
        z = patch[keep].astype(np.float64)
        axes = (table.forward, table.left, table.up)
        base = np.stack([z * axis[rows, cols][keep] for axis in axes], axis=1)
        points = base_to_map(base + offset_m, obs.pose)
        points = points[(points[:, 2] > FLOOR_M) & (points[:, 2] < 2.2)]
        if len(points) < MIN_POINTS:
            continue
        name = names[int(detections.labels[i])]
        embedding = detections.embeddings[i]
        cut = _cut(detections.boxes_px[i], obs.depth_m.shape[1])
        found.append(Sighting(name, float(detections.scores[i]), embedding, points, near, cut))
    return found


def _cut(box_px: F32, width_px: int) -> bool:
    """Whether a box ends at the left or right edge of the image; at the bottom most things that are
    near do."""
    return bool(box_px[0] < EDGE_PX or box_px[2] > width_px - EDGE_PX)


def place(
    semantic: SemanticMap,
    grid: NavigationMap,
    obs: Observation,
    detections: Detections,
    outline: F64,
    mount: Mount,
) -> None:
    """Fuse one image's detections and its room type into the map."""
    names: dict[int, set[str]] = {}
    whole: set[int] = set()
    for sighting in locate(obs, detections, semantic.names, mount):
        new_id = semantic.next_id
        instance = fuse(semantic.instances, new_id, grid.frame, sighting, obs.pose)
        semantic.next_id += instance.id == new_id
        if instance.id not in names:  # the surest of an image comes first, and speaks alone
            called(instance, sighting, obs.pose)
        names.setdefault(instance.id, set()).add(sighting.name)
        if not sighting.cut:
            whole.add(instance.id)
    for id, those in names.items():
        uncalled(semantic.instances[id], those, obs.pose, cut=id not in whole)
    _miss(semantic, obs, mount, names)
    _credit_room(semantic, grid.frame, obs.pose, detections.rooms, outline)


def _miss(
    semantic: SemanticMap,
    obs: Observation,
    mount: Mount,
    seen: Container[int],
) -> None:
    """Lower what should be in plain view and was not detected."""
    unseen = [i for i in semantic.instances.values() if i.id not in seen]
    if not unseen:
        return
    h, w = obs.depth_m.shape
    optical = map_to_optical(np.array([(*i.xy, i.z_m) for i in unseen]), obs.pose, mount)
    z = optical[:, 2]
    close = np.flatnonzero((z >= MISS_RANGE_M[0]) & (z <= MISS_RANGE_M[1]))
    u, v = project(optical[close], obs.intrinsics).T
    inside = (0.12 * w < u) & (u < 0.88 * w) & (0.08 * h < v) & (v < 0.92 * h)
    for n, col, row in zip(close[inside], u[inside], v[inside], strict=True):
        patch = obs.depth_m[int(row) - 4 : int(row) + 5, int(col) - 4 : int(col) + 5]
        patch = patch[patch > 0]
        if patch.size == 0 or float(np.median(patch)) < z[n] - 0.6:
            continue  # hidden
        uncalled(unseen[n], (), obs.pose)


def _credit_room(
    semantic: SemanticMap,
    frame: GridFrame,
    pose: Pose,
    rooms: F32,
    outline: F64,
) -> None:
    if rooms.size == 0:
        return
    apex = outline[0]
    offset = outline - apex
    reach = np.hypot(*offset.T)
    near = apex + offset * np.minimum(1.0, ROOM_CREDIT_M / np.maximum(reach, 1e-6))[:, None]
    low = np.clip(frame.cells(near.min(axis=0)) - 1, 0, None)
    high = np.minimum(frame.cells(near.max(axis=0)) + 2, frame.shape)
    window = (slice(int(low[0]), int(high[0])), slice(int(low[1]), int(high[1])))
    patch = GridFrame(
        frame.x0_m + low[1] * frame.resolution_m,
        frame.y0_m + low[0] * frame.resolution_m,
        frame.resolution_m,
        int(high[0] - low[0]),
        int(high[1] - low[1]),
    )
    semantic.rooms[:, *window] += rooms[:, None, None] * polygon_mask(patch, near)
