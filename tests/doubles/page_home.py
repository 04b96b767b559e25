"""What the operator's page is told of a search for a mug through a flat of four rooms, as the
protocol says it: plausible, and the same every time."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from page_double import PageDouble

from runtime.map_look import room_hue

CELLS_A_M = 20
ROOMS = ["kitchen", "living room", "bedroom", "bathroom", "hallway"]
X0_M, Y0_M = -1.0, -4.0
SIZE_M = 11.0, 8.0
WALLS = (  # x0, y0, x1, y1 m: what stands
    (-0.6, -3.6, 9.4, -3.5), (-0.6, 3.5, 9.4, 3.6), (-0.6, -3.6, -0.5, 3.6), (9.3, -3.6, 9.4, 3.6),
    (4.2, -3.6, 4.3, -1.4), (4.2, -0.4, 4.3, 3.6), (4.3, 0.2, 6.0, 0.3), (7.0, 0.2, 9.4, 0.3),
    (-0.6, 0.6, 1.6, 0.7), (2.6, 0.6, 4.3, 0.7), (6.8, 0.3, 6.9, 1.5), (6.8, 2.5, 6.9, 3.6),
    (0.2, -3.5, 2.4, -2.9), (3.2, -2.8, 4.0, -2.0), (-0.4, 1.4, 0.4, 3.2), (5.0, -3.4, 7.2, -2.6),
    (8.6, -3.0, 9.2, -1.0), (1.6, 2.8, 2.8, 3.4), (7.4, 2.9, 9.0, 3.4),
)  # fmt: skip
FLOORS = (  # x0, y0, x1, y1 m, room
    (-0.5, -3.5, 4.2, 0.6, 1), (-0.5, 0.7, 4.2, 3.5, 2), (4.3, -3.5, 9.3, 0.2, 0),
    (4.3, 0.3, 6.8, 3.5, 4), (6.9, 0.3, 9.3, 3.5, 3),
)  # fmt: skip
PATH = [[0.0, 0.0], [0.6, 0.0], [1.4, -0.4], [2.4, -0.9], [3.4, -0.9], [4.2, -0.9], [4.9, -1.1]]
PLAN = [[4.9, -1.1], [5.6, -0.9], [6.3, -0.5], [6.5, 0.2], [6.2, 1.0], [6.0, 1.9]]
FULL = [
    'Decision 4 of the search for "a red mug", 31 s into it.',
    "It was due: frontier 3 is gone.",
    "Taken: frontier 7, at (6.0, 1.9) m, 3.4 m on foot.",
    "Rule: not all agree, but two of them name it (o2f and r2f).",
]


def cells(share: float = 1.0) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """(R, C) cells and rooms as the page is shown them; `share`: how much of the flat is known."""
    high, wide = (round(m * CELLS_A_M) for m in reversed(SIZE_M))
    grid = np.zeros((high, wide), np.uint8)
    rooms = np.full((high, wide), 255, np.uint8)
    for *box, room in FLOORS:
        grid[_inside(box)] = 1
        rooms[_inside(box)] = room
    for box in WALLS:
        grid[_inside(box)], rooms[_inside(box)] = 2, 255
    y, x = np.mgrid[0:high, 0:wide] / CELLS_A_M
    ragged = 0.25 * np.sin(5 * y) + 0.15 * np.sin(11 * y + 1)
    unseen = (x + X0_M + ragged > -1 + 9.0 * share) | ((y + Y0_M > 2.4 + 2 * share) & (x > 5.6))
    grid[unseen], rooms[unseen] = 0, 255
    return grid, rooms


def _inside(box: Any) -> tuple[slice, slice]:
    x0, y0, x1, y1 = (round(v * CELLS_A_M) for v in _moved(box))
    return slice(y0, y1), slice(x0, x1)


def _moved(box: Any) -> tuple[float, float, float, float]:
    return box[0] - X0_M, box[1] - Y0_M, box[2] - X0_M, box[3] - Y0_M


def state(runtime: str = "searching", cause: str = "", **more: Any) -> dict[str, Any]:
    goal = {
        "id": "5f3a09c1", "text": "a red mug", "state": "searching", "mode": "explore",
        "reason": "to frontier 7, on which o2f and r2f agree", "elapsed_s": 34.2, "driven_m": 6.1,
        "usd": 0.0, "decisions": 4, "frontiers": 3, "paused": "", "limits": {},
    }  # fmt: skip
    return {
        "link": "ok", "age_s": 0.05, "why": "", "pose": [4.9, -1.1, 0.35], "v_mps": 0.31,
        "w_radps": 0.1, "runtime": {"state": runtime, "cause": cause}, "halt": "", "goal": goal,
        "target": [6.0, 1.9], "frontier": 7, "queue": [], "last": None,
        "stopped": runtime == "stopped", "hand": "", "teleop": None, "battery": 81.0,
        "caution": None, **more,
    }  # fmt: skip


def scene(**more: Any) -> dict[str, Any]:
    things = [
        (1, "sofa", 0.93, (1.3, -3.2), (2.2, 0.6), "living room", False),
        (2, "table", 0.81, (3.6, -2.4), (0.8, 0.8), "living room", False),
        (3, "bed", 0.97, (0.0, 2.3), (0.8, 1.8), "bedroom", False),
        (4, "sink", 0.88, (6.1, -3.0), (0.6, 0.5), "kitchen", False),
        (5, "refrigerator", 0.9, (8.9, -2.0), (0.6, 0.8), "kitchen", False),
        (6, "plant", 0.52, (3.9, -3.2), (0.3, 0.3), None, False),
        (8, "mug", 0.47, (5.4, -2.9), (0.1, 0.1), "kitchen", True),
    ]
    names = "id", "name", "confidence", "xy", "size", "room", "goal"
    edge = [[5.2 + 0.05 * i, 2.3 + 0.08 * np.sin(i)] for i in range(24)]
    return {
        "goal": "a red mug",
        "frontiers": [
            {"id": 7, "xy": [6.0, 1.9], "cells": edge, "distance_m": 3.4, "elected": True},
            {"id": 11, "xy": [8.0, -0.4], "distance_m": 3.2, "elected": False,
             "cells": [[8.0 + 0.02 * i, -0.9 + 0.05 * i] for i in range(18)]},
            {"id": 12, "xy": [2.1, 1.3], "distance_m": 5.0, "elected": False,
             "cells": [[1.7 + 0.05 * i, 1.0] for i in range(16)]},
        ],
        "things": [dict(zip(names, thing, strict=True)) for thing in things],
        "plan": PLAN, "path": PATH, "area": None, "rooms": ROOMS,
        "hues": [room_hue(name) for name in ROOMS],
        "belief": [
            {"kind": "surface", "id": 4, "xy": [5.8, -3.0], "p": 0.34, "why": "mugs are by sinks"},
            {"kind": "frontier", "id": 7, "xy": [6.0, 2.2], "p": 0.22, "why": "unknown behind it"},
        ],
        **more,
    }  # fmt: skip


def decision(number: int = 4, frontier: int = 7) -> dict[str, Any]:
    return {
        "number": number, "id": "5f3a09c1", "goal": "a red mug", "elapsed_s": 31.0,
        "frontier": frontier, "rule": "pairs", "rule_said": "two of them name it",
        "taken": "3.4 m on foot, first of 3 in the planned order",
        "why": "frontier 3 is gone", "closest": 11,
        "heads_for": frontier, "chosen": [frontier], "in_words": f"frontier {frontier}",
        "full": FULL,
        "votes": [
            {"expert": "o2f", "frontiers": [7, 11], "probabilities": [[7, 0.58], [11, 0.29]],
             "reason": "", "reasons": [[7, "sink, towel near it"], [11, "refrigerator"]],
             "against": [], "rung": "local", "latency_s": 0.34},
            {"expert": "r2f", "frontiers": [7], "probabilities": [[7, 0.44]], "reason": "",
             "reasons": [[7, "hallway to a bathroom"]], "against": [12], "rung": "local",
             "latency_s": 0.29},
        ],
        "missing": [{"expert": "sle", "why": "no preference", "detail": "",
                     "cause": "no preference: all views look alike"}],
        "without": {"o2f": 11, "r2f": 7, "sle": 7},
        "frontiers": [
            {"id": 7, "goal_xy": [6.0, 1.9], "distance_m": 3.4},
            {"id": 11, "goal_xy": [8.0, -0.4], "distance_m": 3.2},
            {"id": 12, "goal_xy": [2.1, 1.3], "distance_m": 5.0},
        ],
    }  # fmt: skip


def timeline(decisions: int = 4) -> dict[str, Any]:
    told = [
        {"number": n, "t_s": 8.0 * n, "frontier": n + 3, "in_words": f"frontier {n + 3}"}
        for n in range(1, decisions + 1)
    ]
    stop = {"number": 1, "t_s": 19.0, "state": "held", "kind": "obstacle", "over": True}
    goal = {"id": "5f3a09c1", "goal": "a red mug"}
    return {**goal, "decisions": told, "stops": [stop | {"reason": "a person"}]}


def health() -> dict[str, Any]:
    stages = {
        "tick": (0.4, 1.9, 20.0), "frame": (41.0, 96.0, 150.0), "survey": (6.0, 22.0, 40.0),
        "place": (3.0, 14.0, 30.0), "decide": (1.0, 9.0, 40.0), "act": (1.2, 8.0, 25.0),
        "detect": (160.0, 455.0, 400.0),
    }  # fmt: skip
    return {
        "stages": {
            name: {"p50_ms": p50, "p99_ms": p99, "budget_ms": most, "over": int(p99 > most)}
            for name, (p50, p99, most) in stages.items()
        },
        "late_ms": {"p50": 0.2, "p99": 2.1, "max": 6.0},
        "streams": {"camera/color": {"per_s": 10.0, "age_s": 0.1, "bad": 0}},
        "halts": {"obstacle": 1}, "money": None, "rungs": {"o2f": "local", "r2f": "local"},
        "rung": "local", "memory_mb": 612.0, "up_s": 372.0, "wrong": [],
        "view": {"clients": 1, "cpu_share": 0.05, "memory_mb": 88.0},
    }  # fmt: skip


def picture(width: int = 640, height: int = 480) -> bytes:
    """A JPEG of a grey room."""
    ramp = np.linspace(200, 90, height, dtype=np.uint8)[:, None, None]
    image = np.ascontiguousarray(np.broadcast_to(ramp, (height, width, 3)))
    cv2.rectangle(image, (0, 0), (width, height * 5 // 8), (206, 214, 220), -1)
    cv2.rectangle(image, (90, 210), (330, 380), (120, 140, 170), -1)
    cv2.rectangle(image, (418, 232), (450, 268), (40, 40, 190), -1)
    return bytes(cv2.imencode(".jpg", image)[1])


def tell_all(page: PageDouble) -> None:
    """A search under way, all of it."""
    page.say("names", names=["mug", "bed", "toilet", "sofa"])
    page.say("state", **state())
    page.say("scene", **scene())
    page.say("zones", zones=[zone("rug", 2.2, -2.6, 3.0, -1.6)], bound=True)
    page.say("places", places=[{"name": "dock", "xy": [0.0, 0.0], "yaw": 0.0}], memory="none")
    page.say("decision", **decision())
    page.say("timeline", **timeline())
    page.say("health", **health())
    page.show_map(*cells(0.9), X0_M, Y0_M)
    page.show_picture(picture(), 640, 480)
    box = {"x": 418, "y": 232, "w": 32, "h": 36, "name": "mug", "score": 0.47, "goal": True}
    page.say("boxes", stamp_ns=0, width=640, height=480, boxes=[box])


def zone(name: str, x0: float, y0: float, x1: float, y1: float) -> dict[str, Any]:
    return {"name": name, "polygon": [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]}
