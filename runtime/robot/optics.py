"""Images as everything after takes them: upright, straight, depth in the pixels of colour. And
where the camera is that took them, by configuration or tf."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from runtime.core.geometry import mount_of, optical_to_base, wrap_angle
from runtime.core.mapping.solid_depth import solid
from runtime.core.optics.lens import Lens, straightened
from runtime.core.optics.registered import (
    Extrinsics,
    mount_beside,
    registered,
    resized,
    resized_intrinsics,
)
from runtime.core.optics.upright import QUARTER_RAD, quarters_of, upright_axes, upright_mount
from runtime.core.types import F32, F64, U8, Intrinsics, Mount
from runtime.errors import SensorError
from runtime.robot.bounds import check_size
from runtime.robot.calibration import is_rectified
from runtime.robot.camera_info import CameraInfo
from runtime.robot.session import TopicsConfig
from runtime.robot.transforms import CameraConfig, Transforms, UnplacedError

SAME_VIEW: Final = 0.015  # of the image's width, that two cameras' intrinsics differ by: one camera
SAME_PLACE: Final = (0.002, 0.002)  # m, and rad about: frames of one camera
SURE_RAD: Final = 1.0  # a camera that looks more steeply up or down has no roll to be turned by
SAME_WAY: Final = 0.7  # cosine: where tf's camera looks elsewhere its frame is no optical one
IDENTITY: Final = Extrinsics.of(np.eye(4))


@dataclass(frozen=True)
class DepthSight:
    """A depth image in its own camera's pixels, upright and straight, m. `mount`: of that camera
    where tf says; `beside`: from it to the camera that is configured, where it is another;
    `turned`: quarter turns of that one to the right that are not in its configured mount."""

    depth_m: F32
    intrinsics: Intrinsics
    mount: Mount | None = None
    beside: Extrinsics | None = None
    turned: int = 0

    def mounted(self, configured: Mount) -> Mount:
        """The mount by configuration, of an upright image."""
        return upright_mount(_own(configured, self.beside, self.turned))


@dataclass(frozen=True)
class Pair:
    """A colour image and its depth image, upright and straight, pixel by pixel of the same. `mount`
    where tf says. `altered`: whether one of them is not as it came."""

    rgb: U8
    depth_m: F32
    intrinsics: Intrinsics
    mount: Mount | None
    altered: bool


@dataclass(frozen=True)
class _Relation:
    """How a depth camera lies to the colour camera: the lens that took depth, and where it is;
    None: in the same place, with the same view."""

    lens: Lens
    placed: Extrinsics | None


class Optics:
    """One for a robot; any thread may ask. `color`, `depth`: what the two CameraInfo topics tell;
    the second need not tell anything where depth is colour's, pixel by pixel. Messages of theirs
    that cannot be read are told to `bad`."""

    def __init__(
        self,
        config: CameraConfig,
        topics: TopicsConfig,
        transforms: Transforms,
        bad: Callable[[str, SensorError], None],
    ) -> None:
        self._config, self._topics, self._transforms = config, topics, transforms
        self._leans = 0  # quarter turns by tf, as it told last: it may come late for an image
        self.color = CameraInfo(topics.camera_info, bad, is_rectified(topics.color))
        self.depth = CameraInfo(info_topic(topics.depth), bad, is_rectified(topics.depth))

    def pair(self, rgb: U8, depth_m: F32, frame: str, stamp_ns: int) -> Pair:
        """(H, W, 3) and (H, W) m as published, depth of that frame -> what is handed over.
        SensorError for sizes, frames and lenses that do not go together."""
        color, topics = self.color.lens, self._topics
        assert color is not None  # nothing is matched before
        check_size(rgb.shape, topics.color, color.intrinsics, topics.camera_info)
        relation = self._related(depth_m.shape, frame, stamp_ns)
        told = self._frame(relation, frame)
        mount = self._mount(self._config.frame or told, stamp_ns)
        straight = straightened(color, self._quarters(mount, told, stamp_ns))
        size = color.intrinsics.width, color.intrinsics.height
        if relation.placed is not None:
            placed = _turned(relation.placed, straight.quarters)
            seen = registered(solid(depth_m), relation.lens, placed, straight.intrinsics)
        else:
            of = straightened(_sized(relation.lens, *size), straight.quarters)
            seen = of.depth(
                depth_m if depth_m.shape == size[::-1] else resized(solid(depth_m), *size)
            )
        upright, rgb_as_came = _upright(mount) if mount else None, rgb
        rgb = straight.color(rgb)
        altered = rgb is not rgb_as_came or seen is not depth_m
        return Pair(rgb, seen, straight.intrinsics, upright, altered)

    def sight(self, depth_m: F32, frame: str, stamp_ns: int) -> DepthSight | None:
        """(H, W) m as published -> the same in its own pixels; None before the intrinsics are
        known. SensorError as `pair`."""
        if self.color.lens is None:
            return None
        relation = self._related(depth_m.shape, frame, stamp_ns)
        beside, config = relation.placed, self._config
        if config.mount == "tf":
            mount = self._by_tf(config.frame or self._frame(relation, frame), stamp_ns)
            mount = mount_beside(mount, beside) if beside else mount
            straight = straightened(relation.lens, quarters_of(mount.roll_rad))
            return DepthSight(straight.depth(depth_m), straight.intrinsics, _upright(mount))
        turned = self._quarters(None, self._frame(relation, frame), stamp_ns) - config.turned
        own = _own(config, beside, turned)
        straight = straightened(relation.lens, quarters_of(own.roll_rad))
        return DepthSight(straight.depth(depth_m), straight.intrinsics, None, beside, turned)

    def known(self, frame: str, stamp_ns: int) -> F64 | None:
        """(4, 4) from a frame to the base's, of one that tf may know or not, whether or not it is
        gone by otherwise."""
        if not self._transforms.known:
            return None
        try:
            return self._transforms.placed(self._config.base_frame, frame, stamp_ns)
        except SensorError:
            return None

    # -- inside --------------------------------------------------------------------------------

    def _mount(self, frame: str, stamp_ns: int) -> Mount | None:
        """As tf tells, where that is gone by."""
        if self._config.mount != "tf":
            return None
        return self._by_tf(frame, stamp_ns)

    def _by_tf(self, frame: str, stamp_ns: int) -> Mount:
        return self._transforms.mount(self._config.base_frame, frame, stamp_ns)

    def _quarters(self, mount: Mount | None, frame: str, stamp_ns: int) -> int:
        """How the camera is turned: by its mount; where none is configured, also by a tf that is
        not gone by otherwise."""
        if mount is not None:
            return quarters_of(mount.roll_rad)
        if self._config.turned:
            return self._config.turned
        told = self.known(self._config.frame or frame, stamp_ns)
        if told is not None:
            mount = mount_of(told[:3, :3], told[:3, 3], 3)
            same_way = float(told[:3, 2] @ optical_to_base(self._config)[:, 2]) > SAME_WAY
            if same_way and abs(mount.pitch_rad) < SURE_RAD:
                self._leans = quarters_of(mount.roll_rad)
        return self._leans

    def _frame(self, relation: _Relation, depth: str) -> str:
        """Whose mount that of a pair is."""
        return depth if relation.placed is None else self.color.frame or depth

    def _related(self, shape: tuple[int, ...], frame: str, stamp_ns: int) -> _Relation:
        """How depth of that shape and frame lies to colour."""
        color, own, topics = self.color.lens, self.depth.lens, self._topics
        assert color is not None
        frame, other = frame.lstrip("/"), self.color.frame
        apart = bool(frame and other and frame != other)
        if own is not None and (own.intrinsics.height, own.intrinsics.width) != shape:
            own = None  # of another stream, or from before its size was changed
        placed = self._placed(frame, other, stamp_ns) if apart or self._config.depth_at else None
        if placed is not None and not _is_elsewhere(placed):
            placed = None
        if own is None:
            if placed is not None:
                info = self.depth.topic
                raise SensorError(
                    f"{topics.depth}: is of frame {frame}, colour of {other}, and nothing tells "
                    f"its intrinsics: publish {info}, or depth registered to colour (align_depth)"
                )
            return _Relation(self._whole(color, shape), None)
        if placed is None and _same_view(own.intrinsics, color.intrinsics):
            return _Relation(own, None)
        return _Relation(own, placed or IDENTITY)

    def _whole(self, color: Lens, shape: tuple[int, ...]) -> Lens:
        """Colour's lens for depth of another size: that of the same view."""
        i, (height, width) = color.intrinsics, shape
        if abs(width * i.height - height * i.width) > SAME_VIEW * width * i.height:
            check_size(shape, self._topics.depth, i, self._topics.camera_info)
        return _sized(color, width, height)

    def _placed(self, frame: str, color: str, stamp_ns: int) -> Extrinsics:
        """From the depth camera's frame to colour's."""
        if self._config.depth_at:
            return as_configured(self._config.depth_at)
        try:
            return Extrinsics.of(self._transforms.placed(color, frame, stamp_ns))
        except SensorError as error:
            raise UnplacedError(
                f"{self._topics.depth}: is of frame {frame}, {self._topics.camera_info} of "
                f"{color}, and tf does not relate them: publish depth registered to colour "
                "(align_depth), or set camera.depth_at"
            ) from error


