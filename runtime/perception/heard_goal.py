"""From what a person said to a goal, or to what could be asked instead."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import cached_property

from models.words.lexicon import Lexicon, folded, lexicon
from models.words.senses import Senses
from models.words.sizes import size_of
from models.words.vocabulary import Vocabulary
from runtime.core.goal_phrase import Phrase, parse
from runtime.core.mapping.fineness import GoalSize
from runtime.errors import ConfigError
from runtime.perception.goal_words import ARTICLE, Embed, Goal, Words, check, spelling, understand

TOLD = 40  # characters of a goal's words in a refusal
MOST = 4  # things that are looked into where one was to be asked for
MEANT = 0.8  # likeness of letters from which a word is offered as what was meant
SHORTEST = 3  # letters of a word that is part of a longer one
EXAMPLES = "mug, armchair or potted plant"
PICTURED = ("toy", "stuffed", "plush", "rubber", "cuddly")
"""A dog may be looked for after one of these."""


@dataclass(frozen=True)
class Heard:
    """A goal, the phrase that it was found in, and what of that is not used."""

    goal: Goal
    phrase: Phrase
    left: Phrase = field(default_factory=Phrase)


def hear(text: str, words: Words, embed: Embed) -> Heard:
    """A goal as a person says it. ConfigError, one line, says what could be asked instead of a
    room, somebody, several things or words that name none."""
    said = check(text)
    nouns = Known(words, words.lexicon) if words.lexicon is not None else None
    if nouns is None or nouns.listed(ARTICLE.sub("", said.lower())):
        return Heard(understand(said, words, embed), Phrase((said,)))
    phrase = _parsed(said, nouns)
    few = phrase.things[:MOST]
    goals = [_understood(thing, nouns, words, embed) for thing in few]
    if len({goal.name for goal in goals}) > 1 or len(few) < len(phrase.things):
        asked = " or ".join(repr(_cut(thing)) for thing in few)
        raise ConfigError(
            f"goal: {_cut(said)!r} names {len(phrase.things)} things; ask for one: {asked}"
        )
    near = {
        thing: name
        for thing, name in _near(phrase, nouns, words, embed).items()
        if name != goals[0].name
    }
    rooms = tuple(room for room in phrase.rooms if room in words.rooms)
    goal = replace(goals[0], near=tuple(dict.fromkeys(near.values())), rooms=rooms)
    left = replace(
        phrase,
        near=tuple(thing for thing in phrase.near if thing not in near),
        rooms=tuple(room for room in phrase.rooms if room not in rooms),
    )
    return Heard(_told(said, left, goal, nouns), phrase, left)


def _near(phrase: Phrase, nouns: "Known", words: Words, embed: Embed) -> dict[str, str]:
    """What it was said to be near, as far as those are classes that the detector knows."""
    known = {}
    for thing in phrase.near[:MOST]:
        try:
            goal = _understood(thing, nouns, words, embed)
        except ConfigError:
            continue
        if not goal.strange:
            known[thing] = goal.name
    return known


def sized(goal: Goal) -> Goal:
    """With how large such a thing looks, and whether it stands on the floor, as far as that is
    known of it or of its kinds."""
    size = size_of(goal.name, (names for names in goal.names if names != goal.name))
    return replace(goal, wanted=GoalSize(size.size_m, size.on_floor, reaches_m=size.reaches_m))


def hear_each(text: str, words: Words, embed: Embed) -> tuple[Goal, ...]:
    """The same of a text that may name several things: a goal for each, by the words for it."""
    said = check(text)
    nouns = Known(words, words.lexicon) if words.lexicon is not None else None
    if nouns is None or nouns.listed(ARTICLE.sub("", said.lower())):
        return (hear(text, words, embed).goal,)
    things = _parsed(said, nouns).things
    if len(things) < 2:
        return (hear(text, words, embed).goal,)
    if len(things) > MOST:
        raise ConfigError(
            f"goal: {_cut(said)!r} names {len(things)} things; ask for {MOST} at most"
        )
    goals = (hear(thing, words, embed).goal for thing in things)
    return tuple({goal.name: goal for goal in goals}.values())


def _parsed(said: str, nouns: "Known") -> Phrase:
    """ConfigError for what names nothing that can be looked for."""
    phrase = parse(said, nouns)
    if phrase.refusal:
        raise ConfigError(f"goal: {_cut(said)!r} {phrase.refusal}; name one, e.g. {EXAMPLES}")
    return phrase


def _understood(thing: str, nouns: "Known", words: Words, embed: Embed) -> Goal:
    """ConfigError for what is none."""
    goal = understand(nouns.english(thing), words, embed)
    if goal.strange and not nouns.believed(thing):
        raise nouns.unknown(thing)
    return goal


def _told(said: str, phrase: Phrase, goal: Goal, nouns: "Known") -> Goal:
    """The goal by the words that it was asked for by, with what of them is gone to first, and what
    was not used."""
    thing = phrase.things[0]
    how = goal.how.partition(": ")[2]
    english = nouns.english(thing)
    if english != thing:
        how = f"{thing} is {english}, {how}"
    elif spelling(thing) != spelling(ARTICLE.sub("", said.lower())):
        how = f"looked for is {thing}, {how}"
    places = (*(f"near a {near}" for near in goal.near), *(f"in a {room}" for room in goal.rooms))
    if places:
        how += f"; first {', '.join(places)}, where that is mapped"
    if phrase.hints:
        how += f"; not used: {', '.join(phrase.hints)}"
    return replace(goal, text=said, how=f"{said}: {how}")


def words_of(vocabulary: Vocabulary) -> Words:
    """All that the runtime knows of words, by a word list."""
    also, kinds = vocabulary.also, vocabulary.kinds
    return Words(vocabulary.objects, Senses(), also, kinds, lexicon(), tuple(vocabulary.rooms))


def with_labels(words: Words, labels: Sequence[str]) -> Words:
    """With further names that the detector is to look for, each a class of its own."""
    known = {name for names in words.classes for name in names}
    others = tuple((name,) for name in labels if name not in known)
    return replace(words, classes=(*words.classes, *others))


class Known:
    """What the runtime knows of a phrase in lower case."""

    def __init__(self, words: Words, beside: Lexicon) -> None:
        self._words, self._lexicon = words, beside
        names = (
            *(n for c in words.classes for n in c),
            *(n for a in words.also.values() for n in a),
        )
        self._names = dict.fromkeys(names)
        self._listed = frozenset(map(spelling, names))

    def listed(self, phrase: str) -> bool:
        """Whether the word list has it."""
        plain = spelling(phrase)
        return plain in self._listed or plain.removesuffix("s") in self._listed

    def room(self, phrase: str) -> bool:
        """Whether it is a room, or a place like one."""
        if self.listed(phrase):
            return False
        plain = " ".join(self._unwrapped(phrase))
        return plain in self._lexicon.places or plain.endswith(" room")

    def thing(self, phrase: str) -> bool:
        """Whether it is the name of a thing, in English or another language."""
        return self._noun(phrase) or bool(self._translated(phrase))

    def english(self, phrase: str) -> str:
        """The thing that is looked for by these words; ConfigError where there is none."""
        if self.listed(phrase):
            return phrase
        self._refuse_nobody(phrase)
        if phrase in self._lexicon.things:
            return phrase
        bare = " ".join(self._unwrapped(phrase))
        if self.listed(bare) or bare in self._lexicon.things:  # "l'armoire"
            return bare
        head = phrase.rpartition(" ")[2]
        if translated := self._translated(phrase):
            return translated
        if self._noun(phrase) or self._noun(head) or self._compound(head):
            return phrase
        if " " in phrase and all(word in self._all_words for word in phrase.split()):
            return phrase  # a "bedside unit" may be what it is like
        raise self.unknown(phrase)

    def believed(self, phrase: str) -> bool:
        """Whether it may be a class of its own: a noun is known, not only words of other names."""
        head = phrase.rpartition(" ")[2]
        return self.thing(phrase) or self._noun(head) or self._compound(head)

    def unknown(self, phrase: str) -> ConfigError:
        """What to say of words that no thing is known by."""
        first = [names[0] for names in self._words.classes]
        near = get_close_matches(phrase, first, 1, MEANT) or get_close_matches(
            phrase, self._names, 1, MEANT
        )
        meant = f"did you mean {near[0]!r}? Else " if near else ""
        return ConfigError(
            f"goal: {_cut(phrase)!r} is no thing that is known; {meant}ask by a plain noun, e.g. "
            f"{EXAMPLES}, or name it in a word list of your own (models.vocabulary)"
        )

    def _refuse_nobody(self, phrase: str) -> None:
        """ConfigError for a room, somebody, an animal, or a word that names nothing."""
        beside, plain = self._lexicon, " ".join(self._unwrapped(phrase))
        head = plain.rpartition(" ")[2]
        told = repr(_cut(phrase))
        if self.room(phrase):
            thing = beside.places.get(plain, "table")
            raise ConfigError(f"goal: {told} is a place; name a thing in it, e.g. {thing}")
        compound = " " in phrase and self._noun(phrase)  # known as a whole
        if not compound and not plain.startswith(PICTURED):
            for kind, known in (("a person", beside.people), ("an animal", beside.animals)):
                if plain in known or head in known:
                    raise ConfigError(
                        f"goal: {told} is {kind}; only things are looked for, e.g. {EXAMPLES}"
                    )
        if plain in beside.vague or plain.partition(" ")[0] in ("something", "somewhere"):
            raise ConfigError(f"goal: {told} names no thing; name one, e.g. {EXAMPLES}")

    def _noun(self, phrase: str) -> bool:
        things = self._lexicon.things
        return (
            self.listed(phrase)
            or phrase in things
            or phrase.removesuffix("s") in things
            or bool(self._words.senses(phrase))
        )

    def _translated(self, phrase: str) -> str:
        """The English word of another language's, whatever stands around it; ""."""
        words, known = self._unwrapped(phrase), self._lexicon.translations
        whole = known.get(" ".join(words)) or known.get(_umlauts(" ".join(words)), "")
        if whole or not words or self.listed(words[0]) or words[0] in self._lexicon.things:
            return whole
        return known.get(" ".join(self._before(words)), "")

    def _compound(self, word: str) -> bool:
        """Whether two known words were written as one: a tealight is a light."""
        cuts = range(SHORTEST, len(word) - SHORTEST)
        return any(word[:k] in self._all_words and self._noun(word[k:]) for k in cuts)

    def _unwrapped(self, phrase: str) -> list[str]:
        """Folded words without another language's articles, colours and sizes before them."""
        beside = self._lexicon
        words = re.sub(r"\b[ld]'", "", folded(phrase)).split()
        while len(words) > 1 and (words[0] in beside.articles or words[0] in beside.looks):
            words = words[1:]
        return words

    def _before(self, words: Sequence[str]) -> list[str]:
        """What stands before the first preposition, colour or size of another language."""
        ends = self._lexicon.prepositions | self._lexicon.looks
        cut = next((k for k, word in enumerate(words) if k and word in ends), len(words))
        return list(words[:cut])

    @cached_property
    def _all_words(self) -> dict[str, None]:
        return dict.fromkeys(word for name in self._names for word in name.split())


def _umlauts(plain: str) -> str:
    """ "kuehlschrank" as "Kühlschrank" is folded."""
    return re.sub("([aou])e", r"\1", plain)


def _cut(text: str) -> str:
    return text if len(text) <= TOLD else f"{text[:TOLD]}…"
