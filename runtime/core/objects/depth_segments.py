"""The things in a detector's boxes: how far away each is, and where its points are. The surface of
one lies within its box, while what hides a part of it, or is behind it, mostly goes on beyond."""

import math
from functools import lru_cache
from typing import NamedTuple

from runtime.core.geometry import GridFrame, rays
from runtime.core.kernels import objects as kernels
from runtime.core.objects.footprints import STRAYS, numbers, unpacked
from runtime.core.types import F32, F64, Intrinsics, Mount, Observation

STRIDE = 4  # every n-th pixel is looked at

KNOWN_SHARE = 0.5
"""Of a box, whose depth is known: with less, what is known may stand before a thing that is too far
away to have any."""
CORE_SHARE = 0.6  # of a box's width and height, where its depth is read,
NEAR_QUANTILE = 0.3  # of the depths there: the nearest substantial surface
EDGE_M = 0.1  # between two neighbours' depths, from which on surfaces meet there,
EDGE_SHARE = 0.05  # or that share of the depth
FLOOR_M = 0.05  # what is lower is floor, and of no surface
CEILING_M = 2.2  # what is higher is no thing
WITHIN_SHARE = 0.9  # a surface with less of it than this in a box goes on beyond it,
SPAN_SHARE = 0.1  # then one is the object's that does not, and spans so much of the box

CLUSTER_M = 0.35  # points this close in depth to the object belong to it
BEFORE_SHARE = 0.5
"""Toward the camera no further than half as far as the box is wide, and only what hangs together
with it: what is nearer stands before it."""
BEFORE_M = 0.1  # at least
MIN_POINTS = 6  # of an object, else its box gives none
RIM = 20  # one in so many of its points is a stray at its rim, above and below

RULES = (
    EDGE_M, EDGE_SHARE, FLOOR_M, CEILING_M, KNOWN_SHARE, CORE_SHARE, NEAR_QUANTILE, WITHIN_SHARE,
    SPAN_SHARE, CLUSTER_M, BEFORE_SHARE, BEFORE_M, MIN_POINTS, RIM, *STRAYS,
)  # fmt: skip


class SeenThing(NamedTuple):
    """What one view tells of where a thing is, in the map frame, m."""

    range_m: float  # from the camera, along its axis
    xy: tuple[float, float]  # medians of its points
    z_m: float
    low_m: float  # its height above the floor, from
    high_m: float  # and to
    cells_xy: F64  # (N, 2) centres of the map cells under it


class Sighting(NamedTuple):
    """One detection in space."""

    name: str
    score: float
    embedding: F32  # (D,) unit, or (0,)
    thing: SeenThing
    cut: bool = False  # at the left or right edge of the image


def things_in(
    obs: Observation, boxes: F64, mount: Mount, frame: GridFrame
) -> list[SeenThing | None]:
    """The thing in each box (N, 6), which is `kernels.things`'s; None where there is hardly a point
    of one, or the depth of less than KNOWN_SHARE of the box is known. How far it is, unless that is
    known: as far as the nearest substantial surface in the middle of the box or, where that one
    goes on beyond, the one within the box that spans most of it, if there is one."""
    pose, axes = obs.pose, _axes(obs.intrinsics, mount)
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    place = mount.x_m, mount.y_m, mount.z_m, pose.x_m, pose.y_m, c, s
    found = kernels.things(obs.depth_m, axes, STRIDE, boxes, place, numbers(frame), RULES)
    return [told and _thing(*told) for told in found]


@lru_cache(maxsize=8)
def _axes(intrinsics: Intrinsics, mount: Mount) -> tuple[F32, F32, F32]:
    """The image's rays, (h, w) each."""
    table = rays(intrinsics, mount, STRIDE)
    return table.forward, table.left, table.up


def _thing(
    range_m: float, x: float, y: float, z_m: float, low_m: float, high_m: float, cells: bytes
) -> SeenThing:
    return SeenThing(range_m, (x, y), z_m, low_m, high_m, unpacked(cells))
