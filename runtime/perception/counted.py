"""The table of counts, opened for the experts, with the text encoder to tell which names are
alike."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache

from models.words.counts import load_counts
from runtime.core.types import F32
from runtime.core.voting.counts import Count, CountTable
from runtime.experts.counts import CountExperts


def counted_in_homes() -> CountTable:
    """What the file that comes with the project has."""
    return CountTable.of([Count(*counted) for counted in load_counts()])


def seat_counts(embed: Callable[[Sequence[str]], F32]) -> CountExperts:
    """Of the file that comes with the project. `embed`: texts -> (N, D) unit rows; asked only for
    names that were never counted."""
    table = counted_in_homes()
    names = tuple(table.rates)

    @cache
    def rows() -> F32:
        return embed(names)

    def likeness(name: str) -> Mapping[str, float]:
        cosines = rows() @ embed([name])[0]
        return dict(zip(names, cosines.tolist(), strict=True))

    return CountExperts(table, likeness)
