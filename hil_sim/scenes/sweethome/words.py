"""What a drawn thing is: by its catalogue id, its name in a few languages, or what is in it."""

import json
import re
import unicodedata
from collections.abc import Container, Iterable, Mapping
from functools import cache
from pathlib import Path

from hil_sim.scenes.format import CATEGORIES, ROOM_TYPES
from hil_sim.scenes.sweethome.known_words import (
    ALONE,
    CUT,
    ENDINGS,
    ETEKS,
    FAINT,
    FAINT_ROOMS,
    GENITIVE,
    MANY,
    OTHER_BEFORE,
    OUTDOORS,
    ROOMS,
    SHORT_ENDINGS,
    VOTES,
    WORDS,
)

_FURNITURE = Path(__file__).parents[1] / "furniture" / "furniture.json"

_PARTS = re.compile(r"(?<!\bw)/|[&+,;|()\[\]]| - |\b(?:and|und|et)\b", re.IGNORECASE)
"""Between the names of a room that has several."""
_LONGEST = 4
_PLURALS = ("", "s", "es", "n", "en", "e")
_OUTSIDE = "outdoors"
_WINDOW = re.compile(r"window|fenetre|fenster|ventana|finestra|raam|janela|hatch|skylight|velux")
_GLASS_DOOR = re.compile(r"french|porte|tur|door|puerta|porta|deur|balkon|balcon|patio|slid")


def plain(text: str) -> str:
    """Lower case, without accents; everything but letters and digits becomes one space."""
    text = re.sub(r"([a-z])([A-Z])", r"\1 \2", text).lower().replace("ß", "ss")
    bare = unicodedata.normalize("NFKD", re.sub(r"['’]s\b", "s", text)).encode("ascii", "ignore")
    return " ".join(re.sub("[^a-z0-9]+", " ", bare.decode()).split())


def category_of(catalog_id: str, name: str) -> str:
    """A scene category: by catalogue id, else by the name's words, else "other"."""
    if catalog_id.startswith("eTeks#"):
        found = ETEKS.get(catalog_id.removeprefix("eTeks#"))
    else:
        found = _catalogue().get(catalog_id)
    own = catalog_id.partition("#")[2] or catalog_id
    for text in (name, own):
        found = found or _piece(plain(text))
    return found if found in CATEGORIES else "other"


def room_type(name: str, categories: Iterable[str]) -> tuple[str, str]:
    """A room's type and how it was found: by its "name", its "furniture", or "guess"."""
    by_name = _room(name)
    if by_name in ROOM_TYPES:
        return by_name, "name"
    votes = dict.fromkeys(ROOM_TYPES, 0.0)
    for category in categories:
        kind, weight = VOTES.get(category, ("hallway", 0.0))
        votes[kind] += weight
    best = max(ROOM_TYPES, key=lambda kind: votes[kind])
    return (best, "furniture") if votes[best] >= 1 else ("hallway", "guess")


def is_outdoors(name: str) -> bool:
    """Whether a room's name says that it lies outside."""
    return _room(name) == _OUTSIDE


def tells(name: str) -> bool:
    """Whether a room's name says what it is for, or that it lies outside."""
    return bool(_room(name))


def is_window(catalog_id: str, name: str) -> bool:
    """Whether the name says a window and no glass door."""
    text = plain(f"{catalog_id} {name}").replace(" ", "")
    return bool(_WINDOW.search(text)) and not _GLASS_DOOR.search(text)


def _piece(text: str) -> str | None:
    """The category of the last known word before any "with", "of", "de", a number, ..."""
    words = _category_words()
    whole = " ".join(word for word in text.split() if not word.isdigit())
    if whole in ALONE:
        return ALONE[whole]
    known = [] if _of_unknown(text) else _known(text, words, _endings(), True)
    if known and known[0] in _split(OTHER_BEFORE):
        return "other"
    loud = [word for word in known if word not in _split(FAINT)] or known
    return words[loud[-1]] if loud else None


