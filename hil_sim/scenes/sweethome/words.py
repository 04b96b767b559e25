"""What a drawn thing is: by its catalogue id, its name in a few languages, or what is in it."""

import json
import re
import unicodedata
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from hil_sim.scenes.format import CATEGORIES, ROOM_TYPES

_FURNITURE = Path(__file__).parents[1] / "furniture" / "furniture.json"

ETEKS = {
    "bed140x190": "bed", "bed90x190": "bed", "bunkBed90x190": "bed", "cornerBunkBed90x190": "bed",
    "loftBed140x190": "bed", "bed": "bed", "crib": "bed", "chest": "dresser",
    "bedsideTable": "nightstand", "bookcase": "bookcase", "filledBookcase": "bookcase",
    "chair": "chair", "chair2": "chair", "armchair": "armchair", "armchair2": "armchair",
    "roundTable": "table", "squareTable": "table", "table": "table", "coffeeTable": "coffee table",
    "toiletUnit": "toilet", "washbasin": "sink", "washbasinWithCabinet": "sink", "sink": "sink",
    "bath": "bathtub", "fittedBath": "bathtub", "shower": "shower", "plant": "plant",
    "flowers": "plant", "clothesWasher": "washing machine", "cooker": "stove", "oven": "stove",
    "fridge": "refrigerator", "fridgeFreezer": "refrigerator", "kitchenCabinet": "cabinet",
    "kitchenUpperCabinet": "cabinet", "glassDoorCabinet": "cabinet", "piano": "piano",
    "sofa": "sofa", "sofa2": "sofa", "cornerSofa": "sofa", "stool": "stool",
    "tvUnit": "television", "flatTV": "television", "wardrobe": "wardrobe", "desk": "desk",
    "laptop": "laptop", "dresser": "dresser", "fireplace": "fireplace", "frame": "picture",
    "lamp": "lamp", "floorUplight": "lamp", "wallUplight": "lamp", "pendantLamp": "lamp",
    "workLamp": "lamp", "spotlight": "lamp", "electricRadiator": "radiator",
    "hotWaterRadiator": "radiator",
}  # fmt: skip
"""Sweet Home 3D's own catalogue; its other pieces (boxes, stairs, hood, ...) are "other"."""

