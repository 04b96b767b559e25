"""Which instances were ever called something, and which are sure: most are neither the goal nor
sure, and each frame asks for those that are."""

import math
from collections.abc import Iterable, Mapping
from typing import Final, Protocol

OBJECT_CONFIDENCE: Final = 0.6  # less certain ones are not mentioned
_SURE_ODDS: Final = math.log(OBJECT_CONFIDENCE / (1 - OBJECT_CONFIDENCE))
_ROUNDING: Final = 1e-6  # of odds, for confidence is what counts


class Named(Protocol):
    """What was called something, as an `Instance` was."""

    @property
    def id(self) -> int: ...

    @property
    def evidence(self) -> Mapping[str, object]: ...

    @property
    def log_odds(self) -> float: ...

    @property
    def confidence(self) -> float: ...


class Catalogue:
    """By name, and of all names the sure ones: ids."""

    def __init__(self) -> None:
        self._called: dict[str, set[int]] = {}
        self._sure: set[int] = set()
        self._ids: set[int] = set()

    @classmethod
    def of(cls, instances: Mapping[int, Named]) -> "Catalogue":
        """Of all instances."""
        catalogue = cls()
        catalogue.note(instances.values())
        return catalogue

    def __len__(self) -> int:
        return len(self._ids)

    def note(self, instances: Iterable[Named]) -> None:
        """These are new, or something was learnt of them."""
        for one in instances:
            self._ids.add(one.id)
            for name in one.evidence:
                self._called.setdefault(name, set()).add(one.id)
            if one.log_odds > _SURE_ODDS - _ROUNDING and one.confidence >= OBJECT_CONFIDENCE:
                self._sure.add(one.id)
            else:
                self._sure.discard(one.id)

    def called(self, name: str) -> list[int]:
        """Those that were ever called that, ascending."""
        return sorted(self._called.get(name, ()))

    @property
    def sure(self) -> frozenset[int]:
        """Those of OBJECT_CONFIDENCE or more."""
        return frozenset(self._sure)

    def is_sure(self, id: int) -> bool:
        """Whether one is among the sure."""
        return id in self._sure