def _of_unknown(text: str) -> bool:
    """Whether what is known only belongs to what is not, such as the bed of "Tête de lit"."""
    if any(f" {phrase} " in f" {text} " for phrase in _category_words() if " " in phrase):
        return False
    head, genitive, _ = _genitive().sub("\n", text, count=1).partition("\n")
    counts = head.isdigit() or {*head.split()} & _split(MANY)
    known = _known(head, _category_words(), _endings(), False)
    return bool(genitive) and not known and not counts


def _room(name: str) -> str:
    """The type that the first telling part of a room's name says, "outdoors", or ""."""
    words = _room_words()
    for part in _PARTS.split(name):
        known = _known(plain(part), words, _room_endings(), False)
        loud = [word for word in known if word not in _split(FAINT_ROOMS)] or known
        if loud:
            return words[loud[0] if loud[0] in _first_words() else loud[-1]]
    return ""


def _known(
    text: str, words: Mapping[str, str], endings: frozenset[str], numbers_cut: bool
) -> list[str]:
    """The known words of a name, from the left, a phrase before its words, without numbers at their
    ends ("bedroom2"), until something tells that the rest is about what stands with it."""
    tokens = [word.rstrip("0123456789") or word for word in text.split()]
    found: list[str] = []
    while tokens:
        size, word = next(
            (
                (n, stem)
                for n in range(min(_LONGEST, len(tokens)), 1, -1)
                if (stem := _stem(" ".join(tokens[:n]), words, ("", "s")))
            ),
            (1, ""),
        )
        cuts = tokens[0] in _split(CUT) or (numbers_cut and tokens[0].isdigit())
        if not word and cuts and found:
            break
        word = word or _single(tokens[0], words, endings)
        found += [word] if word else []
        tokens = tokens[size:]
    return found


def _single(word: str, words: Mapping[str, str], endings: frozenset[str]) -> str:
    """The word as it is known: without a plural ending, or the end of a compound ("Einzelbett"); ""
    if unknown."""
    ends = (word[i:] for i in range(2, len(word)))  # from the longest
    whole = _stem(word, words, _PLURALS)
    return whole or next((known for end in ends if (known := _stem(end, endings, _PLURALS))), "")


def _stem(word: str, words: Container[str], plurals: tuple[str, ...]) -> str:
    return next((s for end in plurals if (s := word.removesuffix(end)) in words), "")


@cache
def _split(names: str) -> frozenset[str]:
    return frozenset(name.replace("_", " ") for name in names.split())


@cache
def _category_words() -> dict[str, str]:
    words = {w: c for c, names in WORDS.items() for w in _split(names)}
    return dict.fromkeys(_split(OTHER_BEFORE), "other") | words


@cache
def _genitive() -> re.Pattern[str]:
    return re.compile(rf" (?:{'|'.join(sorted(_split(GENITIVE)))}) ")


@cache
def _endings() -> frozenset[str]:
    return _split(ENDINGS)


@cache
def _room_words() -> dict[str, str]:
    words = {w: kind for kind, both in ROOMS.items() for names in both for w in _split(names)}
    return dict.fromkeys(_split(OUTDOORS), _OUTSIDE) | words


@cache
def _first_words() -> frozenset[str]:
    """Words whose language says first what a room is."""
    return frozenset(w for _, first in ROOMS.values() for w in _split(first))


@cache
def _room_endings() -> frozenset[str]:
    long = (w for last, _ in ROOMS.values() for w in _split(last) if len(w) >= 4)
    return frozenset(long) | _split(SHORT_ENDINGS)


@cache
def _catalogue() -> dict[str, str]:
    """Catalogue id -> category, from what our own homes are furnished with."""
    table = json.loads(_FURNITURE.read_text(encoding="utf-8"))
    return {mesh: c for c, meshes in table.items() for mesh in meshes if "#" in mesh}
