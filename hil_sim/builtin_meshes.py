"""Meshes of simple geometry, for what no catalogue has, by name; each comes in six variants."""

from collections.abc import Callable
from functools import partial

from hil_sim import (
    builtin_bathroom,
    builtin_bins,
    builtin_decor,
    builtin_food,
    builtin_furniture,
    builtin_goals,
    builtin_lamps,
    builtin_machines,
    builtin_screens,
    builtin_small,
    builtin_sport,
    builtin_storage,
    builtin_toys,
    builtin_vessels,
)
from hil_sim.builtin_shapes import (
    BLUE,
    CREAM,
    DARK,
    DARK_WOOD,
    GREEN,
    GREY,
    PALE_WOOD,
    RED,
    STEEL,
    WHITE,
    WOOD,
    Part,
    box,
    pick,
)

VARIANTS = 6
HELD_OUT = (4, 5)
"""Variants that no training home shows, in categories with fewer than three catalogue meshes."""


def mirror(k: int) -> Part:
    """A framed pane."""
    w, h = pick(k, (0.6, 0.9), (0.5, 1.4), (0.9, 0.7))
    return [
        box((w, 0.03, h), (0, 0, 0), pick(k, WOOD, WHITE, DARK, STEEL)),
        box((w - 0.08, 0.008, h - 0.08), (0, -0.019, 0.04), (0.72, 0.8, 0.85)),
    ]


def picture(k: int) -> Part:
    """A framed painting."""
    w, h = pick(k, (0.7, 0.5), (0.5, 0.7), (0.9, 0.6), (0.4, 0.4))
    sky, land, sun = pick(
        k,
        ((0.85, 0.8, 0.66), (0.3, 0.45, 0.6), (0.75, 0.4, 0.25)),
        ((0.55, 0.7, 0.85), (0.3, 0.5, 0.3), (0.9, 0.8, 0.4)),
        ((0.9, 0.88, 0.84), (0.2, 0.2, 0.22), (0.7, 0.15, 0.15)),
        ((0.2, 0.25, 0.4), (0.6, 0.6, 0.7), (0.95, 0.9, 0.7)),
        ((0.88, 0.6, 0.45), (0.45, 0.25, 0.3), (0.95, 0.85, 0.5)),
        ((0.75, 0.85, 0.75), (0.25, 0.4, 0.35), (0.85, 0.5, 0.55)),
    )
    return [
        box((w, 0.03, h), (0, 0, 0), pick(k, WOOD, DARK, WHITE, DARK_WOOD)),
        box((w - 0.08, 0.012, h - 0.08), (0, -0.021, 0.04), sky),
        box((w * 0.43, 0.012, h * 0.4), (-w * 0.14, -0.028, h * 0.2), land),
        box((w * 0.28, 0.012, h * 0.24), (w * 0.2, -0.028, h * 0.5), sun),
    ]


def kitchen_counter(k: int) -> Part:
    """A base cabinet with a worktop, 0.6 m wide."""
    return [
        box((0.6, 0.56, 0.1), (0, 0.02, 0), DARK),
        box((0.6, 0.58, 0.76), (0, 0.01, 0.1), pick(k, WHITE, PALE_WOOD, CREAM, GREY)),
        box((0.6, 0.6, 0.04), (0, 0, 0.86), pick(k, (0.45, 0.42, 0.4), DARK, WOOD)),
        box((0.3, 0.02, 0.02), (0, -0.29, 0.75), STEEL),
    ]


def rug(k: int) -> Part:
    """With a border and a field."""
    w, d = pick(k, (2.0, 1.4), (1.6, 1.1), (2.4, 1.7))
    edge, field = pick(k, ((0.55, 0.3, 0.28), (0.55, 0.3, 0.28)), (BLUE, CREAM), (DARK, GREY),
                       (CREAM, RED), (GREEN, CREAM), (GREY, WHITE))  # fmt: skip
    return [
        box((w, d, 0.008), (0, 0, 0), edge),
        box((w - 0.25, d - 0.25, 0.002), (0, 0, 0.008), field),
        box((w * 0.4, d * 0.4, 0.002), (0, 0, 0.0095), edge),
    ]


def plain_box(k: int) -> Part:
    """A cuboid."""
    card, pale = (0.7, 0.55, 0.38), (0.85, 0.83, 0.78)
    return [box((0.4, 0.4, 0.4), (0, 0, 0), pick(k, card, pale, WOOD, GREY, BLUE, GREEN))]


def bathmat(k: int) -> Part:
    """A plain mat."""
    return [
        box((0.8, 0.5, 0.01), (0, 0, 0), pick(k, (0.5, 0.65, 0.7), WHITE, GREY, CREAM, BLUE, RED))
    ]


def door(k: int) -> Part:
    """A door's leaf with a handle."""
    return [
        box((0.85, 0.04, 2.0), (0, 0, 0), pick(k, WOOD, WHITE, PALE_WOOD, GREY, DARK_WOOD, CREAM)),
        box((0.12, 0.08, 0.03), (0.34, 0, 1.0), STEEL),
    ]


def wall_shelf(k: int) -> Part:
    """A board."""
    return [
        box((0.8, 0.22, 0.03), (0, 0, 0), pick(k, WOOD, WHITE, PALE_WOOD, DARK, DARK_WOOD, GREY))
    ]


