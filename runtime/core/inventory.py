"""What is on the maps, as it is told to others."""

import math
from typing import Final

import numpy as np

from runtime.core.looking_closer import doubts
from runtime.core.objects.instances import Instance, shares, size_m
from runtime.core.objects.standpoints import look_from
from runtime.core.world import World

ROOM_M2: Final = 1.0  # of a type of room that is worth a word
UNREACHED: Final = 8  # places that are told


def inventory(world: World) -> list[dict[str, object]]:
    """Every object: its name and others that it was called, how surely, where and how large, and
    from where it can be looked at (None: no way leads there)."""
    return [_told(i, world) for i in world.semantic.instances.values()]


def searched(world: World) -> dict[str, object]:
    """How much floor was seen, and how much of that from near, m2; by type of room where the
    detector told one."""
    cell_m2 = world.map.frame.resolution_m**2
    free, rooms = world.map.free, world.semantic.rooms
    by_room: dict[str, float] = {}
    if rooms.size:
        kinds = rooms.argmax(axis=0)[free & rooms.any(axis=0)]
        areas = np.bincount(kinds, minlength=len(rooms)) * cell_m2
        named = zip(world.semantic.room_names, areas.tolist(), strict=True)
        by_room = {name: round(m2, 1) for name, m2 in named if m2 >= ROOM_M2}
    near_m2 = float((free & world.explored.looked).sum() * cell_m2)
    return {
        "floor_m2": round(float(free.sum() * cell_m2), 1),
        "near_m2": round(near_m2, 1),
        "rooms_m2": by_room,
    }


def unreached(world: World) -> list[dict[str, object]]:
    """Where ways are that were open before and were closed when they were looked at again; and
    where the known ends and no way led to, the widest first."""
    ways = world.explored.passages.still_closed
    closed: list[dict[str, object]] = [
        {"way": way.id, "xy": [round(v, 2) for v in way.xy], "looks": way.looks} for way in ways
    ]
    shut = [f for f in world.frontiers if not math.isfinite(f.distance_m)]
    widest = sorted(shut, key=lambda f: (-len(f.cells_xy), f.id))[:UNREACHED]
    return closed + [
        {"frontier": f.id, "xy": [round(v, 2) for v in f.centre_xy], "cells": len(f.cells_xy)}
        for f in widest
    ]


def in_doubt(world: World) -> list[dict[str, object]]:
    """Where the goal may still be, of what was seen, the likeliest first: on what, with what
    chance, and from how near that was looked at (None: never)."""
    return [
        {
            "on": doubt.on,
            "xy": [round(v, 2) for v in doubt.xy],
            "chance": round(doubt.likely, 3),
            "seen_m": round(doubt.seen_m, 1) if math.isfinite(doubt.seen_m) else None,
        }
        for doubt in doubts(world)
    ]


def _told(thing: Instance, world: World) -> dict[str, object]:
    spot = None
    if world.seen is not None:
        spot = look_from(world.map, *world.seen, thing, world.standoff(thing))
    known = sorted(thing.evidence.items())
    rejected = {name: about.rejections for name, about in known if about.rejections}
    return {
        "id": thing.id,
        "name": thing.name,
        "names": {name: round(share, 4) for name, share in shares(thing).items()},
        "confidence": round(thing.confidence, 4),
        "xy": thing.xy,
        "z_m": thing.z_m,
        "size_m": [round(side, 3) for side in size_m(thing, world.map.frame.resolution_m)],
        "look_from_xy": spot,
        "views": len(thing.views),
        "rejections": sum(rejected.values()),
        "rejected_as": rejected,
        "cells_xy": thing.cells_xy.round(3),
    }
