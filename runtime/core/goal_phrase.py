"""A person's words, taken apart: what is looked for, where it may be, and what else was said of it.

A small grammar of English, with the little of other languages that stands around a noun. What a
noun is, it is told (`Nouns`).
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from runtime.core.small_words import (
    ADJECTIVES,
    BACK,
    BEING,
    CONTRACTED,
    DETERMINERS,
    FRONT,
    JOINS,
    LIKE,
    MEASURES,
    NOT,
    NUMBERS,
    OTHER,
    PLACING,
    SAYING,
    THEN,
)

Tokens = tuple[str, ...]
_THEN = re.compile(
    r"(?:^|[\s,;.])(?:" + "|".join(r"\s+".join(words) for words in THEN) + r")(?=[\s,:])", re.I
)


class Nouns(Protocol):
    """What is known of a phrase in lower case."""

    def thing(self, phrase: str) -> bool:
        """Whether it is the name of a thing."""

    def room(self, phrase: str) -> bool:
        """Whether it is a room, or a place like one."""


@dataclass(frozen=True)
class Phrase:
    """`things` are looked for, several where several were asked for. `near` and `rooms`: where it
    was said to be; `traits`: colours, sizes, numbers, owners; `unlike`: what it was said not to
    be; `other`: what else was said. `refusal`: why none can be looked for, or ""."""

    things: tuple[str, ...] = ()
    near: tuple[str, ...] = ()
    rooms: tuple[str, ...] = ()
    traits: tuple[str, ...] = ()
    unlike: tuple[str, ...] = ()
    other: tuple[str, ...] = ()
    refusal: str = ""

    @property
    def hints(self) -> tuple[str, ...]:
        """All that was said beside what is looked for, each with what it is."""
        return (
            *self.traits,
            *(f"near: {near}" for near in self.near),
            *(f"room: {room}" for room in self.rooms),
            *(f"not: {unlike}" for unlike in self.unlike),
            *self.other,
        )


def in_turn(text: str) -> tuple[str, ...]:
    """ "X, then Y" -> X and Y, for one after the other; any other text, whole."""
    parts = (part.strip(" ,;.") for part in _THEN.split(text))
    return tuple(part for part in parts if part) or (text,)


def parse(text: str, nouns: Nouns) -> Phrase:
    """Never raises; a text of N characters is read in time that grows as N squared at most."""
    words = _courteous(_tokens(text), nouns)
    if not words:
        return Phrase(refusal="names no thing")
    if nouns.thing(" ".join(words)):
        return Phrase((" ".join(words),))
    meant, unlike = _meant(words)
    if not meant:
        return Phrase(refusal=f"says what is not looked for ({' '.join(words)})")
    head, segments = _segments(meant)
    said = replace(_asked(head, nouns), unlike=unlike)
    if not said.things:
        where = next((rest for word, rest in segments if word in PLACING and rest), ())
        place = f" but a place ({' '.join(where)})" if where else ""
        return Phrase(refusal=f"names no thing{place}")
    for word, rest in segments:
        said = _also(said, word, rest, nouns)
    return said


def _tokens(text: str) -> Tokens:
    """Words in lower case, commas among them; other signs are blanks."""
    plain = text.lower().replace("’", "'").replace(" - ", " , ").replace("–", ",")
    plain = re.sub(r"[^\w\s'&+/,;.-]", " ", plain)
    plain = re.sub(r"\.+(?=\s|$)", " ", plain)
    for sign, word in (("&", " and "), ("+", " and "), ("/", " or "), (";", " , "), (",", " , ")):
        plain = plain.replace(sign, word)
    words = (w.strip("'") for w in plain.split())
    return tuple(part for w in words if w for part in CONTRACTED.get(w, (w,)))


def _courteous(words: Tokens, nouns: Nouns) -> Tokens:
    """Without what is only said to a robot: "please find me", "thank you"."""
    while words and not nouns.thing(" ".join(words)):
        front = next((f for f in FRONT if words[: len(f)] == f), ())
        back = next((b for b in BACK if words[-len(b) :] == b), ())
        if front:
            words = words[len(front) :]
        elif back:
            words = words[: -len(back)]
        else:
            break
    return words


def _meant(words: Tokens) -> tuple[Tokens, tuple[str, ...]]:
    """What is looked for, and what is not: "X, not Y", "not Y but X"; () for the first where only
    the second was said."""
    if words[0] in ("not", "neither", "never") or words[:2] in OTHER:
        cut = words.index("but", 2) if "but" in words[2:] else 0
        return (words[cut + 1 :], _denied(words[1:cut])) if cut else ((), ())
    for at in range(1, len(words)):
        marker = next((m for m in NOT if words[at : at + len(m)] == m), ())
        if marker:
            rest = words[at + len(marker) :]
            back = (k + 1 for k, w in enumerate(rest) if w == "," and _preposition(rest, k + 1))
            end = next(back, len(rest))  # "a mug, not a cup, on the table"
            return (*words[:at], *rest[end:]), _denied(rest[:end])
    return words, ()


def _denied(words: Tokens) -> tuple[str, ...]:
    told = _bare(tuple(word for word in words if word != ","))
    return (" ".join(told),) if told else ()


def _bare(words: Tokens) -> Tokens:
    return words[1:] if len(words) > 1 and words[0] in DETERMINERS else words


def _preposition(words: Tokens, at: int) -> Tokens:
    """The preposition or relative that begins at a place, the longest there is, or ()."""
    return next((p for p in (*PLACING, *SAYING) if words[at : at + len(p)] == p), ())


def _segments(words: Tokens) -> tuple[Tokens, list[tuple[Tokens, Tokens]]]:
    """What stands before the first preposition, and each one with what follows it. "of" is none."""
    starts: list[tuple[int, Tokens]] = []
    at = 0
    while at < len(words):
        found = _preposition(words, at)
        if found:
            starts.append((at, found))
        at += max(1, len(found))
    ends = [*(at for at, _ in starts), len(words)]
    rest = [(p, words[at + len(p) : ends[k + 1]]) for k, (at, p) in enumerate(starts)]
    return _untailed(words[: ends[0]]), [(p, _untailed(r)) for p, r in rest]


def _untailed(words: Tokens) -> Tokens:
    """Without "standing", "which is", "," at its end."""
    while words and (words[-1] in BEING or words[-1] == ","):
        words = words[:-1]
    return words


def _split(words: Tokens) -> Iterator[Tokens]:
    part: list[str] = []
    for word in words:
        if word in JOINS:
            yield tuple(part)
            part = []
        else:
            part.append(word)
    yield tuple(part)


def _asked(words: Tokens, nouns: Nouns) -> Phrase:
    """The things that are looked for, their traits, and rooms that were named beside them."""
    out = Phrase()
    waiting: Tokens = ()
    for said in _split(words):
        part = _courteous(said, nouns)
        if not part:
            continue
        bare = tuple(w for w in part if w not in DETERMINERS)
        if not nouns.thing(" ".join(part)) and all(
            _trait(w) for w in bare
        ):  # "black and white mug"
            waiting += bare
            continue
        noun = _noun(part, nouns)
        out = _joined(out, replace(noun, traits=(*waiting, *noun.traits)))
        waiting = ()
    things = tuple(thing for thing in out.things if not nouns.room(thing))
    if things and len(things) < len(out.things):  # "mug, kitchen"
        rooms = tuple(thing for thing in out.things if nouns.room(thing))
        out = replace(out, things=things, rooms=(*out.rooms, *rooms))
    return replace(out, traits=(*out.traits, *waiting))


def _joined(one: Phrase, two: Phrase) -> Phrase:
    return Phrase(
        tuple(dict.fromkeys((*one.things, *two.things))),
        tuple(dict.fromkeys((*one.near, *two.near))),
        tuple(dict.fromkeys((*one.rooms, *two.rooms))),
        tuple(dict.fromkeys((*one.traits, *two.traits))),
        tuple(dict.fromkeys((*one.unlike, *two.unlike))),
        tuple(dict.fromkeys((*one.other, *two.other))),
    )


def _trait(word: str) -> bool:
    return word in ADJECTIVES or word in NUMBERS or word.isdecimal()


def _noun(words: Tokens, nouns: Nouns) -> Phrase:
    """One thing, without articles, with what stands before it as traits and after "of" as other."""
    traits: list[str] = []
    rooms: tuple[str, ...] = ()
    while len(words) > 1 and not nouns.thing(" ".join(words)):
        first, rest = words[0], words[1:]
        wide = next((n for n in (3, 2, 1) if n < len(words) and _is_room(words[:n], nouns)), 0)
        if first in DETERMINERS:
            words = rest
        elif nouns.thing(like := " ".join((LIKE.get(first, first), *rest))):
            return Phrase((like,), rooms=rooms, traits=tuple(traits))
        elif _trait(first) or first.endswith(("'s", "s'")):
            traits.append(first)
            words = rest
        elif first in MEASURES and "of" in words[:-1]:
            words = words[words.index("of") + 1 :]
        elif "of" in words[1:-1]:
            cut = words.index("of", 1)
            more = (" ".join(words[cut:]),)
            return replace(_joined(Phrase((), (), rooms, tuple(traits)), _noun(words[:cut], nouns)),
                           other=more)  # fmt: skip
        elif wide:
            rooms = (*rooms, " ".join(words[:wide]))
            words = words[wide:]
        else:
            break
    if len(words) == 1 and (words[0] in DETERMINERS or _trait(words[0])):
        return Phrase(traits=(*traits, *words) if _trait(words[0]) else tuple(traits))
    return Phrase((" ".join(words),) if words else (), (), rooms, tuple(traits))


def _is_room(words: Sequence[str], nouns: Nouns) -> bool:
    return nouns.room(" ".join(words))


def _also(said: Phrase, word: Tokens, rest: Tokens, nouns: Nouns) -> Phrase:
    """With what follows one preposition: places, or what else is said. After "and" stands another
    thing that is looked for: "a mug on the table and a chair"."""
    if not rest:
        return said
    if word in SAYING:
        told = tuple(w for w in rest if w != ",")
        return replace(said, other=(*said.other, " ".join((*word, *told))))
    parts = [part for part in _split(rest) if part]
    either = word == ("between",) or "or" in rest
    for part in parts if either else parts[:1]:
        room = next((n for n in (2, 1) if n < len(part) and _is_room(_bare(part)[:n], nouns)), 0)
        if room and len(_bare(part)) > room:  # "the kitchen table"
            said = replace(said, rooms=(*said.rooms, " ".join(_bare(part)[:room])))
            part = _bare(part)[room:]
        noun = _noun(part, nouns)
        rooms = tuple(thing for thing in noun.things if nouns.room(thing))
        near = tuple(thing for thing in noun.things if not nouns.room(thing))
        found = Phrase(near=near, rooms=(*rooms, *noun.rooms))
        said = _joined(said, found)
    for part in () if either else parts[1:]:
        said = _joined(said, _asked(part, nouns))
    return said
