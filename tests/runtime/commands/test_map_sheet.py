"""What a map is drawn on."""

import cv2
import numpy as np
import pytest

from runtime.commands.map_sheet import KEY, Sheet


@pytest.fixture
def sheet() -> Sheet:
    """5 by 4 m, white."""
    sheet = Sheet.of({"rows": 80, "cols": 100, "resolution_m": 0.05, "origin_xy": [1.0, 2.0]})
    sheet.image[:] = 255
    return sheet


def count(sheet: Sheet, kind: str) -> int:
    return int((sheet.image == KEY[kind]).all(axis=2).sum())


def test_the_strip_tells_what_was_drawn_and_nothing_else(
    sheet: Sheet, monkeypatch: pytest.MonkeyPatch
):
    written: list[str] = []
    real = cv2.putText
    monkeypatch.setattr(cv2, "putText", lambda image, text, *how: (
        written.append(text), real(image, text, *how))[1])  # fmt: skip
    sheet.line([[1.5, 3.0], [2.5, 3.0]], "zone")
    sheet.dot([2.0, 4.0], "frontier", 3)
    sheet.line([[1.5, 3.0]], "driven")  # of one point there is none
    sheet.finished()
    assert written == ["frontier", "zone", "1 m"]


def test_a_dotted_line_goes_on_over_its_corners(sheet: Sheet):
    along = [[1.5 + 0.01 * n, 3.0] for n in range(201)]
    sheet.dotted([along[0], along[-1]], "planned")
    whole = count(sheet, "planned")
    sheet.image[:] = 255
    sheet.dotted(along, "planned")
    assert count(sheet, "planned") == pytest.approx(whole, rel=0.1)
    assert whole < 0.7 * 2.0 / 0.05 * sheet.cell_px * 5  # gaps between


def test_a_name_that_has_no_room_beside_its_point_has_a_line_to_it(sheet: Sheet):
    for n in range(20):
        sheet.name(f"thing {n}", [3.0, 4.0], KEY["thing"])
    led = [label for label in sheet.labels if label.point]
    assert led
    assert all(label.point == sheet.at([3.0, 4.0]) for label in led)
    assert not sheet.name("thing 20", [3.0, 4.0], KEY["thing"])
    assert sheet.name("sought", [3.0, 4.0], KEY["sought"], must=True)


def test_what_stands_somewhere_is_lighter_than_walls_and_has_an_outline(sheet: Sheet):
    sheet.image[:] = KEY["obstacle"]
    sheet.box([3.0, 4.0], [1.0, 0.5, 0.8], "thing")
    x, y = sheet.at([3.0, 4.0])
    assert (sheet.image[y, x] > np.array(KEY["obstacle"]) + 60).all()
    rows, cols = np.nonzero((sheet.image == KEY["thing"]).all(axis=2))
    scale = sheet.cell_px / sheet.resolution_m
    assert (np.ptp(cols) / scale, np.ptp(rows) / scale) == pytest.approx((1.0, 0.5), abs=0.02)


def test_words_in_the_midst_stay_within_the_picture(sheet: Sheet):
    sheet.middle("34", [[1.0, 2.0]], KEY["frontier"], 0.42, must=True)
    left, top, right, bottom = sheet.labels[0].box
    rows, cols = sheet.image.shape[:2]
    assert left >= 0
    assert top >= 0
    assert right <= cols
    assert bottom <= rows
