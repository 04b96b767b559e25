"""Object instances: one for each thing, whatever a view called it; evidence fused over views."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np

from runtime.core.geometry import GridFrame, wrap_angle
from runtime.core.kernels import objects as kernels
from runtime.core.mapping.grid import RESOLUTION_M
from runtime.core.objects.depth_segments import Sighting
from runtime.core.objects.footprints import joined, length_bounds, middle
from runtime.core.objects.places import InstancePlaces
from runtime.core.types import F32, F64, Pose

_NO_EMBEDDING = np.zeros(0, np.float32)


ASSOCIATE_M = 0.6  # between a detection and the instance it is another view of
OTHER_NAME_M = 0.3  # that much nearer, when it was never called that before,
FAR_M = 4.0  # between the middles of two views of one thing, at most
SAME_COSINE = 0.7
"""Of their embeddings, for two things that are joined to one: of one thing's views that were given
two names a third are so alike, of different things less than a metre apart 2 %."""
SAME_SIZE_SHARE = 0.35  # the shorter of the two at least that share of the longer,
SAME_HEIGHT_SHARE = 0.5  # and that much of the flatter one's height in common
RIVAL_COSINE = 0.6  # for two things of which the surer outdoes the other
RIVAL_SIZE = 0.5  # of the longer one's length, the shorter's share, where looks are not told
NEUTRAL_SCORE = 0.25  # a detection of this score speaks neither for nor against
MAX_STEP = 2.0  # of log-odds that one view can add
MISS_STEP = 0.5  # of log-odds that a view without the object costs
REPEAT_WEIGHT = 0.15  # of a view that is no new one
CUT_WEIGHT = 0.3  # of a view cut off at a side of the image: easily taken for another
NEW_VIEW_M = 0.4  # a view is new from so far away from all earlier ones,
NEW_VIEW_RAD = math.radians(20.0)  # or turned so far about the object
NEARER = 0.65  # of the nearest view's range: from there on the footprint is drawn anew
FARTHER = 1.5  # from there on a view adds evidence but no footprint
LOG_ODDS_MAX = 8.0  # either way, so that no object is ever past doubting


def logit(p: float) -> float:
    """Log-odds of a probability, bounded."""
    p = min(max(p, 1e-4), 1 - 1e-4)
    return math.log(p / (1 - p))


NEUTRAL_LOG_ODDS = logit(NEUTRAL_SCORE)


@dataclass
class Evidence:
    """What is known of one object being one thing."""

    odds: float = 0.0  # fused log-odds that it is there and is that
    backing: list[Pose] = field(default_factory=list)  # the distinct poses whose view spoke for it
    doubts: list[Pose] = field(default_factory=list)  # and those whose view spoke against it
    near_m: float = math.inf  # range of the nearest view that spoke for it
    rejections: int = 0  # as a target of that name
    since: int = 0  # the first view after the last rejection

    def forget_views(self) -> None:
        """What was seen of it speaks neither for nor against it any more."""
        self.backing, self.doubts, self.near_m = [], [], math.inf


@dataclass
class Instance:
    """One object: what it was called, how surely, where. Positions in the map frame, m."""

    id: int
    evidence: dict[str, Evidence]  # by every name that it was ever called
    xy: tuple[float, float]
    z_m: float  # middle of the points seen
    cells_xy: F64  # (N, 2) centres of the map cells under it
    low_m: float = 0.0  # its height above the floor, from
    high_m: float = 0.0  # and to
    embedding_sum: F32 = field(default_factory=lambda: _NO_EMBEDDING)  # (D,) of views, by score
    best_score: float = 0.0
    range_m: float = math.inf  # of the nearest view
    views: list[Pose] = field(default_factory=list)  # distinct poses that it was seen from
    looks: list[Pose] = field(default_factory=list)  # from where it was faced, and left undecided
    unseen: list[Pose] = field(default_factory=list)  # and from where it was hidden
    seen_through: int = 0  # so often its place was, since it was seen last
    _embedding: tuple[F32, F32] | None = field(default=None, repr=False, compare=False)
    _sides: tuple[F64, tuple[float, float]] | None = field(default=None, repr=False, compare=False)
    """Of the sum, and of the cells, that they were computed of."""
    _settled: F64 | None = field(default=None, repr=False, compare=False)
    """The cells, where they were joined of views and none of them is a stray."""

    @property
    def name(self) -> str:
        """What it is most surely; of equals the first that it was called."""
        return max(self.evidence, key=lambda name: self.evidence[name].odds)

    @property
    def log_odds(self) -> float:
        """Of the object being there and being what it is called."""
        return self.evidence[self.name].odds

    @property
    def confidence(self) -> float:
        """The same as a probability."""
        return self.confidence_of(self.name)

    def confidence_of(self, name: str) -> float:
        """Fused probability that it is there and is that."""
        return 1.0 / (1.0 + math.exp(-self.odds_of(name)))

    def odds_of(self, name: str) -> float:
        """Fused log-odds that it is there and is that; -inf for what it was never called."""
        return self.evidence[name].odds if name in self.evidence else -math.inf

    def evidence_of(self, name: str) -> Evidence:
        """What is known of it being that: to be added to."""
        known = self.evidence.get(name)
        if known is None:
            known = self.evidence[name] = Evidence()
        return known

    @property
    def embedding(self) -> F32:
        """(D,) unit: the views' mean by score; (0,) for a detector without embeddings."""
        if self._embedding is None or self._embedding[0] is not self.embedding_sum:
            norm = np.sqrt(self.embedding_sum.dot(self.embedding_sum))
            unit = self.embedding_sum / norm if norm > 0 else _NO_EMBEDDING
            self._embedding = self.embedding_sum, unit
        return self._embedding[1]

    @property
    def sides(self) -> tuple[float, float]:
        """Of the tightest rectangle round the centres of its cells, m, the longer first."""
        if self._sides is None or self._sides[0] is not self.cells_xy:
            _, sides, _ = cv2.minAreaRect(self.cells_xy.astype(np.float32))
            self._sides = self.cells_xy, (max(sides), min(sides))
        return self._sides[1]

    def views_as(self, name: str) -> list[Pose]:
        """From where it was seen, whatever it was called, since it was last rejected as that."""
        return self.views[self.evidence[name].since :] if name in self.evidence else self.views[:]


