"""People, legs, boxes and closed doors in PyBullet: made when first needed, else out of sight."""

import math
from pathlib import Path

import cv2
import numpy as np
import pybullet

from hil_sim.scenes.colours import rgb_of
from hil_sim.scenes.furniture.shapes.primitives import ball, box, cylinder
from hil_sim.scenes.furniture.soup import Soup
from hil_sim.simulation.body import Body
from hil_sim.simulation.raster import Raster
from hil_sim.simulation.shell import Surface

HIDDEN_M = -40.0
SKIN, SHIRT, TROUSERS, DOOR = "#c79a7b", "#3f6d8e", "#3a3f4b", "#b08a5c"
HEAD_RADIUS_M = 0.11

Part = tuple[int, float]  # body id, height of its middle
Key = tuple[str, tuple[float, float, float]]  # kind and size


class Visitors:
    """The bodies of one PyBullet client that come and go. They are seen by the camera and by the
    laser; what stops the robot is `Body.distance_m`."""

    def __init__(self, client: int) -> None:
        self._client = client
        self._parts: dict[Key, list[Part]] = {}
        self.present: tuple[Body, ...] = ()

    def set(self, bodies: tuple[Body, ...]) -> None:
        """Show these and no others. Two of one kind and size cannot be shown at once."""
        placed: dict[Key, Body] = {(body.kind, body.size_m): body for body in bodies}
        for key, body in placed.items():
            if key not in self._parts:
                self._parts[key] = self._made(body)
        for key, parts in self._parts.items():
            there = placed.get(key)
            for id, z in parts:
                x, y, yaw = (there.x_m, there.y_m, there.yaw_rad) if there else (0.0, 0.0, 0.0)
                pybullet.resetBasePositionAndOrientation(
                    id,
                    (x, y, z if there else HIDDEN_M),
                    (0, 0, math.sin(yaw / 2), math.cos(yaw / 2)),
                    physicsClientId=self._client,
                )
        self.present = bodies

    def _made(self, body: Body) -> list[Part]:
        width, depth, height = body.size_m
        if body.kind in ("door", "box"):
            half = (width / 2, depth / 2, height / 2)
            return [self._part(DOOR, height / 2, pybullet.GEOM_BOX, halfExtents=half)]
        r, legs = width / 2, 0.45 * height
        chest = height - 2 * HEAD_RADIUS_M - legs
        cylinder = pybullet.GEOM_CYLINDER
        if body.kind == "leg":
            return [self._part(DOOR, height / 2, cylinder, radius=r, length=height)]
        return [
            self._part(TROUSERS, legs / 2, cylinder, radius=0.75 * r, length=legs),
            self._part(SHIRT, legs + chest / 2, cylinder, radius=r, length=chest),
            self._part(SKIN, height - HEAD_RADIUS_M, pybullet.GEOM_SPHERE, radius=HEAD_RADIUS_M),
        ]

    def _part(self, colour: str, z_m: float, shape: int, **size: object) -> Part:
        client = self._client
        visual = pybullet.createVisualShape(
            shape, rgbaColor=(*rgb_of(colour), 1.0), physicsClientId=client, **size
        )
        if "length" in size:  # the same thing by another name
            size["height"] = size.pop("length")
        solid = pybullet.createCollisionShape(shape, physicsClientId=client, **size)
        body: int = pybullet.createMultiBody(
            0, solid, visual, (0, 0, HIDDEN_M), physicsClientId=client
        )
        return body, z_m


class DrawnVisitors:
    """The same bodies in the picture."""

    def __init__(self, raster: Raster, scratch: Path) -> None:
        self._raster, self._scratch = raster, scratch
        self._parts: dict[Key, list[int]] = {}

    def show(self, bodies: tuple[Body, ...]) -> None:
        """Draw these and no others."""
        placed: dict[Key, Body] = {(body.kind, body.size_m): body for body in bodies}
        for key, body in placed.items():
            if key not in self._parts:
                self._parts[key] = [self._add(soup) for soup in _soups(body)]
        for key, numbers in self._parts.items():
            there = placed.get(key)
            for number in numbers:
                if there is None:
                    self._raster.place(number, (0.0, 0.0, HIDDEN_M), 0.0)
                else:
                    self._raster.place(number, (there.x_m, there.y_m, 0.0), there.yaw_rad)

    def _add(self, soup: Soup) -> int:
        path = self._scratch / f"visitor{len(list(self._scratch.glob('visitor*.obj')))}.obj"
        texture = path.with_suffix(".png")
        bgr = [round(255 * c) for c in soup.material.colour[::-1]]
        cv2.imwrite(str(texture), np.full((4, 4, 3), bgr, np.uint8))
        Surface(soup.corners, soup.uv).write(path, texture)
        return self._raster.add(path)


def _soups(body: Body) -> list[Soup]:
    if body.kind in ("door", "box"):
        return [box(body.size_m, (0.0, 0.0, 0.0), rgb_of(DOOR))]
    r, height = body.size_m[0] / 2, body.size_m[2]
    if body.kind == "leg":
        return [cylinder(r, r, height, rgb_of(DOOR))]
    legs, head = 0.45 * height, 2 * HEAD_RADIUS_M
    neck = height - head
    return [
        cylinder(0.75 * r, 0.75 * r, legs, rgb_of(TROUSERS)),
        cylinder(r, r, neck - legs, rgb_of(SHIRT), at=(0, 0, legs)),
        ball((head, head, head), (0, 0, neck), rgb_of(SKIN)),
    ]
