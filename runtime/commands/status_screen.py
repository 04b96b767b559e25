"""How a running service stands, on one screen: of two of its answers on `rfnav/status`, for what
comes in between them."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from runtime.robot.diagnostics import SILENT_S
from runtime.tracing.budgets import Budgets
from runtime.tracing.stages import Stage

WRONG_STATES: Final = ("fault", "stopped", "held", "degraded")
ERROR_CHARS: Final = 240
LINE_CHARS: Final = 1000
STREAM_COLUMNS, STAGE_COLUMNS = 44, 10
Status = Mapping[str, Any]


def wrong(status: Status, needed: Sequence[str]) -> list[str]:
    """What is not as it should be, the gravest first; `needed`: topics that no search does
    without."""
    runtime, found = _table(status, "runtime"), []
    if runtime.get("state") in WRONG_STATES:
        found.append(_standing(runtime))
    if why := status.get("refuses"):
        found.append(f"no goal is taken: {why}")
    streams = _table(status, "streams")
    for topic in needed:
        if topic in streams and (what := _silent(streams[topic], status)):
            found.append(f"{topic}: {what}")
    models = _table(status, "models")
    found += [f"model: {error}" for error in models.get("errors") or []]
    if error := _table(models, "cloud").get("error"):
        found.append(f"cloud: {error}")
    if lost := status.get("journal_lost"):
        found.append(str(lost))
    return [printable(line, ERROR_CHARS) for line in found]


def screen(status: Status, before: Status, needed: Sequence[str], budgets: Budgets) -> list[str]:
    """Lines. `before`: an earlier answer."""
    problems = wrong(status, needed)
    lines = [
        *(f"WRONG    {line}" for line in problems),
        f"state    {_standing(_table(status, 'runtime'))}",
        *_goal(status),
        *_money(status),
        *_halts(status),
        *_models(status),
        *_streams(status, before),
        *_stages(status, budgets),
        *_itself(status),
    ]
    return [printable(line) for line in lines]


def _standing(runtime: Status) -> str:
    state, cause = runtime.get("state", "unknown"), runtime.get("cause")
    return f"{state}: {cause}" if cause else str(state)


def _goal(status: Status) -> Iterator[str]:
    if goal := status.get("goal"):
        parts = [f'"{goal}"']
        parts += [f"{status['elapsed_s']:.0f} s"] if status.get("elapsed_s") is not None else []
        parts += [f"{status['driven_m']:.1f} m"] if status.get("driven_m") is not None else []
        parts.append(f"{status.get('decisions', 0)} decisions")
        yield f"goal     {', '.join(parts)}"
        if does := status.get("does"):
            yield f"does     {does}"
    else:
        yield "goal     none"
    if waiting := status.get("queue"):
        yield f"queue    {', '.join(_waits(one) for one in waiting)}"
    if last := _table(status, "last"):
        yield f"last     {last.get('sentence') or last.get('result')}"
    if (memory := str(status.get("memory", "none"))) != "none":
        yield f"home     {memory}"


def _waits(one: object) -> str:
    return str(one.get("goal")) if isinstance(one, dict) else str(one)


def _money(status: Status) -> Iterator[str]:
    cloud = _table(_table(status, "models"), "cloud")
    if cloud:
        goal_usd, day_usd = cloud.get("goal_usd", 0.0), cloud.get("day_usd", 0.0)
        calls = f"{cloud.get('calls', 0)} calls of {cloud.get('model')}"
        yield f"money    {goal_usd:.4f} USD for this goal, {day_usd:.4f} today, {calls}"


def _halts(status: Status) -> Iterator[str]:
    counted = ", ".join(f"{kind} {n}" for kind, n in _table(status, "halts").items()) or "none"
    now = f"; now: {status['halt']}" if status.get("halt") else ""
    yield f"halts    {counted}{now}"
    base = _table(status, "base")
    if (percent := base.get("battery_percent")) is not None:
        yield f"battery  {percent:.0f} %"


def _models(status: Status) -> Iterator[str]:
    rungs = ", ".join(f"{e} {r}" for e, r in _table(_table(status, "models"), "rungs").items())
    yield f"models   {status.get('rung', 'none')} answers{f'; {rungs}' if rungs else ''}"


def _streams(status: Status, before: Status) -> Iterator[str]:
    streams, earlier = _table(status, "streams"), _table(before, "streams")
    if not streams:
        return
    yield f"{'stream':{STREAM_COLUMNS}}{'per s':>8}{'age s':>8}{'bad':>7}"
    for topic, health in streams.items():
        age_s = _age_s(health, status)
        rate = "?"
        if then := earlier.get(topic):
            rate = _rate(health.get("received", 0) - then.get("received", 0), status, before)
        age = "never" if age_s is None else f"{age_s:.1f}"
        bad = health.get("bad", 0)
        yield f"  {topic:{STREAM_COLUMNS - 2}}{rate:>8}{age:>8}{bad:>7}"


def _rate(count: int, status: Status, before: Status) -> str:
    span_s = status.get("now_s", 0.0) - before.get("now_s", 0.0)
    return f"{count / span_s:.1f}" if span_s > 0 and count >= 0 else "?"


def _stages(status: Status, budgets: Budgets) -> Iterator[str]:
    stages = _table(status, "stages")
    if not stages:
        return
    yield f"{'stage, ms':{STAGE_COLUMNS}}{'p50':>9}{'p99':>9}{'budget':>9}{'over':>7}"
    for name, told in stages.items():
        known = name in tuple(Stage) and Stage(name) in budgets.stages
        most = f"{budgets.stages[Stage(name)].p99_ms:g}" if known else ""
        figures = f"{told.get('p50_ms', 0):>9.1f}{told.get('p99_ms', 0):>9.1f}"
        yield f"  {name:{STAGE_COLUMNS - 2}}{figures}{most:>9}{told.get('over', 0):>7}"


def _itself(status: Status) -> Iterator[str]:
    if "memory_mb" in status:
        yield f"memory   {status['memory_mb']:.0f} MB, up {_span(status.get('up_s', 0.0))}"
    if journal := status.get("journal"):
        yield f"journal  {journal}"


def _span(seconds: float) -> str:
    for size, name in ((86_400, "days"), (3600, "h"), (60, "min")):
        if seconds >= 2 * size:
            return f"{seconds / size:.1f} {name}"
    return f"{seconds:.0f} s"


def _silent(health: Status, status: Status) -> str:
    if not health.get("received"):
        return "nothing has come"
    age_s = _age_s(health, status)
    return f"silent for {age_s:.0f} s" if age_s is not None and age_s > SILENT_S else ""


def _age_s(health: Status, status: Status) -> float | None:
    arrival_s, now_s = health.get("arrival_s"), status.get("now_s")
    return None if arrival_s is None or now_s is None else max(0.0, now_s - arrival_s)


def _table(table: Status, name: str) -> dict[str, Any]:
    value = table.get(name)
    return value if isinstance(value, dict) else {}


def printable(line: str, most: int = LINE_CHARS) -> str:
    """What came from elsewhere may say anything: what a terminal would obey is left out."""
    return "".join(c if c.isprintable() else " " for c in line)[:most]
