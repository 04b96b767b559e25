"""Placing furniture: against walls facing inward, beside and on top of other things.

A placement is refused when it would cut into something, block a door, leave its room, or
cut the home's floor in two for the robot.
"""

import copy
import itertools
import math
import random
from dataclasses import dataclass, replace

from hil_sim.scenes.colours import hex_colour
from hil_sim.scenes.format import SceneObject
from hil_sim.scenes.furniture.boxes import (
    Box,
    CatalogMesh,
    box_of,
    furniture,
    gap,
    hits,
)
from hil_sim.scenes.generated.floorplan import (
    INNER_M,
    OUTER_M,
    FloorPlan,
    PlanRoom,
    Rect,
    on_line,
    polygon_of,
    shared,
)
from hil_sim.scenes.generated.passage import Floor, Left, door_zone, empty_floor, passage_zone

SIDES = ("south", "east", "north", "west")
YAW = {"south": math.pi, "east": -math.pi / 2, "north": 0.0, "west": math.pi / 2}
"""Yaw of an object whose back is to that wall (its front is local -y)."""
PASSABLE_M = 0.03
"""What is no higher than this is driven over."""
BODY_M = 0.9
OWN, STRETCH, PAINTED = 0.5, (0.85, 1.18), 0.4
"""Of a varied home: how often it uses a mesh of its own, by what a side of its furniture is longer,
how often that is painted over."""
HELD_OUT = 0.5
"""How often a val home uses a mesh kept out of train homes, where there is one."""
TINTED = frozenset(
    ("bed", "sofa", "chair", "armchair", "table", "coffee table", "desk", "wardrobe", "bookcase",
     "cabinet", "nightstand", "dresser", "lamp", "stool", "trash can", "vase", "radiator", "piano",
     "other", "pillow", "towel", "bowl", "mug", "book")
)  # fmt: skip
"""What comes in any colour."""
PAINTABLE = TINTED | frozenset(
    ("backpack", "box", "bucket", "cup", "curtain", "kettle", "laundry basket", "ottoman", "plate",
     "rug", "shelving unit", "side table", "stove", "toilet", "tv stand")
)  # fmt: skip
"""What a varied home may paint over."""


@dataclass(frozen=True)
class Spot:
    """A place that is free: the box, what stays clear in front, and the floor left."""

    box: Box
    front: Box | None = None
    floor: Left | None = None