WORDS = {
    "bed": "bed cot crib lit berceau bett kinderbett doppelbett cama cuna letto culla",
    "sofa": "sofa couch settee loveseat canape sofá divano bank sofabed",
    "chair": "chair chaise stuhl stuhle silla sedia stoel cadeira",
    "armchair": "armchair recliner fauteuil sessel sillon butaca poltrona",
    "table": "table tisch esstisch mesa tavolo tafel dining_table kitchen_table "
    "table_a_manger mesa_de_comedor",
    "coffee table": "coffee_table table_basse couchtisch mesa_de_centro tavolino salontafel",
    "desk": "desk schreibtisch escritorio scrivania bureau bureautafel workstation",
    "toilet": "toilet wc toilette klo inodoro retrete water vaso_sanitario sanitario",
    "bathtub": "bathtub bath tub baignoire badewanne banera vasca bad banheira jacuzzi",
    "shower": "shower douche dusche ducha doccia chuveiro shower_cabin shower_tray",
    "sink": "sink washbasin basin lavabo evier waschbecken spule spulbecken fregadero lavandino "
    "waschtisch lavello wastafel gootsteen pia handbasin",
    "refrigerator": "refrigerator fridge freezer refrigerateur frigo kuhlschrank gefrierschrank "
    "nevera frigorifico frigorifero koelkast geladeira",
    "stove": "stove cooker oven range hob cooktop cuisiniere four herd backofen estufa horno "
    "cocina fornello forno fornuis fogao",
    "microwave": "microwave micro_ondes mikrowelle microondas microonde magnetron",
    "television": "television tv televiseur fernseher televisor televisore televisie tele",
    "plant": "plant houseplant potted_plant flower plante fleur pflanze zimmerpflanze blume planta "
    "flor pianta fiore ficus palm",
    "laptop": "laptop notebook ordinateur_portable portatil portatile",
    "wardrobe": "wardrobe armoire kleiderschrank armario closet guardaroba armadio kledingkast "
    "guarda_roupa pax",
    "bookcase": "bookcase bookshelf bookshelves shelf shelves bibliotheque etagere bucherregal "
    "regal estanteria libreria boekenkast estante book_case",
    "cabinet": "cabinet cupboard sideboard buffet placard meuble schrank kuchenschrank "
    "unterschrank hangeschrank oberschrank kommode_tv tv_stand tv_cabinet tv_bench gabinete "
    "credenza kast base_cabinet wall_cabinet kitchen_unit",
    "nightstand": "nightstand bedside_table bedside_cabinet night_table table_de_chevet chevet "
    "nachttisch nachtkastchen mesita_de_noche mesilla comodino nachtkastje criado_mudo",
    "dresser": "dresser chest_of_drawers commode kommode comoda cassettiera ladekast drawers",
    "lamp": "lamp lampe lampadaire light chandelier leuchte stehlampe tischlampe lampara lampada "
    "floor_lamp table_lamp desk_lamp ceiling_light",
    "washing machine": "washing_machine washer clothes_washer lave_linge machine_a_laver "
    "waschmaschine lavadora lavatrice wasmachine dryer tumble_dryer",
    "stool": "stool tabouret hocker taburete sgabello kruk barhocker bar_stool footstool ottoman",
    "trash can": "trash_can trash_bin waste_bin garbage_can bin wastebasket dustbin poubelle "
    "mulleimer papierkorb papelera cubo_de_basura pattumiera cestino prullenbak lixeira",
    "vase": "vase florero jarron vaso vaas",
    "clock": "clock horloge pendule uhr wanduhr reloj orologio klok wall_clock",
    "alarm clock": "alarm_clock reveil wecker despertador sveglia wekker",
    "radiator": "radiator heater radiateur heizkorper heizung radiador radiatore",
    "piano": "piano klavier flugel pianoforte grand_piano",
    "fireplace": "fireplace cheminee kamin chimenea camino open_haard lareira",
    "mirror": "mirror miroir spiegel espejo specchio espelho",
    "picture": "picture painting poster frame photo tableau cadre bild gemalde cuadro quadro "
    "schilderij wall_art",
    "apple": "apple pomme apfel manzana mela appel",
    "baseball bat": "baseball_bat batte_de_baseball baseballschlager",
    "basketball": "basketball basket_ball",
    "bowl": "bowl bol schussel schale cuenco ciotola",
    "mug": "mug cup tasse becher taza tazza mok coffee_cup coffee_mug",
    "spray bottle": "spray_bottle spruhflasche vaporisateur",
    "door": "door porte tur puerta porta deur",
    "other": "chest trunk rug carpet tapis teppich alfombra tappeto curtain curtains rideau "
    "vorhang stairs staircase escalier treppe dishwasher lave_vaisselle spulmaschine hood hotte "
    "car bath_mat bed_linen",
}
"""Names a category goes by, without accents; `_` stands for a space."""

ROOMS = {
    "kitchen": "kitchen kitchenette cuisine kuche cocina cucina keuken cozinha pantry",
    "bathroom": "bathroom bath toilet toilets wc shower restroom ensuite en_suite salle_de_bain "
    "salle_de_bains salle_d_eau toilettes bad badezimmer gastebad gastewc bano aseo bagno badkamer "
    "banheiro lavabo laundry powder_room",
    "bedroom": "bedroom nursery bed chambre schlafzimmer kinderzimmer gastezimmer dormitorio "
    "habitacion alcoba camera camera_da_letto slaapkamer quarto guest_room kids_room master",
    "living room": "living living_room lounge salon sejour wohnzimmer stube sala sala_de_estar "
    "soggiorno salotto woonkamer family_room sitting_room great_room den wohnen",
    "dining room": "dining dining_room salle_a_manger esszimmer comedor sala_da_pranzo eetkamer "
    "sala_de_jantar essen",
    "study": "study office home_office library bureau arbeitszimmer buro despacho estudio studio "
    "ufficio kantoor werkkamer escritorio workroom",
    "hallway": "hall hallway corridor entry entrance foyer lobby landing vestibule couloir entree "
    "palier flur diele gang eingang pasillo entrada recibidor corridoio ingresso hal overloop "
    "corredor passage stairs",
}

VOTES = {
    "toilet": ("bathroom", 3), "bathtub": ("bathroom", 3), "shower": ("bathroom", 3),
    "bed": ("bedroom", 3), "nightstand": ("bedroom", 1), "wardrobe": ("bedroom", 1),
    "refrigerator": ("kitchen", 3), "stove": ("kitchen", 3), "microwave": ("kitchen", 2),
    "sofa": ("living room", 3), "television": ("living room", 1),
    "coffee table": ("living room", 1), "fireplace": ("living room", 1),
    "table": ("dining room", 1), "chair": ("dining room", 0.3), "desk": ("study", 2),
    "bookcase": ("study", 0.5), "washing machine": ("bathroom", 1), "sink": ("bathroom", 0.5),
}  # fmt: skip
"""What a piece of furniture says of the room that it stands in, and how loudly."""