def info_topic(images: str) -> str:
    """Where a driver tells of the camera whose images are on a topic: beside them."""
    for transport in ("/compressed", "/compressedDepth"):
        images = images.removesuffix(transport)
    return "/".join([*images.split("/")[:-1], "camera_info"])


def as_configured(values: tuple[float, ...]) -> Extrinsics:
    """camera.depth_at: x ahead, y left, z up, m, roll, pitch, yaw, rad, in colour's camera."""
    axes = optical_to_base(Mount(0.0, 0.0, 0.0))
    matrix = np.eye(4)
    matrix[:3, :3] = axes.T @ optical_to_base(Mount(0.0, 0.0, 0.0, *values[3:]))
    matrix[:3, 3] = axes.T @ values[:3]
    return Extrinsics.of(matrix)


def _upright(told: Mount) -> Mount:
    """By tf's mount, which is rounded, so that one that rests does not tremble."""
    mount = upright_mount(told)
    return mount if mount is told else replace(mount, roll_rad=round(mount.roll_rad, 3))


def _own(configured: Mount, beside: Extrinsics | None, turned: int) -> Mount:
    """The mount of the camera that took depth, as it was when it took it."""
    if turned:
        lean = configured.roll_rad + turned * QUARTER_RAD
        configured = replace(configured, roll_rad=wrap_angle(lean))
    return mount_beside(configured, beside) if beside else configured


