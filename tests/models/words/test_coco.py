"""COCO's class list in our words: the map itself, maps that are wrong, and what stands for what."""

from pathlib import Path

import numpy as np
import pytest

from models.errors import ModelFileError
from models.words.coco import coco_map, coco_names, is_coco, read_map, stands_for
from models.words.vocabulary import load_vocabulary

MISLED = ("horse", "bench", "handbag", "skateboard", "bear", "sandwich", "sports ball")
"""What by meaning is a drying rack, a tv stand, a garbage bag, a cabinet, …"""


def test_the_map_names_each_of_the_80_and_no_class_twice() -> None:
    theirs = coco_map()
    assert len(theirs) == 80
    assert coco_names()[0] == "person"
    assert coco_names()[-1] == "toothbrush"
    ours = [name for name in theirs.values() if name]
    assert len(ours) == len(set(ours))
    assert theirs["couch"] == "sofa"
    assert theirs["tv"] == "television"
    assert theirs["potted plant"] == "plant"
    assert all(theirs[name] == "" for name in MISLED)


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


def test_a_class_list_is_cocos_by_its_names() -> None:
    assert is_coco(coco_names()[::-1])
    assert not is_coco((*coco_names()[:-1], "tooth brush"))
    assert not is_coco(coco_names()[:-1])


def test_every_household_word_stands_for_its_class_and_the_others_for_none() -> None:
    objects, names = load_vocabulary().objects, coco_names()
    likeness = stands_for(names, objects, coco_map())
    assert likeness.sum() == sum(1 for ours in coco_map().values() if ours)
    for name, row in zip(names, likeness, strict=True):
        found = [objects[k][0] for k in np.flatnonzero(row)]
        assert found == ([coco_map()[name]] if coco_map()[name] else [])


def test_what_is_asked_for_by_cocos_own_word_is_found_by_it() -> None:
    asked = (*load_vocabulary().objects, ("suitcase",))
    likeness = stands_for(("suitcase", "bench"), asked, coco_map())
    assert likeness[0].argmax() == len(asked) - 1
    assert likeness[1].max() == 0
    # a vocabulary of one's own, in which a sofa is a couch
    assert stands_for(("couch",), (("bed",), ("couch",)), coco_map()).tolist() == [[0, 1]]
