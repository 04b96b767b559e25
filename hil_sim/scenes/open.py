"""Any home by its name: a bundled scene, a scene file, a generated home, a RoboTHOR replica."""

import re
from pathlib import Path

from hil_sim.scenes.format import Scene, SceneError
from hil_sim.scenes.scene_file import known_scenes, load_scene

_GENERATED = re.compile(r"(train|val)-(\d+)(?:-rooms(\d+))?(?:-(cluttered|varied))?")
_REPLICA = "FloorPlan_"


def is_replica(name: str) -> bool:
    """Whether a scene of this name is one of RoboTHOR's."""
    return name.startswith(_REPLICA)


def open_scene(name_or_path: str | Path) -> Scene:
    """`maple`, `path/home.json`, `val-17`, `val-17-rooms7`, `train-17-cluttered` or
    `train-17-varied` (generated), `FloorPlan_Val1_1` (RoboTHOR). SceneError says what there is."""
    name = str(name_or_path)
    if name in known_scenes() or name.endswith(".json"):
        return load_scene(name_or_path)
    generated = _GENERATED.fullmatch(name)
    if generated:
        from hil_sim.scenes.generated.home import generate

        split, seed, rooms, kind = generated.groups()
        return generate(int(seed), split, int(rooms) if rooms else None, kind or "")
    if is_replica(name):
        from hil_sim.scenes.robothor.scenes import robothor_scene

        return robothor_scene(name)
    raise SceneError(
        f"scene {name}: unknown; known: {', '.join(known_scenes())}, a .json file, "
        "train-SEED or val-SEED (generated), FloorPlan_Train1_1 to FloorPlan_Val3_5 (RoboTHOR)"
    )