@dataclass(frozen=True)
class Likeness:
    """How alike two things have to be: by the cosine of their embeddings and by the share that the
    shorter has of the longer one's length, or by that alone where embeddings are not told."""

    cosine: float
    size: float
    size_unseen: float


# To be joined is for good, to be outdone is not: new views may turn it. One bar for both lost a
# find (docs/lab/searches.md).
ONE_THING = Likeness(SAME_COSINE, SAME_SIZE_SHARE, math.inf)
RIVAL = Likeness(RIVAL_COSINE, 0.0, RIVAL_SIZE)


def size_m(instance: Instance, cell_m: float) -> tuple[float, float, float]:
    """Length and width of the footprint's tightest rectangle, and height, m: of what was seen."""
    length_m, width_m = instance.sides
    return length_m + cell_m, width_m + cell_m, instance.high_m - instance.low_m


def shares(instance: Instance) -> dict[str, float]:
    """What it is, by name, if it is there at all: probabilities that sum to 1."""
    best = instance.log_odds
    weights = {name: math.exp(known.odds - best) for name, known in instance.evidence.items()}
    total = sum(weights.values())
    return {name: weight / total for name, weight in weights.items()}


def reject(instance: Instance, name: str, odds_each: float) -> None:
    """It was looked at from close by and not believed to be that: what spoke for it is forgotten,
    its views too. Only new views, more of them after each rejection, bring it back."""
    known = instance.evidence_of(name)
    known.rejections += 1
    known.odds = min(known.odds, known.rejections * odds_each)
    known.since = len(instance.views)
    known.forget_views()
    instance.looks.clear()
    instance.unseen.clear()


