"""Placing furniture: against walls facing inward, around tables, on top of things.

A placement is refused when it would cut into something, block a door, leave its room, or
cut the home's floor in two for the robot.
"""

import colorsys
import functools
import json
import math
import random
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.floorplan import INNER_M, OUTER_M, Plan, Rect
from hil_sim.scene import SceneObject

CELL_M = 0.05
ROBOT_M = 0.22
"""Inflation for the passage check: body radius 0.18 m and a margin."""
DOOR_ZONE_M = 0.75
SIDES = ("south", "east", "north", "west")
YAW = {"south": math.pi, "east": -math.pi / 2, "north": 0.0, "west": math.pi / 2}
"""Yaw of an object whose back is to that wall (its front is local -y)."""


@dataclass(frozen=True)
class Mesh:
    """A mesh with its natural size (width, depth, height) and height above the floor."""

    id: str
    size_m: tuple[float, float, float]
    z_m: float = 0.0
    top: bool = False
    split: str = "train"


@dataclass(frozen=True)
class Box:
    """An upright box: footprint centre, width, depth, yaw, and its span in z. Metres."""

    x: float
    y: float
    width: float
    depth: float
    yaw: float
    z0: float
    z1: float

    def corners(self, grow: float = 0.0) -> NDArray[np.float64]:
        """(4, 2) corners of the footprint, grown by `grow` on each side."""
        w, d = self.width / 2 + grow, self.depth / 2 + grow
        local = np.array([[-w, -d], [w, -d], [w, d], [-w, d]])
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        turned: NDArray[np.float64] = local @ np.array([[c, s], [-s, c]]) + (self.x, self.y)
        return turned

    def overlaps(self, other: "Box", slack: float = 0.005) -> bool:
        """Whether the boxes cut into each other by more than `slack` (separating axes)."""
        if self.z0 >= other.z1 - slack or other.z0 >= self.z1 - slack:
            return False
        reach = math.hypot(self.width, self.depth) + math.hypot(other.width, other.depth)
        if abs(self.x - other.x) + abs(self.y - other.y) > reach:
            return False
        a, b = self.corners(), other.corners()
        for yaw in (self.yaw, other.yaw):
            for axis in ((math.cos(yaw), math.sin(yaw)), (-math.sin(yaw), math.cos(yaw))):
                pa, pb = a @ axis, b @ axis
                if pa.max() <= pb.min() + slack or pb.max() <= pa.min() + slack:
                    return False
        return True


def box_of(obj: SceneObject) -> Box:
    """The box of an object whose size is given."""
    assert obj.size_m is not None
    (x, y, z), (w, d, h) = obj.position_m, obj.size_m
    return Box(x, y, w, d, obj.yaw_rad, z, z + h)


@functools.cache
def furniture() -> dict[str, tuple[Mesh, ...]]:
    """Meshes by category, from furniture.json."""
    rows = json.loads((Path(__file__).parent / "furniture.json").read_text(encoding="utf-8"))
    return {
        category: tuple(
            Mesh(name, tuple(r["size_m"]), r.get("z_m", 0.0), "top" in r, r.get("split", "train"))
            for name, r in meshes.items()
        )
        for category, meshes in rows.items()
    }


