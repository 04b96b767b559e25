"""What a frontier was taken for, in numbers and in words: its way, what is unknown behind it, what
experts say of it, its share of the belief, and its place in the order."""

from typing import Final

from runtime.core.belief import Ahead, Evidence, Said, Taken, signed
from runtime.core.types import Decision
from runtime.core.voting.names import listed, who

LEAST_NATS: Final = 0.05  # that say something: less would be told as 0.0


def said_of(id: int, evidence: Evidence, now: Evidence | None = None) -> tuple[Said, ...]:
    """Who says something of a frontier, sorted by name. `evidence`: what counts of each; `now`:
    what each says at this time, None where all that counts is of now."""
    return tuple(
        Said(expert, nats[id], now is not None and id not in now.get(expert, {}))
        for expert, nats in sorted(evidence.items())
        if abs(nats.get(id, 0.0)) >= LEAST_NATS
    )


def by_whom(said: tuple[Said, ...]) -> str:
    """ "objects near by and look of the view (said earlier)"; "" for nobody."""
    return listed([_named(one) for one in said]) if said else ""


def taken(decision: Decision, way_m: float, ahead: Ahead | None, said: tuple[Said, ...]) -> Taken:
    """Of the elected frontier; `way_m` to it on foot. `ahead`: None where areas are not weighed."""
    id = decision.frontier
    areas = dict(zip(ahead.ids, ahead.unknown_m2, strict=True)) if ahead is not None else {}
    places = decision.belief.places if decision.belief is not None else ()
    share = next((e.p for e in places if (e.kind, e.id) == ("frontier", id)), None)
    place = decision.order.index(id) + 1 if id in decision.order else 0
    return Taken(way_m, areas.get(id) if id is not None else None, said, share,
                 place, len(decision.order))  # fmt: skip


def in_words(taken: Taken, asked: bool) -> str:
    """One line; `asked`: whether any expert was. Where areas are not weighed, evidence is not."""
    parts = [f"{taken.way_m:.1f} m on foot"]
    if taken.unknown_m2 is not None:
        parts.append(f"{taken.unknown_m2:.1f} m² unknown behind it")
    if taken.said:
        each = [f"{signed(one.nats)} nats by {_named(one)}" for one in taken.said]
        parts.append(", ".join(each))
    elif asked and taken.unknown_m2 is not None:
        parts.append("no expert says anything of it")
    if taken.share is not None:
        parts.append(f"{100 * taken.share:.0f} % of the belief")
    if taken.place:
        nth = "first" if taken.place == 1 else f"number {taken.place}"
        parts.append(f"{nth} of {taken.planned} in the planned order")
    return ", ".join(parts)


def _named(one: Said) -> str:
    return f"{who(one.expert)} (said earlier)" if one.earlier else who(one.expert)
