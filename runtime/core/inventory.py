"""What is on the semantic map, as it is told to others."""

from runtime.core.objects.instances import Instance, shares, size_m
from runtime.core.objects.standpoints import look_from
from runtime.core.world import World


def inventory(world: World) -> list[dict[str, object]]:
    """Every object: its name and others that it was called, how surely, where and how large, and
    from where it can be looked at (None: no way leads there)."""
    return [_told(i, world) for i in world.semantic.instances.values()]


def _told(thing: Instance, world: World) -> dict[str, object]:
    spot = None
    if world.seen is not None:
        spot = look_from(world.map, *world.seen, thing, world.seen_from_m(thing.high_m))
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
