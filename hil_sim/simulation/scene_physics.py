"""A scene in PyBullet: what the camera sees of it, and what stops the robot."""

import math
import shutil
import tempfile
from pathlib import Path
from typing import Self

import numpy as np
import pybullet
from numpy.typing import NDArray

from hil_sim.scenes.colours import rgb_of
from hil_sim.scenes.format import Scene, SceneObject
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.furniture.meshes import Mesh
from hil_sim.scenes.furniture.obj import read_geometry
from hil_sim.scenes.scene_file import check_meshes
from hil_sim.simulation.body import Body
from hil_sim.simulation.camera import HM3D_CAMERA, Appearance, CameraModel, Frame, Light
from hil_sim.simulation.flooring import Flooring
from hil_sim.simulation.raster import Raster, RasterError
from hil_sim.simulation.sensors import BEAMS, LASER_M, LASER_Z_M
from hil_sim.simulation.shell import ceiling, wall_pieces, walls
from hil_sim.simulation.software_renderer import draw_software
from hil_sim.simulation.visitors import HIDDEN_M, DrawnVisitors, Visitors
from runtime.core.types import Pose
from runtime.errors import RfNavError

BODY_RADIUS_M, BODY_HEIGHT_M = 0.18, 0.88
BODY_CLEARANCE_M = 0.03
"""Of the body's underside: floor coverings do not stop it."""
SWEEP_M = 0.025


class WorldError(RfNavError):
    """A scene that cannot be drawn on this machine as asked."""


