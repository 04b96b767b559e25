"""From what a person asked for to what the detector looks for."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from models.words.lexicon import Lexicon
from runtime.core.mapping.fineness import GoalSize
from runtime.core.types import F32
from runtime.core.word_senses import Meaning, Senses, meaning
from runtime.errors import ConfigError

LONGEST = 80  # characters of a goal
SAME_AS_SIMILARITY = 0.65  # MiniLM cosine from which a goal is taken for a known class
KIN = 0.05  # of cosine, that being of a kind is worth
ARTICLE = re.compile(r"^(the|a|an|my|our|your|some)\s(?=.)")

Class = tuple[str, ...]
Embed = Callable[[Sequence[str]], F32]


@dataclass(frozen=True)
class Goal:
    """`name` is the class that counts as found; `classes` the detector's vocabulary, the goal's
    among them; `how` one line that says how the goal was understood. `strange`: a class of its own,
    unlike any that is known. `near`, `rooms`: classes and types of rooms that it was said to be
    near and in. `wanted`: what of it a look has to see."""

    text: str
    name: str
    classes: tuple[Class, ...]
    how: str
    strange: bool = False
    near: tuple[str, ...] = ()
    rooms: tuple[str, ...] = ()
    wanted: GoalSize = field(default_factory=GoalSize)

    @property
    def label(self) -> int:
        """Index of the class that counts as found."""
        return [names[0] for names in self.classes].index(self.name)

    @property
    def names(self) -> Class:
        """All names of the class that counts as found."""
        return self.classes[self.label]


@dataclass(frozen=True)
class Words:
    """What the runtime knows about words. `senses` are the meanings that the dictionary has of a
    noun; by a class's first name, `also` are further names that people call it and `kinds` the
    classes that are kinds of it. Without a `lexicon` every text is the name of one thing. `rooms`
    are the types of rooms that are told apart."""

    classes: tuple[Class, ...]
    senses: Senses = lambda word: ()
    also: Mapping[str, Sequence[str]] = field(default_factory=dict)
    kinds: Mapping[str, Sequence[str]] = field(default_factory=dict)
    lexicon: Lexicon | None = None
    rooms: tuple[str, ...] = ()


def check(text: str) -> str:
    """The goal without surrounding blanks; ConfigError for what no detector can look for."""
    goal = " ".join(text.split())
    if not goal:
        raise ConfigError('goal: is empty; name an object, e.g. "toilet"')
    if len(goal) > LONGEST or not goal.isprintable():
        raise ConfigError(f"goal: must be at most {LONGEST} printable characters")
    return goal


def understand(text: str, words: Words, embed: Embed) -> Goal:
    """A goal is looked for as the class whose name it is, or that people also call so, and as the
    kinds of that class, too; else, by the dictionary, as one that means the same or that it is a
    kind of, or as a class of its own that all its kinds belong to; else as one that is nearly the
    same by the cosine of text embeddings; else, when its last word is a class, as that; else as a
    class of its own."""
    classes, senses = words.classes, words.senses
    goal = check(text)
    word = ARTICLE.sub("", goal.lower())
    spelt = {spelling(word), spelling(word).removesuffix("s")}
    for names in classes:
        if word in names or not spelt.isdisjoint(map(spelling, names)):
            return _known(goal, names, words, f"{goal}: known as {names[0]}")
        if not spelt.isdisjoint(map(spelling, words.also.get(names[0], ()))):
            how = f"{goal}: another word for {names[0]}, looked for as that"
            return _known(goal, names, words, how)
    means = meaning(word, classes, senses, embed)
    if means is not None and (means.same or means.broader):
        name = (means.same or means.broader)[0][0]
        how = "another word for" if means.same else "a kind of"
        return Goal(goal, name, classes, f"{goal}: {how} {name}, looked for as that")
    if means is not None and means.narrower:
        return _own(goal, word, classes, means)
    head = word.rpartition(" ")[2]
    kin = _of_kind(head, classes, senses, embed) if head != word else ()
    alike = _alike(goal, word, classes, kin, embed)
    if alike is not None:
        return alike
    for names in kin:
        if head in names:
            how = f"{goal}: a kind of {names[0]}, looked for as that"
            return Goal(goal, names[0], tuple(classes), how)
    return _own(goal, word, classes, means)


def _known(goal: str, names: Class, words: Words, how: str) -> Goal:
    """A class of the list; where others are kinds of it, by their names, too."""
    under = [known for known in words.classes if known[0] in words.kinds.get(names[0], ())]
    if under:
        how += f"; of its kind: {', '.join(known[0] for known in under)}"
    wider = (*names, *(name for known in under for name in known))
    return Goal(goal, names[0], tuple(wider if c is names else c for c in words.classes), how)


def _of_kind(
    head: str, classes: Sequence[Class], senses: Senses, embed: Embed
) -> tuple[Class, ...]:
    """The classes that a thing whose name ends in `head` may be (a laundry hamper is a hamper):
    those called so and those that the dictionary relates to it; where there are any, also those
    that have a name ending in it."""
    means = meaning(head, classes, senses, embed)
    near = (*means.same, *means.broader, *means.narrower) if means else ()
    sure = tuple(names for names in classes if head in names or names in near)
    if not sure:
        return ()
    ends = f" {head}"
    return tuple(c for c in classes if c in sure or any(name.endswith(ends) for name in c))


def spelling(word: str) -> str:
    """ "night stand" and "night-stand" are spelt "nightstand"."""
    return word.replace(" ", "").replace("-", "")


def _alike(
    goal: str, word: str, classes: Sequence[Class], kin: Sequence[Class], embed: Embed,
) -> Goal | None:  # fmt: skip
    """The class with the most similar name, where that is similar enough; of nearly equals one of
    `kin`. What a name only begins with does not count: a toy box is no toy, and a salad is no
    salad bowl."""
    told = [
        (name, known)
        for known in classes
        for name in known
        if not (word.startswith(f"{name} ") or name.startswith(f"{word} "))
    ]
    if not told:
        return None
    cosine = np.asarray(embed([name for name, _ in told])) @ np.asarray(embed([word]))[0]
    akin = np.array([known in kin for _, known in told])
    enough = cosine >= SAME_AS_SIMILARITY
    if not enough.any():
        return None
    best = int(np.argmax(np.where(enough, cosine + KIN * akin, -1.0)))
    name, chosen = told[best]
    wider = tuple((*k, word) if k is chosen else k for k in classes)
    how = f"{goal}: taken for {chosen[0]} (similarity {cosine[best]:.2f} to {name})"
    return Goal(goal, chosen[0], wider, how)


def _own(goal: str, word: str, classes: Sequence[Class], means: Meaning | None) -> Goal:
    """A class of its own, by all names that its meaning and its known kinds have. A "computer
    monitor" is a kind of monitor, whatever the dictionary has."""
    if means is None:
        return Goal(goal, word, (*classes, (word,)), f"{goal}: a class of its own", strange=True)
    known = {name for names in classes for name in names}
    others = [name for name in means.names if name not in known and name != word]
    called = [names for names in classes if any(name.endswith(f" {word}") for name in names)]
    kinds = tuple(dict.fromkeys((*means.narrower, *called))) if means.narrower else ()
    how = f"{goal}: a class of its own"
    if others:
        how += f", also called {', '.join(others)}"
    if kinds:
        how += f"; of its kind: {', '.join(names[0] for names in kinds)}"
    own = (word, *others, *(name for names in kinds for name in names))
    return Goal(goal, word, (*classes, own), how, strange=not kinds)
