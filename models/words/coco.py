"""What COCO's 80 classes are in our vocabulary, by a list that was read and not by likeness.

By meaning a horse is a drying rack and a bear a teddy bear: near in the text encoder's space, and
not what is looked for.
"""

import tomllib
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from models.errors import ModelFileError
from models.words.vocabulary import load_vocabulary

COCO_MAP = Path(__file__).with_name("coco.toml")


def coco_names() -> tuple[str, ...]:
    """COCO's names, in its order."""
    return tuple(coco_map())


@cache
def coco_map() -> Mapping[str, str]:
    """COCO's name -> canonical name of our class, or "" for none."""
    known = {names[0] for names in load_vocabulary().objects}
    return read_map(COCO_MAP, known)


def read_map(path: Path, known: set[str]) -> Mapping[str, str]:
    """A map's table `classes`. Raises ModelFileError, also for a class that is not `known`."""
    try:
        table = dict(tomllib.loads(path.read_text(encoding="utf-8"))["classes"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ModelFileError(f"{path}: not a class map ({error!r})") from error
    for key, ours in table.items():
        if ours != "" and ours not in known:
            raise ModelFileError(
                f"{path}: classes.{key} = {ours!r}: no class of the vocabulary; write a class's "
                'first name, or "" for none'
            )
    return table


def is_coco(names: Sequence[str]) -> bool:
    """Whether a detector's class list is COCO's, in whatever order."""
    return set(names) == set(coco_names())


def stands_for(
    names: Sequence[str], classes: Sequence[Sequence[str]], theirs_to_ours: Mapping[str, str]
) -> NDArray[np.float32]:
    """(names, classes) 1 where a name stands for a class, else 0.

    A class called as the map says; else one called exactly as the name: what is not in our
    vocabulary, but asked for by COCO's own word.
    """
    likeness = np.zeros((len(names), len(classes)), np.float32)
    for row, name in zip(likeness, names, strict=True):
        for word in (theirs_to_ours[name], name):
            called = [k for k, known in enumerate(classes) if word and word in known]
            if called:
                row[called[0]] = 1
                break
    return likeness
