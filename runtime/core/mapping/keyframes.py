"""Keyframes: which of the images seen so far looks toward a frontier best."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import cv2
import numpy as np

from runtime.core.geometry import wrap_angle
from runtime.core.kernels import objects as kernels
from runtime.core.kernels import walking
from runtime.core.keys import key
from runtime.core.mapping.framing import framed, jpeg
from runtime.core.mapping.grid import MapCopy, NavigationMap
from runtime.core.mapping.sights import halved, sight_depth, way_of
from runtime.core.types import (
    F16,
    F32,
    F64,
    U8,
    Detections,
    InImage,
    Intrinsics,
    Mask,
    Mount,
    Observation,
    Pose,
    Sight,
)

KEYFRAMES_KEPT = 200  # the oldest are forgotten
KEYFRAMES_BYTES = 64 << 20  # of all of them
MOVED_M = 0.3  # from every other, to be worth keeping
TURNED_RAD = math.radians(25.0)  # or turned so far
RANGE_M = (0.4, 5.0)  # to the frontier cells it shows
HALF_VIEW_RAD = math.radians(34.0)  # they are well inside the image
SHARP_SIZE = 120, 160  # rows and columns of the image whose edges tell how sharp it is
ONE_COLOUR = 0.3  # no sharper than this shows nothing: a wall close by, a covered lens
PATCHES = 16, 12  # columns and rows of an image whose noise is averaged away
ONE_GREY = 4  # levels; what differs no more from patch to patch shows nothing but noise
BLURRED = 0.6  # share of the older one's sharpness below which the older is kept


@dataclass(frozen=True)
class KeyframeConfig:
    """[keyframes]"""

    image_width_px: int = key(
        0,
        "Width of the images kept for a model that sees, e.g. 320; 0 keeps none.",
        "px",
        within=(0, 1920),
    )


CELLS = 12  # of a frontier that are looked for in each image
TRIED = 12  # images whose line of sight is checked, best first
NOTHING = np.zeros(0, np.float32)
NO_IMAGE = np.zeros((0, 0, 3), np.uint8)
NO_PARTS = np.zeros((0, 0, 0), np.float16)


@dataclass(frozen=True)
class Keyframe:
    """An image's embedding (D,), where it was taken (map frame), and the image itself, (h, w, 3)
    RGB, where images are kept, with what is needed to find a point of the map in it. `features`
    (C, h, w) and `depth` (2, h, w) of the image's parts, as a `Sight` has them, or (0, 0, 0)."""

    pose: Pose
    embedding: F32
    sharpness: float = 0.0
    image: U8 = field(default_factory=lambda: NO_IMAGE)
    intrinsics: Intrinsics | None = None
    mount: Mount | None = None
    features: F16 = field(default_factory=lambda: NO_PARTS)
    depth: F16 = field(default_factory=lambda: NO_PARTS)

    @property
    def tells(self) -> tuple[bool, bool]:
        """Of what the image shows: its parts, and the whole. One that tells more is larger."""
        return self.features.size > 0, self.embedding.size > 0

    @property
    def size_bytes(self) -> int:
        """Of its arrays, and of the JPEG once that is made."""
        held = self.embedding, self.image, self.features, self.depth
        return sum(array.nbytes for array in held) + len(self.__dict__.get("jpeg", b""))

    @cached_property
    def jpeg(self) -> bytes:
        """The image as a JPEG file, made when it is first asked for; b"" where none is kept."""
        return jpeg(self.image)

    def bare(self) -> "Keyframe":
        """Without any picture: pose, embedding, sharpness."""
        return Keyframe(self.pose, self.embedding, self.sharpness)


class KeyframeView(NamedTuple):
    """What the experts are shown of a frontier: an embedding (D,) or (0,), a JPEG or b"", what the
    detector saw of the image's parts, and where in the JPEG the frontier is."""

    embedding: F32 = NOTHING
    jpeg: bytes = b""
    sight: Sight | None = None
    in_image: InImage | None = None


