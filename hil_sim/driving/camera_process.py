"""The robot's camera in a process of its own: PyBullet holds Python's lock while it renders, and
a base that is driven 50 times a second cannot wait for that."""

import multiprocessing
import signal
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hil_sim.driving.link import HarnessError
from hil_sim.scenes.format import Scene
from hil_sim.simulation.body import Body
from hil_sim.simulation.camera import CameraModel
from hil_sim.simulation.noise import generator
from hil_sim.simulation.protocol import Protocol
from hil_sim.simulation.quiet import hushed, keep_stdout_for_python
from hil_sim.simulation.sensors import sense
from runtime.core.types import Pose
from runtime.errors import RfNavError

READY_S = 300.0


@dataclass(frozen=True)
class Glance:
    """What is to be looked at: a pose (scene frame) at a frame's number, while the base turns."""

    number: int
    pose: Pose
    turning_radps: float
    bodies: tuple[Body, ...] = ()


@dataclass(frozen=True)
class Shot:
    """What the camera gives, and the truth: `rgb` (H, W, 3) and `depth_m` (H, W) with the
    protocol's noise; `true_depth_m` and `segmentation` (H, W) without."""

    rgb: NDArray[np.uint8]
    depth_m: NDArray[np.float32]
    true_depth_m: NDArray[np.float32]
    segmentation: NDArray[np.int32]


class CameraProcess:
    """One glance at a time: `look`, then `seen` until it returns something."""

    def __init__(
        self, scene: Scene, protocol: Protocol, episode: str, seed: int, renderer: str = "auto"
    ) -> None:
        spawn = multiprocessing.get_context("spawn")
        self._pipe, theirs = spawn.Pipe()
        arguments = (theirs, scene, protocol, episode, seed, renderer)
        self._process = spawn.Process(target=_serve, args=arguments, daemon=True)
        self._process.start()
        theirs.close()
        self.busy = False

    def __enter__(self) -> Self:
        try:
            if not self._pipe.poll(READY_S):
                raise HarnessError(f"camera: not ready in {READY_S:g} s")
            self._receive()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the process."""
        self._pipe.close()
        self._process.terminate()
        self._process.join(5.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()

    def look(self, glance: Glance) -> None:
        """Begin to render; only when not `busy`."""
        self._pipe.send(glance)
        self.busy = True

    def seen(self) -> Shot | None:
        """What was looked at, once it is there."""
        if not self._pipe.poll():
            return None
        self.busy = False
        sight: Shot = self._receive()
        return sight

    def _receive(self) -> Any:
        try:
            value = self._pipe.recv()
        except (EOFError, OSError):
            raise HarnessError("camera: its process ended") from None
        if isinstance(value, str):
            raise HarnessError(value)
        return value


def _serve(
    pipe: Connection, scene: Scene, protocol: Protocol, episode: str, seed: int, renderer: str
) -> None:
    """The process's main function."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's business
    keep_stdout_for_python()
    try:
        with hushed():
            from hil_sim.scenes.furniture.assets import Assets
            from hil_sim.simulation.scene_physics import ScenePhysics

            world = ScenePhysics(scene, Assets(), renderer)
    except RfNavError as error:
        pipe.send(f"camera: {error}")
        return
    p = protocol
    camera = CameraModel(p.width, p.height, p.hfov_rad, p.camera_z_m)
    with world:
        pipe.send(None)
        while True:
            try:
                glance: Glance = pipe.recv()
            except EOFError:
                return
            at = glance.pose
            world.populate(glance.bodies)
            frame = world.render(at.x_m, at.y_m, at.yaw_rad, camera, p.tilt_rad)
            rng = generator(seed, episode, glance.number, "camera")
            rgb, depth_m = sense(frame, scene, p, glance.turning_radps, rng)
            pipe.send(Shot(rgb, depth_m, frame.depth_m, frame.segmentation))
