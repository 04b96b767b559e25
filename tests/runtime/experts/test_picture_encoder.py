"""Images are encoded once, in the background: those asked for first, then the newest, in bounds."""

import threading

import numpy as np
import pytest
from manual_clock import ManualClock

from runtime.clock import Deadline, SystemClock
from runtime.core.mapping.keyframes import Keyframe
from runtime.core.types import Pose
from runtime.experts import picture_encoder
from runtime.experts.picture_encoder import PictureEncoder

PATIENCE_S = 20.0
KB = 1024


class Tower:
    """Encodes as 1 kB, one image each time it is let; it notes which."""

    def __init__(self, let: int = 1000) -> None:
        self.let, self.took = threading.Semaphore(let), threading.Semaphore(0)
        self.seen: list[bytes] = []

    def encode(self, image: bytes) -> np.ndarray:
        assert self.let.acquire(timeout=PATIENCE_S)
        self.seen.append(image)
        self.took.release()
        return np.zeros(KB, np.uint8)


def frames(count: int) -> list[Keyframe]:
    """From the darkest, the oldest, to the brightest."""
    return [
        Keyframe(
            Pose(float(n), 0.0, 0.0),
            np.zeros(0, np.float32),
            image=np.full((8, 8, 3), 20 * n, np.uint8),
        )
        for n in range(count)
    ]


def never() -> Deadline:
    return Deadline.never(SystemClock())


def encoded(encoder: PictureEncoder, shown: list[bytes]) -> list[bytes]:
    clock = ManualClock()
    return [i for i in shown if i in encoder.of([i], Deadline.after(1.0, clock))]


def test_each_image_is_encoded_once_the_newest_first() -> None:
    tower = Tower()
    encoder, kept = PictureEncoder(tower, SystemClock()), frames(4)
    encoder.hold(kept)
    images = [f.jpeg for f in kept]
    assert len(encoder.of(images[:1], never())) == 1
    encoder.hold([*kept, Keyframe(Pose(9.0, 0.0, 0.0), np.zeros(0, np.float32))])  # has no image
    for _ in range(4):
        assert tower.took.acquire(timeout=PATIENCE_S)
    encoder.close()
    assert sorted(tower.seen) == sorted(images)
    rest = [i for i in tower.seen if i != images[0]]
    assert rest == images[:0:-1]


def test_what_is_asked_for_comes_before_all_else_and_waits_for_nobody() -> None:
    tower = Tower(let=0)
    encoder, kept = PictureEncoder(tower, SystemClock()), frames(5)
    images = [f.jpeg for f in kept]
    soon = Deadline.after(1.0, ManualClock())
    assert encoder.of(images[1:3], soon) == {}
    encoder.hold(kept)
    tower.let.release(2)
    for _ in range(2):
        assert tower.took.acquire(timeout=PATIENCE_S)
    assert tower.seen == images[1:3]
    tower.let.release(1000)
    encoder.close()


def test_what_is_kept_no_more_is_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    tower = Tower()
    encoder, kept = PictureEncoder(tower, SystemClock()), frames(3)
    images = [f.jpeg for f in kept]
    encoder.of(images, never())
    encoder.hold(kept[2:])
    encoder.of(images[2:], never())  # nothing else is asked for
    encoder.of([frames(5)[4].jpeg], never())
    assert len(tower.seen) == 4
    encoder.of(images[:1], never())
    encoder.close()
    assert tower.seen[4:] == images[:1]


def test_there_is_room_for_so_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(picture_encoder, "MOST_BYTES", 3 * KB)
    tower = Tower()
    encoder, kept = PictureEncoder(tower, SystemClock()), frames(6)
    images = [f.jpeg for f in kept]
    encoder.of(images[5:], never())
    encoder.hold(kept)
    for _ in range(3):
        assert tower.took.acquire(timeout=PATIENCE_S)
    encoder.of(images[3:4], never())
    assert tower.seen == [images[5], images[4], images[3]]
    assert len(encoder.of(images[:4], never())) == 4  # what frontiers are judged by has to be there
    encoder.close()
    encoder.of(images, never())  # nobody waits any more


def test_what_cannot_be_encoded_is_tried_once() -> None:
    class Blind(Tower):
        def encode(self, image: bytes) -> np.ndarray:
            super().encode(image)
            raise ValueError("not a\n picture")

    tower = Blind()
    encoder = PictureEncoder(tower, SystemClock())
    for _ in range(2):
        assert encoder.of([b"x"], never()) == {}
    assert (tower.seen, encoder.errors) == ([b"x"], ["not a picture"])
    encoder.close()


def test_two_that_wait_are_both_answered() -> None:
    tower = Tower(let=0)
    encoder, answers = PictureEncoder(tower, SystemClock()), []
    images = [f.jpeg for f in frames(5)]

    def ask(shown: list[bytes]) -> None:
        answers.append(sorted(encoder.of(shown, never())) == sorted(shown))

    askers = [threading.Thread(target=ask, args=(part,)) for part in (images[:3], images[3:])]
    for asker in askers:
        asker.start()
    with encoder._condition:
        assert encoder._condition.wait_for(lambda: len(encoder._waiting) == 2, PATIENCE_S)
    tower.let.release(1000)
    for asker in askers:
        asker.join(PATIENCE_S)
    encoder.close()
    assert answers == [True, True]
    assert sorted(tower.seen) == sorted(images)


def test_a_keyframe_of_which_no_file_can_be_made_does_not_stop_the_others() -> None:
    tower = Tower()
    encoder, kept = PictureEncoder(tower, SystemClock()), frames(2)
    broken = Keyframe(
        Pose(9.0, 0.0, 0.0), np.zeros(0, np.float32), image=np.zeros((2, 2, 7), np.uint8)
    )
    encoder.hold([*kept, broken])
    assert len(encoder.of([f.jpeg for f in kept], never())) == 2
    assert len(encoder.errors) == 1
    encoder.hold(kept)
    encoder.of([frames(5)[4].jpeg], never())
    assert encoder.errors == []
    encoder.close()
