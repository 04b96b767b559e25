"""A runtime in few lines, run as a child process: real Zenoh, real CDR, no models.

python fake_runtime.py MODE --set 'bus.connect=["tcp/..."]' [--set ...]

MODE: walk (forward until 1 m from where it began, then stop), roll (the same by velocities), turn
(never stops), mute (never answers), die (ends with an error at the second observation), broken
(ends before it is ready).
"""

import itertools
import json
import math
import sys
import time
import tomllib
from pathlib import Path
from typing import Any

from runtime.clock import SystemClock
from runtime.core.types import Action, Observation, Twist
from runtime.robot import wire
from runtime.robot.bus import Bus, BusConfig
from runtime.robot.session import open_session

MODES = {4: "target"}


def settings(arguments: list[str]) -> dict[str, Any]:
    """The value of every `--set KEY=VALUE`."""
    found: dict[str, Any] = {}
    for flag, setting in itertools.pairwise(arguments):
        if flag == "--set":
            key, _, value = setting.partition("=")
            found[key] = tomllib.loads(f"v = {value}")["v"]
    return found


def choose(mode: str, obs: Observation, seen: int) -> Action | None:
    if mode == "die" and seen == 2:
        print("rfnav: camera: fell off", file=sys.stderr)
        sys.exit(2)
    if mode == "mute":
        return None
    if mode == "turn":
        return Action.TURN_LEFT
    return Action.STOP if math.hypot(obs.pose.x_m, obs.pose.y_m) >= 1.0 else Action.MOVE_FORWARD


def main() -> None:
    mode = sys.argv[1]
    if mode == "broken":
        print("some noise\nrfnav: models.language: nosuch: unknown\n", file=sys.stderr)
        sys.exit(2)
    connect = tuple(settings(sys.argv)["bus.connect"])
    seen = 0
    heard: list[Any] = []
    log_dir = Path()
    with (
        Bus(BusConfig(connect=connect), SystemClock(), lockstep=True) as bus,
        open_session(BusConfig(connect=connect)) as session,
    ):
        session.declare_subscriber(
            "rfnav/labels",
            lambda s: heard.append(wire.decode_json(s.payload.to_bytes(), "rfnav/labels")),
        )
        while True:
            obs = bus.next(0.2)
            request = bus.request()
            if request is not None and request.kind == "status":
                request.reply({"state": "ready"})
            elif request is not None and request.kind == "goal":
                wanted = request.body["goal"]
                seen = 0
                bus.flush()
                log_dir = Path(request.body["log_dir"])
                (log_dir / "asked.json").write_text(json.dumps(request.body))
                heard.clear()
                if wanted == "nothing":
                    request.reply({"accepted": False, "error": "goal: nothing: unknown"})
                else:
                    request.reply({"accepted": True})
            elif request is not None:
                until_s = time.monotonic() + 5.0  # labels come by another session than images
                while heard and len(heard) < seen and time.monotonic() < until_s:
                    time.sleep(0.01)
                lines = [json.dumps(label) for label in heard]
                (log_dir / "labels.jsonl").write_text("\n".join(lines))
                request.reply({"seconds": {"plan": 0.001 * seen}, "reason": request.body["reason"]})
            if obs is None:
                continue
            seen += 1
            began_s = time.monotonic()
            action = choose(mode, obs, seen)
            if action is None:
                continue
            if seen == 1:
                frontier = {"id": 1, "goal_xy": [0.25, 0.0]}
                bus.publish_decision(
                    {"stamp_ns": obs.stamp_ns, "frontier": 1, "votes": [], "frontiers": [frontier]}
                )
            near_m = float(obs.depth_m[obs.depth_m > 0].min(initial=99.0))
            took_s = time.monotonic() - began_s
            bus.publish_state(
                {
                    "stamp_ns": obs.stamp_ns,
                    "step": seen,
                    "mode": "stop" if action is Action.STOP else MODES.get(seen, "frontier"),
                    "purpose": "approaching" if seen in MODES else "exploring",
                    "toward_xy": [1.5 if seen >= 4 else 0.5, 0.0],
                    "reason": f"red {obs.rgb[0, 0, 0]}, nearest {near_m:.2f} m",
                    "took_s": took_s,
                }
            )
            bus.publish_action(obs.stamp_ns, action, Twist(0.4) if mode == "roll" else None)


if __name__ == "__main__":
    main()
