"""Homes' views that tests ask about."""

from pathlib import Path

import numpy as np

from hil_sim.expert_bench.bank import HOMES
from hil_sim.expert_bench.views import KINDS, HomeViews, write_views
from hil_sim.ground_truth.labels import LABELLED
from hil_sim.scenes.format import ROOM_TYPES

DETECTOR = "d" * 64
"""SHA-256 of who saw them."""
BED, MUG = LABELLED.index("bed"), LABELLED.index("mug")


def home_views(rows: int = 24, seed: int = 0, detector: str = DETECTOR) -> HomeViews:
    """As many frames as rows, each frame of one row, half of them the runtime's choice. A bed is
    beyond, and in view, where the frame's first feature is 1, and not where it is -1; the room is
    a bedroom there, and a kitchen elsewhere. No home has a mug."""
    there = np.random.default_rng(seed).permutation(rows) % 2 == 0
    count = len(LABELLED)
    features = np.zeros((rows, 4, 2, 3))
    features[:, 0] = np.where(there, 1, -1)[:, None, None]
    features[:, 1, 0, 0], features[:, 2, 0, 0] = np.arange(rows), seed  # no two are alike
    room = np.where(there, ROOM_TYPES.index("bedroom"), ROOM_TYPES.index("kitchen"))
    in_view, beyond_m = np.zeros((rows, count)), np.full((rows, count), np.inf)
    in_view[:, BED], beyond_m[:, BED] = there, np.where(there, 4.5, 5.5)
    asked = np.zeros((rows, count))
    asked[:, BED] = 1
    values = {
        "features": features, "depth": np.ones((rows, 2, 2, 3)), "scene": np.eye(rows, 384),
        "rooms": np.full((rows, len(ROOM_TYPES)), 1 / len(ROOM_TYPES)), "room": room,
        "in_view": in_view, "frame": np.arange(rows), "column": np.linspace(0, 1, rows),
        "range_m": np.full(rows, 2.5), "moment": np.arange(rows) // 4, "frontier": np.arange(rows),
        "best": np.arange(rows) % 2 == 0, "distance_m": np.ones(rows), "unknown_m2": np.ones(rows),
        "told_rooms": np.zeros((rows, len(ROOM_TYPES))), "asked": asked, "absent": 1 - asked,
        "beyond_m": beyond_m, "onward_m": beyond_m, "area_m2": np.ones(rows),
        "room_m2": np.zeros((rows, len(ROOM_TYPES))),
    }  # fmt: skip
    columns = {name: np.array(value, KINDS[name]) for name, value in values.items()}
    return HomeViews(**columns, detector=detector)


def write_homes(folder: Path, homes: int = 3, rows: int = 24) -> Path:
    """A folder of such homes."""
    (folder / HOMES).mkdir(parents=True, exist_ok=True)
    for n in range(homes):
        write_views(folder / HOMES / f"val-{300000 + n}.npz", home_views(rows, n))
    return folder
