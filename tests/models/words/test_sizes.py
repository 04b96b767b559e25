"""How large things look, by name."""

from models.words.sizes import ON_FLOOR, UNKNOWN_M, ThingSize, size_of
from models.words.vocabulary import load_vocabulary


def test_a_thing_of_the_table_has_its_own_size():
    assert 0.05 < size_of("apple").size_m < 0.15 < size_of("laptop").size_m < 0.5
    assert 1.0 < size_of("bed").size_m < 3.0
    assert size_of("baseball bat").on_floor == 1.0
    assert size_of("mug", ("bed",)) == size_of("mug")


def test_what_is_not_in_it_is_as_large_as_its_kinds():
    kinds = size_of("lighting", ("desk lamp", "floor lamp", "no such thing"))
    assert size_of("desk lamp").size_m < kinds.size_m < size_of("floor lamp").size_m
    assert size_of("no such thing") == ThingSize(UNKNOWN_M, ON_FLOOR)


def test_what_is_small_looks_small():
    """The vocabulary's own list says the same of nearly all."""
    small = load_vocabulary().small
    assert max(size_of(name).size_m for name in small) < 0.4
