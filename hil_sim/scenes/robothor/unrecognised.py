"""Goals in the replicas that a person would not recognise from 1 m: no episode asks for them.

`unrecognised.json` has them by scene and object, with the reason; `hil-sim sheet` shows all goals.
"""

import functools
import json
from collections.abc import Collection
from pathlib import Path

from hil_sim.scenes.format import Scene


def unrecognised(scene: Scene, categories: Collection[str]) -> str:
    """Why a person would know none of the scene's objects of these categories; "" if they would
    know one, or there is none."""
    why = listed().get(scene.name, {})
    ids = [obj.id for obj in scene.objects if obj.category in categories]
    return "; ".join(sorted({why[id] for id in ids})) if set(ids) <= why.keys() else ""


@functools.cache
def listed() -> dict[str, dict[str, str]]:
    """Reasons by scene and object id."""
    path = Path(__file__).with_name("unrecognised.json")
    table: dict[str, dict[str, str]] = json.loads(path.read_text(encoding="utf-8"))
    return table