def _turned(placed: Extrinsics, quarters: int) -> Extrinsics:
    """To the upright image of the camera that it leads to."""
    return Extrinsics.of(upright_axes(quarters) @ placed.matrix) if quarters else placed


def _is_elsewhere(placed: Extrinsics) -> bool:
    """Whether it is another camera's place, or only another name for it."""
    matrix = placed.matrix
    angle = np.arccos(np.clip((np.trace(matrix[:, :3]) - 1) / 2, -1, 1))
    return bool(np.linalg.norm(matrix[:, 3]) > SAME_PLACE[0] or angle > SAME_PLACE[1])


def _same_view(a: Intrinsics, b: Intrinsics) -> bool:
    """Whether two images show the same, if in another number of pixels."""
    a = resized_intrinsics(a, b.width, b.height)
    most = SAME_VIEW * b.width
    return all(
        abs(p - q) < most for p, q in ((a.fx, b.fx), (a.fy, b.fy), (a.cx, b.cx), (a.cy, b.cy))
    )


def _sized(lens: Lens, width: int, height: int) -> Lens:
    """The same lens in so many pixels."""
    i = lens.intrinsics
    if (i.width, i.height) == (width, height):
        return lens
    return Lens(resized_intrinsics(i, width, height), lens.coefficients, lens.fisheye)