def consider(
    frames: list[Keyframe],
    obs: Observation,
    detections: Detections,
    mount: Mount,
    image_width_px: int,
) -> None:
    """`take` the observation and `keep` it, but for what is blurred beside one from nearly the same
    pose, whatever else it may tell: of that nothing further is worked out."""
    sharpness = _sharpness(obs.rgb)
    most = detections.features.size > 0, detections.scene.size > 0
    if not any(_worse(most, sharpness, old) for old in _beside(frames, obs.pose)):
        keep(frames, take(obs, detections, mount, image_width_px, sharpness))


def take(
    obs: Observation,
    detections: Detections,
    mount: Mount,
    image_width_px: int,
    sharpness: float | None = None,
) -> Keyframe:
    """The observation as a keyframe; `image_width_px` of the image kept with it, 0: none is.
    `sharpness` of its image, where that is known."""
    frame = Keyframe(
        obs.pose, detections.scene, _sharpness(obs.rgb) if sharpness is None else sharpness
    )
    if detections.features.size and frame.sharpness > ONE_COLOUR and _contrast(obs.rgb) > ONE_GREY:
        _, rows, cols = detections.features.shape
        frame = replace(
            frame,
            intrinsics=obs.intrinsics,
            mount=mount,
            features=halved(detections.features),
            depth=halved(sight_depth(obs.depth_m, rows, cols)),
        )
    return _with_image(frame, obs, mount, image_width_px) if image_width_px else frame


def _with_image(frame: Keyframe, obs: Observation, mount: Mount, image_width_px: int) -> Keyframe:
    k = obs.intrinsics
    scale = image_width_px / k.width
    size = image_width_px, round(k.height * scale)
    image = np.asarray(cv2.resize(obs.rgb, size, interpolation=cv2.INTER_AREA), np.uint8)
    shrunk = Intrinsics(k.fx * scale, k.fy * scale, k.cx * scale, k.cy * scale, *size)
    return replace(frame, image=image, intrinsics=shrunk, mount=mount)


def _sharpness(rgb: U8) -> float:
    """(H, W, 3) -> how strong its edges are, of an image of one size."""
    rows, cols = SHARP_SIZE
    if rgb.shape[0] % rows or rgb.shape[1] % cols:
        small = cv2.resize(rgb, (cols, rows), interpolation=cv2.INTER_AREA)
        rgb = np.asarray(small, np.uint8)
    return kernels.sharpness(rgb.reshape(len(rgb), -1), rows, cols)


def _contrast(rgb: U8) -> int:
    """(H, W, 3) -> levels by which its patches differ most, of the colour that differs most."""
    # Every fourth row: a third of the time, and as good an average.
    patches = np.asarray(cv2.resize(rgb[::4], PATCHES, interpolation=cv2.INTER_AREA), np.uint8)
    return int(np.ptp(patches, axis=(0, 1)).max())


def keep(frames: list[Keyframe], frame: Keyframe) -> None:
    """Add a keyframe, in place of those from nearly the same pose, unless it is blurred beside
    them or tells less; what is too many or too much is forgotten, the oldest first, of
    what is too much the images before all else."""
    same = _beside(frames, frame.pose)
    if any(_worse(frame.tells, frame.sharpness, old) for old in same):
        return
    for old in same:
        frames.remove(old)
    frames.append(frame)
    del frames[:-KEYFRAMES_KEPT]
    _bound(frames)


def _bound(frames: list[Keyframe]) -> None:
    """Within KEYFRAMES_BYTES: images go first, which take most, then keyframes, the oldest of
    each; the newest stays whole."""
    held = sum(f.size_bytes for f in frames)
    for n, frame in enumerate(frames[:-1]):
        if held <= KEYFRAMES_BYTES:
            return
        if frame.image.size:
            frames[n] = replace(frame, image=NO_IMAGE)
            held -= frame.size_bytes - frames[n].size_bytes
    while held > KEYFRAMES_BYTES and len(frames) > 1:
        held -= frames.pop(0).size_bytes


def _beside(frames: Sequence[Keyframe], at: Pose) -> list[Keyframe]:
    """Those from nearly the same pose."""
    near = (f for f in frames if abs(f.pose.x_m - at.x_m) < MOVED_M)
    return [f for f in near if _alike(f.pose, at)]


def _worse(told: tuple[bool, bool], sharpness: float, old: Keyframe) -> bool:
    """Whether one that tells so much is worse than the older one: tells less, or as much and is
    blurred beside it."""
    return told < old.tells or (told == old.tells and sharpness < BLURRED * old.sharpness)


