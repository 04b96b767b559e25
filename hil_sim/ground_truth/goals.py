"""What a goal's words mean in the scenes' categories."""

import re

from hil_sim.scenes.format import CATEGORIES, ROOM_TYPES, Scene
from hil_sim.scenes.robothor.unrecognised import unrecognised
from runtime.core.goal_phrase import parse

SYNONYMS: dict[str, str] = {
    "alarm clock": "alarm, bedside clock, wake-up clock",
    "apple": "red apple, green apple",
    "aquarium": "fish tank, fish bowl, fishbowl",
    "armchair": "arm chair, easy chair, recliner, lounge chair",
    "backpack": "rucksack, school bag, knapsack, book bag",
    "baseball bat": "bat, baseball club",
    "basketball": "basket ball",
    "bathtub": "bath, tub, bath tub",
    "blender": "liquidiser, liquidizer, food blender, smoothie maker",
    "book": "paperback, novel, textbook, hardback",
    "bookcase": "bookshelf, book shelf, bookshelves, book case",
    "boots": "boot, pair of boots, wellingtons, rubber boots, wellies",
    "bottle": "water bottle, drink bottle, glass bottle",
    "bowl": "salad bowl, fruit bowl, cereal bowl",
    "box": "cardboard box, carton, storage box, moving box",
    "bread": "loaf, loaf of bread, bread loaf, baguette",
    "broom": "sweeping brush, besom",
    "bucket": "pail",
    "butter knife": "table knife, dinner knife",
    "cabinet": "sideboard, kitchen cabinet, filing cabinet",
    "candle": "candlestick, wax candle",
    "cd": "compact disc, disc, dvd",
    "cell phone": "cellphone, mobile phone, mobile, smartphone, phone, telephone",
    "clothes rack": "clothes rail, garment rack, coat rack",
    "coffee machine": "coffee maker, espresso machine, coffeemaker",
    "coffee table": "cocktail table",
    "computer monitor": "monitor, computer screen, desktop, desktop computer, display",
    "cup": "tumbler, teacup, tea cup, drinking cup, drinking glass",
    "curtain": "curtains, drapes, drape",
    "desk": "writing desk, work desk, computer desk, office desk",
    "desk lamp": "table lamp, reading lamp, work lamp, bedside lamp",
    "dishwasher": "dish washer, dishwashing machine",
    "dog bed": "pet bed, dog basket",
    "dresser": "chest of drawers, drawers, commode",
    "drying rack": "clothes horse, airer, clothes airer, laundry rack",
    "dumbbell": "weight, hand weight, dumb-bell, barbell",
    "egg": "hen's egg",
    "fan": "ventilator, electric fan, table fan",
    "fireplace": "hearth, mantelpiece, chimney",
    "floor lamp": "standing lamp, standard lamp, standing light, torchiere",
    "fork": "dinner fork, table fork",
    "game console": "console, video game console, games console, gaming console",
    "garbage bag": "trash bag, bin bag, rubbish bag, bin liner",
    "guitar": "acoustic guitar, electric guitar",
    "kettle": "tea kettle, electric kettle, water kettle",
    "keyboard": "computer keyboard",
    "laptop": "notebook, notebook computer, laptop computer, portable computer",
    "laundry basket": "laundry hamper, hamper, clothes basket, washing basket, clothes hamper",
    "lettuce": "salad, head of lettuce",
    "microwave": "microwave oven",
    "mirror": "looking glass, wall mirror",
    "mug": "coffee mug, tea mug, coffee cup",
    "newspaper": "paper, daily paper",
    "nightstand": "bedside table, night stand, night table, bedside cabinet",
    "ottoman": "pouffe, footstool, foot stool, footrest, hassock",
    "pan": "frying pan, skillet, fry pan",
    "paper towel": "paper towels, kitchen roll, paper towel roll, kitchen paper",
    "pen": "ballpoint, ballpoint pen, biro",
    "pencil": "lead pencil",
    "pepper shaker": "pepper mill, pepper pot, pepper grinder",
    "piano": "upright piano, grand piano",
    "picture": "painting, poster, framed picture, wall art, picture frame, photo",
    "pillow": "cushion, throw pillow, sofa cushion",
    "plant": "potted plant, houseplant, house plant, indoor plant, pot plant, flower",
    "plate": "dinner plate",
    "plunger": "toilet plunger, sink plunger",
    "pot": "saucepan, cooking pot, stockpot, casserole",
    "potato": "spud",
    "printer": "inkjet printer, scanner",
    "radiator": "heater, heating",
    "radio": "stereo, wireless, transistor radio",
    "refrigerator": "fridge, icebox, fridge freezer, fridge-freezer, freezer",
    "remote control": "remote, tv remote, television remote, remote controller",
    "rug": "carpet, floor rug",
    "safe": "strongbox, strong box",
    "salt shaker": "salt cellar, salt pot",
    "shower": "shower stall, shower cabin, shower cubicle",
    "side table": "end table, occasional table, lamp table",
    "shelving unit": "shelves, storage rack, rack, storage shelf",
    "sink": "washbasin, basin, wash basin, hand basin, kitchen sink",
    "soap bottle": "soap dispenser, hand soap, liquid soap, soap",
    "soccer ball": "football, soccerball",
    "sofa": "couch, settee, loveseat, love seat, divan",
    "speaker": "loudspeaker, loud speaker, hi-fi speaker",
    "spoon": "tablespoon, teaspoon",
    "spray bottle": "sprayer, spray, cleaning spray, trigger spray, atomiser",
    "statue": "sculpture, figurine, bust, statuette",
    "stool": "bar stool, barstool, kitchen stool",
    "stove": "oven, cooker, kitchen range, range, hob",
    "suitcase": "luggage, travel bag, trolley case, travel case",
    "table": "dining table, dinner table, kitchen table",
    "teapot": "tea pot",
    "teddy bear": "teddy, plush bear, stuffed bear, soft toy",
    "television": "tv, tv monitor, telly, tv set, television set, flat screen, tv screen",
    "tennis racket": "racket, tennis racquet, racquet",
    "tissue box": "tissues, box of tissues, kleenex, tissue",
    "toaster": "bread toaster",
    "toilet": "lavatory, wc, loo, water closet",
    "toilet paper": "toilet roll, loo roll, bathroom tissue, toilet tissue",
    "towel": "bath towel, hand towel",
    "toy": "toy car, building blocks, stacking toy, plaything",
    "trash can": "garbage can, bin, wastebasket, waste basket, dustbin, rubbish bin, waste bin, "
    "trash bin, wastepaper basket, recycling bin",
    "tv stand": "tv cabinet, television stand, media console, tv bench, tv unit",
    "umbrella": "brolly, parasol",
    "vacuum cleaner": "vacuum, hoover, vac",
    "vase": "flower vase",
    "wardrobe": "closet, armoire, clothes cupboard",
    "washing machine": "washer, clothes washer, laundry machine",
    "watch": "wristwatch, wrist watch",
    "watering can": "watering pot",
    "wine bottle": "bottle of wine",
    "wine glass": "goblet, wineglass, stemware",
}
"""Other words for one category."""
BROAD: dict[str, tuple[str, ...]] = {
    "ball": ("basketball", "soccer ball"),
    "chair": ("chair", "armchair"),
    "clock": ("clock", "alarm clock"),
    "computer": ("laptop", "computer monitor"),
    "cupboard": ("cabinet", "wardrobe"),
    "glass": ("cup", "wine glass"),
    "knife": ("knife", "butter knife"),
    "lamp": ("lamp", "desk lamp", "floor lamp"),
    "light": ("lamp", "desk lamp", "floor lamp"),
    "seat": ("chair", "armchair", "sofa", "stool", "bench"),
    "shelf": ("shelf", "shelving unit"),
}
"""Words that several categories satisfy."""
GOALS: dict[str, tuple[str, ...]] = {
    **{word: (category,) for category, text in SYNONYMS.items() for word in text.split(", ")},
    **BROAD,
}
"""What a goal's words mean, where they are not the one category of that name."""
# The runtime reads a goal by a pattern of its own: the harness must not share what it judges.
ARTICLE = re.compile(r"^(the|a|an|my|our|your|some) ")


def categories_of(goal: str) -> tuple[str, ...]:
    """The scene categories that satisfy a goal."""
    word = ARTICLE.sub("", " ".join(goal.lower().split()))
    return GOALS.get(word, (word,))


def category_word(text: str) -> str:
    """The one word of a goal in a person's words that names a category here; the text as it is
    where there is none. What stands around it is taken off by the runtime's grammar; which category
    it is, is not asked of the runtime."""
    things = parse(text, _Named()).things
    named = tuple(thing for thing in things if _Named().thing(thing))
    return named[0] if len(things) == len(named) == 1 else text


class _Named:
    """What a phrase is, by the scenes' own categories."""

    def thing(self, phrase: str) -> bool:
        """Whether categories satisfy it."""
        return all(category in CATEGORIES for category in GOALS.get(phrase, (phrase,)))

    def room(self, phrase: str) -> bool:
        """Whether it is a type of room."""
        return phrase in ROOM_TYPES


def not_asked(scene: Scene, goal: str) -> str:
    """Why no episode in this scene asks for the goal, though something there satisfies it: a person
    would not recognise that. "" where one may ask."""
    return unrecognised(scene, categories_of(goal))
