"""The picture of the rooms has all of them."""

from xml.etree import ElementTree

import pytest
from places import ROOT

PICTURE = ROOT / "docs/figures/architecture.svg"


@pytest.mark.parametrize("code", ["runtime", "hil_sim", "models"])
def test_every_room_is_in_the_picture_and_so_is_the_bridge(code: str):
    rooms = {file.parent.name for file in (ROOT / code).glob("*/__init__.py")}
    assert len(rooms) > 5
    words = set()
    for text in ElementTree.parse(PICTURE).iter("{http://www.w3.org/2000/svg}text"):
        words.update(word.strip(",;:") for word in "".join(text.itertext()).split())
    assert rooms - words == set()
    assert "mqtt" in words
