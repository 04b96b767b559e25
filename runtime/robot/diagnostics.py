"""How the runtime and its streams stand, as diagnostic_msgs/DiagnosticArray."""

from collections.abc import Mapping
from enum import IntEnum
from types import MappingProxyType
from typing import Any, Final

from runtime.robot import wire
from runtime.robot.messages import StreamHealth

DIAGNOSTICS: Final = "diagnostic_msgs/msg/DiagnosticArray"
SILENT_S: Final = 2.0  # after which a stream on which something came is stale
HARDWARE: Final = "rfnav"
_T: Final = wire.STORE.types


class DiagnosticLevel(IntEnum):
    """DiagnosticStatus.level."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


RUNTIME_LEVELS: Final = {
    "fault": DiagnosticLevel.ERROR,
    "stopped": DiagnosticLevel.ERROR,
    "held": DiagnosticLevel.WARN,
    "degraded": DiagnosticLevel.WARN,
    "paused": DiagnosticLevel.WARN,
}
"""By what `loops.standing.RunState` calls it; all else is well."""


NOTHING: Final[Mapping[str, Any]] = MappingProxyType({})


class Diagnostics:
    """Tells of every stream what is new since it was told of last. One thread."""

    def __init__(self) -> None:
        self._bad: dict[str, int] = {}

    def encode(
        self,
        runtime: Mapping[str, object],
        late: Mapping[str, object],
        streams: Mapping[str, StreamHealth],
        now_s: float,
        stamp_ns: int,
        service: Mapping[str, Any] = NOTHING,
    ) -> bytes:
        """-> DiagnosticArray. `runtime`: state and cause; `late`: how late control's turns were;
        `streams`: by topic; `now_s`: by the clock that their arrivals are told by; `service`: what
        a query on `rfnav/status` is answered."""
        state, cause = str(runtime.get("state", "")), str(runtime.get("cause", ""))
        level = RUNTIME_LEVELS.get(state, DiagnosticLevel.OK)
        told = [_status(level, "runtime", cause or state, {"state": state, **late})]
        told += [_goal(service), _models(service)] if service else []
        for topic, health in streams.items():
            told.append(self._stream(topic, health, now_s))
        return wire.encode(_T[DIAGNOSTICS](wire.header(stamp_ns, ""), told))

    def _stream(self, topic: str, health: StreamHealth, now_s: float) -> Any:
        new = health.bad - self._bad.get(topic, 0)
        self._bad[topic] = health.bad
        age_s = None if health.arrival_s is None else now_s - health.arrival_s
        values: dict[str, object] = {
            "received": health.received,
            "bad": health.bad,
            "last error": health.last_error,
            "blank": health.blank,
            "jumped": health.jumped,
            "set back": health.set_back,
            "age (s)": "" if age_s is None else f"{age_s:.2f}",
        }
        if new > 0:
            return _status(DiagnosticLevel.WARN, topic, health.last_error, values)
        if health.received == 0:
            return _status(DiagnosticLevel.STALE, topic, "nothing has come", values)
        if age_s is not None and age_s > SILENT_S:
            return _status(DiagnosticLevel.STALE, topic, f"silent for {age_s:.0f} s", values)
        return _status(DiagnosticLevel.OK, topic, "comes", values)


def _goal(service: Mapping[str, Any]) -> Any:
    """What is looked for, what waits, and how the goal before ended."""
    last, queue = service.get("last") or {}, service.get("queue") or ()
    values = {
        "id": service.get("id") or "",
        "elapsed (s)": _rounded(service.get("elapsed_s")),
        "driven (m)": _rounded(service.get("driven_m")),
        "decisions": service.get("decisions", 0),
        "waiting": len(queue),
        "last result": last.get("sentence") or last.get("result") or "",
        "results": ", ".join(f"{k} {n}" for k, n in service.get("results", {}).items()),
    }
    return _status(DiagnosticLevel.OK, "goal", str(service.get("goal") or "none"), values)


def _models(service: Mapping[str, Any]) -> Any:
    """Who answers, what it costs, what failed."""
    models = service.get("models", {})
    cloud, errors = models.get("cloud", {}), list(models.get("errors", ()))
    errors += [cloud["error"]] if cloud.get("error") else []
    values = {
        "rungs": ", ".join(f"{k} {rung}" for k, rung in models.get("rungs", {}).items()),
        "spent, goal (USD)": cloud.get("goal_usd", 0),
        "spent, day (USD)": cloud.get("day_usd", 0),
        "memory (MB)": service.get("memory_mb", ""),
    }
    level = DiagnosticLevel.WARN if errors else DiagnosticLevel.OK
    message = str(errors[0]) if errors else f"{service.get('rung', 'none')} answers"
    return _status(level, "models", message, values)


def _rounded(value: float | None) -> str:
    return "" if value is None else f"{value:.1f}"


def _status(level: DiagnosticLevel, name: str, message: str, values: Mapping[str, object]) -> Any:
    pairs = [_T["diagnostic_msgs/msg/KeyValue"](key, str(value)) for key, value in values.items()]
    kind = _T["diagnostic_msgs/msg/DiagnosticStatus"]
    return kind(int(level), f"{HARDWARE}: {name}", message, HARDWARE, pairs)
