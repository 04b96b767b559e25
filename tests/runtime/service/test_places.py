"""Names for places, on disk at once."""

import json
from pathlib import Path

import pytest

from runtime.core.types import Pose
from runtime.errors import SavedError
from runtime.service.places import PLACES_FILE, PLACES_KEPT, NamedPlaces, place_name, place_pose

TABLE = Pose(1.5, -2.0, 0.7)


def test_a_place_is_there_after_a_restart_whatever_its_case(tmp_path: Path):
    places = NamedPlaces(tmp_path)
    assert len(places) == 0
    places.put("Kitchen table", TABLE)
    places.put("dock", Pose(0.0, 0.0, 0.0))
    again = NamedPlaces(tmp_path)
    assert again.of(" kitchen  TABLE ") == TABLE
    assert list(again.listed()) == ["Kitchen table", "dock"]
    assert again.of("sofa") is None
    assert again.remove("kitchen table")
    assert not again.remove("kitchen table")
    assert list(NamedPlaces(tmp_path).listed()) == ["dock"]


def test_a_name_that_is_given_again_is_of_the_new_place(tmp_path: Path):
    places = NamedPlaces(tmp_path)
    places.put("here", TABLE)
    places.put("Here", Pose(9.0, 9.0, 0.0))
    assert places.listed() == {"Here": Pose(9.0, 9.0, 0.0)}


def test_there_are_so_many_and_no_more(tmp_path: Path):
    places = NamedPlaces(tmp_path)
    for number in range(PLACES_KEPT):
        places._places[str(number)] = (str(number), TABLE)
    with pytest.raises(SavedError, match="remove one first"):
        places.put("one more", TABLE)
    places.put("7", Pose(0.0, 1.0, 0.0))
    assert len(places) == PLACES_KEPT


def test_what_cannot_be_written_is_not_believed_to_be(tmp_path: Path):
    places = NamedPlaces(tmp_path / "state")
    (tmp_path / "state").write_bytes(b"")
    with pytest.raises(SavedError):
        places.put("here", TABLE)
    assert places.of("here") is None


@pytest.mark.parametrize(
    "raw",
    [
        b"", b"[]", b'{"version": 2, "places": {}}', b'{"version": 1, "places": []}',
        b'{"version": 1, "places": {"a": [1, 2]}}', b'{"version": 1, "places": {"a": [1, 2, "x"]}}',
        b'{"version": 1, "places": {"a": [1e9, 2, 3]}}',
        b'{"version": 1, "places": {"": [1, 2, 3]}}',
    ],
)  # fmt: skip
def test_a_file_that_is_none_is_kept_aside(tmp_path: Path, raw: bytes):
    (tmp_path / PLACES_FILE).write_bytes(raw)
    with pytest.raises(SavedError, match=r"put aside as places\.json\.aside-1"):
        NamedPlaces(tmp_path)
    assert len(NamedPlaces(tmp_path)) == 0


def test_more_places_than_there_may_be_are_refused(tmp_path: Path):
    places = {str(n): [0, 0, 0] for n in range(PLACES_KEPT + 1)}
    told = json.dumps({"version": 1, "places": places})
    (tmp_path / PLACES_FILE).write_text(told)
    with pytest.raises(SavedError, match="more than"):
        NamedPlaces(tmp_path)


@pytest.mark.parametrize("value", [None, 3, "", "  ", "a\nb", "x" * 61])
def test_what_is_no_name_is_refused(value: object):
    with pytest.raises(ValueError, match="name of a place"):
        place_name(value)


def test_blanks_in_a_name_are_one():
    assert place_name("  my   desk ") == "my desk"


@pytest.mark.parametrize(
    "value", [None, [1, 2], [1, 2, True], [1, 2, "3"], [1e5, 0, 0], [0, 0, 8], {"x_m": 1}]
)
def test_what_is_no_pose_is_refused(value: object):
    with pytest.raises(ValueError, match="a place"):
        place_pose(value)
    assert place_pose([1, 2, -3]) == Pose(1.0, 2.0, -3.0)