class Furnisher:
    """A home being furnished: what stands where, and whether the floor still connects."""

    def __init__(self, rng: random.Random, plan: Plan, split: str = "train") -> None:
        self.rng, self.plan, self.split = rng, plan, split
        self.objects: list[SceneObject] = []
        self.boxes: list[Box] = []
        self.zones: list[Box] = [_door_zone(door.start, door.end) for door in plan.doors]
        self.door_zones = len(self.zones)
        self.home = Rect(
            min(r.x0 for _, r in plan.rooms),
            min(r.y0 for _, r in plan.rooms),
            max(r.x1 for _, r in plan.rooms),
            max(r.y1 for _, r in plan.rooms),
        )
        self.free, self.cut_off = self._empty_floor(), 0
        self.room = plan.rooms[0][1]

    def enter(self, room: Rect) -> None:
        """Furnish this room from now on; `self.room` is its floor between the wall faces."""
        home = self.home

        def half(side: float, outer: float) -> float:
            return (OUTER_M if side == outer else INNER_M) / 2

        self.room = Rect(
            room.x0 + half(room.x0, home.x0),
            room.y0 + half(room.y0, home.y0),
            room.x1 - half(room.x1, home.x1),
            room.y1 - half(room.y1, home.y1),
        )

    def pick(self, category: str, only: tuple[str, ...] = (), longest: float = 9.0) -> Mesh:
        """A random mesh of the category for this split, its size varied by up to 10 %."""
        meshes = [m for m in furniture()[category] if not only or m.id in only]
        held_out = [m for m in meshes if m.split == "val"]
        if self.split == "val" and held_out and self.rng.random() < 0.5:
            meshes = held_out
        else:
            meshes = [m for m in meshes if m.split == "train"] or meshes
        fitting = [m for m in meshes if max(m.size_m[:2]) <= longest]
        mesh = self.rng.choice(fitting or sorted(meshes, key=lambda m: max(m.size_m[:2]))[:1])
        scale = self.rng.uniform(0.92, 1.08)
        w, d, h = (round(side * scale * self.rng.uniform(0.97, 1.03), 3) for side in mesh.size_m)
        return Mesh(mesh.id, (w, d, h), mesh.z_m, mesh.top, mesh.split)

    def put(
        self,
        category: str,
        mesh: Mesh,
        x: float,
        y: float,
        yaw: float,
        z: float | None = None,
        front_m: float = 0.0,
    ) -> SceneObject | None:
        """Place it if nothing is in the way. `front_m` is kept clear in front of it."""
        z = mesh.z_m if z is None else z
        w, d, h = mesh.size_m
        box = Box(x, y, w, d, yaw, z, z + h)
        if not self._inside(box) or any(box.overlaps(other) for other in self.boxes):
            return None
        if z < 0.3 and any(box.overlaps(zone) for zone in self.zones):
            return None
        if z < 2.1 and any(box.overlaps(zone) for zone in self.zones[: self.door_zones]):
            return None
        zone = _front_zone(box, front_m) if front_m else None
        if zone and (not self._inside(zone) or any(zone.overlaps(b) for b in self.boxes)):
            return None
        if z < 0.9 and h > 0.04 and not self._still_connected(box):
            return None
        self.boxes.append(box)
        if zone:
            self.zones.append(zone)
        obj = SceneObject(
            id=f"{category.replace(' ', '-')}-{len(self.objects)}",
            category=category,
            mesh=mesh.id,
            position_m=(round(x, 4), round(y, 4), round(z, 4)),
            yaw_rad=round(yaw, 4),
            size_m=mesh.size_m,
            tint=self._tint(category),
        )
        self.objects.append(obj)
        return obj

    def against_wall(
        self, category: str, mesh: Mesh | None = None, z: float | None = None,
        front_m: float = 0.0, side: str | None = None, corner: bool = False,
        yaw_jitter: float = 0.0,
    ) -> SceneObject | None:  # fmt: skip
        """Back to a wall, facing the room; tries several places."""
        mesh = mesh or self.pick(category)
        for _ in range(14):
            where = side or self.rng.choice(SIDES)
            length = self.wall_length(where)
            if mesh.size_m[0] > length:
                continue
            slack = (length - mesh.size_m[0]) / 2
            along = self.rng.uniform(-slack, slack)
            if corner:
                along = self.rng.choice([-1, 1]) * (slack - 0.01)
            gap = self.rng.uniform(0.005, 0.05) if z is None else 0.004
            yaw = YAW[where] + self.rng.uniform(-yaw_jitter, yaw_jitter)
            extra = abs(math.sin(yaw_jitter)) * mesh.size_m[0] / 2
            x, y = self.wall_point(where, along, mesh.size_m[1] / 2 + gap + extra)
            if obj := self.put(category, mesh, x, y, yaw, z, front_m):
                return obj
        return None

    def free_standing(
        self, category: str, mesh: Mesh | None = None, margin: float = 0.0, square: bool = False
    ) -> SceneObject | None:
        """Anywhere in the room, at least `margin` from its walls."""
        mesh = mesh or self.pick(category)
        room = self.room.inset(margin + min(mesh.size_m[:2]) / 2)
        if room.width <= 0 or room.depth <= 0:
            return None
        for _ in range(12):
            x, y = self.rng.uniform(room.x0, room.x1), self.rng.uniform(room.y0, room.y1)
            turns = self.rng.randrange(4) * math.pi / 2
            jitter = self.rng.gauss(0, 0.05) if square else self.rng.uniform(-0.8, 0.8)
            if obj := self.put(category, mesh, x, y, turns + jitter):
                return obj
        return None

    def on_top(
        self, category: str, support: SceneObject | None, mesh: Mesh | None = None,
        facing: bool = False,
    ) -> SceneObject | None:  # fmt: skip
        """On the top of a supporting object; `facing`: the same way as the support."""
        if support is None or support.size_m is None or not has_top(support):
            return None
        mesh = mesh or self.pick(category)
        (w, d, h), (mw, md, _) = support.size_m, mesh.size_m
        room_w, room_d = (w - mw) / 2 - 0.02, (d - md) / 2 - 0.01
        if room_w < 0 or room_d < 0:
            return None
        top = support.position_m[2] + h
        for _ in range(6):
            u, v = self.rng.uniform(-room_w, room_w), self.rng.uniform(-room_d, room_d)
            x, y = offset(support, u, v)
            turn = self.rng.gauss(0, 0.15) if facing else 0.0
            if not facing and max(mw, md) < min(w, d) - 0.1:
                turn = self.rng.uniform(-math.pi, math.pi)
                reach = math.hypot(mw, md) / 2
                if abs(u) > w / 2 - reach or abs(v) > d / 2 - reach:
                    continue
            if obj := self.put(category, mesh, x, y, support.yaw_rad + turn, top):
                return obj
        return None

    def beside(
        self, category: str, anchor: SceneObject, u: float, v: float, turn: float = 0.0,
        mesh: Mesh | None = None, z: float | None = None,
    ) -> SceneObject | None:  # fmt: skip
        """At (u, v) in the anchor's own axes, turned by `turn` from it."""
        x, y = offset(anchor, u, v)
        return self.put(category, mesh or self.pick(category), x, y, anchor.yaw_rad + turn, z)

    def seats(self, table: SceneObject, category: str, most: int) -> int:
        """Chairs around a table, facing it, pulled out by a random amount."""
        assert table.size_m is not None
        w, d, _ = table.size_m
        slots = [(u * w, s * d / 2, 0.0 if s > 0 else math.pi)
                 for s in (-1, 1) for u in ((-0.25, 0.25) if w > 1.15 else (0.0,))]  # fmt: skip
        slots += [(s * w / 2, 0.0, -s * math.pi / 2) for s in (-1, 1)]
        self.rng.shuffle(slots)
        mesh, placed = self.pick(category), 0
        for u, v, turn in slots:
            sideways = abs(turn) == math.pi / 2
            twist = self.rng.gauss(0, 0.12)
            out = mesh.size_m[1] / 2 + abs(twist) * mesh.size_m[0] / 2
            out += self.rng.uniform(0.02, 0.22)
            du, dv = (math.copysign(out, u), 0.0) if sideways else (0.0, math.copysign(out, v))
            if self.beside(category, table, u + du, v + dv, turn + twist, mesh):
                placed += 1
            if placed == most:
                break
        return placed

    def wall_length(self, side: str) -> float:
        return self.room.width if side in ("south", "north") else self.room.depth

    def wall_point(self, side: str, along: float, out: float) -> tuple[float, float]:
        """The point `along` the wall from its middle and `out` from its face."""
        r = self.room
        mx, my = (r.x0 + r.x1) / 2, (r.y0 + r.y1) / 2
        return {
            "south": (mx + along, r.y0 + out),
            "north": (mx + along, r.y1 - out),
            "west": (r.x0 + out, my + along),
            "east": (r.x1 - out, my + along),
        }[side]

    def _inside(self, box: Box) -> bool:
        corners, r = box.corners(), self.room
        low, high = corners.min(axis=0), corners.max(axis=0)
        return bool(low[0] >= r.x0 and low[1] >= r.y0 and high[0] <= r.x1 and high[1] <= r.y1)

    def _tint(self, category: str) -> str | None:
        if self.rng.random() < 0.6:
            return None
        strong = self.rng.random() < 0.4 and category not in ("plant", "television", "clock")
        saturation = self.rng.uniform(0.25, 0.75) if strong else self.rng.uniform(0.0, 0.25)
        return hex_colour(self.rng.random(), saturation, self.rng.uniform(0.6, 1.0))

    def _empty_floor(self) -> NDArray[np.uint8]:
        """(H, W) u8: 1 where the robot's centre fits between the walls of the empty home."""
        home = self.home
        shape = (math.ceil(home.depth / CELL_M), math.ceil(home.width / CELL_M))
        free = np.zeros(shape, np.uint8)
        for _, room in self.plan.rooms:
            self._fill(free, _rect_box(room.inset(INNER_M / 2 + ROBOT_M)).corners(), 1)
        for door in self.plan.doors:
            (x0, y0), (x1, y1) = door.start, door.end
            upright = abs(x1 - x0) < abs(y1 - y0)
            dx, dy = (0.5, -ROBOT_M) if upright else (-ROBOT_M, 0.5)
            gap = Rect(min(x0, x1) - dx, min(y0, y1) - dy, max(x0, x1) + dx, max(y0, y1) + dy)
            self._fill(free, _rect_box(gap).corners(), 1)
        return free

    def _fill(self, grid: NDArray[np.uint8], corners: NDArray[np.float64], value: int) -> None:
        cells = (corners - (self.home.x0, self.home.y0)) / CELL_M - 0.5
        cv2.fillConvexPoly(grid, np.round(cells).astype(np.int32), value)

    def _still_connected(self, box: Box) -> bool:
        trial = self.free.copy()
        self._fill(trial, box.corners(ROBOT_M), 0)
        _, labels, stats, _ = cv2.connectedComponentsWithStats(trial, connectivity=4)
        if len(stats) < 2:
            return False
        main = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
        cut_off = int(stats[1:, cv2.CC_STAT_AREA].sum() - stats[main, cv2.CC_STAT_AREA])
        pocket = (cut_off - self.cut_off) * CELL_M**2
        if pocket > 0.3 or not self._doors_open(labels == main):
            return False
        self.free, self.cut_off = trial, cut_off
        return True

    def _doors_open(self, main: NDArray[np.bool_]) -> bool:
        for door in self.plan.doors:
            x, y = (door.start[0] + door.end[0]) / 2, (door.start[1] + door.end[1]) / 2
            row, col = int((y - self.home.y0) / CELL_M), int((x - self.home.x0) / CELL_M)
            if not main[row, col]:
                return False
        return True


