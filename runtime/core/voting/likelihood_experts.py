"""DEFA: the experts' questions and votes. Prompts out, numbers in; no model and no clock here.

A small language model is never asked to choose. It scores the same continuation (the goal) in the
context of one object or one room type. Two centrings turn the score into evidence: against other
household words in the same context (some contexts make every noun likely), and against the same
word in other contexts (some nouns are likely everywhere).
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import Final, Literal

from runtime.core.keys import key
from runtime.core.types import Absence, Brief, FrontierBrief, Missing, Vote

OBJECT_DECAY_M = 1.5  # distance at which an object's weight has fallen to 1 / e
OBJECTS_HEARD = 5  # around a frontier, the nearest; of many the average says nothing
PRIOR_WEIGHT = 0.3  # of "nothing known", in objects right at the frontier
VIEW_SCALE = 8.0  # nats per unit of cosine between a view and the goal
UNKNOWN_WEIGHT = 0.5  # exponent of the unknown area behind a frontier, in its prior
DOOR_WEIGHT = 0.7  # of what a doorway seems to lead to, against the room it is seen from


SceneRung = Literal["head", "language", "embedding"]
WordEvidence = Literal["language", "counts", "both"]


@dataclass(frozen=True)
class ExpertConfig:
    """How experts that weigh words vote; all of it to compare with."""

    temperature: float = key(
        0.6,
        "Temperature of the softmax over frontiers.",
        "nats",
        research="experts_temperature",
        within=(0.01, 100.0),
    )
    bar: float = key(
        1.5,
        "A frontier of n is recommended when its probability is bar / n or more.",
        research="experts_bar",
        within=(0.0, 100.0),
    )
    scene_layout: SceneRung = key(
        "head",
        "How SLE judges a view without a model that sees: by a network that was taught what lies "
        'beyond, "head", or "language", which shows the view to the language model; "embedding": '
        "by its likeness to the goal's place, of which it was taught nothing.",
        research="scene_layout",
    )
    words: WordEvidence = key(
        "counts",
        'What tells O2F and R2F where things are: "counts" of what stands where in homes, or a '
        '"language" model; "both": the mean of what counts and a model that scores words say.',
        research="word_evidence",
    )
    doubt: float = key(
        0.0, "A frontier of n is voted against when it is doubt / n or less; see `consensus_veto`.",
        research="experts_doubt",
        within=(0.0, 100.0),
    )  # fmt: skip


@dataclass(frozen=True)
class LikelihoodQuestion:
    """Score `continuation` after `context`; equal questions have equal answers and are memoised.
    `seen`: a digest of what stands before the context in place of words, "" for nothing."""

    context: str
    continuation: str
    seen: str = ""


@dataclass(frozen=True)
class Topic:
    """How one kind of context is put into words; `anchors` are the contexts averaged over."""

    templates: tuple[str, ...]
    anchors: tuple[str, ...]


Doors = Mapping[str, Mapping[str, float]]
"""By room type: what a door of it leads to."""
NO_DOORS: Doors = {}
Evidence = dict[int, tuple[float, str]]
"""Nats, and what they come from, by frontier."""
NOTHING: Final[Mapping[int, tuple[float, str]]] = {}
REFERENCES = ("bed", "sofa", "table", "toilet", "refrigerator", "lamp", "desk", "plant")
OBJECTS = Topic(
    (
        "In the room there is {a_thing}. Next to it you will also find a",
        "Things found together in one room: bed, pillow, nightstand. "
        "Things found together in one room: stove, pan, kettle. "
        "Things found together in one room: {thing},",
    ),
    REFERENCES,
)
ROOMS = Topic(
    ("The {thing} contains a", "In the {thing} there is a", "Things found in a {thing}: a"),
    ("kitchen", "bathroom", "bedroom", "living room", "dining room", "home office", "hallway"),
)

DOORS = (
    "Next to the {thing}, through the door, is the",
    "The door of the {thing} leads to the",
)
VIEW = "the view toward it"
LEAST_M2 = 0.2  # taken to be unknown behind any frontier
SCENE = "a room with a {thing}"


def questions(topic: Topic, goal: str, things: Iterable[str]) -> tuple[LikelihoodQuestion, ...]:
    """Everything to be scored before `affinities` can be computed, without repeats, in a fixed
    order that keeps equal contexts together."""
    asked: dict[LikelihoodQuestion, None] = {}
    for thing in (*topic.anchors, *things):
        for template in topic.templates:
            context = _context(template, thing)
            for word in (*REFERENCES, goal):
                asked[LikelihoodQuestion(context, " " + word)] = None
    return tuple(asked)


def affinities(
    topic: Topic, goal: str, things: Iterable[str], answers: Mapping[LikelihoodQuestion, float]
) -> dict[str, float]:
    """How much more likely the goal becomes in the context of each thing, nats; only for things
    whose questions are all answered."""
    known: dict[str, float] = {}
    for thing in dict.fromkeys(things):
        try:
            known[thing] = fmean(
                _preference(template, thing, goal, answers)
                - fmean(_preference(template, anchor, goal, answers) for anchor in topic.anchors)
                for template in topic.templates
            )
        except KeyError:
            continue
    return known


def door_questions(rooms: Sequence[str]) -> tuple[LikelihoodQuestion, ...]:
    """Everything to be scored before `behind` can be computed; `rooms` are all room types."""
    contexts = [t.format(thing=room) for room in rooms for t in DOORS]
    return tuple(
        LikelihoodQuestion(context, " " + other) for context in contexts for other in rooms
    )


def behind(rooms: Sequence[str], answers: Mapping[LikelihoodQuestion, float]) -> Doors:
    """What a door of each room type leads to: probabilities of the other types; {} while a question
    is unanswered. A language model likes to say the same room again; a door leads to another."""
    try:
        nats = {
            (room, other): fmean(
                answers[LikelihoodQuestion(t.format(thing=room), " " + other)]
                - fmean(answers[LikelihoodQuestion(t.format(thing=r), " " + other)] for r in rooms)
                for t in DOORS
            )
            for room in rooms
            for other in rooms
            if other != room
        }
    except KeyError:
        return {}
    total = {r: math.fsum(math.exp(nats[r, o]) for o in rooms if o != r) for r in rooms}
    return {r: {o: math.exp(nats[r, o]) / total[r] for o in rooms if o != r} for r in rooms}


def vote_objects(
    brief: Brief,
    affinity: Mapping[str, float],
    cfg: ExpertConfig,
    beside: Mapping[int, tuple[float, str]] = NOTHING,
) -> Vote | Missing:
    """O2F: which frontiers do the objects near them recommend? `beside`: evidence of another kind,
    which is averaged with it."""
    return vote_where_known("o2f", brief, averaged(object_evidence(brief, affinity), beside), cfg)


def vote_rooms(
    brief: Brief,
    affinity: Mapping[str, float],
    cfg: ExpertConfig,
    doors: Doors = NO_DOORS,
    beside: Mapping[int, tuple[float, str]] = NOTHING,
) -> Vote | Missing:
    """R2F: which frontiers do their room types, and what doors seem to lead to, recommend?"""
    evidence = averaged(room_evidence(brief, affinity, doors), beside)
    return vote_where_known("r2f", brief, evidence, cfg)


def averaged(one: Evidence, other: Mapping[int, tuple[float, str]]) -> Evidence:
    """The mean of two kinds of evidence of frontiers that both have some for; else what there is.
    What it comes from is told as the first has it."""
    found = {**other, **one}
    for id in one.keys() & other.keys():
        found[id] = (one[id][0] + other[id][0]) / 2, one[id][1]
    return found


def object_evidence(brief: Brief, affinity: Mapping[str, float]) -> Evidence:
    """Nats and the objects behind them, by frontier. The goal is with one of the objects nearest to
    it or with none (`prior_weight`): a mixture, so that one telling object is not drowned by many
    that say nothing. Weights fall with the distance on foot and rise with confidence."""
    evidence: Evidence = {}
    for frontier in brief.frontiers:
        weights = [
            (o.confidence * math.exp(-o.distance_m / OBJECT_DECAY_M), o.name)
            for o in frontier.objects
            if o.name in affinity and o.name != brief.goal
        ]
        if not weights:
            continue
        heard = sorted(weights, reverse=True)[:OBJECTS_HEARD]
        total = sum(w for w, _ in heard) + PRIOR_WEIGHT
        likely = sum(w * math.exp(affinity[name]) for w, name in heard) + PRIOR_WEIGHT
        strongest = sorted(heard, key=lambda w: (-w[0] * affinity[w[1]], w[1]))
        told = ", ".join(dict.fromkeys(n for _, n in strongest[:3]))
        evidence[frontier.id] = math.log(likely / total), told
    return evidence


def room_evidence(brief: Brief, affinity: Mapping[str, float], doors: Doors) -> Evidence:
    """Nats and the likeliest room type, by frontier; a doorway also has what is behind it."""
    beyond = {
        room: sum(p * affinity[other] for other, p in others.items())
        for room, others in doors.items()
        if all(other in affinity for other in others)
    }
    evidence: Evidence = {}
    for frontier in brief.frontiers:
        spoken = [(p, spoken_room(name), name) for name, p in frontier.rooms]
        known = [(p, room, name) for p, room, name in spoken if room in affinity]
        total = sum(p for p, _, _ in known)
        if total <= 0:
            continue
        nats = sum(p * affinity[room] for p, room, _ in known) / total
        told = max(known)[2]
        if frontier.doorway and all(room in beyond for _, room, _ in known):
            behind_it = sum(p * beyond[room] for p, room, _ in known) / total
            nats += DOOR_WEIGHT * (behind_it - nats)
            told = f"door of {told}"
        evidence[frontier.id] = nats, told
    return evidence


def vote_scene(brief: Brief, likeness: Mapping[int, float], cfg: ExpertConfig) -> Vote | Missing:
    """SLE without a vision-language model: which frontiers' views are like the goal's place?
    `likeness` is a cosine by frontier."""
    evidence = {i: VIEW_SCALE * cosine for i, cosine in likeness.items()}
    return recommend("sle", brief, evidence, dict.fromkeys(evidence, VIEW), cfg)


def vote_both(brief: Brief, near: Evidence, around: Evidence, cfg: ExpertConfig) -> Vote | Missing:
    """One expert in place of two, to compare with: objects' and rooms' evidence added up."""
    ids = sorted({*near, *around})
    evidence = {i: near.get(i, (0.0, ""))[0] + around.get(i, (0.0, ""))[0] for i in ids}
    told = {i: ", ".join(v[i][1] for v in (near, around) if i in v) for i in ids}
    return recommend("both", brief, evidence, told, cfg)


def recommend(
    expert: str,
    brief: Brief,
    evidence: Mapping[int, float],
    told: Mapping[int, str],
    cfg: ExpertConfig,
    unknown_weight: float = UNKNOWN_WEIGHT,
) -> Vote | Missing:
    """p = softmax of the evidence (nats) over the frontiers that have any, times a prior: the more
    is unknown behind one, the more may be there: its area to the power of `unknown_weight`. The
    set is those with p >= bar / n. Nothing above the bar is an abstention, not an empty set."""
    if not evidence:
        return Missing(expert, Absence.NO_EVIDENCE)
    ids, nats = sorted(evidence), tuple(sorted(evidence.items()))
    top = max(evidence.values())
    area = {f.id: (f.unknown_m2 + LEAST_M2) ** unknown_weight for f in brief.frontiers}
    weights = [area[i] * math.exp((evidence[i] - top) / cfg.temperature) for i in ids]
    total = math.fsum(weights)
    p = {i: w / total for i, w in zip(ids, weights, strict=True)}
    chosen = tuple(i for i in ids if p[i] >= cfg.bar / len(ids))
    if not chosen:
        return Missing(expert, Absence.NO_PREFERENCE, nats=nats)
    reasons = tuple((i, told[i]) for i in chosen)
    reason = "; ".join(f"{i}: {why}" for i, why in reasons)
    against = tuple(i for i in ids if p[i] <= cfg.doubt / len(ids))
    told_p = tuple(p.items())
    return Vote(expert, chosen, told_p, reason, against=against, reasons=reasons, nats=nats)


def vote_where_known(
    expert: str,
    brief: Brief,
    evidence: Mapping[int, tuple[float, str]],
    cfg: ExpertConfig,
    unknown_weight: float = UNKNOWN_WEIGHT,
) -> Vote | Missing:
    """Where nothing is known at all of some frontiers, that is no evidence against them: 0 nats."""
    if not evidence:
        return Missing(expert, Absence.NO_EVIDENCE)
    known = {
        f.id: evidence.get(f.id) or (0.0, f"{_unknown(expert, f)}: by what is unknown behind it")
        for f in brief.frontiers
    }
    nats = {i: value for i, (value, _) in known.items()}
    texts = {i: told for i, (_, told) in known.items()}
    return recommend(expert, brief, nats, texts, cfg, unknown_weight)


def _unknown(expert: str, frontier: FrontierBrief) -> str:
    """Why nothing is known of a frontier to one expert."""
    if expert == "sle":
        return "no view of it yet"
    if not frontier.objects and not frontier.rooms:
        return "no object or room known near it"
    if expert == "o2f" and not frontier.objects:
        return "no object known near it"
    if expert == "r2f" and not frontier.rooms:
        return "no room known near it"
    return "nothing near it that tells of the goal"


def spoken_room(name: str) -> str:
    """The room type as the language model is told of it ("study" reads as a verb)."""
    return {"study": "home office"}.get(name, name)


def things_near(brief: Brief) -> tuple[str, ...]:
    """Names of all objects in the brief, sorted."""
    return tuple(sorted({o.name for f in brief.frontiers for o in f.objects}))


def _preference(
    template: str, thing: str, goal: str, answers: Mapping[LikelihoodQuestion, float]
) -> float:
    context = _context(template, thing)
    return answers[LikelihoodQuestion(context, " " + goal)] - fmean(
        answers[LikelihoodQuestion(context, " " + word)] for word in REFERENCES
    )


def _context(template: str, thing: str) -> str:
    article = "an" if thing[:1].lower() in "aeiou" else "a"
    return template.format(thing=thing, a_thing=f"{article} {thing}")
