"""Whatever bytes come from outside: nothing but an answer, within a second of computing. The same
entry points are fuzzed with coverage as a guide, and far longer, by scripts/fuzz."""

import runpy
import time

import pytest
from answers import EntryPoint
from entry_points import ENTRY_POINTS, REFUSALS
from hypothesis import HealthCheck, given, settings
from mutations import SPOILINGS, Spoiling, spoilt
from places import ROOT

EXAMPLES = 2000
LONGEST_S = 1.0  # of this thread's own computing, however busy the machine is

EVERY = [
    pytest.param(name, marks=[pytest.mark.slow] * entry.slow)
    for name, entry in ENTRY_POINTS.items()
]


@pytest.mark.parametrize("name", EVERY)
@settings(max_examples=EXAMPLES, suppress_health_check=list(HealthCheck), database=None)
@given(spoiling=SPOILINGS)
def test_bytes_from_outside_are_answered(name: str, spoiling: Spoiling):
    entry = ENTRY_POINTS[name]
    given_bytes = spoilt(entry.seeds, spoiling)
    # Within the first there may have been a collection of all that other tests have left.
    assert computed_s(entry, given_bytes) < LONGEST_S or computed_s(entry, given_bytes) < LONGEST_S


def computed_s(entry: EntryPoint, given_bytes: bytes) -> float:
    began_s = time.thread_time()
    entry.run(given_bytes)
    return time.thread_time() - began_s


@pytest.mark.parametrize("name", sorted(set(ENTRY_POINTS) - {"requests"}))
def test_what_is_good_is_not_refused(name: str):
    """Else nothing behind the first check would be fuzzed."""
    for seed in ENTRY_POINTS[name].seeds:
        REFUSALS.clear()
        ENTRY_POINTS[name].run(seed)
        assert not REFUSALS, seed[:100]


def test_scripts_fuzz_has_a_share_for_each():
    shares = runpy.run_path(str(ROOT / "scripts" / "fuzz.py"))["SHARES"]
    assert set(shares) == set(ENTRY_POINTS)
    assert sum(shares.values()) == pytest.approx(1.0)
