"""The semantic map: object instances with fused evidence, and room types per cell."""

import math
from collections.abc import Container, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from runtime.core.geometry import GridFrame, optical_to_base
from runtime.core.kernels import objects as kernels
from runtime.core.mapping.grid import NavigationMap
from runtime.core.mapping.windows import padded, polygon_mask
from runtime.core.objects.catalogue import Catalogue
from runtime.core.objects.depth_segments import STRIDE, Sighting, things_in
from runtime.core.objects.footprints import unpacked
from runtime.core.objects.gone import HIDES_M, LOOKS, covered, seen_through
from runtime.core.objects.instances import (
    ASSOCIATE_M,
    Instance,
    called,
    first_view,
    fuse,
    reject,
    uncalled,
)
from runtime.core.objects.places import InstancePlaces
from runtime.core.types import F32, F64, Detections, Intrinsics, Mount, Observation, Pose

MISS_RANGE_M = (1.2, 4.0)  # where not seeing an object means something,
MISS_MARGIN = (0.12, 0.08)  # in the image without so much of it at its sides, above and below,
HIDDEN_M = 0.6  # and with nothing so far before its middle, nor before all of its front,
COVERED_M = MISS_RANGE_M[1] + HIDDEN_M  # of which so much may be farther than the middle
AGAIN_M = 0.5  # from where something was that went: what is called so there again is no news
GONE_LOG_ODDS = -1.0  # what is then left of its evidence
GONE_KEPT = 200  # places, the latest
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
    gone_xy: list[tuple[float, float]] = field(default_factory=list)  # of what has left the map
    _places: tuple[dict[int, Instance], InstancePlaces] | None = field(default=None, repr=False)
    _catalogue: tuple[dict[int, Instance], Catalogue] | None = field(default=None, repr=False)

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

    @property
    def catalogue(self) -> Catalogue:
        """What the instances are called, and which are sure."""
        held = self._catalogue
        if held is None or held[0] is not self.instances or len(held[1]) != len(self.instances):
            held = self._catalogue = self.instances, Catalogue.of(self.instances)
        return held[1]

    def called(self, name: str) -> list[Instance]:
        """The instances that were ever called that, by id."""
        return [self.instances[id] for id in self.catalogue.called(name)]

    def learnt(self, instances: Iterable[Instance]) -> None:
        """What is known of these is not what it was."""
        if self._catalogue is not None and self._catalogue[0] is self.instances:
            self._catalogue[1].note(instances)

    def forget(self, instance: Instance) -> None:
        """It has gone. What was rejected, or seems to be where something went before, stays known
        as what it is not: else each far view would send the robot there."""
        rejected = any(known.rejections for known in instance.evidence.values())
        if rejected or any(math.dist(instance.xy, xy) <= AGAIN_M for xy in self.gone_xy):
            for name in instance.evidence:
                reject(instance, name, GONE_LOG_ODDS)
            self.learnt((instance,))
            return
        self.gone_xy = [*self.gone_xy, instance.xy][-GONE_KEPT:]
        del self.instances[instance.id]
        self._places = self._catalogue = None

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
    frame: GridFrame,
) -> list[Sighting]:
    """Project each box through depth, the surest first. A box without usable depth gives none."""
    order = np.argsort(-detections.scores, kind="stable")
    boxes = detections.boxes_px
    windows = _windows(boxes, detections.depths_m, obs.intrinsics)[order]
    cut = (boxes[:, 0] < EDGE_PX) | (boxes[:, 2] > obs.depth_m.shape[1] - EDGE_PX)
    found = zip(
        order.tolist(),
        things_in(obs, windows, mount, frame),
        detections.labels[order].tolist(),
        detections.scores[order].tolist(),
        cut[order].tolist(),
        strict=True,
    )
    embeddings = detections.embeddings
    return [
        Sighting(names[label], score, embeddings[n], thing, cut)
        for n, thing, label, score, cut in found
        if thing is not None
    ]


