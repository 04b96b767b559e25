"""Which meshes a word of the placement statistics means."""

from hil_sim.furnish import Mesh, furniture
from hil_sim.furnisher import Furnisher

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
        "Blend Swap CC-0#crate", "Blend Swap CC-0#electricGuitar", "Blend Swap CC-BY#backpack",
        "Blend Swap CC-BY#gift", "Blend Swap CC-BY#suitcase", "Kator Legaz#bench",
        "Scopia#water_cooler", "Scopia#indoor-bike", "Scopia#clothes-horse", "Scopia#doll-house",
        "Blend Swap CC-0#ammoBox", "Kator Legaz#trunk-large", "Scopia#puff",
        "Blend Swap CC-0#speaker3",
    ),
    "kitchen": (
        "Blend Swap CC-0#kitchenaid", "Blend Swap CC-0#tetrapak", "Blend Swap CC-BY#boiler",
        "Blend Swap CC-BY#breadBox", "Blend Swap CC-BY#coffeePress", "Scopia#cooker",
        "Blend Swap CC-BY#kitchenblender", "Kator Legaz#oil-servers", "Scopia#teapot",
        "Scopia#small-oven", "Scopia#bowlWithFruits",
    ),
    "desk": (
        "Kator Legaz#apple-imac-1998", "Scopia#apple_pc", "Scopia#inkjet_and_scanner_printer",
        "Scopia#mini_stereo", "Blend Swap CC-BY#radio", "Blend Swap CC-0#tableFan",
        "Scopia#folded_clothes", "Scopia#aquarium", "Blend Swap CC-BY#gift",
    ),
}  # fmt: skip
RUGS = ("Kator Legaz#oriental-rug", "Scopia#round-carpet")


def _sized(category: str, low: float, high: float, widest: float = 9.0) -> tuple[str, ...]:
    """Ids of the category's meshes with a height in [low, high) m and sides up to `widest`."""
    return tuple(
        mesh.id
        for mesh in furniture().get(category, ())
        if low <= mesh.size_m[2] < high and max(mesh.size_m[:2]) <= widest
    )


FINER: dict[str, tuple[str, tuple[str, ...]]] = {
    "counter": ("cabinet", LOW_CABINETS),
    "shelf": ("other", tuple(m.id for m in furniture()["other"] if "wall_shelf" in m.id)),
    "tv stand": ("other", ("Blend Swap CC-BY#tvStand",)),
    "floor lamp": ("lamp", _sized("lamp", 1.0, 3.0)),
    "desk lamp": ("lamp", _sized("lamp", 0.0, 0.75, 0.45)),
    "teddy bear": ("other", ("Blend Swap CC-0#teddyBear",)),
    "laundry basket": ("other", ("Scopia#clothes-basket",)),
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
SMALLER = {"plant": "small plant", "vase": "small vase", "television": "standing television"}
HUNG = {"television": "hung television"}
LARGER = {"plant": "big plant", "vase": "floor vase"}


LIKE = {"cup": "mug", "wine bottle": "bottle", "soap bottle": "bottle", "ottoman": "stool"}
"""What stands in for a category of which there is no mesh."""


def find(home: Furnisher, word: str, longest: float = 9.0, on: str = "floor") -> Mesh | None:
    """A mesh for the word that suits where it is to stand; None if there is none."""
    kinds = {"floor": LARGER, "wall": HUNG}.get(on, SMALLER)
    word = kinds.get(word, word)
    if word in furniture():
        return home.pick(word, (), longest)
    category, only = FINER.get(word, (LIKE.get(word, word), ()))
    if word in FINER and not only:
        return None
    return home.pick(category, only, longest)