class Furnisher:
    """A home being furnished: what stands where, and whether the floor still connects."""

    def __init__(
        self, rng: random.Random, plan: FloorPlan, split: str = "train", high_m: float = 2.4,
        varied: bool = False,
    ) -> None:  # fmt: skip
        self.rng, self.split, self.high_m, self.varied = rng, split, high_m, varied
        self.objects: list[SceneObject] = []
        self.names: dict[str, str] = {}
        """What an object was placed as ("counter", "tv stand", ...), by id."""
        self.home = plan.bounds
        self._door_zones = [door_zone(door) for door in plan.doors]
        for room in plan.rooms:
            for a, b in itertools.combinations(room.rects, 2):
                if line := shared(a, b, 0.0):
                    axis, at, low, end = line
                    self._door_zones.append(
                        passage_zone(on_line(axis, at, low), on_line(axis, at, end))
                    )
        polygons = [polygon_of(room) for room in plan.rooms]
        high = (self.home.x1, self.home.y1)
        self._floor = Floor(empty_floor(polygons, plan.walls, plan.doors, high), plan.doors)
        self.enter(plan.rooms[0])

    def enter(self, room: PlanRoom) -> None:
        """Furnish this room from now on; `self.room` is its floor between the wall faces."""
        home, rect = self.home, max(room.rects, key=lambda rect: rect.area)

        def half(side: float, outer: float) -> float:
            return (OUTER_M if side == outer else INNER_M) / 2

        self.room = Rect(
            rect.x0 + half(rect.x0, home.x0),
            rect.y0 + half(rect.y0, home.y0),
            rect.x1 - half(rect.x1, home.x1),
            rect.y1 - half(rect.y1, home.y1),
        )
        floor = Box(*self._middle(), self.room.width, self.room.depth, 0.0, 0.0, 9.0)
        self._ways = [zone for zone in self._door_zones if zone.overlaps(floor)]
        self._before = (len(self.objects), copy.copy(self._floor))
        self.here: list[SceneObject] = []
        self._boxes: list[Box] = []
        self.box: dict[str, Box] = {}
        self._fronts: list[Box] = []

    def clear(self) -> None:
        """Take away what was placed since this room was entered."""
        count, self._floor = self._before
        del self.objects[count:]

    def pick(
        self, category: str, only: tuple[str, ...] = (), longest: float = 9.0
    ) -> CatalogMesh | None:
        """A random mesh of the category for this split, its size varied by up to 10 %; in a varied
        home each side by up to a quarter."""
        meshes = [m for m in furniture().get(category, ()) if not only or m.id in only]
        held_out = [m for m in meshes if m.split == "val"]
        if self.split == "val" and held_out and self.rng.random() < HELD_OUT:
            meshes = held_out
        else:
            own = [m for m in meshes if m.split == "varied"]
            meshes = [m for m in meshes if m.split == "train"]
            if self.varied and own and self.rng.random() < OWN:
                meshes = own
        if not meshes:
            return None
        fitting = [m for m in meshes if max(m.size_m[:2]) <= longest]
        mesh = self.rng.choice(fitting or sorted(meshes, key=lambda m: max(m.size_m[:2]))[:1])
        scale = self.rng.uniform(0.92, 1.08)
        stretch = STRETCH if self.varied else (0.97, 1.03)
        w, d, h = (round(side * scale * self.rng.uniform(*stretch), 3) for side in mesh.size_m)
        return replace(mesh, size_m=(w, d, h))

    def spot(
        self, mesh: CatalogMesh, x: float, y: float, yaw: float, z: float | None = None,
        front_m: float = 0.0, under: Box | None = None,
    ) -> Spot | None:  # fmt: skip
        """The place as a Spot if nothing is in the way; `front_m` must be clear in front of it.

        `under`: the box of a thing it may lie in, as a pillow does in a sofa's.
        """
        z = mesh.z_m if z is None else z
        w, d, h = mesh.size_m
        box = Box(round(x, 4), round(y, 4), w, d, round(yaw, 4), round(z, 4), round(z, 4) + h)
        if not self._inside(box) or box.z1 > self.high_m:
            return None
        if h <= PASSABLE_M and z == 0.0:
            return Spot(box)
        if hits(box, (other for other in self._boxes if other is not under)):
            return None
        if (z < 0.3 and hits(box, self._fronts)) or (z < 2.1 and hits(box, self._ways)):
            return None
        front = _front(box, front_m) if front_m else None
        if front and (not self._inside(front) or hits(front, self._boxes)):
            return None
        if z >= BODY_M or under is not None:
            return Spot(box, front) if self._floor.reaches(box) else None
        floor = self._floor.without(box, self.room)
        return None if floor is None else Spot(box, front, floor)

    def take(self, mesh: CatalogMesh, spot: Spot | None, name: str = "") -> SceneObject | None:
        """Place the mesh there."""
        if spot is None:
            return None
        box = spot.box
        obj = SceneObject(
            id=f"{mesh.category.replace(' ', '-')}-{len(self.objects)}",
            category=mesh.category,
            mesh=mesh.id,
            position_m=(box.x, box.y, box.z0),
            yaw_rad=box.yaw,
            size_m=mesh.size_m,
            tint=self._tint(mesh),
            paint=self._paint(mesh) if self.varied else None,
        )
        if box.z1 > PASSABLE_M:
            self._boxes.append(box)
        self.box[obj.id] = box
        if spot.front:
            self._fronts.append(spot.front)
        if spot.floor is not None:
            self._floor.take(spot.floor)
        self.objects.append(obj)
        self.here.append(obj)
        self.names[obj.id] = name or mesh.category
        return obj

    def release(self, obj: SceneObject) -> None:
        """The space in front of it need no longer stay clear."""
        box = box_of(obj)
        self._fronts = [front for front in self._fronts if gap(front, box) > 0.02]

    def drop_unreachable(self) -> None:
        """Take away what later furniture has cut off, and what stands on it."""
        cut = [box_of(o) for o in self.objects if o.category != "other"]
        cut = [box for box in cut if not self._floor.reaches(box)]
        self.objects = [
            obj for obj in self.objects
            if not any(box.holds(*obj.position_m[:2]) and obj.position_m[2] >= box.z0 - 1e-6
                       for box in cut)
        ]  # fmt: skip

    def named(self, name: str) -> list[SceneObject]:
        """What stands in this room under that name."""
        return [obj for obj in self.here if self.names[obj.id] == name]

    def wall_length(self, side: str) -> float:
        return self.room.width if side in ("south", "north") else self.room.depth

    def wall_point(self, side: str, along: float, out: float) -> tuple[float, float]:
        """The point `along` the wall from its middle and `out` from its face."""
        r = self.room
        mx, my = self._middle()
        return {
            "south": (mx + along, r.y0 + out),
            "north": (mx + along, r.y1 - out),
            "west": (r.x0 + out, my + along),
            "east": (r.x1 - out, my + along),
        }[side]

    def inward(self, x: float, y: float) -> float:
        """The yaw of what stands there and faces the middle of the room."""
        mx, my = self._middle()
        return math.atan2(mx - x, y - my)

    def _middle(self) -> tuple[float, float]:
        return (self.room.x0 + self.room.x1) / 2, (self.room.y0 + self.room.y1) / 2

    def keep_clear(self, a: tuple[float, float], b: tuple[float, float], wide_m: float) -> None:
        """Nothing more may stand on the floor between the two points."""
        yaw = math.atan2(b[1] - a[1], b[0] - a[0])
        middle = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
        self._fronts.append(Box(*middle, math.dist(a, b), wide_m, yaw, 0.0, 1.0))

    def _inside(self, box: Box) -> bool:
        (x0, y0, x1, y1), r = box.span, self.room
        return x0 >= r.x0 and y0 >= r.y0 and x1 <= r.x1 and y1 <= r.y1

    def _tint(self, mesh: CatalogMesh) -> str | None:
        if self.rng.random() < 0.6 or mesh.category not in TINTED or mesh.id.startswith("builtin:"):
            return None
        strong = self.rng.random() < 0.4
        saturation = self.rng.uniform(0.25, 0.75) if strong else self.rng.uniform(0.0, 0.25)
        return hex_colour(self.rng.random(), saturation, self.rng.uniform(0.6, 1.0))

    def _paint(self, mesh: CatalogMesh) -> str | None:
        if mesh.category not in PAINTABLE or self.rng.random() >= PAINTED:
            return None
        strong = self.rng.random() < 0.3
        hue = self.rng.random() if strong else self.rng.gauss(0.09, 0.03) % 1.0  # of wood and cloth
        saturation = self.rng.uniform(0.3, 0.9) if strong else self.rng.uniform(0.0, 0.5)
        return hex_colour(hue, saturation, self.rng.uniform(0.15, 1.0))


def _front(box: Box, depth: float) -> Box:
    out = (box.depth + depth) / 2 + 0.01
    x, y = box.x + math.sin(box.yaw) * out, box.y - math.cos(box.yaw) * out
    return Box(x, y, box.width * 0.9, depth, box.yaw, 0.0, 0.8)
