"""Durations in buckets: percentiles as near as the buckets are wide."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.tracing.histogram import PER_OCTAVE, Histogram


@given(st.lists(st.floats(1e-4, 100.0), min_size=1, max_size=200), st.floats(0.01, 1.0))
def test_a_percentile_is_the_least_that_so_many_reach_or_a_bucket_more(durations, share):
    histogram = Histogram()
    for seconds in durations:
        histogram.add(seconds)
    least = np.quantile(durations, share, method="inverted_cdf")
    assert least * (1 - 1e-9) <= histogram.percentile(share)
    assert histogram.percentile(share) <= least * 2 ** (1 / PER_OCTAVE) * (1 + 1e-9)
    assert histogram.percentile(1.0) == max(durations)


def test_what_is_outside_of_the_buckets_is_counted_in_the_outermost():
    histogram = Histogram()
    for seconds in (-1.0, 0.0, 1e-9, 1e6):
        histogram.add(seconds)
    assert (histogram.n, histogram.counts[0], histogram.counts[-1]) == (4, 3, 1)
    assert histogram.told()["max_ms"] == 1e9
    assert Histogram().percentile(0.5) == 0


def test_what_is_told_is_in_milliseconds():
    histogram = Histogram()
    for _ in range(99):
        histogram.add(0.010)
    histogram.add(0.5)
    told = histogram.told()
    assert told["p50_ms"] == pytest.approx(10, rel=0.1)
    assert told["p999_ms"] == told["max_ms"] == 500