class ScenePhysics:
    """One scene: PyBullet for what stops the robot, OpenGL through EGL for what it sees, or
    PyBullet's software renderer ("tiny") where there is no EGL."""

    def __init__(
        self,
        scene: Scene,
        assets: Assets,
        renderer: str = "auto",
        appearance: Appearance | None = None,
    ) -> None:
        label = str(scene.source) if scene.source else None
        check_meshes(scene, assets.known(obj.mesh for obj in scene.objects), label)
        self.scene, self._assets = scene, assets
        self._appearance = appearance or Appearance()
        self._client = pybullet.connect(pybullet.DIRECT)
        self._scratch = Path(tempfile.mkdtemp(prefix="rf-nav-world-"))
        self._raster: Raster | None = None
        self._visitors = Visitors(self._client)
        self._owner = np.full(0, -1, np.int32)  # body id -> index into scene.objects
        self._solid: set[int] = set()
        try:
            self.renderer = self._start_renderer(renderer)
            self._build()
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the client. Idempotent."""
        if self._client >= 0:
            if self._raster is not None:
                self._raster.close()
            pybullet.disconnect(self._client)
            self._client = -1
        shutil.rmtree(self._scratch, ignore_errors=True)

    # -- what the camera sees ------------------------------------------------------------------

    def render(
        self,
        x_m: float,
        y_m: float,
        yaw_rad: float,
        camera: CameraModel = HM3D_CAMERA,
        pitch_rad: float = 0.0,
        light: Light | None = None,
        colour: bool = True,
    ) -> Frame:
        """The view from a pose of the base, scene frame; positive pitch looks down. Without
        `colour` the picture may be black, and is quicker to draw."""
        light = light or self._appearance.light
        eye = (x_m, y_m, camera.z_m)
        if self._raster is not None:
            sun = light.direction, light.colour, light.ambient, light.diffuse
            size = camera.width, camera.height
            return Frame(
                *self._raster.draw(eye, yaw_rad, pitch_rad, size, camera.hfov_rad, sun, colour)
            )
        rgb, metres, bodies = draw_software(self._client, eye, yaw_rad, pitch_rad, camera, light)
        bodies[bodies >= len(self._owner)] = -1  # a visitor
        owner = np.r_[self._owner, np.int32(-1)]  # index -1: no body
        return Frame(rgb, metres, owner[bodies])

    # -- what stops the robot ------------------------------------------------------------------

    def collides(self, x_m: float, y_m: float) -> bool:
        """Whether the body, standing there, touches a wall or a piece of furniture."""
        height = BODY_HEIGHT_M - BODY_CLEARANCE_M
        z = BODY_CLEARANCE_M + height / 2
        client = self._client
        pybullet.resetBasePositionAndOrientation(
            self._robot, (x_m, y_m, z), (0, 0, 0, 1), physicsClientId=client
        )
        r = BODY_RADIUS_M
        if any(body.distance_m(x_m, y_m) <= BODY_RADIUS_M for body in self._visitors.present):
            return True
        near = pybullet.getOverlappingObjects(
            (x_m - r, y_m - r, BODY_CLEARANCE_M), (x_m + r, y_m + r, BODY_HEIGHT_M), client
        )
        return any(
            pybullet.getClosestPoints(self._robot, body, 0.0, physicsClientId=client)
            for body in sorted({body for body, _ in near or ()} & self._solid)
        )

    def move(
        self, x_m: float, y_m: float, yaw_rad: float, distance_m: float
    ) -> tuple[float, float, bool]:
        """Sweep the body straight ahead, or back; it stops before the first contact and does not
        slide. Returns where it ends and whether something was hit."""
        steps = max(1, math.ceil(abs(distance_m) / SWEEP_M))
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        x, y = x_m, y_m
        for n in range(1, steps + 1):
            d = distance_m * n / steps
            ahead = x_m + d * c, y_m + d * s
            if self.collides(*ahead):
                return x, y, True
            x, y = ahead
        return x, y, False

    def falls(self, x_m: float, y_m: float) -> bool:
        """Whether the robot, standing there, has left the floor."""
        return self.flooring.falls(x_m, y_m)

    def scan(self, pose: Pose) -> NDArray[np.float32]:
        """(BEAMS,) m: a level laser scan around the base from straight behind it,
        counter-clockwise; inf where nothing is in range."""
        near, far = LASER_M
        angles = pose.yaw_rad - math.pi + np.arange(BEAMS) * math.tau / BEAMS
        rays = np.stack([np.cos(angles), np.sin(angles), np.zeros(BEAMS)], axis=1)
        origin = np.array([pose.x_m, pose.y_m, LASER_Z_M])
        pybullet.resetBasePositionAndOrientation(
            self._robot, (0, 0, -5), (0, 0, 0, 1), physicsClientId=self._client
        )
        hits = pybullet.rayTestBatch(
            (origin + near * rays).tolist(),
            (origin + far * rays).tolist(),
            physicsClientId=self._client,
        )
        ranges = np.array([near + hit[2] * (far - near) for hit in hits], np.float32)
        return np.where(ranges < far, ranges, np.float32(np.inf))

    def populate(self, bodies: tuple[Body, ...]) -> None:
        """Have these people, closed doors and openings in the home, and no others."""
        self.flooring.open(bodies)
        standing = tuple(body for body in bodies if body.kind != "opening")
        self._visitors.set(standing)
        if self._raster is not None:
            self._drawn.show(standing)

    def obstacle_triangles(self) -> NDArray[np.float64]:
        """(N, 3, 3) m in the scene frame: furniture and walls, whatever their height."""
        pieces = [p.triangles for p in wall_pieces(self.scene)]
        for obj in self.scene.objects:
            mesh, scale = self._mesh(obj)
            if mesh.size_m[2] * scale[2] + obj.position_m[2] <= 2 * BODY_CLEARANCE_M:
                continue  # a floor covering
            c, s = math.cos(obj.yaw_rad), math.sin(obj.yaw_rad)
            turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
            for part in mesh.parts:
                corners = read_geometry(part.obj).triangles * scale
                pieces.append(corners @ turn.T + np.array(obj.position_m))
        return np.concatenate(pieces)

    # -- building ------------------------------------------------------------------------------

    def _start_renderer(self, wanted: str) -> str:
        if wanted not in ("auto", "egl", "tiny"):
            raise WorldError(f"renderer: {wanted}: must be auto, egl or tiny")
        if wanted == "tiny":
            return "tiny"
        try:
            self._raster = Raster()
            self._drawn = DrawnVisitors(self._raster, self._scratch)
        except RasterError as error:
            if wanted == "egl":
                raise WorldError(f"renderer: egl: {error}; use tiny") from error
            return "tiny"
        return "egl"

    def _build(self) -> None:
        for index, obj in enumerate(self.scene.objects):
            self._place(index, obj)
        for n, (surface, texture) in enumerate(
            (*walls(self.scene, self._scratch), ceiling(self.scene, self._scratch))
        ):
            path = self._scratch / f"shell{n}.obj"
            surface.write(path, texture)
            self._draw(path)
        self.flooring = Flooring(self.scene, self._scratch, self._draw, self._hide)
        # A body without a visual shape is drawn as its collision shape: give it one out of sight.
        unseen = pybullet.createVisualShape(
            pybullet.GEOM_SPHERE,
            radius=1e-3,
            visualFramePosition=(0, 0, -50),
            physicsClientId=self._client,
        )
        for piece in wall_pieces(self.scene):
            shape = pybullet.createCollisionShape(
                pybullet.GEOM_BOX, halfExtents=piece.half_m, physicsClientId=self._client
            )
            self._solid.add(self._body(unseen, shape, piece.centre_m, piece.yaw_rad))
        height = BODY_HEIGHT_M - BODY_CLEARANCE_M
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_CYLINDER,
            radius=BODY_RADIUS_M,
            height=height,
            physicsClientId=self._client,
        )
        self._robot = self._body(unseen, shape, (0, 0, -5), 0.0)

    def _draw(self, path: Path) -> int:
        """Something that is seen and stops nobody; its number."""
        if self._raster is not None:
            return self._raster.add(path)
        return self._body(self._visual(path, (1, 1, 1)), -1, (0, 0, 0), 0.0)

    def _hide(self, number: int) -> None:
        if self._raster is not None:
            self._raster.place(number, (0.0, 0.0, HIDDEN_M), 0.0)
            return
        pybullet.resetBasePositionAndOrientation(
            number, (0, 0, HIDDEN_M), (0, 0, 0, 1), physicsClientId=self._client
        )

    def _place(self, index: int, obj: SceneObject) -> None:
        mesh, scale = self._mesh(obj)
        top = obj.position_m[2] + mesh.size_m[2] * scale[2]
        solid = top > 2 * BODY_CLEARANCE_M and obj.position_m[2] < BODY_HEIGHT_M
        tint = rgb_of(obj.tint) if obj.tint else (1.0, 1.0, 1.0)
        paint = rgb_of(obj.paint) if obj.paint else None
        for part in mesh.parts:
            shape = -1
            if solid:
                shape = pybullet.createCollisionShape(
                    pybullet.GEOM_MESH,
                    fileName=str(part.obj),
                    meshScale=scale,
                    flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
                    physicsClientId=self._client,
                )
            visual = -1
            if self._raster is not None:
                pose = obj.position_m, obj.yaw_rad
                self._raster.add(part.obj, *pose, scale, tint, index, paint)
                if not solid:
                    continue
            else:
                visual = self._visual(self._alias(part.obj, scale), paint or tint, scale)
            body = self._body(visual, shape, obj.position_m, obj.yaw_rad)
            self._owner[body] = index
            if solid:
                self._solid.add(body)

    def _mesh(self, obj: SceneObject) -> tuple[Mesh, tuple[float, float, float]]:
        base = self.scene.source.parent if self.scene.source else None
        mesh = self._assets.mesh(obj.mesh, base)
        wanted = obj.size_m or mesh.size_m
        sx, sy, sz = (w / max(s, 1e-6) for w, s in zip(wanted, mesh.size_m, strict=True))
        return mesh, (sx, sy, sz)

    def _alias(self, obj: Path, scale: tuple[float, float, float]) -> Path:
        """A path of its own for each size of a mesh: PyBullet keeps what it drew by file name."""
        name = "_".join((obj.parent.name, *(f"{s:.6f}" for s in scale)))
        folder = self._scratch / name
        if not folder.exists():
            folder.symlink_to(obj.parent.resolve(), target_is_directory=True)
        return folder / obj.name

    def _visual(
        self,
        path: Path,
        rgb: tuple[float, float, float],
        scale: tuple[float, float, float] = (1.0, 1.0, 1.0),
    ) -> int:
        visual: int = pybullet.createVisualShape(
            pybullet.GEOM_MESH,
            fileName=str(path),
            meshScale=scale,
            rgbaColor=(*rgb, 1.0),
            specularColor=(0.1, 0.1, 0.1),
            physicsClientId=self._client,
        )
        return visual

    def _body(
        self,
        visual: int,
        shape: int,
        position: tuple[float, float, float],
        yaw_rad: float,
    ) -> int:
        body: int = pybullet.createMultiBody(
            0,
            shape,
            visual,
            position,
            (0, 0, math.sin(yaw_rad / 2), math.cos(yaw_rad / 2)),
            physicsClientId=self._client,
        )
        grown = body + 1 - len(self._owner)
        self._owner = np.concatenate([self._owner, np.full(grown, -1, np.int32)])
        return body
