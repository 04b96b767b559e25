"""Memory: a new goal, asked of what an earlier search has seen."""

from collections.abc import Sequence

import numpy as np

from runtime.core.objects.instances import MISS_STEP, Instance, logit
from runtime.core.objects.semantic_map import SemanticMap
from runtime.core.types import F32, F64

RECALL_LOG_ODDS = 1.5  # at most, for what an earlier search saw: to be looked at again


def embedded(semantic: SemanticMap) -> tuple[tuple[Instance, ...], F32]:
    """The instances that have an embedding, by id, and those as (N, D) unit rows."""
    found = tuple(i for _, i in sorted(semantic.instances.items()) if i.embedding.size)
    rows = [i.embedding for i in found]
    return found, np.stack(rows) if rows else np.zeros((0, 0), np.float32)


def recall(
    semantic: SemanticMap,
    goal: str,
    names: Sequence[str],
    likeness: F64,
) -> tuple[int, ...]:
    """Give the `embedded` instances evidence for a new goal, in place; returns the ids of those
    that became candidates.

    `names` are the new vocabulary's classes, the goal among them; `likeness` (N, C) says with what
    probability each instance is each of them. One that is the goal more likely than anything else
    is called that from now on. Memory alone confirms nothing: the evidence is bounded, and every
    instance has to be seen again. What was rejected as this goal before stays rejected.
    """
    for instance in semantic.instances.values():
        instance.looks.clear()
        instance.unseen.clear()
        for known in instance.evidence.values():
            known.forget_views()
    found = []
    for instance, row in zip(embedded(semantic)[0], likeness, strict=True):
        rejected = goal in instance.evidence and instance.evidence[goal].rejections
        if rejected or names[int(row.argmax())] != goal:
            continue
        is_goal = float(row[names.index(goal)]) * instance.confidence
        odds = max(min(logit(is_goal), RECALL_LOG_ODDS), instance.odds_of(goal))
        for other in instance.evidence.values():  # with the new words at hand less likely that
            other.odds = min(other.odds, odds - MISS_STEP)
        instance.evidence_of(goal).odds = float(odds)
        found.append(instance.id)
        semantic.learnt((instance,))
    return tuple(found)
