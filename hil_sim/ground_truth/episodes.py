"""Episodes: a scene, a start pose, a goal and the length of the shortest path to it.

Sampled by seed, or read from a suite: a JSON file (`rf-nav-suite/1`) that lists them.
"""

import json
import math
import random
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hil_sim.ground_truth.freespace import FreeSpace, scene_hash
from hil_sim.scenes.format import SceneError, contains

FORMAT = "rf-nav-suite/1"
SUITES_DIR = Path(__file__).parents[1] / "suites"
SHORTEST_M = 2.0
"""A start is at least this far from success, where the home is large enough."""
TRIES = 60
HM3D_GOALS = ("chair", "sofa", "plant", "bed", "toilet", "tv monitor")
ROBOTHOR_GOALS = ("alarm clock", "apple", "baseball bat", "basketball", "bowl", "laptop", "mug",
                  "plant", "spray bottle", "television", "trash can", "vase")  # fmt: skip

Sees = Callable[[float, float, float], bool]


@dataclass(frozen=True)
class Start:
    """A pose in the scene frame."""

    x_m: float
    y_m: float
    yaw_rad: float


@dataclass(frozen=True)
class Episode:
    """One task: reach and face the goal. `shortest_path_m` is geodesic, to success; `home` names
    the content of the scene that it was made for, "" when it is not known."""

    id: str
    scene: str
    start: Start
    goal: str
    shortest_path_m: float
    home: str = ""


def sample_episode(
    space: FreeSpace,
    success: NDArray[np.integer],
    goal: str,
    seed: int,
    sees_goal: Sees = lambda x, y, yaw: False,
    scene: str | None = None,
) -> Episode:
    """An episode in this home: the same seed gives the same one.

    `success` (N, 2) are the goal's success cells. The start lies in a spawn area, connected to
    success, at least 2 m away and without the goal in view; the last two give way in homes that
    have no such place. SceneError if no start is connected.
    """
    name = scene or space.scene.name
    field = space.distance_field(space.points(success))
    starts = _starts(space, field)
    if len(starts) == 0:
        raise SceneError(f"{name}: goal {goal!r}: no start is connected to a place that sees it")
    far = starts[field[tuple(starts.T)] >= SHORTEST_M]
    pool = far if len(far) else starts
    rng = random.Random(f"episode/{name}/{goal}/{seed}")
    for attempt in range(TRIES):
        row, col = pool[rng.randrange(len(pool))]
        x, y = (float(v) for v in space.points(np.array([[row, col]]))[0])
        yaw = rng.randrange(-180, 180, 30) * math.pi / 180
        if attempt == TRIES - 1 or not sees_goal(x, y, yaw):
            break
    start = Start(round(x, 3), round(y, 3), round(yaw, 4))
    slug = goal.replace(" ", "-")
    short = Path(name).stem if name.endswith(".json") else name
    length = round(float(field[row, col]), 3)
    return Episode(f"{short}-{slug}-{seed}", name, start, goal, length, home_name(space))


def _starts(space: FreeSpace, field: NDArray[np.float64]) -> NDArray[np.intp]:
    cells = np.argwhere(np.isfinite(field))
    areas = space.scene.spawn or tuple(room.polygon for room in space.scene.rooms)
    points = space.points(cells)
    kept = [any(contains(area, x, y) for area in areas) for x, y in points]
    starts: NDArray[np.intp] = cells[np.array(kept, bool)]
    return starts


def known_suites() -> tuple[str, ...]:
    """Names of the bundled suites."""
    return tuple(sorted(path.stem for path in SUITES_DIR.glob("*.json")))


def load_suite(name_or_path: str | Path) -> tuple[Episode, ...]:
    """The episodes of a bundled suite by name, or of a suite file by path."""
    path = Path(name_or_path)
    if path.suffix != ".json":
        path = SUITES_DIR / f"{name_or_path}.json"
        if str(name_or_path) not in known_suites():
            known = ", ".join(known_suites())
            raise SceneError(f"suite {name_or_path}: unknown; known: {known}, or a .json file")
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise SceneError(f"{path}: no such suite file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"{path}: cannot be read: {error}") from None
    except json.JSONDecodeError as error:
        raise SceneError(f"{path}:{error.lineno}: not JSON: {error.msg}") from None
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise SceneError(f"{path}: format: not a suite; this version reads {FORMAT!r}")
    rows = data.get("episodes")
    if not isinstance(rows, list) or not rows:
        raise SceneError(f"{path}: episodes: a list with at least one episode is needed")
    episodes = tuple(_episode(row, f"{path}: episodes[{i}]") for i, row in enumerate(rows))
    _check_ids(episodes, path)
    return episodes


def _check_ids(episodes: Sequence[Episode], path: Path) -> None:
    """Results are kept by id."""
    count = Counter(episode.id for episode in episodes)
    twice = [id for id, times in count.items() if times > 1]
    if twice:
        raise SceneError(f"{path}: two episodes have the id {twice[0]!r}; give each one of its own")


def save_suite(episodes: tuple[Episode, ...], path: Path, note: str = "") -> None:
    """Write a suite, one episode a line, with a note for people."""
    _check_ids(episodes, path)
    rows = ",\n".join(f"    {json.dumps(asdict(episode))}" for episode in episodes)
    said = f'  "note": {json.dumps(note)},\n' if note else ""
    text = f'{{\n  "format": "{FORMAT}",\n{said}  "episodes": [\n{rows}\n  ]\n}}\n'
    path.write_text(text, encoding="utf-8")


def _episode(row: Any, place: str) -> Episode:
    if not isinstance(row, dict):
        raise SceneError(f"{place}: not an object")
    want = {"id": str, "scene": str, "goal": str, "start": dict, "shortest_path_m": (int, float)}
    for key, kind in want.items():
        if not isinstance(row.get(key), kind):  # type: ignore[arg-type]
            raise SceneError(f"{place}: {key}: missing or of the wrong kind")
    start = row["start"]
    for key in ("x_m", "y_m", "yaw_rad"):
        value = start.get(key)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise SceneError(f"{place}: start.{key}: missing or not a number")
    pose = Start(float(start["x_m"]), float(start["y_m"]), float(start["yaw_rad"]))
    length = float(row["shortest_path_m"])
    return Episode(row["id"], row["scene"], pose, row["goal"], length, str(row.get("home", "")))


def home_name(space: FreeSpace) -> str:
    """Names a scene's content, for `Episode.home`."""
    return scene_hash(space.scene)[:10]


def check_start(episode: Episode, space: FreeSpace) -> None:
    """SceneError if this is another home, or the start is not a free place of it."""
    if episode.home and episode.home != home_name(space):
        raise SceneError(
            f"{episode.id}: {episode.scene} has changed since this was made; make the suite "
            "again (hil-sim episodes)"
        )
    x, y = episode.start.x_m, episode.start.y_m
    if not space.is_free(x, y):
        raise SceneError(
            f"{episode.id}: start ({x:g}, {y:g}): inside furniture, a wall or outside the home"
        )
