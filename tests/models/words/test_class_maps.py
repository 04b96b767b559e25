"""Known class lists in our words: the maps themselves, spellings, maps that are wrong, and what
stands for what."""

from pathlib import Path

import numpy as np
import pytest

from models.errors import ModelFileError
from models.words.class_maps import (
    built_in,
    coco_91,
    coco_names,
    map_of,
    own_map,
    read_map,
    stands_for,
)
from models.words.vocabulary import load_vocabulary

MISLED = ("horse", "bench", "handbag", "skateboard", "bear", "sandwich", "sports ball")
"""What by meaning is a drying rack, a tv stand, a garbage bag, a cabinet, …"""
DARKNET = {
    "motorcycle": "motorbike", "airplane": "aeroplane", "couch": "sofa", "tv": "tvmonitor",
    "potted plant": "pottedplant", "dining table": "diningtable", "cell phone": "Cell_Phone",
}  # fmt: skip


def ours_of(names: tuple[str, ...]) -> dict[str, str]:
    known = map_of(names)
    assert known is not None
    return {name: words[0] for name, words in known.words.items()}


def test_the_map_names_each_of_the_80_and_no_class_twice() -> None:
    theirs = ours_of(coco_names())
    assert len(theirs) == 80
    assert coco_names()[0] == "person"
    assert coco_names()[-1] == "toothbrush"
    ours = [name for name in theirs.values() if name]
    assert len(ours) == len(set(ours))
    assert theirs["couch"] == "sofa"
    assert theirs["tv"] == "television"
    assert theirs["potted plant"] == "plant"
    assert all(theirs[name] == "" for name in MISLED)


def test_open_images_has_601_and_only_what_is_meant() -> None:
    names = built_in("open-images")
    assert len(names) == 601
    theirs = ours_of(names)
    assert {n for n, ours in theirs.items() if ours == "sofa"} == {
        "Couch", "Loveseat", "Sofa bed", "Studio couch"
    }  # fmt: skip
    assert theirs["Waste container"] == "trash can"
    for near in ("Drawer", "Infant bed", "Musical keyboard", "Bat (Animal)", "Window blind"):
        assert theirs[near] == ""
    assert map_of(names[::-1][:500]) is not None  # its challenge's part of them
    assert map_of(names[:100]) is None
    known = map_of(names)
    assert known is not None
    asked = (("bed",), ("suitcase",))  # by its own word, in whatever case
    assert stands_for(("Suitcase", "Drawer"), asked, known).tolist() == [[0, 1], [0, 0]]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[classes]\ncouch = "sofa"\ntv = "telvision"\n', r"map\.toml: classes\.tv = 'telvision'"),
        ("[classes]\ncouch = 3\n", r"map\.toml: classes\.couch = 3: no class"),
        ("[names]\n", r"map\.toml: not a class map"),
        ("classes = 3\n", r"map\.toml: not a class map"),
        ("[classes", r"map\.toml: not a class map"),
    ],
)
def test_a_map_that_names_what_does_not_exist_is_refused(
    text: str, said: str, tmp_path: Path
) -> None:
    path = tmp_path / "map.toml"
    path.write_text(text)
    with pytest.raises(ModelFileError, match=said) as told:
        read_map(path, {"sofa", "television"})
    assert "\n" not in str(told.value)
    with pytest.raises(ModelFileError, match=said):
        own_map(path)


def test_a_class_list_is_cocos_by_its_names() -> None:
    assert map_of(coco_names()[::-1]) is not None
    assert map_of((*coco_names()[:-1], "tooth paste")) is None
    assert map_of(coco_names()[:-1]) is None
    assert map_of(()) is None


def test_other_spellings_of_cocos_names_are_cocos() -> None:
    theirs = ours_of(tuple(DARKNET.get(name, name) for name in coco_names()))
    assert [theirs[DARKNET.get(name, name)] for name in coco_names()] == list(
        ours_of(coco_names()).values()
    )
    # who asks for an airplane is served by an aeroplane
    known = map_of(tuple(theirs))
    assert known is not None
    assert stands_for(("aeroplane",), (("airplane",),), known).tolist() == [[1]]


def test_the_91_numbers_leave_the_80_in_their_order() -> None:
    numbered = coco_91()
    assert len(numbered) == 91
    assert tuple(name for name in numbered if name) == coco_names()
    for number, name in ((1, "person"), (44, "bottle"), (67, "dining table"), (90, "toothbrush")):
        assert numbered[number] == name


def test_every_household_word_stands_for_its_class_and_the_others_for_none() -> None:
    for path in ("coco", "open-images"):
        objects, names = load_vocabulary().objects, built_in(path)
        known, theirs = map_of(names), ours_of(names)
        assert known is not None
        likeness = stands_for(names, objects, known)
        for name, row in zip(names, likeness, strict=True):
            found = [objects[k][0] for k in np.flatnonzero(row)]
            assert found == ([theirs[name]] if theirs[name] else [])


def test_what_is_asked_for_by_cocos_own_word_is_found_by_it() -> None:
    asked, known = (*load_vocabulary().objects, ("suitcase",)), map_of(coco_names())
    assert known is not None
    likeness = stands_for(("suitcase", "bench"), asked, known)
    assert likeness[0].argmax() == len(asked) - 1
    assert likeness[1].max() == 0
    # a vocabulary of one's own, in which a sofa is a couch
    assert stands_for(("couch",), (("bed",), ("couch",)), known).tolist() == [[0, 1]]
