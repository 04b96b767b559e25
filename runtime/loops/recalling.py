"""What was seen before a restart, taken into a search that has begun without it."""

from dataclasses import replace

import numpy as np

from runtime.core.exploration import with_frontiers
from runtime.core.keepsake import Keepsake, meet_again, take_in
from runtime.core.objects.recall import embedded, recall
from runtime.core.objects.semantic_map import SemanticMap
from runtime.loops.order import SearchModels
from runtime.loops.search import Search


def remember(search: Search, known: Keepsake, models: SearchModels) -> None:
    """As `Search.inherit`, where this search has not seen for itself. `known` is `turned_onto` its
    map."""
    world, names, goal = search.world, search.order.names, search.goal.name
    assert world is not None
    apart = SemanticMap.empty(names, (), world.map.frame)
    meet_again(apart, take_in(world, known))
    things, rows = embedded(apart)
    likeness = models.likeness(rows) if things else np.zeros((0, len(names)))
    renamed = set(recall(apart, goal, names, likeness))
    met = meet_again(world.semantic, tuple(apart.instances.values()))
    hint = world.explored.hint
    world.explored.hint = replace(hint, before=hint.before | {thing.id for thing in met})
    with_frontiers(world, search.config.navigate)
    told = [
        {"id": new.id, "xy": new.xy, "p": round(new.confidence_of(goal), 4)}
        for new in met
        if goal in new.evidence
    ]
    recalled = [new.id for old, new in zip(apart.instances, met, strict=True) if old in renamed]
    search.journal.write("memory", objects=len(met), renamed=recalled, goal=told)
