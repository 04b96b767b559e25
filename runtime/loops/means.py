"""What every drive of a runtime has at hand."""

from collections.abc import Mapping
from dataclasses import dataclass

from runtime.clock import Clock
from runtime.loops.drawings import Drawer
from runtime.loops.order import SearchModels
from runtime.loops.ports import Control, Decisions, LoopDetector, RealTimeBus
from runtime.loops.remembering import HomeMemory
from runtime.loops.shedding import Shedding
from runtime.robot.battery import Battery
from runtime.service.telemetry import Telemetry
from runtime.tracing.tracer import Tracer


@dataclass(frozen=True)
class Means:
    """See the module."""

    bus: RealTimeBus
    control: Control
    models: SearchModels
    clock: Clock
    decisions: Decisions
    detector: LoopDetector
    tracer: Tracer
    shedding: Shedding
    battery: Battery
    when_low: str  # what becomes of a search: see `BatteryConfig`
    drawer: Drawer
    telemetry: Telemetry
    memory: HomeMemory | None = None  # over restarts

    def lacks(self) -> dict[str, object]:
        """What is done without, and how it stands with what was remembered."""
        memory = self.memory.in_words() if self.memory is not None else "none"
        unstamped = self.bus.unstamped()
        return {"shed": self.shedding.in_words(), "unstamped": unstamped, "memory": memory}

    def spent_usd(self) -> float:
        """What a cloud has cost for the goal under way."""
        cloud = self.models.health().get("cloud")
        return float(cloud["goal_usd"]) if isinstance(cloud, Mapping) else 0.0
