"""The semantic map: object instances with fused evidence, and room types per cell."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from runtime.core.geometry import (
    GridFrame,
    base_to_map,
    map_to_optical,
    project,
    rays,
    wrap_angle,
)
from runtime.core.map import NavigationMap, polygon_mask
from runtime.core.types import F32, F64, Detections, Mount, Observation, Pose


@dataclass(frozen=True)
class SemanticsConfig:
    """[semantics]"""

    stride: int = 4  # every n-th pixel of a box is projected
    core_share: float = 0.6  # of a box's width and height, where its depth is read
    cluster_m: float = 0.35  # points this close in depth to the core belong to the object
    min_points: int = 6
    associate_m: float = 0.6  # between a detection and the instance it is another view of
    neutral_score: float = 0.25  # a detection of this score speaks neither for nor against
    max_step: float = 2.0  # of log-odds that one view can add
    miss_step: float = 0.5  # of log-odds that a view without the object costs
    miss_range_m: tuple[float, float] = (1.2, 4.0)  # where not seeing an object means something
    repeat_weight: float = 0.15  # of a view that is no new one
    new_view_m: float = 0.4
    new_view_rad: float = math.radians(20.0)
    nearer: float = 0.65  # of the nearest view's range: from there on the footprint is drawn anew
    farther: float = 1.5  # from there on a view adds evidence but no footprint
    log_odds_max: float = 8.0
    room_range_m: float = 3.0  # a view's room type is credited to cells this close


@dataclass
class Instance:
    """One object: what it is called, how sure, where. Positions in the map frame, m."""

    id: int
    name: str
    embedding: F32  # (D,) of its best view
    xy: tuple[float, float]
    z_m: float  # middle of the points seen
    cells_xy: F64  # (N, 2) centres of the map cells under it
    log_odds: float = 0.0
    best_score: float = 0.0
    range_m: float = math.inf  # of the nearest view
    views: list[Pose] = field(default_factory=list)  # poses that count as distinct views
    rejections: int = 0  # as a target, after looks from close by

    @property
    def confidence(self) -> float:
        """Fused probability that the object is there and is what it is called."""
        return 1.0 / (1.0 + math.exp(-self.log_odds))


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


@dataclass(frozen=True)
class Sighting:
    """One detection in space."""

    name: str
    score: float
    embedding: F32
    points: F64  # (N, 3) m in the map frame
    range_m: float  # from the camera, along its axis


def locate(
    obs: Observation,
    detections: Detections,
    names: Sequence[str],
    mount: Mount,
    cfg: SemanticsConfig,
) -> list[Sighting]:
    """Project each box through depth. A box without usable depth gives none."""
    table = rays(obs.intrinsics, mount, cfg.stride)
    offset = cfg.stride // 2
    depth = obs.depth_m[offset :: cfg.stride, offset :: cfg.stride]
    found = []
    for i in np.argsort(-detections.scores, kind="stable"):
        box = (detections.boxes_px[i] - offset) / cfg.stride
        x0, y0, x1, y1 = (int(v) for v in (*np.floor(box[:2]), *np.ceil(box[2:])))
        rows, cols = slice(max(0, y0), max(0, y1) + 1), slice(max(0, x0), max(0, x1) + 1)
        patch = np.nan_to_num(depth[rows, cols], nan=0.0, posinf=0.0)
        known = float(detections.depths_m[i]) if detections.depths_m.size else None
        near = _surface_m(patch, cfg) if known is None else known
        keep = (patch > 0) & (np.abs(patch - near) < cfg.cluster_m)
        if int(keep.sum()) < cfg.min_points:
            continue
        z = patch[keep].astype(np.float64)
        axes = (table.forward, table.left, table.up)
        base = np.stack([z * axis[rows, cols][keep] for axis in axes], axis=1)
        points = base_to_map(base + np.array([mount.x_m, mount.y_m, mount.z_m]), obs.pose)
        points = points[(points[:, 2] > 0.05) & (points[:, 2] < 2.2)]
        if len(points) < cfg.min_points:
            continue
        name = names[int(detections.labels[i])]
        embedding = detections.embeddings[i]
        found.append(Sighting(name, float(detections.scores[i]), embedding, points, near))
    return found


def _surface_m(patch: F32, cfg: SemanticsConfig) -> float:
    """(h, w) depth, m -> how far the nearest substantial surface in the middle of the box is."""
    h, w = patch.shape
    dy, dx = int(h * (1 - cfg.core_share) / 2), int(w * (1 - cfg.core_share) / 2)
    core = patch[dy : h - dy, dx : w - dx]
    core = core[core > 0]
    return float(np.quantile(core, 0.3)) if core.size else 0.0


def place(
    semantic: SemanticMap,
    grid: NavigationMap,
    obs: Observation,
    detections: Detections,
    outline: F64,
    mount: Mount,
    cfg: SemanticsConfig,
) -> None:
    """Fuse one image's detections and its room type into the map."""
    seen = set()
    for sighting in locate(obs, detections, semantic.names, mount, cfg):
        seen.add(_fuse(semantic, grid.frame, sighting, obs.pose, cfg))
    _miss(semantic, obs, mount, seen, cfg)
    _credit_room(semantic, grid.frame, obs.pose, detections.rooms, outline, cfg)


