"""A goal's word among the classes that are known, by what words mean.

Meanings come from a dictionary of household nouns. Most words have several: which one is meant is
chosen by the cosine of text embeddings, for the goal's word with the names of all classes, for a
class's name with the other names of its class.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from runtime.core.types import F32

MARGIN = 0.05
"""Less cosine than a class's likeliest meaning has, and still taken for one of its own."""
KINDRED = 0.25
"""Cosine of a word of several meanings to a name of the class that it is taken for a kind of: a
runner may be a rug, a safe is no cupboard for meat."""

Embed = Callable[[Sequence[str]], F32]
Class = tuple[str, ...]


class Sense(Protocol):
    """One meaning of a word: the `names` that share it, a definition or "", and the ids of the
    meanings it is a kind of (`broader`) and of its kinds (`narrower`). `common`: the word mostly
    means this, or another thing of a home."""

    @property
    def id(self) -> int: ...
    @property
    def names(self) -> tuple[str, ...]: ...
    @property
    def gloss(self) -> str: ...
    @property
    def broader(self) -> tuple[int, ...]: ...
    @property
    def narrower(self) -> tuple[int, ...]: ...
    @property
    def common(self) -> bool: ...


Senses = Callable[[str], Sequence[Sense]]
"""All meanings of a noun; () of what is none."""


@dataclass(frozen=True)
class Meaning:
    """What a word means, and the classes that mean the same, are what it is a kind of, or are kinds
    of it. `names` is empty where the word mostly means something else."""

    names: tuple[str, ...]
    same: tuple[Class, ...]
    broader: tuple[Class, ...]
    narrower: tuple[Class, ...]


def meaning(word: str, classes: Sequence[Class], senses: Senses, embed: Embed) -> Meaning | None:
    """None where the dictionary does not have the word."""
    found = senses(word)
    if not found or not classes:
        return None
    meant = found[_likeliest(word, found, classes, embed)]
    wanted = {meant.id, *meant.broader, *meant.narrower}
    of = {names: _ids(names, wanted, senses, embed) for names in classes}

    def having(ids: Iterable[int]) -> tuple[Class, ...]:
        return tuple(dict.fromkeys(c for id in ids for c in classes if id in of[c]))

    return Meaning(
        meant.names if meant.common else (),
        having([meant.id]),
        tuple(c for c in having(meant.broader) if len(found) == 1 or _like(word, c, embed)),
        having(meant.narrower),
    )


def _like(word: str, names: Class, embed: Embed) -> bool:
    like = np.asarray(embed(names)) @ np.asarray(embed([word]))[0]
    return bool(like.max() >= KINDRED)


def _likeliest(word: str, found: Sequence[Sense], classes: Sequence[Class], embed: Embed) -> int:
    """Index of the meaning that is most like a name of a class which the word itself is like."""
    if len(found) == 1:
        return 0
    names = np.asarray(embed([name for known in classes for name in known]))
    like = names @ np.asarray(embed([word]))[0]
    return int((_texts(found, embed) @ names.T + like).max(axis=1).argmax())


def _ids(names: Class, wanted: set[int], senses: Senses, embed: Embed) -> set[int]:
    """Of the wanted meanings, those that this class's names may have."""
    out: set[int] = set()
    for name in names:
        found = senses(name)
        if wanted.isdisjoint(s.id for s in found):
            continue  # most: nothing to be embedded
        like = (_texts(found, embed) @ np.asarray(embed(names)).T).mean(axis=1)
        out |= {s.id for s, c in zip(found, like, strict=True) if c >= like.max() - MARGIN}
    return out & wanted


def _texts(found: Sequence[Sense], embed: Embed) -> F32:
    """(N, D): names and definition of each meaning."""
    return np.asarray(
        embed([", ".join(s.names) + (f": {s.gloss}" if s.gloss else "") for s in found])
    )
