"""From what a person asked for to what the detector looks for."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from runtime.core.types import F32
from runtime.errors import ConfigError

LONGEST = 80  # characters of a goal


@dataclass(frozen=True)
class Goal:
    """`name` is the class that counts as found; `classes` the detector's vocabulary, the goal's
    among them; `how` one line that says how the goal was understood."""

    text: str
    name: str
    classes: tuple[tuple[str, ...], ...]
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
    classes: Sequence[tuple[str, ...]],
    embed: Callable[[Sequence[str]], F32],
    same_as: float,
) -> Goal:
    """A goal that is a class's name, or means nearly the same, is looked for as that class; any
    other becomes a class of its own. Similarity is the cosine of text embeddings."""
    goal = check(text)
    word = goal.lower()
    for names in classes:
        if word in names:
            return Goal(goal, names[0], tuple(classes), f"{goal}: known as {names[0]}")
    words = [name for known in classes for name in known]
    owner = [known for known in classes for _ in known]
    cosine = np.asarray(embed(words)) @ np.asarray(embed([word]))[0] if words else np.zeros(0)
    if cosine.size and float(cosine.max()) >= same_as:
        best = int(np.argmax(cosine))
        chosen = owner[best]
        wider = tuple((*k, word) if k is chosen else k for k in classes)
        how = f"{goal}: taken for {chosen[0]} (similarity {cosine[best]:.2f} to {words[best]})"
        return Goal(goal, chosen[0], wider, how)
    return Goal(goal, word, (*classes, (word,)), f"{goal}: a class of its own")
