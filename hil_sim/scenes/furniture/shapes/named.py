"""Meshes of simple geometry, for what no catalogue has, by name; most come in six variants."""

from collections.abc import Callable
from functools import partial

from hil_sim.scenes.furniture.shapes import (
    armchairs,
    bathroom,
    beds,
    bins,
    chairs,
    decor,
    drawn_goals,
    food,
    furniture,
    goals,
    greens,
    lamps,
    machines,
    screens,
    small,
    sofas,
    sport,
    storage,
    toys,
    vessels,
)
from hil_sim.scenes.furniture.shapes import palette as c
from hil_sim.scenes.furniture.shapes.primitives import Part, box, pick

VARIANTS = 6
OWN = {
    "armchair": 8, "bed": 8, "chair": 14, "plant": 8, "sofa": 10, "closed_laptop": 6,
    "drawn_alarm_clock": 12, "drawn_apple": 12, "drawn_ball": 8, "drawn_bat": 10, "drawn_bowl": 12,
    "drawn_leaning_bat": 21, "drawn_low_vase": 9, "drawn_mug": 12, "drawn_spray_bottle": 12,
    "drawn_vase": 12,
}  # fmt: skip
"""How many variants there are of what only varied homes and replicas show."""
HELD_OUT = (4, 5)
"""Variants that no training home shows, in categories with fewer than three catalogue meshes."""


def mirror(k: int) -> Part:
    """A framed pane."""
    w, h = pick(k, (0.6, 0.9), (0.5, 1.4), (0.9, 0.7))
    return [
        box((w, 0.03, h), (0, 0, 0), pick(k, c.WOOD, c.WHITE, c.DARK, c.STEEL)),
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
        box((w, 0.03, h), (0, 0, 0), pick(k, c.WOOD, c.DARK, c.WHITE, c.DARK_WOOD)),
        box((w - 0.08, 0.012, h - 0.08), (0, -0.021, 0.04), sky),
        box((w * 0.43, 0.012, h * 0.4), (-w * 0.14, -0.028, h * 0.2), land),
        box((w * 0.28, 0.012, h * 0.24), (w * 0.2, -0.028, h * 0.5), sun),
    ]


def kitchen_counter(k: int) -> Part:
    """A base cabinet with a worktop, 0.6 m wide."""
    return [
        box((0.6, 0.56, 0.1), (0, 0.02, 0), c.DARK),
        box((0.6, 0.58, 0.76), (0, 0.01, 0.1), pick(k, c.WHITE, c.PALE_WOOD, c.CREAM, c.GREY)),
        box((0.6, 0.6, 0.04), (0, 0, 0.86), pick(k, (0.45, 0.42, 0.4), c.DARK, c.WOOD)),
        box((0.3, 0.02, 0.02), (0, -0.29, 0.75), c.STEEL),
    ]


def rug(k: int) -> Part:
    """With a border and a field."""
    w, d = pick(k, (2.0, 1.4), (1.6, 1.1), (2.4, 1.7))
    edge, field = pick(k, ((0.55, 0.3, 0.28), (0.55, 0.3, 0.28)), (c.BLUE, c.CREAM),
                       (c.DARK, c.GREY),
                       (c.CREAM, c.RED), (c.GREEN, c.CREAM), (c.GREY, c.WHITE))  # fmt: skip
    return [
        box((w, d, 0.008), (0, 0, 0), edge),
        box((w - 0.25, d - 0.25, 0.002), (0, 0, 0.008), field),
        box((w * 0.4, d * 0.4, 0.002), (0, 0, 0.0095), edge),
    ]


def plain_box(k: int) -> Part:
    """A cuboid."""
    card, pale = (0.7, 0.55, 0.38), (0.85, 0.83, 0.78)
    return [box((0.4, 0.4, 0.4), (0, 0, 0), pick(k, card, pale, c.WOOD, c.GREY, c.BLUE, c.GREEN))]


def bathmat(k: int) -> Part:
    """A plain mat."""
    return [
        box(
            (0.8, 0.5, 0.01),
            (0, 0, 0),
            pick(k, (0.5, 0.65, 0.7), c.WHITE, c.GREY, c.CREAM, c.BLUE, c.RED),
        )
    ]


def door(k: int) -> Part:
    """A door's leaf with a handle."""
    return [
        box(
            (0.85, 0.04, 2.0),
            (0, 0, 0),
            pick(k, c.WOOD, c.WHITE, c.PALE_WOOD, c.GREY, c.DARK_WOOD, c.CREAM),
        ),
        box((0.12, 0.08, 0.03), (0.34, 0, 1.0), c.STEEL),
    ]


def wall_shelf(k: int) -> Part:
    """A board."""
    return [
        box(
            (0.8, 0.22, 0.03),
            (0, 0, 0),
            pick(k, c.WOOD, c.WHITE, c.PALE_WOOD, c.DARK, c.DARK_WOOD, c.GREY),
        )
    ]


