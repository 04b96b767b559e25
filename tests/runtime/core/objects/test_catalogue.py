"""The catalogue says what a look through all instances would."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.objects.catalogue import OBJECT_CONFIDENCE, Catalogue
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.types import Pose

NAMES = ("chair", "sofa", "bed")
LEARNT = st.tuples(st.integers(1, 6), st.sampled_from(NAMES), st.floats(-2.0, 2.0))


def instance(id: int) -> Instance:
    return Instance(id, {"chair": Evidence()}, (0.0, 0.0), 0.5, np.zeros((1, 2)))


@settings(deadline=None)
@given(st.lists(LEARNT, max_size=40))
def test_it_follows_what_is_learnt(steps: list[tuple[int, str, float]]):
    instances: dict[int, Instance] = {}
    catalogue = Catalogue.of(instances)
    for id, name, odds in steps:
        one = instances.setdefault(id, instance(id))
        one.evidence_of(name).odds = odds
        one.views.append(Pose(0.0, 0.0, 0.0))
        catalogue.note((one,))
        assert len(catalogue) == len(instances)
        sure = {i.id for i in instances.values() if i.confidence >= OBJECT_CONFIDENCE}
        assert catalogue.sure == sure
        assert {n for n in instances if catalogue.is_sure(n)} == sure
        for known in NAMES:
            called = sorted(i.id for i in instances.values() if known in i.evidence)
            assert catalogue.called(known) == called
