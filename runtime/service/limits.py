"""What a goal may take at most."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Final, Self

from runtime.core.types import SearchState
from runtime.errors import ConfigError
from runtime.service.outcomes import FailCause, GoalEnd
from runtime.toml_values import unknown

MOST: Final = {"time_s": 86_400.0, "distance_m": 100_000.0, "money_usd": 1e6}


@dataclass(frozen=True)
class GoalLimits:
    """None is none. Of money spent the cloud is asked no more, and the search goes on."""

    time_s: float | None = None
    distance_m: float | None = None
    money_usd: float | None = None

    @classmethod
    def read(cls, value: object) -> Self:
        """{"time_s", "distance_m", "money_usd"}, each if it is wished; ConfigError."""
        if not isinstance(value, dict):
            raise ConfigError('goal request: limits: must be an object, e.g. {"time_s": 300}')
        for name in value:
            if name not in MOST:
                names = [field.name for field in fields(cls)]
                raise ConfigError(f"goal request: limits: {unknown(str(name)[:40], names)}")
        return cls(**{name: _amount(name, value[name]) for name in value})

    def passed(self, elapsed_s: float, driven_m: float) -> GoalEnd | None:
        """How a search ends by now, if it does."""
        if self.time_s is not None and elapsed_s >= self.time_s:
            return GoalEnd(SearchState.TIMED_OUT, f"{self.time_s:g} s have passed")
        if self.distance_m is not None and driven_m >= self.distance_m:
            why = f"{self.distance_m:g} m were driven"
            return GoalEnd(SearchState.FAILED, why, FailCause.DISTANCE)
        return None

    def told(self) -> Mapping[str, float]:
        """Those that there are."""
        return {name: value for name, value in vars(self).items() if value is not None}


NO_LIMITS: Final = GoalLimits()


def _amount(name: str, value: Any) -> float:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    least = 0.0 if name == "money_usd" else 1e-3
    if not number or not math.isfinite(value) or not least <= value <= MOST[name]:
        raise ConfigError(
            f"goal request: limits: {name}: must be a number from {least:g} to {MOST[name]:g}"
        )
    return float(value)