def _fuse(
    semantic: SemanticMap, frame: GridFrame, sighting: Sighting, pose: Pose, cfg: SemanticsConfig
) -> int:
    xyz = np.median(sighting.points, axis=0)
    cells = _footprint(frame, sighting.points[:, :2])
    instance = _same(semantic, sighting.name, cells, (float(xyz[0]), float(xyz[1])), cfg)
    if instance is None:
        instance = Instance(
            semantic.next_id,
            sighting.name,
            sighting.embedding,
            (float(xyz[0]), float(xyz[1])),
            float(xyz[2]),
            cells,
        )
        semantic.instances[instance.id] = instance
        semantic.next_id += 1
    elif sighting.range_m < cfg.farther * instance.range_m:
        if sighting.range_m > cfg.nearer * instance.range_m:
            cells = _footprint(frame, np.concatenate([instance.cells_xy, cells]))
        instance.cells_xy = cells  # of the near views alone: far ones spill over the edges
        x, y = np.median(instance.cells_xy, axis=0)
        instance.xy, instance.z_m = (float(x), float(y)), 0.7 * instance.z_m + 0.3 * float(xyz[2])
    instance.range_m = min(instance.range_m, sighting.range_m)
    if sighting.score > instance.best_score:
        instance.best_score, instance.embedding = sighting.score, sighting.embedding
    step = _logit(sighting.score) - _logit(cfg.neutral_score)
    weight = _view_weight(instance, pose, cfg, remember=True)
    _add(instance, weight * max(-cfg.max_step, min(cfg.max_step, step)), cfg)
    return instance.id


def _footprint(frame: GridFrame, xy: F64) -> F64:
    """(N, 2) m -> (M, 2) centres of the cells under them, each once, in scan order."""
    rows, cols = frame.cells(xy).astype(np.int64).T
    code = np.unique(rows * 1_000_003 + cols)
    return frame.centres(np.stack(np.divmod(code, 1_000_003), axis=1).astype(np.int32))


def _same(
    semantic: SemanticMap, name: str, cells: F64, xy: tuple[float, float], cfg: SemanticsConfig
) -> Instance | None:
    """The instance of that name nearest to the new cells, if near enough."""
    best: tuple[float, int] | None = None
    for instance in semantic.instances.values():
        if instance.name != name:
            continue
        if math.dist(instance.xy, xy) > 4.0:
            continue
        gap = min(
            math.dist(instance.xy, xy),
            float(np.hypot(*(instance.cells_xy - xy).T).min()),
            float(np.hypot(*(cells - instance.xy).T).min()),
        )
        if gap <= cfg.associate_m and (best is None or (gap, instance.id) < best):
            best = gap, instance.id
    return semantic.instances[best[1]] if best else None


def _view_weight(instance: Instance, pose: Pose, cfg: SemanticsConfig, remember: bool) -> float:
    """1 for a view from a new place or direction, little for one more from where it was seen."""
    bearing = math.atan2(instance.xy[1] - pose.y_m, instance.xy[0] - pose.x_m)
    for view in instance.views:
        moved = math.hypot(view.x_m - pose.x_m, view.y_m - pose.y_m)
        earlier = math.atan2(instance.xy[1] - view.y_m, instance.xy[0] - view.x_m)
        turned = abs(wrap_angle(bearing - earlier))
        if moved < cfg.new_view_m and turned < cfg.new_view_rad:
            return cfg.repeat_weight
    if remember:
        instance.views.append(pose)
    return 1.0


def _miss(
    semantic: SemanticMap, obs: Observation, mount: Mount, seen: set[int], cfg: SemanticsConfig
) -> None:
    """Lower what should be in plain view and was not detected."""
    h, w = obs.depth_m.shape
    for instance in semantic.instances.values():
        if instance.id in seen:
            continue
        point = np.array([[*instance.xy, instance.z_m]])
        optical = map_to_optical(point, obs.pose, mount)
        z = float(optical[0, 2])
        if not cfg.miss_range_m[0] <= z <= cfg.miss_range_m[1]:
            continue
        u, v = project(optical, obs.intrinsics)[0]
        if not (0.12 * w < u < 0.88 * w and 0.08 * h < v < 0.92 * h):
            continue
        patch = obs.depth_m[int(v) - 4 : int(v) + 5, int(u) - 4 : int(u) + 5]
        patch = patch[patch > 0]
        if patch.size == 0 or float(np.median(patch)) < z - 0.6:
            continue  # hidden
        weight = _view_weight(instance, obs.pose, cfg, remember=False)
        _add(instance, -weight * cfg.miss_step, cfg)


def _credit_room(
    semantic: SemanticMap,
    frame: GridFrame,
    pose: Pose,
    rooms: F32,
    outline: F64,
    cfg: SemanticsConfig,
) -> None:
    if rooms.size == 0:
        return
    apex = outline[0]
    offset = outline - apex
    reach = np.hypot(*offset.T)
    near = apex + offset * np.minimum(1.0, cfg.room_range_m / np.maximum(reach, 1e-6))[:, None]
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


def _add(instance: Instance, step: float, cfg: SemanticsConfig) -> None:
    total = instance.log_odds + step
    instance.log_odds = max(-cfg.log_odds_max, min(cfg.log_odds_max, total))


def _logit(p: float) -> float:
    p = min(max(p, 1e-4), 1 - 1e-4)
    return math.log(p / (1 - p))
