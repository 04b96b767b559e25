"""Last resorts come one after the other, each once."""

import pytest

from runtime.core.resorts import LastLooks, Resort

ORDERS: dict[LastLooks, list[Resort]] = {
    "afar": [Resort.RETRY, Resort.TIGHT, Resort.AFAR, Resort.FAINT],
    "closer": [Resort.CLOSER, Resort.RETRY, Resort.TIGHT, Resort.FAINT],
}


@pytest.mark.parametrize("looks", ORDERS)
def test_who_looks_closer_does_not_go_to_what_was_seen_from_afar_as_well(looks: LastLooks):
    tried, resort = [], Resort.NONE.next(looks)
    while resort is not None:
        tried.append(resort)
        resort = resort.next(looks)
    assert tried == ORDERS[looks]
    assert len({resort.reason for resort in tried}) == len(tried)
