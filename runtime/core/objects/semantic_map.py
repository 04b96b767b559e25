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
from runtime.core.mapping.grid import NavigationMap
from runtime.core.mapping.windows import Window, padded, polygon_mask
from runtime.core.objects.depth_segments import (
    EDGE_M,
    FLOOR_M,
    Surfaces,
    attached,
    distance_m,
    segment,
)
from runtime.core.objects.instances import (
    Instance,
    Sighting,
    called,
    fuse,
    uncalled,
)
from runtime.core.objects.places import InstancePlaces
from runtime.core.types import F32, F64, Detections, Intrinsics, Mask, Mount, Observation, Pose

STRIDE = 4  # every n-th pixel of a box is projected
CLUSTER_M = 0.35  # points this close in depth to the core belong to the object
BEFORE_SHARE = 0.5
"""Toward the camera no further than half as far as the box is wide, and only what hangs together
with it: what is nearer stands before it."""
BEFORE_M = 0.1  # at least
CEILING_M = 2.2  # what is higher is no thing
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
    _places: tuple[dict[int, Instance], InstancePlaces] | None = field(default=None, repr=False)

    @classmethod
    def empty(
        cls, names: Sequence[str], room_names: Sequence[str], frame: GridFrame
    ) -> "SemanticMap":
        """No instance, no room evidence."""
        return cls(
            tuple(names), tuple(room_names), np.zeros((len(room_names), *frame.shape), np.float32)
        )

    @property
    def places(self) -> InstancePlaces:
        """Where the instances are."""
        held = self._places
        if held is None or held[0] is not self.instances or len(held[1]) != len(self.instances):
            held = self._places = self.instances, InstancePlaces.of(self.instances)
        return held[1]

    def room_around(self, frame: GridFrame, xy: tuple[float, float], range_m: float) -> str:
        """The room type with most evidence in the square around a point; "" when there is none."""
        row, col = frame.cell(*xy)
        n = math.ceil(range_m / frame.resolution_m)
        window = slice(max(0, row - n), row + n + 1), slice(max(0, col - n), col + n + 1)
        evidence = self.rooms[:, *window].sum(axis=(1, 2))
        return self.room_names[int(evidence.argmax())] if evidence.any() else ""

    def grow(self, padding: tuple[int, int, int, int]) -> None:
        """Follow `NavigationMap.grow`."""
        self.rooms = padded(self.rooms, padding)


def locate(
    obs: Observation,
    detections: Detections,
    names: Sequence[str],
    mount: Mount,
) -> list[Sighting]:
    """Project each box through depth. A box without usable depth gives none."""
    view, focal_px = _View.of(obs, mount), obs.intrinsics.fx
    found = []
    for i in np.argsort(-detections.scores, kind="stable"):
        box_px = detections.boxes_px[i]
        box = (box_px - STRIDE // 2) / STRIDE
        x0, y0, x1, y1 = (int(v) for v in (*np.floor(box[:2]), *np.ceil(box[2:])))
        window = slice(max(0, y0), max(0, y1) + 1), slice(max(0, x0), max(0, x1) + 1)
        known = float(detections.depths_m[i]) if detections.depths_m.size else None
        width_px = float(box_px[2] - box_px[0])
        near, points = view.object_in(window, known, width_px / focal_px)
        if len(points) < MIN_POINTS:
            continue
        name, score = names[int(detections.labels[i])], float(detections.scores[i])
        cut = _cut(box_px, obs.depth_m.shape[1])
        found.append(Sighting(name, score, detections.embeddings[i], points, near, cut))
    return found


@dataclass(frozen=True)
class _View:
    """A depth image, every STRIDE-th pixel of it: where its points are, and what hangs together."""

    depth: F32  # (h, w) m, 0 for unknown
    points: F64  # (h, w, 3) m in the map frame
    standing: Mask  # (h, w) whether a thing may be there, neither floor nor ceiling
    surfaces: Surfaces

    @classmethod
    def of(cls, obs: Observation, mount: Mount) -> "_View":
        table, offset = rays(obs.intrinsics, mount, STRIDE), STRIDE // 2
        depth = np.nan_to_num(obs.depth_m[offset::STRIDE, offset::STRIDE], posinf=0.0)
        axes = (table.forward, table.left, table.up)
        offset_m = np.array([mount.x_m, mount.y_m, mount.z_m])
        base = np.stack([depth.astype(np.float64) * axis for axis in axes], axis=-1) + offset_m
        points = base_to_map(base.reshape(-1, 3), obs.pose).reshape(base.shape)
        standing = (points[..., 2] > FLOOR_M) & (points[..., 2] < CEILING_M)
        surfaces = segment(depth, depth * table.up + np.float32(mount.z_m))
        return cls(depth, points, standing, surfaces)

    def object_in(self, window: Window, known_m: float | None, wide: float) -> tuple[float, F64]:
        """How far away the object in a box is, m, unless that is known, and its points (N, 3);
        `wide` is the box, per metre of distance."""
        patch, own = self.depth[window], self.surfaces.label[window]
        near = distance_m(patch, own, self.surfaces.size) if known_m is None else known_m
        before_m = min(CLUSTER_M, max(BEFORE_M, BEFORE_SHARE * wide * near))
        keep = (patch > 0) & (patch > near - before_m) & (patch < near + CLUSTER_M)
        keep &= (patch > near - EDGE_M) | attached(patch, own, near)
        if np.count_nonzero(keep) < MIN_POINTS:
            return near, self.points[:0, 0]
        return near, self.points[window][keep & self.standing[window]]


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
        instance = fuse(semantic.instances, new_id, grid.frame, sighting, obs.pose, semantic.places)
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
    h, w = obs.depth_m.shape
    reach_m = math.hypot(mount.x_m, mount.y_m) + MISS_RANGE_M[1] * _widest(obs.intrinsics)
    ids, middles = semantic.places.within((obs.pose.x_m, obs.pose.y_m), reach_m)
    unseen = [semantic.instances[id] for id in ids]
    optical = map_to_optical(middles, obs.pose, mount)
    z = optical[:, 2]
    close = np.flatnonzero((z >= MISS_RANGE_M[0]) & (z <= MISS_RANGE_M[1]))
    u, v = project(optical[close], obs.intrinsics).T
    inside = (0.12 * w < u) & (u < 0.88 * w) & (0.08 * h < v) & (v < 0.92 * h)
    for n, col, row in zip(close[inside], u[inside], v[inside], strict=True):
        if unseen[n].id in seen:
            continue
        patch = obs.depth_m[int(row) - 4 : int(row) + 5, int(col) - 4 : int(col) + 5]
        patch = patch[patch > 0]
        if patch.size == 0 or float(np.median(patch)) < z[n] - 0.6:
            continue  # hidden
        uncalled(unseen[n], (), obs.pose)


def _widest(intrinsics: Intrinsics) -> float:
    """How far from the camera, per metre along its axis, the image's corners are at most."""
    x = max(intrinsics.cx, intrinsics.width - intrinsics.cx) / intrinsics.fx
    y = max(intrinsics.cy, intrinsics.height - intrinsics.cy) / intrinsics.fy
    return math.hypot(1.0, x, y)


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
