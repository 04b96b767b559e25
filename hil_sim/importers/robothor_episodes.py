"""The official RoboTHOR 2021 episodes, read into ours."""

import math
import random
from collections.abc import Collection
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from hil_sim.ground_truth.episodes import Episode, Start
from hil_sim.scenes.robothor.evidence import read_rows
from hil_sim.scenes.robothor.metadata import APARTMENTS, MetadataError
from hil_sim.scenes.robothor.scenes import GOALS


@dataclass(frozen=True)
class OfficialEpisode(Episode):
    """An official episode. `horizon_rad`: how far down the camera looks at its start."""

    horizon_rad: float = 0.0


def official_episodes(
    folder: Path,
    scenes: Collection[str] | None = None,
    limit: int | None = None,
    seed: int = 0,
) -> tuple[OfficialEpisode, ...]:
    """The episodes in a folder's *.json.gz, at any depth, ordered by scene, then as in the file.

    `scenes` keeps those of these names (none given: all); `limit` draws that many by seed, in
    order. The shortest path's length is the official one, to where the goal is visible within 1 m.
    MetadataError is one line that names the file, and the episode where it is one's fault.
    """
    found: list[OfficialEpisode] = []
    for path in _files(folder):
        name = path.name.removesuffix(".json.gz")
        if not scenes or name in scenes or name not in APARTMENTS:
            rows = enumerate(read_rows(path))
            read = [_episode(row, f"{path}: episodes[{i}]") for i, row in rows]
            found += [episode for episode in read if not scenes or episode.scene in scenes]
    if not found:
        raise MetadataError(f"{folder}: no official episodes of these scenes")
    if limit is not None and limit < len(found):
        drawn = random.Random(f"official/{seed}").sample(range(len(found)), limit)
        found = [found[i] for i in sorted(drawn)]
    return tuple(found)


def _files(folder: Path) -> list[Path]:
    """The folder's episode files, in the order of the scenes; files of other names come last."""
    if not folder.is_dir():
        raise MetadataError(f"{folder}: no such folder of official episodes")
    paths = list(folder.rglob("*.json.gz"))
    if not paths:
        raise MetadataError(f"{folder}: holds no *.json.gz, the official episodes")
    place = {f"{name}.json.gz": i for i, name in enumerate(APARTMENTS)}
    return sorted(paths, key=lambda path: (place.get(path.name, len(place)), str(path)))


def _episode(row: dict[str, Any], place: str) -> OfficialEpisode:
    goal, scene = _text(row, "object_type", place), _text(row, "scene", place)
    if goal not in GOALS:
        raise MetadataError(f"{place}: object_type: {goal!r} is none of {', '.join(GOALS)}")
    if scene not in APARTMENTS:
        raise MetadataError(f"{place}: scene: {scene!r} is not one of the {len(APARTMENTS)} scenes")
    at = row.get("initial_position")
    if not isinstance(at, dict):
        raise MetadataError(f"{place}: initial_position: missing or not an object")
    theta = math.radians(_number(row, "initial_orientation", place))
    start = Start(
        round(_number(at, "x", f"{place}: initial_position"), 4),
        round(_number(at, "z", f"{place}: initial_position"), 4),
        round(math.remainder(math.pi / 2 - theta, 2 * math.pi), 4),
    )
    return OfficialEpisode(
        id=_text(row, "id", place),
        scene=scene,
        start=start,
        goal=GOALS[goal],
        shortest_path_m=round(_length(row, place), 4),
        horizon_rad=round(math.radians(_number(row, "initial_horizon", place)), 4),
    )


def _length(row: dict[str, Any], place: str) -> float:
    path = row.get("shortest_path")
    if not isinstance(path, list) or not all(isinstance(point, dict) for point in path):
        raise MetadataError(f"{place}: shortest_path: missing or not a list of points")
    label = f"{place}: shortest_path"
    line = [tuple(_number(point, axis, label) for axis in "xyz") for point in path]
    return sum(math.dist(a, b) for a, b in pairwise(line))


def _text(row: dict[str, Any], key: str, place: str) -> str:
    value = row.get(key)
    if not isinstance(value, str) or not value:
        raise MetadataError(f"{place}: {key}: missing or not a text")
    return value


def _number(row: dict[str, Any], key: str, place: str) -> float:
    value = row.get(key)
    good = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not good or not math.isfinite(value):  # type: ignore[arg-type]
        raise MetadataError(f"{place}: {key}: missing or not a finite number")
    return float(value)  # type: ignore[arg-type]