def _windows(boxes_px: F32, depths_m: F32, intrinsics: Intrinsics) -> F64:
    """(N, 4) px, (N,) m or (0,) -> (N, 6) as `things_in` takes them."""
    scaled = (boxes_px - STRIDE // 2) / STRIDE
    windows = np.full((len(boxes_px), 6), np.nan)
    windows[:, :2] = np.fmax(np.floor(scaled[:, 1::-1]), 0)
    windows[:, 2:4] = np.fmax(np.ceil(scaled[:, 3:1:-1]), 0) + 1
    if depths_m.size:
        windows[:, 4] = depths_m
    wide = boxes_px[:, 2] - boxes_px[:, 0]
    windows[:, 5] = wide.astype(np.float64) / intrinsics.fx
    return windows


def place(
    semantic: SemanticMap,
    grid: NavigationMap,
    obs: Observation,
    detections: Detections,
    outline: F64,
    mount: Mount,
) -> dict[int, set[str]]:
    """Fuse one image's detections and its room type into the map, which what has gone leaves.
    Returns what the image calls each instance in it, by id."""
    names: dict[int, set[str]] = {}
    whole: set[int] = set()
    places = semantic.places
    for sighting in locate(obs, detections, semantic.names, mount, grid.frame):
        view = first_view(semantic.next_id, sighting)
        near = places.near(view.xy, view.cells_xy, ASSOCIATE_M)
        instance = fuse(semantic.instances, view, grid.frame, sighting, obs.pose, near)
        places.put([instance])
        semantic.next_id += instance is view
        if instance.id not in names:  # the surest of an image comes first, and speaks alone
            called(instance, sighting, obs.pose)
        names.setdefault(instance.id, set()).add(sighting.name)
        if not sighting.cut:
            whole.add(instance.id)
    for id, those in names.items():
        uncalled(semantic.instances[id], those, obs.pose, cut=id not in whole)
    missed = _miss(semantic, obs, mount, names)
    semantic.learnt(semantic.instances[id] for id in (*names, *missed))
    for instance in seen_through((semantic.instances[id] for id in missed), obs, mount):
        instance.seen_through += 1
        if instance.seen_through == LOOKS:
            semantic.forget(instance)
    _credit_room(semantic, grid.frame, obs.pose, detections.rooms, outline)
    return names


def _miss(
    semantic: SemanticMap,
    obs: Observation,
    mount: Mount,
    seen: Container[int],
) -> list[int]:
    """Lower what should be in plain view and was not detected: their ids."""
    pose, k = obs.pose, obs.intrinsics
    reach_m = math.hypot(mount.x_m, mount.y_m) + MISS_RANGE_M[1] * _widest(k)
    lens = (
        pose.x_m, pose.y_m, math.cos(pose.yaw_rad), math.sin(pose.yaw_rad),
        mount.x_m, mount.y_m, mount.z_m, *optical_to_base(mount).ravel().tolist(),
        k.fx, k.fy, k.cx, k.cy, *MISS_RANGE_M, reach_m, *MISS_MARGIN, HIDDEN_M,
    )  # fmt: skip
    places, things = semantic.places, semantic.instances
    missed = [id for id in places.in_plain_view(obs.depth_m, lens) if id not in seen]
    if missed:  # most are seen to their middle: only the others may be behind something
        bare = set(places.in_plain_view(obs.depth_m, (*lens[:-1], HIDES_M)))
        missed = [i for i in missed if i in bare or not covered(things[i], obs, mount, COVERED_M)]
    for id in missed:
        uncalled(things[id], (), pose)
    return missed


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
    packed, low_x, low_y, high_x, high_y = kernels.shortened(outline, ROOM_CREDIT_M)
    (top, left), (bottom, right) = frame.cell(low_x, low_y), frame.cell(high_x, high_y)
    top, left = max(0, top - 1), max(0, left - 1)
    bottom, right = min(frame.rows, bottom + 2), min(frame.cols, right + 2)
    cell_m = frame.resolution_m
    x0_m, y0_m = frame.x0_m + left * cell_m, frame.y0_m + top * cell_m
    patch = GridFrame(x0_m, y0_m, cell_m, bottom - top, right - left)
    inside = polygon_mask(patch, unpacked(packed))
    for kind, share in enumerate(rooms.tolist()):
        if share:
            kernels.add_where(semantic.rooms[kind, top:bottom, left:right], inside, share)
