"""No stage of a frame is slower than at the commit whose times were accepted last (baseline.md): as
a ratio, of medians of turns, never in ms.

A stage counts as slow when it is over LIMIT in each of several comparisons: on a busy machine one
alone may be.
"""

import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from places import ROOT
from turns import Version, drive, observations, versions
from workload import MOUNT, keep

from runtime.bench.checkout import checkout

LIMIT = 1.13
SLOWED = 0.3
LEAST_MS = 0.5  # a stage that takes less is not watched
WATCHED = {"prepare", "survey", "place", "decide", "act", "steer"}
BASELINE = "tests/latency/baseline.md"


@pytest.fixture(scope="module")
def images(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("images") / "drive.npz"
    keep(path, observations(MOUNT))
    return path


@pytest.fixture(scope="module")
def accepted() -> Iterator[Path]:
    """The code of the commit that last changed baseline.md."""
    command = ["git", "-C", str(ROOT), "log", "-1", "--format=%H", "--", BASELINE]
    rev = subprocess.run(command, capture_output=True, text=True).stdout.strip()
    if not rev:
        pytest.skip("the history does not go back to the times that were accepted")
    with checkout(ROOT, rev) as root:
        yield root


def slow(ours: Version, theirs: Version, comparisons: int) -> set[str]:
    """The stages of ours that are over LIMIT every time."""
    found = set(WATCHED)
    for _ in range(comparisons):
        times = drive(ours, theirs)
        assert set(times) == WATCHED
        found &= {s for s, (ratio, ms) in times.items() if ratio > LIMIT and ms >= LEAST_MS}
        if not found:
            break
    return found


def test_no_stage_is_slower_than_was_accepted(images: Path, accepted: Path):
    with versions(Version(ROOT, images), Version(accepted, images)) as (ours, theirs):
        assert slow(ours, theirs, 3) == set(), "see baseline.md"


def test_a_stage_that_is_slowed_by_30_percent_is_found(images: Path):
    with versions(Version(ROOT, images, SLOWED), Version(ROOT, images)) as (slowed, usual):
        surely_ms = 1.3 * LEAST_MS * (1 + SLOWED)  # no stage that is now watched and now not
        watched = {s for s, (_, ms) in drive(usual, slowed).items() if ms >= surely_ms}
        assert watched, "every stage is too short to be watched"
        # On a busy machine a comparison may miss one; three in a row do not.
        assert any(slow(slowed, usual, 1) >= watched for _ in range(3))
