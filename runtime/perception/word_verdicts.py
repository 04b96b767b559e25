"""What is looked for when somebody asks for the names that training never saw (`unseen` in
models/train/names.toml) or for others (models/evaluation/asked.toml)."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from models.evaluation.truth import NameLists
from models.words.lexicon import lexicon
from models.words.senses import Senses
from models.words.text_encoder import TextEncoder
from models.words.vocabulary import load_vocabulary
from runtime.errors import ConfigError
from runtime.perception.goal_words import Goal, Words
from runtime.perception.heard_goal import hear

Understanding = Callable[[str], Goal]


class WordVerdict(NamedTuple):
    """Where a `word` for a category that was trained ends, and `how` it was understood."""

    word: str
    category: str
    verdict: str
    how: str


def by_default(
    encoder: TextEncoder,
    classes: Sequence[tuple[str, ...]] | None = None,
    senses: bool = True,
    listed: bool = True,
) -> Understanding:
    """Goals as the runtime understands them by its default word list, or by other classes; with the
    dictionary's `senses`, and with the further names that are `listed` for its classes."""
    vocabulary = load_vocabulary()
    known = Words(vocabulary.objects if classes is None else tuple(classes))
    if listed and classes is None:
        known = replace(known, also=vocabulary.also, kinds=vocabulary.kinds)
    if senses:
        known = replace(known, senses=Senses(), lexicon=lexicon())
    return lambda text: hear(text, known, encoder.embed).goal


def word_verdicts(
    words: NameLists, understood: Understanding, others: Mapping[str, Sequence[str]]
) -> list[WordVerdict]:
    """Of all `others`, names of trained categories, in their order."""
    rows = []
    for category, synonyms in others.items():
        near = words.near.get(category, ())
        for synonym in synonyms:
            try:
                goal = understood(synonym)
            except ConfigError as error:
                rows.append(WordVerdict(synonym, category, "refused", str(error)))
                continue
            if goal.name == category:
                verdict = "its own"
            elif goal.name in words.trained:
                verdict = "one that is neither right nor wrong" if goal.name in near else "another"
            else:
                verdict = "alone, with its name" if category in goal.names else "alone"
            rows.append(WordVerdict(synonym, category, verdict, goal.how))
    return rows
