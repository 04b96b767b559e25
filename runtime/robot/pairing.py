"""Pairs of images that may be mapped by: they go together, in a unit that can be, over a floor that
is where the mount has it."""

from runtime.core.optics.upright import upright_mount
from runtime.core.types import U8, Pose
from runtime.robot.floor_look import FloorLook
from runtime.robot.images.camera_images import DepthImage
from runtime.robot.images.plausible import DepthWatch
from runtime.robot.optics import Optics, Pair
from runtime.robot.session import TopicsConfig
from runtime.robot.transforms import CameraConfig


class Pairing:
    """Of one robot. In lockstep a harness answers for units and mounts."""

    def __init__(
        self, optics: Optics, camera: CameraConfig, topics: TopicsConfig, lockstep: bool
    ) -> None:
        self._optics, self._camera, self._lockstep = optics, camera, lockstep
        self._watch = None if lockstep else DepthWatch(topics.depth, camera)
        self._floor = FloorLook(camera)

    def mounts(self, camera: CameraConfig) -> None:
        """From the next pair on the camera is there; it is looked at anew."""
        self._camera, self._floor = camera, FloorLook(camera)

    def pair(self, rgb: U8, depth: DepthImage, frame: str, stamp_ns: int, pose: Pose) -> Pair:
        """Of images as they were published, depth of that frame; where the base was. SensorError
        for what is not to be mapped."""
        pair = self._optics.pair(rgb, depth.depth_m, frame, stamp_ns)
        if self._watch is not None:
            mount = pair.mount or upright_mount(self._camera)
            seen = DepthImage(pair.depth_m, depth.unit_m) if pair.altered else depth
            self._watch.check(seen, pair.intrinsics, mount)
        if not self._lockstep:
            self._floor.check(pair, pose)
        return pair