OUTDOORS = (
    "terrace patio balcony garden yard driveway lawn pool terrasse balkon garten hof jardin cour "
    "balcon terraza patio terrazza balcone giardino cortile tuin terras terraco varanda loggia"
)
"""Rooms of these names are not of the home's inside."""

_CUT = re.compile(
    r" (?:de|di|da|do|du|for|with|without|of|on|in|mit|fur|avec|pour|con|para|per|met|com|a|et|and)"
    r" .*"
)
_WINDOW = re.compile(r"window|fenetre|fenster|ventana|finestra|raam|janela|hatch|skylight|velux")
_GLASS_DOOR = re.compile(r"french|porte|tur|door|puerta|porta|deur|balkon|balcon|patio|slid")


def plain(text: str) -> str:
    """Lower case, without accents; everything but letters and digits becomes one space."""
    text = re.sub(r"([a-z])([A-Z])", r"\1 \2", text).lower().replace("ß", "ss")
    bare = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    return " ".join(re.sub("[^a-z0-9]+", " ", bare).split())


def category_of(catalog_id: str, name: str) -> str:
    """A scene category: by catalogue id, else by the name's words, else "other"."""
    if catalog_id.startswith("eTeks#"):
        found = ETEKS.get(catalog_id.removeprefix("eTeks#"))
    else:
        found = _catalogue().get(catalog_id)
    own = catalog_id.partition("#")[2] or catalog_id
    for text in (name, own):
        found = found or _named(plain(text), _category_words())
    return found if found in CATEGORIES else "other"


def room_type(name: str, categories: Iterable[str]) -> tuple[str, str]:
    """A room's type and how it was found: by its "name", its "furniture", or "guess"."""
    by_name = _first(plain(name), _room_words())
    if by_name:
        return by_name, "name"
    votes = dict.fromkeys(ROOM_TYPES, 0.0)
    for category in categories:
        kind, weight = VOTES.get(category, ("hallway", 0.0))
        votes[kind] += weight
    best = max(ROOM_TYPES, key=lambda kind: votes[kind])
    return (best, "furniture") if votes[best] >= 1 else ("hallway", "guess")


def is_outdoors(name: str) -> bool:
    """Whether a room's name says that it lies outside."""
    return bool({*plain(name).split()} & {*OUTDOORS.split()})


def is_window(catalog_id: str, name: str) -> bool:
    """Whether the name says a window and no glass door."""
    text = plain(f"{catalog_id} {name}").replace(" ", "")
    return bool(_WINDOW.search(text)) and not _GLASS_DOOR.search(text)


def _named(text: str, words: dict[str, str]) -> str | None:
    """Phrases count first, then the last known word before any "with", "of", "de", ..."""
    padded = f" {text} "
    phrases = [w for w in words if " " in w and (f" {w} " in padded or f" {w}s " in padded)]
    if phrases:
        return words[max(phrases, key=len)]
    known = [words[w] for word in _CUT.sub("", text).split() if (w := _singular(word, words))]
    return known[-1] if known else None


def _first(text: str, words: dict[str, str]) -> str | None:
    padded = f" {text} "
    places = [(padded.find(f" {w} "), -len(w), w) for w in words if f" {w} " in padded]
    if places:
        return words[min(places)[2]]
    known = [words[w] for word in text.split() if (w := _singular(word, words))]
    return known[0] if known else None


def _singular(word: str, words: dict[str, str]) -> str:
    """The word as it is known: without a number ("bedroom2") or a plural ending, or the end of a
    German compound ("Einzelbett"); "" if unknown."""
    word = word.rstrip("0123456789")
    stems = [word.removesuffix(end) for end in ("", "s", "es", "n", "en", "e")]
    whole = next((stem for stem in stems if stem in words), "")
    ends = (known for known in words if len(known) >= 4 and word.endswith(known))
    return whole or max(ends, key=len, default="")


@cache
def _category_words() -> dict[str, str]:
    return {w.replace("_", " "): c for c, names in WORDS.items() for w in names.split()}


@cache
def _room_words() -> dict[str, str]:
    return {w.replace("_", " "): kind for kind, names in ROOMS.items() for w in names.split()}


@cache
def _catalogue() -> dict[str, str]:
    """Catalogue id -> category, from what our own homes are furnished with."""
    table = json.loads(_FURNITURE.read_text(encoding="utf-8"))
    return {mesh: c for c, meshes in table.items() for mesh in meshes if "#" in mesh}
