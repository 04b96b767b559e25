"""A decision told in full, for a person who knows none of our words: where to, by which rule, who
voted for what and what each had to go by, who did not vote, and what it would have been else."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from runtime.core.belief import Taken
from runtime.core.types import Brief, Decision, FrontierBrief, Missing, Vote
from runtime.core.voting import taken
from runtime.core.voting.explain import no_agreement
from runtime.core.voting.names import ANSWERED_BY, introduced, listed, rule_said, who

OBJECTS_TOLD: Final = 5  # near a frontier, the nearest; experts hear no more
ROOMS_TOLD: Final = 3
FRONTIERS_TOLD: Final = 4  # of one vote, the likeliest
REASON_CHARS: Final = 300
PLACES_TOLD: Final = 3  # where the thing may be, the likeliest


@dataclass(frozen=True)
class ToldDecision:
    """A decision with what it was made on. `number`: of its search, from 1; `at`: where its
    frontiers were, (x, y) m by id; `heads_for`: where the robot went when the votes were in;
    `elapsed_s`: since the search began, None where nobody knows."""

    number: int
    goal: str
    decision: Decision
    brief: Brief
    at: Mapping[int, tuple[float, float]]
    heads_for: int | None
    elapsed_s: float | None = None


def in_full(told: ToldDecision) -> tuple[str, ...]:
    """Lines for a person; what belongs to a line above it is indented."""
    decision = told.decision
    since = "" if told.elapsed_s is None else f", {told.elapsed_s:.0f} s into it"
    lines = [f'Decision {told.number} of the search for "{told.goal}"{since}.']
    lines.append(f"It was due: {decision.why or 'nobody noted why'}.")
    if decision.frontier is None:
        lines.append("No frontier (an edge of what has been seen) could be reached: none was taken")
    else:
        lines.append(f"Taken: {_place(told, decision.frontier)}.")
        lines.extend(_taken_for(told, decision.frontier))
        lines.append("  A frontier is an edge of what has been seen; behind it is the unknown.")
        lines.append(f"Rule: {_rule(told, decision.frontier)}.")
        lines.extend(_planned(decision))
    for vote in decision.ballot.votes:
        lines.extend(_vote(told, vote))
    lines.extend(_absence(missing) for missing in decision.ballot.missing)
    lines.extend(_otherwise(told))
    return tuple(_printable(line) for line in lines)


def _place(told: ToldDecision, id: int) -> str:
    """ "frontier 7, at (3.1, -0.4) m, 4.2 m on foot"."""
    parts, brief = [f"frontier {id}"], _brief_of(told, id)
    if id in told.at:
        x_m, y_m = told.at[id]
        parts.append(f"at ({x_m:.1f}, {y_m:.1f}) m")
    if brief is not None:
        parts.append(f"{brief.distance_m:.1f} m on foot")
    return ", ".join(parts)


def _brief_of(told: ToldDecision, id: int) -> FrontierBrief | None:
    return next((f for f in told.brief.frontiers if f.id == id), None)


def _taken_for(told: ToldDecision, elected: int) -> Iterator[str]:
    """Of one that is not told of any more, as in recordings, what the brief has."""
    found, brief = told.decision.taken, _brief_of(told, elected)
    if found is None and brief is not None:
        found = Taken(brief.distance_m, brief.unknown_m2)
    if found is not None:
        ballot = told.decision.ballot
        asked = told.decision.taken is not None and bool(ballot.votes or ballot.missing)
        yield f"  What took it: {taken.in_words(found, asked)}."


def _rule(told: ToldDecision, elected: int) -> str:
    decision = told.decision
    said = rule_said(decision.rule, planned=bool(decision.order))
    if not decision.chosen:
        return f"{said}, as {no_agreement(decision, who)}"
    if decision.rule == "prior":
        return said
    backers = [v.expert for v in decision.ballot.votes if elected in v.frontiers]
    names = backers or [v.expert for v in decision.ballot.votes]
    said += f" ({listed([who(name) for name in names])})" if names else ""
    others = [i for i in decision.chosen if i != elected]
    if not others:
        return said
    return f"{said}, as they do {_ids(others)}; {_first_of(told, elected)}"


def _planned(decision: Decision) -> Iterator[str]:
    """What comes after it, and where the thing may be."""
    if len(decision.order) > 1:
        yield f"After it: {', '.join(str(i) for i in decision.order[1:])}, as far as is known now."
    if decision.belief is None:
        return
    places = decision.belief.places[:PLACES_TOLD]
    others = 100 * max(0.0, 1.0 - sum(place.p for place in places))
    yield f"Where it may be, likeliest first ({others:.0f} % elsewhere):"
    for place in places:
        where = (
            f"behind frontier {place.id}"
            if place.kind == "frontier"
            else f"{place.kind} {place.id}"
        )
        x_m, y_m = place.xy
        yield f"  {where}, at ({x_m:.1f}, {y_m:.1f}) m, {100 * place.p:.0f} %: {place.why}"


def _first_of(told: ToldDecision, elected: int) -> str:
    far = {f.id: f.distance_m for f in told.brief.frontiers if f.id in told.decision.chosen}
    nearest = elected in far and far[elected] <= min(far.values())
    return "of these it is the nearest" if nearest else "of these it is ranked first"


def _vote(told: ToldDecision, vote: Vote) -> Iterator[str]:
    by = ANSWERED_BY.get(vote.rung, vote.rung)
    took_s = told.decision.ballot.latency_s.get(vote.expert)
    took = "" if took_s is None else f" in {took_s:.2f} s"
    voter = _capital(introduced(vote.expert))
    yield f"{voter}: votes for {_ids(vote.frontiers)}; answered by {by}{took}."
    p = dict(vote.probabilities)
    likely = sorted(vote.frontiers, key=lambda i: (-p.get(i, 0.0), i))
    for id in likely[:FRONTIERS_TOLD]:
        sure = f", {100 * p[id]:.0f} % of its belief" if id in p else ""
        yield f"  {_place(told, id)}{sure}: {_short(vote.reason_for(id))}"
        known = _known(vote.expert, _brief_of(told, id))
        if known:
            yield f"    it knew: {known}"
    if len(likely) > FRONTIERS_TOLD:
        yield f"  and {len(likely) - FRONTIERS_TOLD} less likely"
    if vote.against:
        yield f"  against {_ids(vote.against)}"


def _known(expert: str, frontier: FrontierBrief | None) -> str:
    """What an expert was told of a frontier."""
    if frontier is None:
        return ""
    parts: list[str] = []
    if expert != "r2f" and expert != "sle":
        near = frontier.objects[:OBJECTS_TOLD]
        parts += [
            f"{o.name} {o.distance_m:.1f} m from it ({100 * o.confidence:.0f} % sure)" for o in near
        ]
    if expert != "o2f" and expert != "sle":
        rooms = sorted(frontier.rooms, key=lambda room: (-room[1], room[0]))[:ROOMS_TOLD]
        parts += [f"{name} {100 * p:.0f} %" for name, p in rooms]
        parts += ["a doorway"] if frontier.doorway else []
    if expert == "sle":
        parts.append("the camera's picture toward it")
    return ", ".join([*parts, f"{frontier.unknown_m2:.1f} m² unknown behind it"])


def _absence(missing: Missing) -> str:
    return f"{_capital(introduced(missing.expert))}: does not vote: {_short(missing.cause)}."


def _otherwise(told: ToldDecision) -> Iterator[str]:
    """What it would have been without each, and what else there was."""
    decision = told.decision
    if decision.frontier is None:
        return
    changes = {e: id for e, id in decision.without if id not in (None, decision.frontier)}
    if decision.without and not changes:
        yield "Any one expert left out: the same."
    for expert, id in changes.items():
        yield f"Without {who(expert)} it would have been {_place(told, id)}."
    same = [who(expert) for expert, _ in decision.without if expert not in changes]
    if changes and same:
        yield f"Without {' or '.join(same)}: the same."
    if decision.closest == decision.frontier:
        yield "It is the closest, too."
    elif decision.closest is not None:
        yield f"The closest was {_place(told, decision.closest)}."
    if told.heads_for not in (None, decision.frontier):
        yield f"When the votes were in it was gone: the robot went for frontier {told.heads_for}."


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _short(text: str) -> str:
    return text if len(text) <= REASON_CHARS else text[: REASON_CHARS - 1] + "…"


def _printable(line: str) -> str:
    """A model may say anything: what a terminal would obey is left out."""
    return "".join(c if c.isprintable() else " " for c in line)


def _ids(ids: Sequence[int]) -> str:
    return listed([str(i) for i in ids])
