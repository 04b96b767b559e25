"""Recipes of the bundled suites `val`, `labels` and `official`: homes, goals, and their order.

The suites themselves are data (`suites/*.json`), so that nothing drifts when a generator changes
its mind about an order; `hil-sim episodes --make NAME` makes them again.
"""

import itertools
import random
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from hil_sim.evaluation.sample import Wish, sample_all
from hil_sim.ground_truth.episodes import HM3D_GOALS, ROBOTHOR_GOALS, SHORTEST_M, Episode
from hil_sim.scenes.format import SceneError

REPLICAS = tuple(f"FloorPlan_Val{i}_{j}" for i in (1, 2) for j in range(1, 6))
OTHERS = ("refrigerator", "bathtub", "stove", "laptop", "bookcase", "washing machine", "desk",
          "sink")  # fmt: skip
"""Goals beside HM3D's six, one in five."""
VAL_HOMES, VAL_REPLICAS = 40, 20
LABEL_HOMES, LABEL_GOALS, LABEL_STARTS = 30, 4, 2
LABEL_FIRST = 1000  # the seed of the first home, beyond those of `val`
REPLICA_GOALS = 3
UNSEEN = tuple(f"FloorPlan_Val3_{j}" for j in range(1, 6))
"""Apartments of RoboTHOR that nothing was trained or tuned on."""
DRAWN, NO_GOAL = 100, "vase"
"""How many of their official episodes are drawn, and the goal that is left out: as when they were
driven first, in replicas whose vases no person would have known."""
NOTE = (
    "Episodes in FloorPlan_* start where the public RoboTHOR 2021 challenge data set (Apache-2.0) "
    "has them start; homes, other meshes and lengths are ours."
)
OFFICIAL_NOTE = (
    f"Drawn from the episodes of {UNSEEN[0]} to {UNSEEN[-1]} in the public RoboTHOR 2021 challenge "
    "data set (Apache-2.0), whose starts and lengths these are; without vases, and without those "
    "that cannot be driven in our replicas, which have other meshes."
)


def make_suite(
    name: str, replicas: Path | None, workers: int = 1
) -> tuple[tuple[Episode, ...], str]:
    """A suite's episodes by its recipe, and a note on where they come from."""
    if name not in ("val", "labels", "official"):
        raise SceneError(f"suite {name}: no recipe; known: labels, official, val")
    if name == "labels":
        return tuple(_labels(workers)), ""
    if replicas is None:
        raise SceneError(
            f"suite {name}: needs RoboTHOR's episodes; name their folder by --replicas"
        )
    if name == "official":
        return tuple(_official(replicas, workers)), OFFICIAL_NOTE
    return tuple(_val(replicas, workers)), NOTE


def _val(folder: Path, workers: int) -> list[Episode]:
    """20 episodes in replicas and 40 in generated homes, a third and two thirds of any part."""
    from hil_sim.importers.robothor_episodes import official_episodes

    wishes = [_home(seed) for seed in range(VAL_HOMES)]
    given = official_episodes(folder, REPLICAS, None, 0)
    wishes += offers(given, VAL_REPLICAS // len(REPLICAS))
    found = sample_all(wishes, workers)
    generated = [episode for episodes in found[:VAL_HOMES] for episode in episodes]
    rows = found[VAL_HOMES:]
    official = [e for row in itertools.zip_longest(*rows) for e in row if e is not None]
    return interleaved(official, generated)


def _official(folder: Path, workers: int) -> list[Episode]:
    """As `hil-sim eval --episodes FOLDER --limit 100` draws them, the apartments in turn."""
    from hil_sim.importers.robothor_episodes import official_episodes

    drawn = official_episodes(folder, UNSEEN, DRAWN, 0)
    wanted = [episode for episode in drawn if episode.goal != NO_GOAL]
    given = {scene: tuple(e for e in wanted if e.scene == scene) for scene in UNSEEN}
    wishes = [Wish(scene, given=given[scene], all_given=True) for scene in UNSEEN]
    rows = itertools.zip_longest(*sample_all(wishes, workers))
    return [episode for row in rows for episode in row if episode is not None]


def _home(seed: int) -> Wish:
    """One episode in a generated home: HM3D's goals in turn, every fifth time another one."""
    turn, left = divmod(seed, 5)
    first = OTHERS[turn % len(OTHERS)] if left == 4 else HM3D_GOALS[(seed - turn) % 6]
    rest = random.Random(f"goals/{seed}").sample(HM3D_GOALS, len(HM3D_GOALS))
    return Wish(f"val-{seed}", (first, *(g for g in rest if g != first)), most=1, seed=seed)


def _labels(workers: int) -> list[Episode]:
    """300 episodes: many a home, since homes take long to set up; any part has all homes."""
    wishes = []
    for number in range(LABEL_HOMES):
        goals = random.Random(f"labels/{number}").sample(HM3D_GOALS, len(HM3D_GOALS))
        place = number % (len(goals) - 1)
        goals.insert(place, OTHERS[number % len(OTHERS)])
        scene = f"val-{LABEL_FIRST + number}"
        wishes.append(Wish(scene, tuple(goals), LABEL_GOALS, LABEL_STARTS, seed=number))
    for number, scene in enumerate(REPLICAS):
        names = random.Random(f"labels/{scene}").sample(ROBOTHOR_GOALS, len(ROBOTHOR_GOALS))
        wishes.append(Wish(scene, tuple(names), REPLICA_GOALS, LABEL_STARTS, seed=number))
    rows = itertools.zip_longest(*sample_all(wishes, workers))
    return [episode for row in rows for episode in row if episode is not None]


def offers(given: Sequence[Episode], most: int) -> list[Wish]:
    """For each scene its official episodes, in an order that spreads the goals: where many scenes
    take the first few, no goal is taken twice as often as another that could be had."""
    rng = random.Random("official")
    taken: Counter[str] = Counter()
    wishes = []
    for scene in sorted({episode.scene for episode in given}):
        left = [e for e in given if e.scene == scene and e.shortest_path_m >= SHORTEST_M]
        rng.shuffle(left)
        order: list[Episode] = []
        for number in range(len(left)):
            have = {e.goal for e in order[-most:]}
            best = min(left, key=lambda e: (e.goal in have, taken[e.goal]))
            left.remove(best)
            order.append(best)
            taken[best.goal] += number < most
        wishes.append(Wish(scene, given=tuple(order), most=most))
    return wishes


def interleaved(few: Sequence[Episode], many: Sequence[Episode]) -> list[Episode]:
    """Both lists, evenly mixed, so that any part from the beginning holds its share of each."""
    places = [((i + 0.5) / len(few), 0, e) for i, e in enumerate(few)]
    places += [((i + 0.5) / len(many), 1, e) for i, e in enumerate(many)]
    return [episode for _, _, episode in sorted(places, key=lambda place: place[:2])]
