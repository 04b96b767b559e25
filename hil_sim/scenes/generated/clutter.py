"""Things strewn about a home, for detectors to learn what furnished homes seldom show."""

from hil_sim.scenes.furniture.boxes import CatalogMesh
from hil_sim.scenes.furniture.surfaces import resting_place
from hil_sim.scenes.generated.furnisher import Furnisher
from hil_sim.scenes.generated.placing import against_wall, in_the_open, on_top
from hil_sim.scenes.generated.wares import find

SMALL = (
    "apple", "backpack", "blender", "book", "bowl", "butter knife", "candle", "cd", "cell phone",
    "computer monitor", "cup", "egg", "fork", "game console", "kettle", "keyboard", "knife",
    "lamp", "lettuce", "mug", "newspaper", "pan", "paper towel", "pen", "pencil", "pillow",
    "plate", "pot", "potato", "printer", "radio", "remote control", "salt shaker", "speaker",
    "spoon", "spray bottle", "teapot", "teddy bear", "tissue box", "toaster", "tomato", "toy",
    "watch", "wine bottle", "wine glass",
)  # fmt: skip
LARGE = (
    "baseball bat", "bookcase", "bucket", "clothes rack", "dishwasher", "dog bed", "drying rack",
    "fireplace", "garbage bag", "laundry basket", "ottoman", "piano", "plunger", "shelving unit",
    "stool", "tennis racket", "vacuum cleaner", "washing machine",
)  # fmt: skip
"""Both: what fewer than some 250 of 6,000 frames of furnished homes show, and hard goals."""
SMALL_A_ROOM, LARGE_A_ROOM = 12, 5
SEATS = (
    "armchair", "bed", "chair", "coffee table", "desk", "dresser", "ottoman", "plant", "sofa",
    "stool", "television", "toilet", "wardrobe",
)  # fmt: skip
"""The larger goals, and what is taken for them."""
SEATS_A_ROOM = 3
FLOOR_SHARE = 0.25
"""Of the small things that lie on the floor where a top would do."""


def strew(home: Furnisher) -> None:
    """Things of any kind in the room that was entered, wherever there is space for them."""
    rng = home.rng
    for name in rng.sample(LARGE, LARGE_A_ROOM):
        _stand(home, find(home, name))
    for name in rng.sample(SMALL, SMALL_A_ROOM):
        if rng.random() < FLOOR_SHARE or not _lay(home, find(home, name, on="table")):
            _stand(home, find(home, name))


def seat(home: Furnisher) -> None:
    """Furniture that need not fit the type of the room, before what does."""
    for name in home.rng.sample(SEATS, SEATS_A_ROOM):
        _stand(home, find(home, name))


def _lay(home: Furnisher, mesh: CatalogMesh | None) -> bool:
    supports = [obj for obj in home.here if resting_place(obj)]
    home.rng.shuffle(supports)
    return any(on_top(home, mesh, support) for support in supports)


def _stand(home: Furnisher, mesh: CatalogMesh | None) -> None:
    if home.rng.random() < 0.5:
        in_the_open(home, mesh)
    else:
        against_wall(home, mesh, jitter=0.4)
