"""What a room still lacks, put where the statistics have it: on the floor, a wall, or a thing."""

import random
from dataclasses import dataclass, field

from hil_sim.scenes.format import SceneObject
from hil_sim.scenes.furniture.boxes import CatalogMesh
from hil_sim.scenes.furniture.surfaces import resting_place
from hil_sim.scenes.generated.furnisher import Furnisher
from hil_sim.scenes.generated.placement import Habit, Habits, habits
from hil_sim.scenes.generated.placing import against_wall, beside, in_the_open, on_top
from hil_sim.scenes.generated.wares import CLUTTER, RUGS, find

HEIGHT_M = {"picture": (1.15, 1.5), "mirror": (1.0, 1.25), "clock": (1.5, 1.8),
            "towel": (0.7, 1.2), "shelf": (1.3, 1.6), "toilet paper": (0.6, 0.75),
            "television": (0.95, 1.1)}  # fmt: skip
"""How high the underside of what hangs on a wall is."""
TALL_M = 2.1
"""How high what hangs on a wall reaches at most."""
MOST = {"shelf": 2, "nightstand": 3, "vase": 3, "statue": 3, "chair": 6, "counter": 4}
NOT_ON_FLOOR = ("remote control", "cell phone", "candle", "laptop", "tissue box", "book", "bowl",
                "soap bottle", "newspaper", "pillow", "mug", "television")  # fmt: skip
"""The statistics have some of these on floors too, where one would only be told to tidy up."""
IN_THE_OPEN = ("chair", "armchair", "stool", "box", "basketball")
"""What may stand away from walls, where the statistics have it so."""
FACING = ("television", "laptop", "alarm clock", "microwave", "coffee machine", "toaster",
          "desk lamp", "statue", "pillow", "teddy bear")  # fmt: skip
"""Small things that look the same way as what they stand on."""
ORDER = (
    "bed", "sofa", "bathtub", "shower", "table", "desk", "wardrobe", "dresser", "tv stand",
    "bookcase", "coffee table", "armchair", "chair", "nightstand", "counter", "shelf",
    "television", "mirror", "picture", "floor lamp", "stool", "trash can", "laundry basket",
    "baseball bat", "basketball", "plant", "laptop", "microwave", "coffee machine", "desk lamp",
    "alarm clock", "pillow", "spray bottle", "bowl", "mug", "apple", "vase",
)  # fmt: skip
"""Large things are placed first, what others stand on before those, and goals before trifles."""
UNSEEN = {
    "kitchen": {"washing machine": 0.35, "radiator": 0.25, "clock": 0.4},
    "bathroom": {"washing machine": 0.3, "radiator": 0.4, "clock": 0.05},
    "bedroom": {"wardrobe": 0.75, "radiator": 0.35, "clock": 0.15, "lamp": 0.1},
    "living room": {"radiator": 0.35, "piano": 0.2, "fireplace": 0.2, "living cabinet": 0.35,
                    "clock": 0.3},
    "dining room": {"radiator": 0.3, "piano": 0.2, "fireplace": 0.2, "living cabinet": 0.35,
                    "clock": 0.3},
    "study": {"radiator": 0.35, "piano": 0.1, "bookcase": 0.4, "low cabinet": 0.3, "clock": 0.2},
    "hallway": {"radiator": 0.35, "wardrobe": 0.15, "clock": 0.2, "mirror": 0.3},
}  # fmt: skip
"""Chances of what homes have and iTHOR's rooms do not: set by hand, not counted."""


@dataclass
class Wanted:
    """What a room shall hold: habits by category, and how many are still to be placed."""

    habits: Habits
    left: dict[str, int] = field(default_factory=dict)

    @classmethod
    def draw(cls, rng: random.Random, kind: str) -> "Wanted":
        table = habits(kind)
        left = {
            name: min(habit.draw_count(rng), MOST.get(name, 9)) for name, habit in table.items()
        }
        return cls(table, left)

    def take(self, name: str) -> int:
        """How many of them; from now on none is left."""
        return self.left.pop(name, 0)

    def placed(self, name: str, count: int = 1) -> None:
        self.left[name] = max(0, self.left.get(name, 0) - count)