def fuse(
    instances: dict[int, Instance],
    seen: Instance,
    frame: GridFrame,
    sighting: Sighting,
    pose: Pose,
    near: Sequence[tuple[float, int]] | None = None,
) -> Instance:
    """Join a sighting, of `first_view`, to the instance that it is another view of, or to a new
    one. What it says for names is left to `called` and `uncalled`: one place may have two names in
    one image. `near` are the instances that it may be of, of `InstancePlaces.near`, where that is
    known."""
    if near is None:
        near = InstancePlaces.of(instances).near(seen.xy, seen.cells_xy, ASSOCIATE_M)
    instance, range_m = same(instances, seen, near), sighting.thing.range_m
    if instance is None:
        instance = instances[seen.id] = seen
    else:
        _widen(instance, seen, range_m, frame)
        total, one = instance.embedding_sum, seen.embedding_sum
        if one.size:  # not every detector, nor every frame, has one
            instance.embedding_sum = total + one if total.shape == one.shape else one
    instance.range_m, instance.seen_through = min(instance.range_m, range_m), 0
    instance.best_score = max(instance.best_score, sighting.score)
    if _is_new(instance, pose, instance.views_as(sighting.name)):
        instance.views.append(pose)
    return instance


def first_view(id: int, sighting: Sighting) -> Instance:
    """What the sighting alone tells of a thing."""
    _, xy, z_m, low_m, high_m, cells = sighting.thing
    total = sighting.embedding * np.float32(sighting.score)
    return Instance(id, {sighting.name: Evidence()}, xy, z_m, cells, low_m, high_m, total)


def called(instance: Instance, sighting: Sighting, pose: Pose) -> None:
    """It was called that, the surest name that this image has for it."""
    step = logit(sighting.score) - NEUTRAL_LOG_ODDS
    if step > 0:
        known = instance.evidence_of(sighting.name)
        known.near_m = min(known.near_m, sighting.thing.range_m)
    step = max(-MAX_STEP, min(MAX_STEP, step))
    weigh(instance, sighting.name, step * (CUT_WEIGHT if sighting.cut else 1.0), pose)


def uncalled(instance: Instance, names: Collection[str], pose: Pose, cut: bool = False) -> None:
    """It was in view and had these names, or none: that speaks against all others it ever had."""
    for name in instance.evidence:
        if name not in names:
            weigh(instance, name, -MISS_STEP * (CUT_WEIGHT if cut else 1.0), pose)


def _widen(instance: Instance, seen: Instance, range_m: float, frame: GridFrame) -> None:
    """Where it is and how large, of the near views alone: far ones spill over the edges."""
    if range_m >= FARTHER * instance.range_m:
        return
    low_m, high_m = seen.low_m, seen.high_m
    if range_m > NEARER * instance.range_m:
        settled = instance._settled is instance.cells_xy
        both = joined(frame, instance.cells_xy, seen.cells_xy, settled)
        if both is not None:
            instance.cells_xy, whole, instance.xy = both
            instance._settled = instance.cells_xy if whole else None
        low_m, high_m = min(low_m, instance.low_m), max(high_m, instance.high_m)
    else:
        instance.cells_xy, instance.xy = seen.cells_xy, middle(seen.cells_xy)
    instance.low_m, instance.high_m = low_m, high_m
    instance.z_m = 0.7 * instance.z_m + 0.3 * seen.z_m


