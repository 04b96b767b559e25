"""Where a search may be: what it is kept out of, as people draw it while it goes on."""

from collections.abc import Callable
from dataclasses import dataclass

from runtime import navigate
from runtime.core.mapping.zones import Zone
from runtime.core.world import World
from runtime.journal import Journal
from runtime.record import Record

ZoneSource = Callable[[], tuple[Zone, ...]]
"""What is kept out of, as it is now, in the map frame."""


def no_zones() -> tuple[Zone, ...]:
    """Nothing is kept out of."""
    return ()


@dataclass
class Whereabouts:
    """A search's. One thread's, which owns the world."""

    zones: ZoneSource = no_zones

    def keep(self, world: World, journal: Journal, record: Record) -> None:
        """Have on the map what is kept out of now."""
        zones = self.zones()
        if zones != world.map.zones.zones:
            navigate.keep_out(world, zones)
            record("heard", {"name": "zones", "value": zones})
            journal.write("zones", zones=zones)