SHAPES: dict[str, Callable[[int], Part]] = {
    "alarm_clock": goals.alarm_clock,
    "apple": goals.apple,
    "aquarium": toys.aquarium,
    "armchair": armchairs.armchair,
    "backpack": sport.backpack,
    "baseball_bat": goals.baseball_bat,
    "baseball_bat_standing": goals.baseball_bat_standing,
    "basketball": goals.basketball,
    "bathmat": bathmat,
    "bed": beds.bed,
    "bench": furniture.bench,
    "blender": machines.blender,
    "book": small.book,
    "boots": toys.boots,
    "bottle": vessels.bottle,
    "bowl": goals.bowl,
    "box": plain_box,
    "cardboard_box": decor.cardboard_box,
    "bread": food.bread,
    "broom": toys.broom,
    "bucket": bins.bucket,
    "butter_knife": food.butter_knife,
    "candle": small.candle,
    "cd": small.cd,
    "cell_phone": small.cell_phone,
    "chair": chairs.chair,
    "clock": decor.clock,
    "closed_laptop": drawn_goals.closed_laptop,
    "clothes_rack": furniture.clothes_rack,
    "coffee_machine": machines.coffee_machine,
    "computer_monitor": screens.computer_monitor,
    "cup": vessels.cup,
    "curtain": decor.curtain,
    "desk_lamp": lamps.desk_lamp,
    "dishwasher": furniture.dishwasher,
    "dog_bed": furniture.dog_bed,
    "door": door,
    "dresser": storage.dresser,
    "drawn_alarm_clock": drawn_goals.drawn_alarm_clock,
    "drawn_apple": drawn_goals.drawn_apple,
    "drawn_ball": drawn_goals.drawn_ball,
    "drawn_bat": drawn_goals.drawn_bat,
    "drawn_bowl": drawn_goals.drawn_bowl,
    "drawn_leaning_bat": drawn_goals.drawn_leaning_bat,
    "drawn_low_vase": drawn_goals.drawn_low_vase,
    "drawn_mug": drawn_goals.drawn_mug,
    "drawn_spray_bottle": drawn_goals.drawn_spray_bottle,
    "drawn_vase": drawn_goals.drawn_vase,
    "drying_rack": furniture.drying_rack,
    "dumbbell": sport.dumbbell,
    "egg": food.egg,
    "fan": machines.fan,
    "fireplace": furniture.fireplace,
    "floor_lamp": lamps.floor_lamp,
    "fork": food.fork,
    "game_console": screens.game_console,
    "garbage_bag": bins.garbage_bag,
    "guitar": sport.guitar,
    "kettle": vessels.kettle,
    "keyboard": screens.keyboard,
    "kitchen_counter": kitchen_counter,
    "knife": food.knife,
    "laptop": screens.laptop,
    "laundry_basket": bins.laundry_basket,
    "lettuce": food.lettuce,
    "microwave": machines.microwave,
    "mirror": mirror,
    "mug": goals.mug,
    "newspaper": small.newspaper,
    "nightstand": storage.nightstand,
    "ottoman": furniture.ottoman,
    "pan": vessels.pan,
    "paper_towel": bathroom.paper_towel,
    "pen": small.pen,
    "pencil": small.pencil,
    "pepper_shaker": food.pepper_shaker,
    "piano": furniture.piano,
    "picture": picture,
    "pillow": decor.pillow,
    "pillow_upright": decor.pillow_upright,
    "plant": greens.plant,
    "plate": vessels.plate,
    "plunger": bathroom.plunger,
    "pot": vessels.pot,
    "potato": food.potato,
    "printer": screens.printer,
    "radio": screens.radio,
    "remote_control": small.remote_control,
    "rug": rug,
    "safe": storage.safe,
    "salt_shaker": food.salt_shaker,
    "shelf": storage.shelf,
    "shelving_unit": storage.shelving_unit,
    "shower": bathroom.shower,
    "side_table": storage.side_table,
    "soap_bottle": bathroom.soap_bottle,
    "soccer_ball": sport.soccer_ball,
    "sofa": sofas.sofa,
    "speaker": screens.speaker,
    "spoon": food.spoon,
    "spray_bottle": goals.spray_bottle,
    "statue": decor.statue,
    "suitcase": sport.suitcase,
    "teapot": vessels.teapot,
    "teddy_bear": toys.teddy_bear,
    "television": screens.television,
    "tennis_racket": sport.tennis_racket,
    "tennis_racket_standing": sport.tennis_racket_standing,
    "tissue_box": bathroom.tissue_box,
    "toaster": machines.toaster,
    "toilet": bathroom.toilet,
    "toilet_paper": bathroom.toilet_paper,
    "tomato": food.tomato,
    "towel": bathroom.towel,
    "toy": toys.toy,
    "trash_can": bins.trash_can,
    "tv_stand": storage.tv_stand,
    "umbrella": toys.umbrella,
    "vacuum_cleaner": machines.vacuum_cleaner,
    "vase": bins.vase,
    "wall_shelf": wall_shelf,
    "washing_machine": furniture.washing_machine,
    "watch": small.watch,
    "watering_can": bins.watering_can,
    "wine_bottle": vessels.wine_bottle,
    "wine_glass": vessels.wine_glass,
}
"""Name -> what builds its variant k."""

BUILTINS: dict[str, Callable[[], Part]] = {
    **{name: partial(shape, 0) for name, shape in SHAPES.items()},
    **{
        f"{name}.{k}": partial(shape, k)
        for name, shape in SHAPES.items()
        for k in range(OWN.get(name, VARIANTS))
    },
}
"""NAME is variant 0, NAME.K is variant K."""