def has_top(obj: SceneObject) -> bool:
    """Whether things can stand on it."""
    return any(m.top for meshes in furniture().values() for m in meshes if m.id == obj.mesh)


def offset(anchor: SceneObject, u: float, v: float) -> tuple[float, float]:
    """(u, v) in the anchor's axes -> scene."""
    c, s = math.cos(anchor.yaw_rad), math.sin(anchor.yaw_rad)
    x, y, _ = anchor.position_m
    return x + u * c - v * s, y + u * s + v * c


def hex_colour(hue: float, saturation: float, value: float) -> str:
    rgb = colorsys.hsv_to_rgb(hue, saturation, value)
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in rgb)


def _rect_box(rect: Rect) -> Box:
    x, y = (rect.x0 + rect.x1) / 2, (rect.y0 + rect.y1) / 2
    return Box(x, y, rect.width, rect.depth, 0.0, 0.0, 2.1)


def _door_zone(start: tuple[float, float], end: tuple[float, float]) -> Box:
    x, y = (start[0] + end[0]) / 2, (start[1] + end[1]) / 2
    wide, deep = math.dist(start, end), 2 * DOOR_ZONE_M
    yaw = math.atan2(end[1] - start[1], end[0] - start[0])
    return Box(x, y, wide, deep, yaw, 0.0, 2.1)


def _front_zone(box: Box, depth: float) -> Box:
    out = (box.depth + depth) / 2 + 0.01
    x, y = box.x + math.sin(box.yaw) * out, box.y - math.cos(box.yaw) * out
    return Box(x, y, box.width * 0.9, depth, box.yaw, 0.0, 0.8)
