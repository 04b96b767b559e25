"""What the page is told, made of what the service tells: values in, JSON values out. What is not
there, or is not what it should be, is null: a page shows what it can."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from runtime.core.voting.names import rule_said
from runtime.tracing.budgets import Budgets
from runtime.tracing.stages import Stage

NAMES_MOST: Final = 300  # that are suggested
ERROR_CHARS: Final = 300
Told = Mapping[str, Any]


def state_of(state: Told, feedback: Told, status: Told) -> dict[str, Any]:
    """Of the newest `rfnav/state`, `rfnav/feedback` and `rfnav/status`, each {} where none came."""
    origin, base, runtime = origin_of(state), table(state, "base"), table(state, "runtime")
    runtime = runtime or table(status, "runtime")
    return {
        "pose": moved(state.get("pose"), origin),
        "v_mps": state.get("v_mps", 0.0),
        "w_radps": state.get("w_radps", 0.0),
        "runtime": {"state": runtime.get("state", "unknown"), "cause": runtime.get("cause", "")},
        "halt": state.get("halt") or "",
        "goal": _goal(state, feedback, status),
        "target": moved(state.get("toward_xy"), origin),
        "frontier": state.get("frontier"),
        "queue": [_waits(one) for one in status.get("queue") or ()],
        "last": _last(feedback, status, origin_of({**state, **feedback})),
        "stopped": runtime.get("state") == "stopped",
        "hand": base.get("hand") or "",
        "battery": base.get("battery_percent"),
        "caution": state.get("caution"),
        "refuses": status.get("refuses") or "",
    }


def under_way(feedback: Told, status: Told) -> bool:
    """Whether there is a goal, by the newest of both."""
    if feedback and "result" not in feedback:
        return feedback.get("id") == status.get("id") or not status
    return bool(status.get("goal")) and status.get("id") != feedback.get("id")


def _goal(state: Told, feedback: Told, status: Told) -> dict[str, Any] | None:
    if not under_way(feedback, status):
        return None
    ours = feedback.get("id") == status.get("id") or not status
    told = feedback if ours else {}
    return {
        "id": told.get("id") or status.get("id"),
        "text": told.get("goal") or status.get("goal"),
        "state": told.get("state", "searching"),
        "mode": told.get("mode") or state.get("mode") or "",
        "reason": told.get("reason") or state.get("reason") or status.get("does") or "",
        "elapsed_s": told.get("elapsed_s", status.get("elapsed_s")),
        "driven_m": told.get("driven_m", status.get("driven_m")),
        "usd": told.get("usd"),
        "decisions": told.get("decisions", status.get("decisions", 0)),
        "frontiers": told.get("frontiers"),
        "paused": told.get("paused") or status.get("paused") or "",
        "limits": told.get("limits"),
    }


def _last(feedback: Told, status: Told, origin: tuple[float, float]) -> dict[str, Any] | None:
    told = feedback if "result" in feedback else table(status, "last")
    if not told:
        return None
    names = "id", "goal", "result", "sentence", "elapsed_s", "driven_m"
    return {name: told.get(name) for name in names} | {"at_xy": moved(told.get("at_xy"), origin)}


def _waits(one: object) -> dict[str, Any]:
    if isinstance(one, Mapping):
        return {"id": one.get("id"), "goal": one.get("goal")}
    return {"id": None, "goal": str(one)}


def health_of(status: Told, before: Told, budgets: Budgets, wrong: Sequence[str]) -> dict[str, Any]:
    """Of two answers on `rfnav/status`, the newest first; `wrong`: what is not as it should be."""
    models = table(status, "models")
    cloud = table(models, "cloud")
    names = "goal_usd", "day_usd", "calls", "model"
    return {
        "stages": {n: _stage(n, told, budgets) for n, told in table(status, "stages").items()},
        "late_ms": table(status, "tick_late_ms") or None,
        "streams": {n: _stream(n, status, before) for n in table(status, "streams")},
        "halts": table(status, "halts"),
        "money": {name: cloud.get(name) for name in names} if cloud else None,
        "rungs": table(models, "rungs"),
        "rung": status.get("rung", "none"),
        "memory": status.get("memory", "none"),
        "memory_mb": status.get("memory_mb"),
        "up_s": status.get("up_s"),
        "wrong": [line[:ERROR_CHARS] for line in wrong],
    }


def budgets_of(budgets: Budgets) -> dict[str, Any]:
    """By stage, ms."""
    each = budgets.stages.items()
    return {str(n): {"median_ms": b.median_ms, "p99_ms": b.p99_ms} for n, b in each}


def _stage(name: str, told: object, budgets: Budgets) -> dict[str, Any]:
    known = name in tuple(Stage) and Stage(name) in budgets.stages
    figures = told if isinstance(told, Mapping) else {}
    return {
        "p50_ms": figures.get("p50_ms"),
        "p99_ms": figures.get("p99_ms"),
        "over": figures.get("over", 0),
        "budget_ms": budgets.stages[Stage(name)].p99_ms if known else None,
    }


def _stream(name: str, status: Told, before: Told) -> dict[str, Any]:
    now, then = table(table(status, "streams"), name), table(table(before, "streams"), name)
    span_s = number(status.get("now_s")) - number(before.get("now_s"))
    came = number(now.get("received")) - number(then.get("received"))
    arrival_s = now.get("arrival_s")
    age_s = None if arrival_s is None else max(0.0, number(status.get("now_s")) - arrival_s)
    return {
        "per_s": round(came / span_s, 1) if then and span_s > 0 and came >= 0 else None,
        "age_s": None if age_s is None else round(age_s, 2),
        "bad": now.get("bad", 0),
    }


def decision_of(
    report: Told,
    number: int,
    goal: str,
    full: Sequence[str],
    origin_xy: tuple[float, float] = (0.0, 0.0),
) -> dict[str, Any]:
    """Of a report on `rfnav/decision`, {} where only its words are known; the map begins at
    `origin_xy` in odometry's frame."""
    told: dict[str, Any] = {"number": number, "goal": goal, "full": list(full)}
    if not report:
        return told
    took = table(report, "latency_s")
    names = (
        "frontier", "rule", "why", "closest", "heads_for", "chosen", "in_words", "missing",
        "step", "stamp_ns",
    )  # fmt: skip
    told |= {name: report[name] for name in names if name in report}
    votes = [one for one in report.get("votes") or () if isinstance(one, Mapping)]
    told["votes"] = [{**_vote(v), "latency_s": took.get(str(v.get("expert")))} for v in votes]
    if isinstance(rule := report.get("rule"), str):
        told["rule_said"] = rule_said(rule, planned=bool(report.get("order")))
    told["taken"] = str(table(report, "taken").get("in_words") or "")
    told["without"] = table(report, "without")
    on = [one for one in report.get("frontiers") or () if isinstance(one, Mapping)]
    told["frontiers"] = [{**f, "goal_xy": moved(f.get("goal_xy"), origin_xy)} for f in on]
    told["belief"] = belief_of(report, origin_xy)
    return told