def same(
    instances: Mapping[int, Instance], seen: Instance, near: Sequence[tuple[float, int]]
) -> Instance | None:
    """The instance that a first view `seen` is another view of: the nearest that was called that
    before, or that is alike in place, size and embedding whatever it was called. A name that is
    new to it costs as much as OTHER_NAME_M."""
    (name,) = seen.evidence
    alike = bool(seen.embedding_sum.size)
    best, others = (ASSOCIATE_M, math.inf), []
    for least, id in near:
        if least > best[0]:
            break
        if name in instances[id].evidence:
            best = min(best, (_gap_m(instances[id], seen), id))
        elif alike and least + OTHER_NAME_M <= best[0]:
            others.append((least + OTHER_NAME_M, id))
    for least, id in others:
        if least > best[0]:
            break
        nearer = _gap_m(instances[id], seen) + OTHER_NAME_M, id
        if nearer < best and same_thing(instances[id], seen, ONE_THING):
            best = nearer
    return instances[int(best[1])] if best[1] < math.inf else None


def _gap_m(a: Instance, b: Instance) -> float:
    """From the middle of either to the middle or a cell of the other, m; inf for what is far."""
    apart = math.dist(a.xy, b.xy)
    if apart > FAR_M:
        return math.inf
    return min(apart, kernels.cells_gap(a.cells_xy, a.xy, b.cells_xy, b.xy))


def same_thing(a: Instance, b: Instance, bar: Likeness) -> bool:
    """Whether two things in one place could be one that was called by two names: they stand at one
    height, neither is much smaller than the other, and they look alike. Where the detector does
    not tell how things look, their size has to do: a clock is no nightstand."""
    if not at_one_height(a, b):
        return False
    likeness = kernels.cosine(a.embedding_sum, b.embedding_sum)
    told = not math.isnan(likeness)
    if told and likeness < bar.cosine:
        return False
    return _as_long(a, b, bar.size if told else bar.size_unseen)


def _as_long(a: Instance, b: Instance, share: float) -> bool:
    """Whether the shorter has that share of the longer one's length. Mostly the extents tell."""
    low_a, high_a = length_bounds(a.cells_xy)
    low_b, high_b = length_bounds(b.cells_xy)
    if min(low_a, low_b) + RESOLUTION_M >= share * (max(high_a, high_b) + RESOLUTION_M):
        return True
    if min(high_a, high_b) + RESOLUTION_M < share * (max(low_a, low_b) + RESOLUTION_M):
        return False
    lengths = a.sides[0] + RESOLUTION_M, b.sides[0] + RESOLUTION_M
    return min(lengths) >= share * max(lengths)


def at_one_height(a: Instance, b: Instance) -> bool:
    """Whether two things are at one height, and not one on top of the other."""
    common = min(a.high_m, b.high_m) - max(a.low_m, b.low_m)
    return common >= SAME_HEIGHT_SHARE * min(a.high_m - a.low_m, b.high_m - b.low_m)


def weigh(instance: Instance, name: str, step: float, pose: Pose) -> None:
    """What a view from `pose` says for a name, or against it (`step`, log-odds): all of it from a
    new place or direction, little for one more of the kind from where there was one."""
    known = instance.evidence_of(name)
    mine = known.backing if step > 0 else known.doubts
    others = () if step > 0 else known.backing
    if _is_new(instance, pose, mine) and _is_new(instance, pose, others):
        mine.append(pose)
    else:
        step *= REPEAT_WEIGHT
    known.odds = max(-LOG_ODDS_MAX, min(LOG_ODDS_MAX, known.odds + step))


def _is_new(instance: Instance, pose: Pose, earlier: Sequence[Pose]) -> bool:
    """Whether a view is from another place, or in another direction, than all earlier ones."""
    x, y = pose.x_m, pose.y_m
    to_x, to_y = instance.xy
    for view in reversed(earlier):  # the latest are the likeliest to be near
        dx, dy = view.x_m - x, view.y_m - y
        if abs(dx) >= NEW_VIEW_M or abs(dy) >= NEW_VIEW_M or math.hypot(dx, dy) >= NEW_VIEW_M:
            continue
        turned = math.atan2(to_y - y, to_x - x) - math.atan2(to_y - view.y_m, to_x - view.x_m)
        if abs(wrap_angle(turned)) < NEW_VIEW_RAD:
            return False
    return True
