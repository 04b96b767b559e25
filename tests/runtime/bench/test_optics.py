"""What is timed of setting images right does it."""

import numpy as np

from runtime.bench.optics import stages


def test_every_stage_gives_an_image_or_the_floor():
    found = {name: stage() for name, stage in stages()}
    assert len(found) == 7
    images = {name: image for name, image in found.items() if isinstance(image, np.ndarray)}
    assert {name for name in found if name not in images} == {"the floor, by a mistaken mount"}
    assert images["turned by 90 degrees: colour"].shape == (640, 480, 3)
    assert images["of half the size"].shape == (480, 640)
    assert found["the floor, by a mistaken mount"] is not None
