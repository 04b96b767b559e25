"""Files as `hil-sim beyond` writes them, of homes in which what lies beyond can be seen: the right
half of a keyframe's features is that of the room behind the frontier."""

from pathlib import Path

import numpy as np

CATEGORIES = ("bed", "toilet", "stove", "sofa", "bathtub", "nightstand", "guitar", "sink")
ROOMS = ("kitchen", "bathroom", "bedroom", "living room")
IN_ROOM = ((2, 7), (1, 4, 7), (0, 5), (3, 6))
CHANNELS, GRID = 24, (6, 8)
DETECTOR = "d" * 64
"""SHA-256 of who saw them."""


def draw_homes(folder: Path, homes: int, seed: int, frames: int = 24, rows: int = 60) -> None:
    """Write FOLDER/homes/*.npz."""
    rng = np.random.default_rng(seed)
    (folder / "homes").mkdir(parents=True, exist_ok=True)
    for home in range(homes):
        np.savez(folder / "homes" / f"home-{home:03}.npz", **draw_home(rng, frames, rows))


def draw_home(rng: np.random.Generator, frames: int, rows: int) -> dict[str, np.ndarray]:
    """One home's table."""
    look = np.random.default_rng(0).normal(size=(len(ROOMS), CHANNELS))
    holds = np.zeros((len(ROOMS), len(CATEGORIES)), bool)
    for room, things in enumerate(IN_ROOM):
        holds[room, list(things)] = True
    room, behind = rng.integers(0, len(ROOMS), (2, frames))
    features = rng.normal(size=(frames, CHANNELS, *GRID)) * 0.3
    features[..., :4] += look[room][..., None, None]
    features[..., 4:] += look[behind][..., None, None]
    frame = np.sort(rng.integers(0, frames, rows))
    moment, frontier = np.arange(rows) // 6, np.arange(rows) % 3
    order = moment * 3 + frontier
    best = np.zeros(rows, bool)
    best[np.unique(order, return_index=True)[1]] = True
    there = holds[behind[frame]]
    asked = ~holds[room[frame]]
    area = np.zeros((rows, len(ROOMS)))
    area[np.arange(rows), behind[frame]] = 9.0
    beyond = np.where(there & asked, 3.0, np.inf)
    return {
        "features": features.astype(np.float16),
        "depth": np.ones((frames, 2, *GRID), np.float16),
        "rooms": np.eye(len(ROOMS), dtype=np.float16)[room],
        "room": room.astype(np.int8),
        "in_view": holds[room],
        "frame": frame.astype(np.int32),
        "column": np.full(rows, 0.75, np.float32),
        "range_m": np.full(rows, 2.0, np.float32),
        "moment": moment.astype(np.int32),
        "frontier": frontier.astype(np.int32),
        "best": best,
        "unknown_m2": np.full(rows, 2.0, np.float32),
        "told_rooms": np.eye(len(ROOMS), dtype=np.float16)[room[frame]],
        "asked": asked,
        "absent": np.zeros_like(asked),
        "beyond_m": beyond.astype(np.float32),
        "onward_m": np.where(asked, np.where(there, 3.0, 9.0), np.inf).astype(np.float32),
        "area_m2": area.sum(axis=1).astype(np.float32),
        "room_m2": area.astype(np.float32),
        "categories": np.array(CATEGORIES),
        "room_names": np.array(ROOMS),
        "detector": np.array(DETECTOR),
    }
