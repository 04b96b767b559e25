"""The floor of a first look, held against the mount: what would map nonsense is refused."""

from collections.abc import Callable

from runtime.core.mapping.floor_plane import CARRIED
from runtime.core.mapping.mount_check import MountCheck
from runtime.core.optics.upright import upright_mount
from runtime.core.types import Mount, Pose
from runtime.errors import SensorError
from runtime.log import say
from runtime.robot.optics import Pair
from runtime.robot.transforms import CameraConfig


class FloorLook:
    """Of one search. Where the floor says how the camera is mounted it may be off by more."""

    def __init__(self, camera: CameraConfig, tell: Callable[[str], None] = say) -> None:
        self._camera, self._tell = camera, tell
        self._check = MountCheck(CARRIED if camera.mount == "floor" else None)

    def check(self, pair: Pair, pose: Pose) -> None:
        """SensorError where nothing is to be mapped by an image, with what would fit. What is off
        by little is said once."""
        if self._check.done:
            return
        mount: Mount = pair.mount or upright_mount(self._camera)
        self._check.look(pair.depth_m, pair.intrinsics, mount, pose.yaw_rad)
        verdict = self._check.verdict(mount)
        if verdict is None or verdict.fits:
            return
        told = mount if pair.mount else self._camera
        words = verdict.in_words(told, by_tf=pair.mount is not None)
        if not verdict.maps:
            raise SensorError(words)
        self._tell(words)