def best_views(
    frames: Sequence[Keyframe], frontiers: Mapping[int, F64], grid: NavigationMap | MapCopy
) -> dict[int, KeyframeView]:
    """Of frontiers by id, their cells (N, 2) m: the keyframe that shows most of them, the nearer
    the better, with nothing known in between; an empty view when none shows any."""
    poses = np.array([(f.pose.x_m, f.pose.y_m, f.pose.yaw_rad) for f in frames]).reshape(-1, 3)
    return {id: _best_view(frames, poses, cells, grid) for id, cells in frontiers.items()}


def _best_view(
    frames: Sequence[Keyframe], poses: F64, cells_xy: F64, grid: NavigationMap | MapCopy
) -> KeyframeView:
    found = best_frames(poses, cells_xy, grid, 1)
    if not found:
        return KeyframeView()
    frame = frames[found[0]]
    sight = sight_toward(frame, cells_xy)
    if not frame.jpeg or frame.intrinsics is None or frame.mount is None:
        return KeyframeView(frame.embedding, b"", sight)
    at = framed(cells_xy, frame.pose, frame.mount, frame.intrinsics)
    return KeyframeView(frame.embedding, frame.jpeg, sight, at)


def sight_toward(frame: Keyframe, cells_xy: F64) -> Sight | None:
    """What a keyframe shows toward a frontier's cells (N, 2) m; None where the detector did not
    tell what it saw."""
    k, mount = frame.intrinsics, frame.mount
    if not frame.features.size or k is None or mount is None:
        return None
    _, rows, cols = frame.features.shape
    column, range_m = way_of(cells_xy, frame.pose, mount, k, rows, cols)
    return Sight(frame.features, frame.depth, column, range_m)


def best_frames(
    poses: F64, cells_xy: F64, grid: NavigationMap | MapCopy, most: int
) -> tuple[int, ...]:
    """Of poses (N, 3) m, m, rad, those that show most of a frontier's cells (M, 2) m, the best
    first, `most` of them; () when nothing shows any."""
    cells = cells_xy[np.linspace(0, len(cells_xy) - 1, min(CELLS, len(cells_xy))).astype(int)]
    worth = _worth(poses, cells)
    ranked = np.argsort(-worth.sum(axis=1), kind="stable")[:TRIED]
    found: list[tuple[float, int]] = []  # how much is shown, less; the best first
    for n in ranked:
        if worth[n].sum() <= (-found[most - 1][0] if len(found) >= most else 0.0):
            break
        shown = float(worth[n][_clear(grid, poses[n, :2], cells)].sum())
        if shown > 0.0:
            found = sorted([*found, (-shown, int(n))], key=lambda f: f[0])[:most]
    return tuple(n for _, n in found)


def _worth(poses: F64, cells: F64) -> F64:
    """(N, 3) poses, (M, 2) cells -> (N, M) how well each is placed in each view: 0 out of sight,
    less when far or off the middle."""
    gap = cells[None] - poses[:, None, :2]
    range_m = np.hypot(gap[..., 0], gap[..., 1])
    off = np.arctan2(gap[..., 1], gap[..., 0]) - poses[:, None, 2]
    off = np.abs((off + math.pi) % (2 * math.pi) - math.pi)
    near, far = RANGE_M
    inside = (off <= HALF_VIEW_RAD) & (range_m >= near) & (range_m <= far)
    worth: F64 = inside / (1.0 + range_m) / (1.0 + off / HALF_VIEW_RAD)
    return worth


def _clear(grid: NavigationMap | MapCopy, start: F64, ends: F64) -> Mask:
    """(2,), (M, 2) m -> (M,) whether nothing is known to stand on the straight line."""
    f = grid.frame
    span = float(np.hypot(*(ends - start).T).max())
    steps = max(2, math.ceil(span / f.resolution_m))
    from_xy = float(start[0]), float(start[1])
    return walking.in_sight(grid.occupied, f.place, from_xy, ends, steps)


def _alike(a: Pose, b: Pose) -> bool:
    moved = math.hypot(a.x_m - b.x_m, a.y_m - b.y_m)
    return moved < MOVED_M and abs(wrap_angle(a.yaw_rad - b.yaw_rad)) < TURNED_RAD
