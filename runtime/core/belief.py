"""Where the thing that is looked for may be: a probability over the places of the map, and how far
those are from one another."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

Kind = Literal["frontier", "surface", "room"]
Evidence = Mapping[str, Mapping[int, float]]
"""By expert: nats by frontier."""
ELSEWHERE_M2 = 2.0  # of unknown floor that lies behind no frontier that can be gone to
STANDING = 0.5  # what a square metre of a surface holds of what one of unknown floor does
LIKELIEST = 10  # places that are told
NOBODY: Mapping[int, str] = {}


class SeenSurface(Protocol):
    """A surface that was seen: where, how large, and how likely such a thing on it was missed."""

    @property
    def id(self) -> int | str: ...

    @property
    def xy(self) -> tuple[float, float]: ...

    @property
    def area_m2(self) -> float: ...

    @property
    def missed(self) -> float: ...


@dataclass(frozen=True)
class Expected:
    """A place that may hold the thing: `xy` m, how likely, and why."""

    kind: Kind
    id: int | str
    xy: tuple[float, float]
    p: float
    why: str


@dataclass(frozen=True)
class Belief:
    """The likeliest place first; what is `elsewhere` lies at none of them. All come to 1."""

    places: tuple[Expected, ...]
    elsewhere: float

    def told(self) -> dict[str, object]:
        """As it is published: the LIKELIEST, and what the others come to."""
        told = [vars(place) | {"p": round(place.p, 3)} for place in self.places[:LIKELIEST]]
        others = 1.0 - sum(place.p for place in self.places[:LIKELIEST])
        return {"places": told, "others": round(max(0.0, others), 3)}


@dataclass(frozen=True)
class Said:
    """What an expert says of one frontier: `nats` of it that count. `earlier`: it says nothing of
    it now, and did before."""

    expert: str
    nats: float
    earlier: bool = False


@dataclass(frozen=True)
class Taken:
    """What the elected frontier was taken for. `way_m` on foot; `unknown_m2` behind it, None where
    areas are not weighed; `said` by those that say something of it; `share` of the belief, 0..1,
    None where there is none; its `place` from 1 in an order of `planned`, 0 where none is."""

    way_m: float
    unknown_m2: float | None = None
    said: tuple[Said, ...] = ()
    share: float | None = None
    place: int = 0
    planned: int = 0

    def told(self) -> dict[str, object]:
        """As it is published."""
        return {
            "way_m": round(self.way_m, 3),
            "unknown_m2": None if self.unknown_m2 is None else round(self.unknown_m2, 3),
            "said": [vars(one) | {"nats": round(one.nats, 3)} for one in self.said],
            "share": None if self.share is None else round(self.share, 3),
            "place": self.place,
            "planned": self.planned,
        }


@dataclass(frozen=True, eq=False)
class Ahead:
    """What an order of frontiers is made of. By frontier, n of them: `ids`, where each is gone to,
    `unknown_m2` behind it, `mass` (n,) that area with what else speaks for it; ways on foot, m:
    `first_m` (n,) from the robot, `between_m` (n, n), or (0, 0) where no order is planned.
    `standing`: the one that is driven to. `before`: by expert, what it has said of frontiers so
    far, nats by id. `patches`: surfaces that were not seen finely enough."""

    ids: tuple[int, ...]
    at_xy: tuple[tuple[float, float], ...]
    unknown_m2: tuple[float, ...]
    mass: NDArray[np.float64]
    first_m: NDArray[np.float64]
    between_m: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0)))
    standing: int | None = None
    before: Evidence = field(default_factory=dict)
    patches: tuple[SeenSurface, ...] = ()

    @property
    def planned(self) -> bool:
        """Whether the order of several frontiers is."""
        return self.between_m.size > 0


def signed(nats: float) -> str:
    """ "+0.4"; never "-0.0"."""
    return f"{round(nats, 1) + 0.0:+.1f}"


def believed(ahead: Ahead, nats: Mapping[int, float], said: Mapping[int, str] = NOBODY) -> Belief:
    """What lies behind frontiers by their unknown area and the evidence, nats by id; on surfaces by
    theirs and how likely it was missed there. `said`: whose the evidence is, by id."""
    weighed: list[Expected] = []
    for id, xy, area_m2 in zip(ahead.ids, ahead.at_xy, ahead.unknown_m2, strict=True):
        mass = area_m2 * float(np.exp(nats.get(id, 0.0)))
        why = f"{area_m2:.1f} m² unknown behind it"
        if said.get(id):
            why += f", {signed(nats.get(id, 0.0))} nats by {said[id]}"
        weighed.append(Expected("frontier", id, xy, mass, why))
    for patch in ahead.patches:
        mass = STANDING * patch.area_m2 * patch.missed
        why = f"{patch.area_m2:.1f} m² on which it is missed with {100 * patch.missed:.0f} %"
        weighed.append(Expected("surface", patch.id, patch.xy, mass, why))
    total = sum(place.p for place in weighed) + ELSEWHERE_M2
    shares = [Expected(e.kind, e.id, e.xy, e.p / total, e.why) for e in weighed]
    ranked = sorted(shares, key=lambda e: (-e.p, e.kind, str(e.id)))
    return Belief(tuple(ranked), ELSEWHERE_M2 / total)
