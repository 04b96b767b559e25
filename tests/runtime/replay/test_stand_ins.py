"""What stands around the loop hands over what was recorded, and keeps no more than that needs."""

from types import SimpleNamespace

import numpy as np
import pytest
from apartment import NO_DETECTIONS

from runtime.core.mapping.attention import View
from runtime.core.types import Intrinsics, Observation, Pose
from runtime.errors import RecordingError
from runtime.loops.detector_worker import Surveyed
from runtime.recording.exact import exact
from runtime.replay.script import Turn
from runtime.replay.stand_ins import FilmLooks


def offered(looks: FilmLooks, stamp_ns: int) -> None:
    image, lens = np.zeros((2, 2), np.float32), Intrinsics(1.0, 1.0, 1.0, 1.0, 2, 2)
    obs = Observation(stamp_ns, np.zeros((2, 2, 3), np.uint8), image, Pose(0.0, 0.0, 0.0), lens)
    looks.offer(Surveyed(None, obs, np.zeros((0, 2)), 0.0), View(frozenset(), 0), False)


def looked(*stamps: int) -> tuple[FilmLooks, Turn]:
    """Looks in a turn in which these images had been looked at."""
    turn = Turn(1, "frame", 0.0)
    turn.heard["looked"].extend(stamps)
    turn.heard["detections"].extend(exact(NO_DETECTIONS) for _ in stamps)
    film = SimpleNamespace(turn=turn, heard=lambda name: turn.heard[name].popleft())
    return FilmLooks(film, frozenset(stamps)), turn  # type: ignore[arg-type]


def test_an_image_may_be_looked_at_long_after_it_was_offered():
    looks, _ = looked(3, 499)
    for stamp_ns in range(500):
        offered(looks, stamp_ns)
    assert list(looks._offered) == [3, 499]  # what nobody looked at is not kept
    assert [look.of.obs.stamp_ns for look in looks.take()] == [3, 499]
    assert not looks._offered


def test_an_image_of_a_search_before_is_not_looked_at():
    looks, _ = looked(3)
    offered(looks, 3)
    looks.begin(False)
    with pytest.raises(RecordingError, match="was not offered"):
        looks.take()
