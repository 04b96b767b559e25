"""People and closed doors in PyBullet: made when first needed, out of sight when not."""

import math

import pybullet

from hil_sim.body import Body

HIDDEN_M = -40.0
SKIN, SHIRT, TROUSERS, DOOR = "#c79a7b", "#3f6d8e", "#3a3f4b", "#b08a5c"
HEAD_RADIUS_M = 0.11

Part = tuple[int, float]  # body id, height of its middle


class Visitors:
    """The bodies of one PyBullet client that come and go. They are seen by the camera and by the
    laser; what stops the robot is `Body.distance_m`."""

    def __init__(self, client: int) -> None:
        self._client = client
        self._parts: dict[tuple[str, tuple[float, float, float]], list[Part]] = {}
        self.present: tuple[Body, ...] = ()

    def set(self, bodies: tuple[Body, ...]) -> None:
        """Show these and no others. Two of one kind and size cannot be shown at once."""
        placed = {(body.kind, body.size_m): body for body in bodies}
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
        if body.kind == "door":
            half = (width / 2, depth / 2, height / 2)
            return [self._part(DOOR, height / 2, pybullet.GEOM_BOX, halfExtents=half)]
        r, legs = width / 2, 0.45 * height
        chest = height - 2 * HEAD_RADIUS_M - legs
        cylinder = pybullet.GEOM_CYLINDER
        return [
            self._part(TROUSERS, legs / 2, cylinder, radius=0.75 * r, length=legs),
            self._part(SHIRT, legs + chest / 2, cylinder, radius=r, length=chest),
            self._part(SKIN, height - HEAD_RADIUS_M, pybullet.GEOM_SPHERE, radius=HEAD_RADIUS_M),
        ]

    def _part(self, colour: str, z_m: float, shape: int, **size: object) -> Part:
        rgb = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        client = self._client
        visual = pybullet.createVisualShape(
            shape, rgbaColor=(*rgb, 1.0), physicsClientId=client, **size
        )
        if "length" in size:  # the same thing by another name
            size["height"] = size.pop("length")
        solid = pybullet.createCollisionShape(shape, physicsClientId=client, **size)
        body: int = pybullet.createMultiBody(
            0, solid, visual, (0, 0, HIDDEN_M), physicsClientId=client
        )
        return body, z_m
