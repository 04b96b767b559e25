"""From what a person asked for to what the detector looks for."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from runtime.core.meaning import Meaning, Senses, meaning
from runtime.core.types import F32
from runtime.errors import ConfigError

LONGEST = 80  # characters of a goal

Class = tuple[str, ...]
Embed = Callable[[Sequence[str]], F32]


@dataclass(frozen=True)
class Goal:
    """`name` is the class that counts as found; `classes` the detector's vocabulary, the goal's
    among them; `how` one line that says how the goal was understood."""

    text: str
    name: str
    classes: tuple[Class, ...]
    how: str


def check(text: str) -> str:
    """The goal without surrounding blanks; ConfigError for what no detector can look for."""
    goal = " ".join(text.split())
    if not goal:
        raise ConfigError('goal: is empty; name an object, e.g. "toilet"')
    if len(goal) > LONGEST or not goal.isprintable():
        raise ConfigError(f"goal: must be at most {LONGEST} printable characters")
    return goal


def understand(
    text: str,
    classes: Sequence[Class],
    embed: Embed,
    same_as: float,
    senses: Senses = lambda word: (),
) -> Goal:
    """A goal is looked for as the class whose name it is; else, by a dictionary, as one that means
    the same or that it is a kind of, or as a class of its own that all its kinds belong to; else as
    one that is nearly the same by the cosine of text embeddings; else as a class of its own.
    `senses` are the meanings that the dictionary has of a noun."""
    goal = check(text)
    word = goal.lower()
    for names in classes:
        if word in names or _spelt(word) in map(_spelt, names):
            return Goal(goal, names[0], tuple(classes), f"{goal}: known as {names[0]}")
    means = meaning(word, classes, senses, embed)
    if means is not None and (means.same or means.broader):
        name = (means.same or means.broader)[0][0]
        how = "another word for" if means.same else "a kind of"
        return Goal(goal, name, tuple(classes), f"{goal}: {how} {name}, looked for as that")
    if means is not None and means.narrower:
        return _own(goal, word, classes, means)
    return _alike(goal, word, classes, embed, same_as) or _own(goal, word, classes, means)


def _spelt(word: str) -> str:
    """ "night stand" and "night-stand" are spelt "nightstand"."""
    return word.replace(" ", "").replace("-", "")


def _alike(
    goal: str, word: str, classes: Sequence[Class], embed: Embed, same_as: float
) -> Goal | None:
    """The class with the most similar name, where that is similar enough."""
    words = [name for known in classes for name in known]
    owner = [known for known in classes for _ in known]
    cosine = np.asarray(embed(words)) @ np.asarray(embed([word]))[0] if words else np.zeros(0)
    if not cosine.size or float(cosine.max()) < same_as:
        return None
    best = int(np.argmax(cosine))
    chosen = owner[best]
    wider = tuple((*k, word) if k is chosen else k for k in classes)
    how = f"{goal}: taken for {chosen[0]} (similarity {cosine[best]:.2f} to {words[best]})"
    return Goal(goal, chosen[0], wider, how)


def _own(goal: str, word: str, classes: Sequence[Class], means: Meaning | None) -> Goal:
    """A class of its own, by all names that its meaning and its known kinds have. A "computer
    monitor" is a kind of monitor, whatever the dictionary has."""
    if means is None:
        return Goal(goal, word, (*classes, (word,)), f"{goal}: a class of its own")
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
    return Goal(goal, word, (*classes, own), how)
