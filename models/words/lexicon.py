"""Words of goals beside the names of what is looked for: rooms, people, and other languages."""

import unicodedata
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from models.errors import ModelFileError
from models.toml_text import read_toml
from models.words.class_maps import built_in

PATH = Path(__file__).with_name("goal_lexicon.toml")


class Lexicon(NamedTuple):
    """All in lower case. `places`: rooms and the like, each with a thing that may be asked for
    there. `people`, `animals`: none is looked for. `vague`: words that name no thing. `things`:
    nouns that neither the word list nor the dictionary has. `translations`: other languages' words,
    as `folded` has them, and the English one; theirs are `articles`, `prepositions` and `looks`,
    colours and sizes."""

    places: Mapping[str, str]
    people: frozenset[str]
    animals: frozenset[str]
    vague: frozenset[str]
    things: frozenset[str]
    translations: Mapping[str, str]
    articles: frozenset[str]
    prepositions: frozenset[str]
    looks: frozenset[str]


def folded(word: str) -> str:
    """Lower case without accents, so that a keyboard without them will do."""
    plain = unicodedata.normalize("NFKD", word.lower().replace("ß", "ss"))
    return "".join(c for c in plain if not unicodedata.combining(c))


def read_lexicon(path: Path = PATH) -> Lexicon:
    """Raises ModelFileError for a file that is none."""
    try:
        table: dict[str, Any] = read_toml(path)
        living, around = table["living"], table["around"]
        return Lexicon(
            {word: thing for thing, words in table["places"].items() for word in _words(words)},
            frozenset(_words(living["people"])),
            frozenset(_words(living["animals"])),
            frozenset(_words(table["vague"]["words"])),
            frozenset(_words(table["things"]["words"])) | {n.lower() for n in _built_in()},
            {
                folded(word): thing
                for thing, words in table["translations"].items()
                for word in _words(words)
            },
            *(frozenset(_words(around[k])) for k in ("articles", "prepositions", "looks")),
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise ModelFileError(f"{path}: no words of goals ({error!r}); reinstall rf-nav") from error


@cache
def lexicon() -> Lexicon:
    """The one that comes with the package."""
    return read_lexicon()


def _words(text: str) -> tuple[str, ...]:
    return tuple(word.replace("_", " ") for word in text.split())


def _built_in() -> tuple[str, ...]:
    return (*built_in("coco"), *built_in("open-images"))
