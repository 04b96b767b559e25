"""Words in a picture do not cover each other."""

from hil_sim.evaluation.label_places import LABEL_PT, LabelPlaces


def test_the_first_spot_with_room_is_taken() -> None:
    places = LabelPlaces((0.0, 4.0, 0.0, 4.0), 0.01)
    spots = [(2.0, 2.0), (2.0, 3.0)]
    assert places.first(spots, "kitchen") == (2.0, 2.0)
    assert places.first(spots, "toilet") == (2.0, 3.0)
    assert places.first(spots, "sink") is None


def test_what_would_leave_the_picture_has_no_room() -> None:
    places = LabelPlaces((0.0, 4.0, 0.0, 4.0), 0.01)
    assert places.first([(0.05, 2.0)], "a long word") is None


def test_what_is_kept_is_kept_from_others_and_larger_words_need_more() -> None:
    places = LabelPlaces((0.0, 4.0, 0.0, 4.0), 0.01)
    places.keep((2.0, 2.0), "star")
    near = [(2.0, 2.15)]
    assert places.first(near, "sofa", 2 * LABEL_PT) is None
    assert places.first(near, "sofa") == near[0]
