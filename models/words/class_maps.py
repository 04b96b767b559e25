"""What the classes of well-known lists are in our vocabulary, by maps that were read and not by
likeness.

By meaning a horse is a drying rack and a bear a teddy bear: near in the text encoder's space, and
not what is looked for.
"""

import re
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.errors import ModelFileError
from models.toml_text import read_toml
from models.words.vocabulary import load_vocabulary

COCO = Path(__file__).with_name("coco.toml")
OPEN_IMAGES = Path(__file__).with_name("open_images.toml")
PART_OF_OPEN_IMAGES = 500
"""So many of its names, and no others, are its list: its challenge has 500 of the 601."""
GAPS = (0, 12, 26, 29, 30, 45, 66, 68, 69, 71, 83)
"""Numbers under 91 that are none of COCO's 80 categories."""
BUILT_IN = ("coco", "open-images")


class ClassMap(NamedTuple):
    """`title`, whose list it is; `words`, by name: our class or "", then what else it is called."""

    title: str
    words: Mapping[str, tuple[str, ...]]


def coco_names() -> tuple[str, ...]:
    """COCO's 80 names, in its order."""
    return tuple(_coco())


def coco_91() -> tuple[str, ...]:
    """COCO's names by its 91 numbers, "" where there is none."""
    names = iter(coco_names())
    return tuple("" if k in GAPS else next(names) for k in range(91))


def built_in(name: str) -> tuple[str, ...]:
    """The names of one of BUILT_IN, in its order. Raises ModelFileError for any other."""
    if name not in BUILT_IN:
        raise ModelFileError(f"class list {name!r} is unknown; known are {', '.join(BUILT_IN)}")
    return coco_names() if name == "coco" else tuple(_open_images())


def map_of(names: Sequence[str]) -> ClassMap | None:
    """The map of a detector's class list where that is COCO's or Open Images', in whatever order
    and usual spelling; None for any other."""
    theirs = {_spelt(name): name for name in _coco()}
    theirs |= {_spelt(other): name for other, name in _spellings().items()}
    meant = [theirs.get(_spelt(name), "") for name in names]
    if set(meant) == set(_coco()):
        ours = _coco()
        words = {name: (ours[m], m, name) for name, m in zip(names, meant, strict=True)}
        return ClassMap("COCO's", words)
    theirs = {_spelt(name): name for name in _open_images()}
    if len(set(names)) >= PART_OF_OPEN_IMAGES and all(_spelt(name) in theirs for name in names):
        ours = _open_images()
        return ClassMap(
            "Open Images'", {name: (ours[theirs[_spelt(name)]], name.lower()) for name in names}
        )
    return None


def own_map(path: Path) -> ClassMap:
    """A map that came with a detector: its names in order, each with our class or "" for none.
    Raises ModelFileError, also for a class that the vocabulary does not have."""
    table = read_map(path, _known())
    return ClassMap("its own map's", {name: (ours, name.lower()) for name, ours in table.items()})


def read_map(path: Path, known: set[str]) -> Mapping[str, str]:
    """A map's table `classes`. Raises ModelFileError, also for a class that is not `known`."""
    table = _table(path, "classes")
    for key, ours in table.items():
        if ours != "" and ours not in known:
            raise ModelFileError(
                f"{path}: classes.{key} = {ours!r}: no class of the vocabulary; write a class's "
                'first name, or "" for none'
            )
    return table


def stands_for(
    names: Sequence[str], classes: Sequence[Sequence[str]], known: ClassMap
) -> NDArray[np.float32]:
    """(names, classes) 1 where a name stands for a class, else 0.

    A class called as the map says; else one called exactly as the name: what is not in our
    vocabulary, but asked for by the list's own word.
    """
    likeness = np.zeros((len(names), len(classes)), np.float32)
    for row, name in zip(likeness, names, strict=True):
        for word in known.words[name]:
            called = [k for k, other in enumerate(classes) if word and word in other]
            if called:
                row[called[0]] = 1
                break
    return likeness


@cache
def _known() -> set[str]:
    return {names[0] for names in load_vocabulary().objects}


@cache
def _coco() -> Mapping[str, str]:
    return read_map(COCO, _known())


@cache
def _open_images() -> Mapping[str, str]:
    return read_map(OPEN_IMAGES, _known())


@cache
def _spellings() -> Mapping[str, str]:
    return _table(COCO, "spellings")


def _table(path: Path, key: str) -> dict[str, str]:
    try:
        return dict(read_toml(path)[key])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ModelFileError(f"{path}: not a class map ({error!r})") from error


def _spelt(name: str) -> str:
    """ "Potted-Plant" and "potted_plant" are spelt "pottedplant"."""
    return re.sub(r"[\s_-]", "", name.lower())
