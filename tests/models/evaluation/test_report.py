"""What the report and the cards of the models want."""

import re
from collections.abc import Iterator

import pytest
from places import ROOT

from models.evaluation.report import WANTED, wanted

CARD = ROOT / "models" / "weights" / "README.md"
ROWS = (
    ("held out", "AP50, held out"),
    ("share of own AP", "share of own AP"),
    ("RoboTHOR goals", "AP50, RoboTHOR goals"),
    ("reported from", "reported"),
    ("false sightings in 1,000 photographs", "reported"),
    ("false sightings", "false sightings"),
    ("HM3D goals", "AP50, HM3D goals"),
    ("calibration error", "calibration error"),
    ("AP50, trained", "AP50, trained"),
    ("AP50, COCO", "AP50, household"),
    ("AP50, NYU", "AP50, household"),
    ("photographs of COCO", "AP50, household"),
    ("room type", "room type"),
    ("1 thread(s)", "ms of one, 1 thread"),
    ("2 thread(s)", "ms of one, 2 threads"),
    ("at their rates", "ms of several, 2 threads"),
    ("file, MB", "file, MB"),
    ("memory, MB", "memory, MB"),
)
"""What a row of the cards begins with, and which figure that is."""


def card_rows() -> Iterator[tuple[str, str]]:
    """The first cell and the last of all tables whose last column is "wanted"."""
    inside = False
    for line in CARD.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if not line.startswith("|"):
            inside = False
        elif cells[-1] == "wanted":
            inside = True
        elif inside and set(cells[-1]) - set("-–"):
            yield cells[0], cells[-1]


def test_the_cards_want_what_the_report_wants() -> None:
    rows = list(card_rows())
    assert len(rows) > 30
    for what, said in rows:
        key = next(key for words, key in ROWS if words in what)
        assert re.fullmatch(r"[≥≤] [\d.]+", said)
        assert any(said in re.split(r"[;,] | on | or ", text) for text in WANTED[key]), (what, said)


@pytest.mark.parametrize(
    ("key", "domain", "text"),
    [
        ("room type", "photographs", "≥ 0.70"),
        ("room type", "renderings", "≥ 0.78"),
        ("room type", "", "renderings ≥ 0.78, photographs ≥ 0.70"),
        ("AP50, RoboTHOR goals", "photographs", "–"),
        ("AP50, RoboTHOR goals", "", "renderings ≥ 0.68"),
        ("calibration error", "", "≤ 0.05"),
        ("ms of several, 1 thread", "renderings", "–"),
    ],
)
def test_what_is_wanted_depends_on_what_the_images_are(key: str, domain: str, text: str) -> None:
    assert wanted(key, domain) == text
