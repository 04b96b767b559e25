"""The scene-layout expert asked about single views: is a thing beyond, is one in view, what room is
this. Beside it what it has to beat: a table of things by room type."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from hil_sim.expert_bench.auc import LEAST, Area, HomeAreas
from hil_sim.expert_bench.plan_counts import PlanCounts
from hil_sim.expert_bench.room_table import RoomTable
from hil_sim.expert_bench.scene_ways import PRIOR, WayFigures, judge_ways, prior_scores, with_prior
from hil_sim.expert_bench.view_questions import (
    Floats,
    Indices,
    SightRows,
    ViewBank,
    ViewQuestions,
)
from hil_sim.ground_truth.labels import LABELLED
from hil_sim.scenes.format import ROOM_TYPES

About = Literal["beyond", "view", "room"]
TABLE, GUESSING, HEAD = "room × table", "room × table, guessing", "detector's room head"
"""Rows beside those of the expert's own kinds: the table with counts of all categories, the same
that has not counted those never trained, and who tells rooms without any of it."""
ORACLE_ROOMS, ORACLE_FLOOR = "oracle rooms", "oracle rooms and area"
"""Who is told by the truth which rooms lie behind each frontier, or how much of each, and knows of
train homes what stands in them: how far anybody could get who understands views that well."""
TAUGHT, NEVER = "taught", "never taught"


class Beholder(Protocol):
    """One kind of the expert; `about` is what is asked."""

    def evidence(self, about: About, sights: SightRows, names: Sequence[str]) -> Floats:
        """(N, K) nats for each of the names, of things or of room types."""
        ...


@dataclass(frozen=True)
class HomesCounted:
    """How things were counted in train homes, for those that the expert is compared with: in their
    `plans`, and in `views` of them, where there are any."""

    views: ViewBank | None
    plans: PlanCounts

    def table(self, about: About) -> RoomTable:
        """How often a thing is beyond a view, or in it, by the room that is seen: as views have it,
        else plans, by which what is beyond is in the same room or next door."""
        if self.views is not None:
            views = self.views
            return RoomTable.fit(views.beyond if about == "beyond" else views.in_view)
        return RoomTable(self.plans.nearby if about == "beyond" else self.plans.share)


@dataclass(frozen=True)
class AreaRow:
    """Areas of one judge: the mean over names, all names' questions together, and the mean less
    the table's, paired. `weighed`: the mean with the prior, as a vote weighs both, and `gain` that
    less the prior's alone; None of what is in view, for which there is no prior."""

    macro: Area
    micro: Area
    gap: Area
    weighed: Area | None = None
    gain: Area | None = None


@dataclass(frozen=True)
class ViewTable:
    """`areas` by what is asked ("beyond" or "view") and group of names, then by judge; `rooms` and
    `photographs` the share of views whose room is told right, by judge; `ways` whether evidence
    about what is beyond knows the way. `asked`: how many names and questions each group has."""

    areas: Mapping[tuple[About, str], Mapping[str, AreaRow]]
    rooms: Mapping[str, Area]
    photographs: Mapping[str, Area]
    ways: Mapping[str, WayFigures]
    asked: Mapping[tuple[About, str], tuple[int, int]]
    homes: int


def judge_views(
    views: ViewBank,
    counted: HomesCounted,
    beholders: Mapping[str, Beholder],
    name_rows: Floats,
    never: Collection[str],
    photographs: tuple[SightRows, NDArray[np.int8]] | None = None,
    seed: int = 0,
) -> ViewTable:
    """Judge all on `views`; `name_rows` (C, D) are the embedded names of LABELLED, `never` those of
    them that were never trained."""
    areas, asked, ways = {}, {}, {}
    new = [k for k, name in enumerate(LABELLED) if name in never]
    kinds: tuple[tuple[About, ViewQuestions], ...] = (
        ("beyond", views.beyond),
        ("view", views.in_view),
    )
    for about, questions in kinds:
        names, table = enough(questions), counted.table(about)
        scores = {
            kind: _whole(b.evidence(about, questions.sights, [LABELLED[k] for k in names]), names)
            for kind, b in beholders.items()
        }
        every, rooms = np.arange(len(LABELLED)), questions.sights.rooms
        scores[TABLE] = table.score(rooms, every)
        scores[GUESSING] = table.guessing(new, name_rows).score(rooms, every)
        if about == "beyond":
            scores[PRIOR] = prior_scores(views.ways.unknown_m2)
            room_m2 = views.ways.room_m2.astype(np.float64)
            scores[ORACLE_ROOMS] = counted.plans.by_rooms(room_m2)
            scores[ORACLE_FLOOR] = counted.plans.by_floor(room_m2)
            ways = judge_ways(questions, views.ways, scores, names, seed)
        for group in (TAUGHT, NEVER):
            chosen = np.array([k for k in names if (k in new) == (group == NEVER)], np.intp)
            areas[about, group] = _areas(questions, scores, chosen, group, seed)
            asked[about, group] = len(chosen), int(questions.asked[:, chosen].sum())
    rooms_told = _rooms(views.in_view.sights, views.room, beholders, seed)
    told = _rooms(*photographs, beholders, seed) if photographs else {}
    return ViewTable(areas, rooms_told, told, ways, asked, views.homes)


def enough(questions: ViewQuestions) -> Indices:
    """The categories with enough answers of both kinds."""
    yes = (questions.asked & questions.true).sum(axis=0)
    no = (questions.asked & ~questions.true).sum(axis=0)
    return np.flatnonzero(np.minimum(yes, no) >= LEAST)


def _whole(evidence: Floats, names: Indices) -> Floats:
    """(N, K) of some names -> (N, C)."""
    scores = np.zeros((len(evidence), len(LABELLED)))
    scores[:, names] = evidence
    return scores


def _areas(
    questions: ViewQuestions, scores: Mapping[str, Floats], names: Indices, group: str, seed: int
) -> dict[str, AreaRow]:
    """What was counted needs no guessing."""
    homes = HomeAreas(questions.sights.home, seed)
    asked, true = questions.asked, questions.true
    kinds = [kind for kind in scores if kind != GUESSING or group == NEVER]

    def macro(values: Floats) -> Area:
        return homes.macro(values, asked, true, names)

    plain = {kind: macro(scores[kind]) for kind in kinds}
    rows = {
        kind: AreaRow(area, homes.micro(scores[kind], asked, true, names), area.minus(plain[TABLE]))
        for kind, area in plain.items()
    }
    for kind in kinds if PRIOR in scores else ():
        both = scores[kind] if kind == PRIOR else with_prior(kind, scores[kind], scores[PRIOR])
        weighed = macro(both)
        rows[kind] = replace(rows[kind], weighed=weighed, gain=weighed.minus(plain[PRIOR]))
    return rows


def _rooms(
    sights: SightRows, room: NDArray[np.int8], beholders: Mapping[str, Beholder], seed: int
) -> dict[str, Area]:
    known = room >= 0
    homes = HomeAreas([home for home, is_known in zip(sights.home, known, strict=True) if is_known],
                      seed)  # fmt: skip
    told = {kind: b.evidence("room", sights, ROOM_TYPES) for kind, b in beholders.items()}
    told[HEAD] = sights.rooms
    return {kind: homes.share((rows.argmax(axis=1) == room)[known]) for kind, rows in told.items()}
