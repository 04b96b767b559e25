"""`python -m runtime.perception.word_verdicts`: what the runtime looks for when it is asked for the names
that training never saw (`unseen` in models/train/names.toml) or for others (`--asked`,
models/evaluation/asked.toml)."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import click

from models.evaluation.truth import NameLists, read_words
from models.store import manifest
from models.words.senses import Senses
from models.words.text_encoder import TextEncoder
from models.words.vocabulary import load_vocabulary
from runtime.config import DetectorConfig, GoalConfig
from runtime.perception.goal_words import Goal, understand
from runtime.perception.goal_words import Words as WordList

LOOKS = DetectorConfig().second_looks
"""Places of a frame that the runtime looks at again."""

Understand = Callable[[str], Goal]


def as_runtime(
    encoder: TextEncoder,
    classes: Sequence[tuple[str, ...]] | None = None,
    senses: bool = True,
    listed: bool = True,
) -> Understand:
    """Goals as the runtime understands them by its default word list, or by other classes; with the
    dictionary's `senses`, and with the further names that are `listed` for its classes."""
    vocabulary = load_vocabulary()
    known = WordList(vocabulary.objects if classes is None else tuple(classes))
    if listed and classes is None:
        known = replace(known, also=vocabulary.also, kinds=vocabulary.kinds)
    if senses:
        known = replace(known, senses=Senses())
    similar = GoalConfig().same_as_similarity
    return lambda text: understand(text, known, encoder.embed, similar)


def looked_for(understood: Understand, text: str) -> tuple[str, ...]:
    """The names of the class that a goal is looked for as."""
    goal = understood(text)
    return next(names for names in goal.classes if names[0] == goal.name)


def verdicts(
    words: NameLists, understood: Understand, others: Mapping[str, Sequence[str]]
) -> list[tuple[str, str, str, str]]:
    """(synonym, its category, verdict, how it was understood) for all `others`, names of trained
    categories."""
    rows = []
    for category, synonyms in others.items():
        near = words.near.get(category, ())
        for synonym in synonyms:
            goal = understood(synonym)
            if goal.name == category:
                verdict = "its own"
            elif goal.name in words.trained:
                verdict = "one that is neither right nor wrong" if goal.name in near else "another"
            else:
                names = looked_for(understood, synonym)
                verdict = "alone, with its name" if category in names else "alone"
            rows.append((synonym, category, verdict, goal.how))
    return rows


@click.command()
@click.option("--names", is_flag=True, help="By the names of training alone, not the word list.")
@click.option("--senses/--no-senses", default=True, show_default=True, help="With WordNet.")
@click.option("--listed/--not-listed", default=True, show_default=True, help="With more names.")
@click.option("--asked", is_flag=True, help="Names of models/evaluation/asked.toml.")
def main(names: bool, senses: bool, listed: bool, asked: bool) -> None:
    """Print at which class each name that training never saw ends."""
    encoder, words = TextEncoder(manifest.fetch("minilm")), read_words()
    classes = tuple(words.trained.values()) if names else None
    others = words.asked if asked else words.unseen
    rows = verdicts(words, as_runtime(encoder, classes, senses, listed), others)
    for _synonym, category, verdict, how in sorted(rows, key=lambda row: row[2]):
        click.echo(f"{verdict:36} {category:18} {how}")
    for verdict, count in Counter(row[2] for row in rows).most_common():
        click.echo(f"{count:4} of {len(rows)}: {verdict}")


if __name__ == "__main__":
    main()