def complete(home: Furnisher, wanted: Wanted, kind: str) -> None:
    """Place what is left: large furniture first, then what hangs, then what stands on things."""
    _unseen(home, kind)
    rows = [(name, count) for name, count in wanted.left.items() if count]
    for name, count in sorted(rows, key=lambda row: (_turn(row[0]), row[0])):
        habit = wanted.habits[name]
        for _ in range(count):
            place(home, name, habit)
    if kind != "bathroom" and home.rng.random() < 0.35:
        _clutter(home)


def place(home: Furnisher, name: str, habit: Habit) -> SceneObject | None:
    """One of them where the statistics have it, else where else they have it in this room."""
    chances = dict(row for row in habit.on if _offers(home, name, row[0]))
    while chances:
        on = home.rng.choices(list(chances), list(chances.values()))[0]
        if on == "inside":
            return None
        del chances[on]
        if (mesh := find(home, name, on=on)) and (obj := _put(home, mesh, name, on, habit)):
            return obj
    return None


def _put(
    home: Furnisher, mesh: CatalogMesh, name: str, on: str, habit: Habit
) -> SceneObject | None:
    if on == "floor":
        return stand(home, mesh, name, habit)
    if on == "wall":
        return hang(home, mesh, name)
    choices, facing = home.named(on), 0.12 if name in FACING else None
    home.rng.shuffle(choices)
    placed = (on_top(home, mesh, support, facing, name, name == "pillow") for support in choices)
    return next((obj for obj in placed if obj), None)


def stand(home: Furnisher, mesh: CatalogMesh, name: str, habit: Habit) -> SceneObject | None:
    """On the floor, against a wall or in the open, near what it is usually near."""
    if name in IN_THE_OPEN and home.rng.random() >= habit.wall:
        return in_the_open(home, mesh, near=habit.near, name=name)
    jitter = 0.2 if name in IN_THE_OPEN else 0.0
    return against_wall(home, mesh, jitter=jitter, near=habit.near, name=name)


def hang(home: Furnisher, mesh: CatalogMesh | None, name: str) -> SceneObject | None:
    """On a wall, at the height of such things."""
    if mesh is None:
        return None
    low, high = HEIGHT_M.get(name, (1.1, 1.5))
    z = min(home.rng.uniform(low, high), TALL_M - mesh.size_m[2])
    return against_wall(home, mesh, z, name=name)


def load(home: Furnisher, support: SceneObject | None, clutter: str, most: int) -> None:
    """Things that the statistics do not have, on a support."""
    for _ in range(home.rng.randint(0, most)):
        mesh = find(home, home.rng.choice(CLUTTER[clutter]), on="table")
        on_top(home, mesh, support, facing=0.15)


def rug(home: Furnisher, chance: float, under: SceneObject | None = None) -> None:
    """A thin rug, under that thing or anywhere."""
    if home.rng.random() >= chance:
        return
    mesh = home.pick("rug", RUGS)
    if under is None:
        in_the_open(home, mesh, square=True, name="rug")
    else:
        beside(home, mesh, under, 0.0, 0.0, name="rug")


def _offers(home: Furnisher, name: str, on: str) -> bool:
    """Whether this room has that support, and it can bear things of that name."""
    if on == "wall":
        return name in HEIGHT_M
    if on == "floor" and name in NOT_ON_FLOOR:
        return False
    return on in ("floor", "inside") or any(resting_place(obj) for obj in home.named(on))


def _turn(name: str) -> int:
    return ORDER.index(name) if name in ORDER else len(ORDER)


def _unseen(home: Furnisher, kind: str) -> None:
    for name, chance in UNSEEN[kind].items():
        if home.rng.random() >= chance:
            continue
        mesh = find(home, name, on="wall" if name in HEIGHT_M else "floor")
        if mesh is None:
            continue
        if name in HEIGHT_M:
            hang(home, mesh, name)
        else:
            against_wall(home, mesh, front_m=0.4 if name == "wardrobe" else 0.0, name=name)


def _clutter(home: Furnisher) -> None:
    mesh = find(home, home.rng.choice(CLUTTER["floor"]))
    against_wall(home, mesh, jitter=0.15)
