"""Where a search may be: what it is kept out of, as people draw it while it goes on."""

from dataclasses import dataclass, field
from typing import Protocol

from runtime import navigate
from runtime.core.mapping.zones import Zone
from runtime.core.world import World
from runtime.journal import Journal
from runtime.record import Record


class ZoneKeeper(Protocol):
    """Who knows of the zones that people draw; see `service/zones.py` `Zones`."""

    def now(self) -> tuple[Zone, ...]:
        """As they are, in the map frame."""

    def unbound(self) -> str:
        """Why no goal can be taken; "" where one can."""


class NoZones:
    """Nobody draws any."""

    def now(self) -> tuple[Zone, ...]:
        return ()

    def unbound(self) -> str:
        return ""


@dataclass
class Whereabouts:
    """A search's. One thread's, which owns the world."""

    keeper: ZoneKeeper = field(default_factory=NoZones)

    def keep(self, world: World, journal: Journal, record: Record) -> None:
        """Have on the map what is kept out of now."""
        zones = self.keeper.now()
        if zones != world.map.zones.zones:
            navigate.keep_out(world, zones)
            record("heard", {"name": "zones", "value": zones})
            journal.write("zones", zones=zones)