def belief_of(report: Told, origin_xy: tuple[float, float]) -> list[dict[str, Any]]:
    """Where the thing may be, of a report on `rfnav/state` or `rfnav/decision`: places in
    odometry's frame, the likeliest first; [] where that is not worked out."""
    places = table(report, "belief").get("places") or ()
    return [
        {
            **{name: place.get(name) for name in ("kind", "id", "why")},
            "xy": moved(place.get("xy"), origin_xy),
            "p": number(place.get("p")),
        }
        for place in places
        if isinstance(place, Mapping)
    ]


def _vote(vote: Told) -> dict[str, Any]:
    names = "expert", "frontiers", "probabilities", "reason", "reasons", "against", "rung"
    return {name: vote.get(name) for name in names}


def stop_of(told: Told) -> dict[str, Any]:
    """A stop as `rfnav/why` tells it; `halt` is its kind."""
    names = "number", "state", "reason", "in_words"
    more = {"halt": told.get("kind"), "over": told.get("ended_s") is not None}
    return {name: told.get(name) for name in names} | more


def zones_of(answer: Told) -> dict[str, Any]:
    """The answer on `rfnav/zones`."""
    zones = [one for one in answer.get("zones") or () if isinstance(one, Mapping)]
    drawn = [{"name": one.get("name"), "polygon": one.get("polygon")} for one in zones]
    return {"zones": drawn, "bound": bool(answer.get("bound", True))}


def places_of(answer: Told) -> dict[str, Any]:
    """The answer on `rfnav/places`."""
    told = []
    for name, at in sorted(table(answer, "places").items()):
        known = isinstance(at, list | tuple) and len(at) == 3
        told.append(
            {"name": name, "xy": at[:2] if known else None, "yaw": at[2] if known else None}
        )
    return {"places": told, "memory": answer.get("memory", "")}


def names_of(seen: Iterable[str], status: Told) -> list[str]:
    """What may be asked for: things that were seen, then what the detectors know by name."""
    known = table(status, "detector").get("classes") or ()
    every = dict.fromkeys([*sorted(set(seen)), *(str(name) for name in known)])
    return list(every)[:NAMES_MOST]


def moved(at: object, by: tuple[float, float]) -> list[float] | None:
    """A place or pose of the map in odometry's frame."""
    if not isinstance(at, list | tuple) or len(at) < 2:
        return None
    return [round(at[0] + by[0], 3), round(at[1] + by[1], 3), *at[2:]]


def origin_of(told: Told) -> tuple[float, float]:
    """Where the map of a report begins in odometry's frame, m."""
    origin = told.get("origin_xy") or (0.0, 0.0)
    return origin[0], origin[1]


def table(told: Told, name: str) -> dict[str, Any]:
    """A table within one; {} where there is none."""
    value = told.get(name)
    return value if isinstance(value, dict) else {}


def number(value: object) -> float:
    """0 where it is none."""
    return float(value) if isinstance(value, int | float) else 0.0