SHAPES: dict[str, Callable[[int], Part]] = {
    "alarm_clock": builtin_goals.alarm_clock,
    "apple": builtin_goals.apple,
    "aquarium": builtin_toys.aquarium,
    "backpack": builtin_sport.backpack,
    "baseball_bat": builtin_goals.baseball_bat,
    "baseball_bat_standing": builtin_goals.baseball_bat_standing,
    "basketball": builtin_goals.basketball,
    "bathmat": bathmat,
    "bench": builtin_furniture.bench,
    "blender": builtin_machines.blender,
    "book": builtin_small.book,
    "boots": builtin_toys.boots,
    "bottle": builtin_vessels.bottle,
    "bowl": builtin_goals.bowl,
    "box": plain_box,
    "cardboard_box": builtin_decor.cardboard_box,
    "bread": builtin_food.bread,
    "broom": builtin_toys.broom,
    "bucket": builtin_bins.bucket,
    "butter_knife": builtin_food.butter_knife,
    "candle": builtin_small.candle,
    "cd": builtin_small.cd,
    "cell_phone": builtin_small.cell_phone,
    "clock": builtin_decor.clock,
    "clothes_rack": builtin_furniture.clothes_rack,
    "coffee_machine": builtin_machines.coffee_machine,
    "computer_monitor": builtin_screens.computer_monitor,
    "cup": builtin_vessels.cup,
    "curtain": builtin_decor.curtain,
    "desk_lamp": builtin_lamps.desk_lamp,
    "dishwasher": builtin_furniture.dishwasher,
    "dog_bed": builtin_furniture.dog_bed,
    "door": door,
    "dresser": builtin_storage.dresser,
    "drying_rack": builtin_furniture.drying_rack,
    "dumbbell": builtin_sport.dumbbell,
    "egg": builtin_food.egg,
    "fan": builtin_machines.fan,
    "fireplace": builtin_furniture.fireplace,
    "floor_lamp": builtin_lamps.floor_lamp,
    "fork": builtin_food.fork,
    "game_console": builtin_screens.game_console,
    "garbage_bag": builtin_bins.garbage_bag,
    "guitar": builtin_sport.guitar,
    "kettle": builtin_vessels.kettle,
    "keyboard": builtin_screens.keyboard,
    "kitchen_counter": kitchen_counter,
    "knife": builtin_food.knife,
    "laptop": builtin_screens.laptop,
    "laundry_basket": builtin_bins.laundry_basket,
    "lettuce": builtin_food.lettuce,
    "microwave": builtin_machines.microwave,
    "mirror": mirror,
    "mug": builtin_goals.mug,
    "newspaper": builtin_small.newspaper,
    "nightstand": builtin_storage.nightstand,
    "ottoman": builtin_furniture.ottoman,
    "pan": builtin_vessels.pan,
    "paper_towel": builtin_bathroom.paper_towel,
    "pen": builtin_small.pen,
    "pencil": builtin_small.pencil,
    "pepper_shaker": builtin_food.pepper_shaker,
    "piano": builtin_furniture.piano,
    "picture": picture,
    "pillow": builtin_decor.pillow,
    "pillow_upright": builtin_decor.pillow_upright,
    "plate": builtin_vessels.plate,
    "plunger": builtin_bathroom.plunger,
    "pot": builtin_vessels.pot,
    "potato": builtin_food.potato,
    "printer": builtin_screens.printer,
    "radio": builtin_screens.radio,
    "remote_control": builtin_small.remote_control,
    "rug": rug,
    "safe": builtin_storage.safe,
    "salt_shaker": builtin_food.salt_shaker,
    "shelf": builtin_storage.shelf,
    "shelving_unit": builtin_storage.shelving_unit,
    "shower": builtin_bathroom.shower,
    "side_table": builtin_storage.side_table,
    "soap_bottle": builtin_bathroom.soap_bottle,
    "soccer_ball": builtin_sport.soccer_ball,
    "speaker": builtin_screens.speaker,
    "spoon": builtin_food.spoon,
    "spray_bottle": builtin_goals.spray_bottle,
    "statue": builtin_decor.statue,
    "suitcase": builtin_sport.suitcase,
    "teapot": builtin_vessels.teapot,
    "teddy_bear": builtin_toys.teddy_bear,
    "television": builtin_screens.television,
    "tennis_racket": builtin_sport.tennis_racket,
    "tennis_racket_standing": builtin_sport.tennis_racket_standing,
    "tissue_box": builtin_bathroom.tissue_box,
    "toaster": builtin_machines.toaster,
    "toilet": builtin_bathroom.toilet,
    "toilet_paper": builtin_bathroom.toilet_paper,
    "tomato": builtin_food.tomato,
    "towel": builtin_bathroom.towel,
    "toy": builtin_toys.toy,
    "trash_can": builtin_bins.trash_can,
    "tv_stand": builtin_storage.tv_stand,
    "umbrella": builtin_toys.umbrella,
    "vacuum_cleaner": builtin_machines.vacuum_cleaner,
    "vase": builtin_bins.vase,
    "wall_shelf": wall_shelf,
    "washing_machine": builtin_furniture.washing_machine,
    "watch": builtin_small.watch,
    "watering_can": builtin_bins.watering_can,
    "wine_bottle": builtin_vessels.wine_bottle,
    "wine_glass": builtin_vessels.wine_glass,
}
"""Name -> what builds its variant k."""

BUILTINS: dict[str, Callable[[], Part]] = {
    **{name: partial(shape, 0) for name, shape in SHAPES.items()},
    **{f"{n}.{k}": partial(shape, k) for n, shape in SHAPES.items() for k in range(VARIANTS)},
}
"""NAME is variant 0, NAME.K is variant K."""
