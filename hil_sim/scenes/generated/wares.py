"""Which meshes a word of the placement statistics means."""

from hil_sim.scenes.furniture.boxes import CatalogMesh, furniture
from hil_sim.scenes.generated.furnisher import Furnisher

KITCHEN_SINKS = ("Blend Swap CC-0#sinkCabinet", "Blend Swap CC-BY#kitchenSink")
LOW_CABINETS = (
    "Blend Swap CC-0#drawersCabinet", "Blend Swap CC-0#lowerCabinet",
    "Blend Swap CC-BY#kitchenDrawersCabinet", "Blend Swap CC-BY#kitchenLowerCabinet",
    "Blend Swap CC-BY#kitchenSmallLowerCabinet",
)  # fmt: skip
LIVING_CABINETS = ("Scopia#box_room", "Blend Swap CC-0#televisionCabinet", "Scopia#office_box")
OFFICE_CHAIRS = ("Kator Legaz#office-chair", "Scopia#office_chair", "Scopia#kids_desk_chair")
ODD_CHAIRS = ("Scopia#children_chair", "Scopia#classSeat", "Kator Legaz#office-chair",
              "Scopia#office_chair", "Scopia#kids_desk_chair", "Scopia#leaf_chair",
              "Scopia#designChair")  # fmt: skip
"""Not for dining tables."""
CLUTTER = {
    "floor": (
        "guitar", "backpack", "suitcase", "bench", "ottoman", "speaker", "drying rack", "toy",
        "dumbbell", "vacuum cleaner", "dog bed", "boots", "garbage bag", "bucket", "clothes rack",
        "fan", "umbrella", "soccer ball", "watering can", "safe", "large other",
    ),
    "kitchen": (
        "kettle", "teapot", "blender", "bread", "tomato", "lettuce", "potato", "egg", "cup",
        "salt shaker", "pepper shaker", "wine bottle", "wine glass", "knife", "fork", "spoon",
        "butter knife", "paper towel", "radio", "kitchen other",
    ),
    "desk": (
        "computer monitor", "printer", "radio", "fan", "aquarium", "pen", "pencil", "keyboard",
        "cd", "watch", "tissue box", "candle", "newspaper", "game console", "small other",
    ),
}  # fmt: skip
"""What stands about that the statistics do not have."""


RUGS = (
    "Kator Legaz#oriental-rug", "Scopia#round-carpet", "builtin:rug.0", "builtin:rug.1",
    "builtin:rug.2", "builtin:rug.3", "builtin:rug.4", "builtin:rug.5",
)  # fmt: skip


def _sized(category: str, low: float, high: float, widest: float = 9.0) -> tuple[str, ...]:
    """Ids of the category's meshes with a height in [low, high) m and sides up to `widest`."""
    return tuple(
        mesh.id
        for mesh in furniture().get(category, ())
        if low <= mesh.size_m[2] < high and max(mesh.size_m[:2]) <= widest
    )


def _hung(category: str, hung: bool) -> tuple[str, ...]:
    """Ids of the category's meshes that hang on a wall, or that do not."""
    return tuple(m.id for m in furniture()[category] if (m.z_m > 0.0) == hung)


FINER: dict[str, tuple[str, tuple[str, ...]]] = {
    "hung towel": ("towel", _hung("towel", True)),
    "folded towel": ("towel", _hung("towel", False)),
    "hung toilet paper": ("toilet paper", _hung("toilet paper", True)),
    "roll": ("toilet paper", _hung("toilet paper", False)),
    "lying bat": ("baseball bat", _sized("baseball bat", 0.0, 0.2)),
    "large other": ("other", (
        "Scopia#water_cooler", "Scopia#indoor-bike", "Scopia#doll-house", "Scopia#puff",
        "Blend Swap CC-0#ammoBox", "Kator Legaz#trunk-large")),
    "small other": ("other", ("Scopia#folded_clothes", "Blend Swap CC-BY#gift")),
    "kitchen other": ("other", (
        "Blend Swap CC-0#kitchenaid", "Blend Swap CC-0#tetrapak", "Blend Swap CC-BY#breadBox",
        "Blend Swap CC-BY#coffeePress", "Scopia#cooker", "Scopia#small-oven",
        "Kator Legaz#oil-servers")),
    "counter": ("cabinet", LOW_CABINETS),
    "small plant": ("plant", _sized("plant", 0.0, 0.62, 0.5)),
    "big plant": ("plant", _sized("plant", 0.5, 3.0)),
    "floor vase": ("vase", _sized("vase", 0.45, 3.0)),
    "small vase": ("vase", _sized("vase", 0.0, 0.45)),
    "standing television": ("television", tuple(
        m.id for m in furniture()["television"] if m.z_m == 0.0)),
    "hung television": ("television", tuple(
        m.id for m in furniture()["television"] if m.z_m > 0.0)),
    "kitchen sink": ("sink", KITCHEN_SINKS),
    "bathroom sink": ("sink", tuple(
        m.id for m in furniture()["sink"] if m.id not in KITCHEN_SINKS)),
    "low cabinet": ("cabinet", tuple(m.id for m in furniture()["cabinet"] if m.z_m < 1)),
    "upper cabinet": ("cabinet", tuple(m.id for m in furniture()["cabinet"] if m.z_m > 1)),
    "living cabinet": ("cabinet", LIVING_CABINETS),
    "office chair": ("chair", OFFICE_CHAIRS),
    "dining chair": ("chair", tuple(
        m.id for m in furniture()["chair"] if m.id not in ODD_CHAIRS)),
}  # fmt: skip
"""Finer words: (category, which of its meshes). What stands on something is the small kind."""
SMALLER = {
    "plant": "small plant", "vase": "small vase", "television": "standing television",
    "towel": "folded towel", "toilet paper": "roll", "baseball bat": "lying bat",
}  # fmt: skip
HUNG = {"television": "hung television", "towel": "hung towel", "toilet paper": "hung toilet paper"}
LARGER = {
    "plant": "big plant", "vase": "floor vase", "towel": "folded towel", "toilet paper": "roll",
    "baseball bat": "lying bat",
}  # fmt: skip


LIKE = {"cup": "mug", "wine bottle": "bottle", "soap bottle": "bottle", "ottoman": "stool"}
"""What stands in for a category of which there is no mesh."""


def find(home: Furnisher, word: str, longest: float = 9.0, on: str = "floor") -> CatalogMesh | None:
    """A mesh for the word that suits where it is to stand; None if there is none."""
    kinds = {"floor": LARGER, "wall": HUNG}.get(on, SMALLER)
    word = kinds.get(word, word)
    if word in furniture():
        return home.pick(word, (), longest)
    category, only = FINER.get(word, (LIKE.get(word, word), ()))
    if word in FINER and not only:
        return None
    return home.pick(category, only, longest)
