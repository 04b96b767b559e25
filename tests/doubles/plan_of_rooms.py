"""Three rooms in a row as a plan: a bedroom, a hallway in the middle, a bathroom; doors between."""

from hil_sim.scenes.format import Door, Room, Scene, SceneObject, Wall

CORNERS = [(0.0, 0.0), (12.0, 0.0), (12.0, 4.0), (0.0, 4.0)]
KINDS = ("bedroom", "hallway", "bathroom")


def thing(id: str, category: str, x: float, y: float, size_m: tuple[float, float, float]):
    """A box on the floor."""
    return SceneObject(id, category, "none", (x, y, 0.0), size_m=size_m)


def three_rooms(*more: SceneObject) -> Scene:
    """Rooms of 4 m by 4 m: a bed in the first, a toilet in the last, at its far wall."""
    outer = tuple(
        Wall(a, b, 0.1, "outer") for a, b in zip(CORNERS, CORNERS[1:] + CORNERS[:1], strict=True)
    )
    inner = tuple(Wall((x, 0.0), (x, 4.0), 0.1) for x in (4.0, 8.0))
    rooms = tuple(
        Room(kind, kind, ((x, 0.0), (x + 4.0, 0.0), (x + 4.0, 4.0), (x, 4.0)))
        for kind, x in zip(KINDS, (0.0, 4.0, 8.0), strict=True)
    )
    doors = (Door((4.0, 2.5), (4.0, 3.4)), Door((8.0, 0.6), (8.0, 1.5)))
    bed = thing("bed", "bed", 1.0, 1.2, (1.6, 2.0, 0.5))
    toilet = thing("toilet", "toilet", 11.6, 3.0, (0.5, 0.7, 0.8))
    return Scene("three", (*outer, *inner), doors, rooms, (bed, toilet, *more))
