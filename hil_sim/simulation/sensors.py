"""What a real camera makes of a view, a laser scanner and a bumper. All seeded."""

import math
from collections.abc import Mapping
from typing import Any, Final
from typing import Protocol as Port

import cv2
import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_typestore

from hil_sim.scenes.format import Scene
from hil_sim.simulation.depth_cameras import CAMERAS, edges, mixed, photograph_depth
from hil_sim.simulation.flooring import CLIFF_FAR_M
from hil_sim.simulation.noise import Noise
from hil_sim.simulation.protocol import Protocol
from runtime.robot.wire_senses import encode_range


class Seen(Port):
    """A view as it truly is, before noise: colour (H, W, 3), depth (H, W) m, 0 where nothing is,
    and the index of the object in each pixel, or -1."""

    @property
    def rgb(self) -> NDArray[np.uint8]: ...

    @property
    def depth_m(self) -> NDArray[np.float32]: ...

    @property
    def segmentation(self) -> NDArray[np.int32]: ...


SCAN, BUMPER = "scan", "bumper"  # topics
GLASS = ("mirror", "shower")
"""Categories whose depth is lost; also anything whose id or mesh speaks of a window."""
BEAMS: Final = 360
LASER_M: Final = (0.1, 12.0)
LASER_Z_M: Final = 0.18
"""Height of the laser scanner: over floor coverings, under seats."""

_STORE: Final = get_typestore(Stores.ROS2_HUMBLE)
_T: Final = _STORE.types


def sense(
    view: Seen, scene: Scene, protocol: Protocol, turned_radps: float, rng: np.random.Generator
) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """What the protocol's camera makes of a view while the robot turns: rgb (H, W, 3), depth
    (H, W) m, 0 where it has no reading."""
    noise = protocol.noise
    rgb, depth_m = view.rgb, view.depth_m
    if noise.flying:
        depth_m = mixed(depth_m, noise.flying, rng)
    if noise.camera:
        glass, focal_px = glass_in(scene)[view.segmentation], protocol.intrinsics.fx
        depth_m = photograph_depth(CAMERAS[noise.camera], depth_m, rgb, glass, focal_px, rng)
    if noise.depth or noise.edges or noise.glass or noise.missing:
        depth_m = depth_read(depth_m, glass_in(scene)[view.segmentation], noise, rng)
    if noise.exposure or noise.blur:
        turned_px = turned_radps * noise.blur * protocol.intrinsics.fx
        rgb = colour_read(rgb, turned_px, noise, rng)
    return rgb, protocol.sensed(depth_m)


def beside(
    protocol: Protocol,
    ranges_m: NDArray[np.float32] | None,
    touching: bool,
    below_m: Mapping[str, float],
    stamp_ns: int,
) -> dict[str, bytes]:
    """What is published beside the camera, as topic: CDR."""
    found = {}
    if protocol.laser and ranges_m is not None:
        found[SCAN] = encode_scan(ranges_m, stamp_ns)
    return found | felt(protocol, touching, below_m, stamp_ns)


def felt(
    protocol: Protocol, touching: bool, below_m: Mapping[str, float], stamp_ns: int
) -> dict[str, bytes]:
    """What is published of the body, however often, as topic: CDR. `below_m`: by topic, how far
    down the ground is under a cliff sensor."""
    found = {BUMPER: encode_bumper(touching)} if protocol.bumper else {}
    if protocol.cliffs:
        for topic, range_m in below_m.items():
            found[topic] = encode_range(range_m, stamp_ns, CLIFF_FAR_M, topic.replace("/", "_"))
    return found


def glass_in(scene: Scene) -> NDArray[np.bool_]:
    """(objects + 1,) which of the scene's objects are glass or mirrors; the last is for -1."""
    found = [
        obj.category in GLASS or "window" in f"{obj.id} {obj.mesh}".lower() for obj in scene.objects
    ]
    return np.array([*found, False], bool)


def depth_read(
    depth_m: NDArray[np.float32],
    glass: NDArray[np.bool_],
    noise: Noise,
    rng: np.random.Generator,
) -> NDArray[np.float32]:
    """(H, W) true depth, m, and which pixels show glass -> what the sensor makes of it; 0 where it
    has no reading. sigma = noise.depth * z^2."""
    read = depth_m.astype(np.float32, copy=True)
    if noise.depth:
        read += np.float32(noise.depth) * read**2 * rng.standard_normal(read.shape, np.float32)
    chance = np.full(read.shape, noise.missing, np.float32)
    if noise.edges:
        chance[edges(depth_m)] = noise.edges
    if noise.glass:
        chance[glass] = noise.glass
    if chance.any():
        read[rng.random(read.shape, np.float32) < chance] = 0.0
    read[depth_m <= 0] = 0.0
    return np.maximum(read, np.float32(0))


def colour_read(
    rgb: NDArray[np.uint8],
    turn_px: float,
    noise: Noise,
    rng: np.random.Generator,
) -> NDArray[np.uint8]:
    """(H, W, 3) -> the same under another exposure, smeared by `turn_px` pixels along the rows."""
    gain, offset = rng.standard_normal(2)
    width = round(abs(turn_px)) if noise.blur else 0
    if width > 1:
        rgb = np.asarray(cv2.blur(rgb, (width, 1), borderType=cv2.BORDER_REPLICATE), np.uint8)
    if not noise.exposure:
        return rgb
    scale = math.exp(noise.exposure * float(gain))
    levels = np.arange(256) * scale + 64.0 * noise.exposure * float(offset)
    return np.asarray(np.clip(np.round(levels), 0, 255).astype(np.uint8)[rgb], np.uint8)


def encode_scan(ranges_m: NDArray[np.float32], stamp_ns: int, frame: str = "laser") -> bytes:
    """(N,) ranges around the robot from straight behind (-pi), counter-clockwise, inf where
    nothing is -> sensor_msgs/LaserScan."""
    turn = math.tau / len(ranges_m)
    near, far = LASER_M
    scan = _T["sensor_msgs/msg/LaserScan"](
        header=_header(stamp_ns, frame),
        angle_min=-math.pi,
        angle_max=math.pi - turn,
        angle_increment=turn,
        time_increment=0.0,
        scan_time=0.0,
        range_min=near,
        range_max=far,
        ranges=np.asarray(ranges_m, np.float32),
        intensities=np.zeros(0, np.float32),
    )
    return bytes(_STORE.serialize_cdr(scan, scan.__msgtype__))


def encode_bumper(touching: bool) -> bytes:
    """std_msgs/Bool."""
    message = _T["std_msgs/msg/Bool"](bool(touching))
    return bytes(_STORE.serialize_cdr(message, message.__msgtype__))


def _header(stamp_ns: int, frame: str) -> Any:
    sec, nanosec = divmod(stamp_ns, 1_000_000_000)
    return _T["std_msgs/msg/Header"](_T["builtin_interfaces/msg/Time"](sec, nanosec), frame)
