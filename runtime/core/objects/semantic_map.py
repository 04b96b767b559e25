"""The semantic map: object instances with fused evidence, and room types per cell."""

import math
from collections.abc import Container, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

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
    ASSOCIATE_M,
    Instance,
    Sighting,
    called,
    first_views,
    fuse,
    uncalled,
)
from runtime.core.objects.places import InstancePlaces, Nearby
from runtime.core.types import F32, F64, Detections, Intrinsics, Mount, Observation, Pose

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
    view, boxes = _View.of(obs, mount), detections.boxes_px
    scaled = (boxes - STRIDE // 2) / STRIDE
    corner = np.maximum(np.floor(scaled[:, :2]).astype(np.int64), 0).tolist()
    end = (np.maximum(np.ceil(scaled[:, 2:]).astype(np.int64), 0) + 1).tolist()
    wide = ((boxes[:, 2] - boxes[:, 0]).astype(np.float64) / obs.intrinsics.fx).tolist()
    cut = (boxes[:, 0] < EDGE_PX) | (boxes[:, 2] > obs.depth_m.shape[1] - EDGE_PX)
    found = []
    for i in np.argsort(-detections.scores, kind="stable").tolist():
        (left, top), (right, bottom) = corner[i], end[i]
        known = float(detections.depths_m[i]) if detections.depths_m.size else None
        near, points = view.object_in((slice(top, bottom), slice(left, right)), known, wide[i])
        if len(points) < MIN_POINTS:
            continue
        name, score = names[int(detections.labels[i])], float(detections.scores[i])
        embedding = detections.embeddings[i]
        found.append(Sighting(name, score, embedding, points, near, bool(cut[i])))
    return found


@dataclass(frozen=True)
class _View:
    """A depth image, every STRIDE-th pixel of it: where its points are, and what hangs together."""

    depth: F32  # (h, w) m, 0 for unknown
    standing: F32  # (h, w) the same where a thing may be, neither floor nor ceiling; else -inf
    points: F64  # (3, h * w) m in the map frame
    number: NDArray[np.intp]  # (h, w) of the point
    surfaces: Surfaces

    @classmethod
    def of(cls, obs: Observation, mount: Mount) -> "_View":
        table, offset = rays(obs.intrinsics, mount, STRIDE), STRIDE // 2
        depth = obs.depth_m[offset::STRIDE, offset::STRIDE]
        depth = np.where(np.isfinite(depth), depth, np.float32(0))
        base = _axes(obs.intrinsics, mount) * depth.astype(np.float64).ravel()
        base += ((mount.x_m,), (mount.y_m,), (mount.z_m,))
        points = base_to_map(base.T, obs.pose).T
        up = points[2].reshape(depth.shape)
        thing = (up > FLOOR_M) & (up < CEILING_M) & (depth > 0)
        standing = np.where(thing, depth, np.float32(-np.inf))
        surfaces = segment(depth, depth * table.up + np.float32(mount.z_m))
        number = np.arange(depth.size).reshape(depth.shape)
        return cls(depth, standing, points, number, surfaces)

    def object_in(self, window: Window, known_m: float | None, wide: float) -> tuple[float, F64]:
        """How far away the object in a box is, m, unless that is known, and its points (N, 3);
        `wide` is the box, per metre of distance."""
        surfaces, near = self.surfaces, known_m
        patch, own = np.ascontiguousarray(self.depth[window]), surfaces.label[window]
        if near is None:
            near = distance_m(patch, own, surfaces.size, surfaces.span)
        before_m = min(CLUSTER_M, max(BEFORE_M, BEFORE_SHARE * wide * near))
        standing = self.standing[window]
        keep = (standing > near - before_m) & (standing < near + CLUSTER_M)
        at, depth = self.number[window][keep], standing[keep]
        behind = depth > near - EDGE_M
        if not behind.all():
            behind |= attached(patch, own, near)[own[keep]]
            at = at[behind]
        return near, self.points.take(at, axis=1).T


@lru_cache(maxsize=8)
def _axes(intrinsics: Intrinsics, mount: Mount) -> F64:
    """(3, h * w): forward, left, up of the rays, shared. Products with a table of single precision
    are the same, and slower."""
    table = rays(intrinsics, mount, STRIDE)
    return np.stack([table.forward, table.left, table.up]).astype(np.float64).reshape(3, -1)


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
    sightings = locate(obs, detections, semantic.names, mount)
    views = first_views(grid.frame, sightings, semantic.next_id)
    near = Nearby(semantic.places, [v.xy for v in views], [v.cells_xy for v in views], ASSOCIATE_M)
    for n, (sighting, view) in enumerate(zip(sightings, views, strict=True)):
        view.id = semantic.next_id
        instance = fuse(semantic.instances, view, grid.frame, sighting, obs.pose, near.of(n))
        near.put(instance)
        semantic.next_id += instance is view
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
    close, u, v = close[inside], u[inside], v[inside]
    visible = _depths_at(obs.depth_m, v.astype(np.int64), u.astype(np.int64)) >= z[close] - 0.6
    for n in close[visible].tolist():
        if unseen[n].id not in seen:
            uncalled(unseen[n], (), obs.pose)


def _depths_at(depth_m: F32, rows: NDArray[np.int64], cols: NDArray[np.int64]) -> F32:
    """(N,) m: medians of what is known round pixels of a depth image; -inf where nothing is."""
    around = np.arange(-4, 5)
    rows = np.clip(rows[:, None] + around, 0, depth_m.shape[0] - 1)
    cols = np.clip(cols[:, None] + around, 0, depth_m.shape[1] - 1)
    patches = depth_m[rows[:, :, None], cols[:, None]].reshape(len(rows), around.size**2)
    known = patches > 0
    count = np.count_nonzero(known, axis=1)
    ordered = np.sort(np.where(known, patches, np.float32(np.inf)), axis=1)
    each = np.arange(len(rows))
    low, high = ordered[each, (count - 1) // 2], ordered[each, count // 2]
    return np.where(count > 0, (low + high) / np.float32(2), np.float32(-np.inf))


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
    inside = polygon_mask(patch, near).astype(np.float32)
    for kind in rooms.nonzero()[0].tolist():
        semantic.rooms[kind, *window] += rooms[kind] * inside
