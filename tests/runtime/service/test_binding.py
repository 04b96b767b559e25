"""Nothing that is saved is used before it is known where that is."""

from runtime.core.types import Pose
from runtime.service.binding import BEGUN_HERE, ORIGIN, Binding, Bound

AT = Pose(1.0, 2.0, 0.5)


def test_where_nothing_was_saved_it_begins_here():
    binding = Binding(saved=False)
    assert binding.transform() == ORIGIN
    assert binding.in_words() == "none: it begins here"


def test_what_was_saved_is_unbound_until_somebody_tells():
    binding = Binding(saved=True)
    assert binding.transform() is None
    assert binding.in_words() == "unbound: this odometry began with the process"
    binding.bind(Bound(AT, "the dock", 3.0))
    assert binding.transform() == AT
    assert binding.in_words() == "bound by the dock"
    binding.unbind("odometry has jumped")
    assert binding.bound() is None
    assert binding.in_words() == "unbound: odometry has jumped"
    binding.bind(BEGUN_HERE)
    assert binding.transform() == ORIGIN


def test_what_was_only_said_is_told_as_such():
    binding = Binding(saved=True)
    binding.bind(Bound(AT, "the dock", 3.0, sure=False))
    assert (binding.sure(), binding.in_words()) == (False, "bound by the dock, not seen yet")
    binding.bind(Bound(AT, "the dock", 3.0))
    assert binding.sure()
    binding.unbind("odometry has jumped")
    assert not binding.sure()
