"""Keyframes' images, encoded for a model that sees before anybody votes by them: a vision tower
takes seconds for one on a robot's processor, and a vote has no such time.

One thread encodes each image once: first those that frontiers are judged by, then what was kept
last. What it made is held for as long as its keyframe is, within MOST_BYTES.
"""

import math
import os
import threading
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from typing import Final, Protocol

from runtime.clock import Clock, Deadline
from runtime.core.mapping.keyframes import Keyframe

MOST_BYTES: Final = 32 << 20  # of encoded images; one of 64 tokens is some 250 kB
NICE: Final = 10


class Encoded(Protocol):
    """What a vision tower made of an image."""

    @property
    def nbytes(self) -> int: ...


class Encodes(Protocol):
    """A model that sees; it raises for what is no image."""

    def encode(self, image: bytes) -> Encoded: ...


class PictureEncoder:
    """Encodes images, JPEG files, in the background."""

    def __init__(self, model: Encodes, clock: Clock) -> None:
        self._model, self._clock = model, clock
        self._condition = threading.Condition()
        self._frames: tuple[Keyframe, ...] = ()  # that are kept, the oldest first
        self._wanted: tuple[bytes, ...] = ()  # by the last that asked
        self._waiting: list[tuple[bytes, ...]] = []  # what each that waits wants
        self._done: dict[bytes, Encoded] = {}
        self._failed: dict[bytes, str] = {}
        self._changed = self._closed = False
        self._last_s = 0.0
        self._thread = threading.Thread(target=self._work, name="pictures", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Have the thread end after the image under way; nobody waits any more."""
        with self._condition:
            self._closed = True
            self._condition.notify_all()

    def close(self) -> None:
        """End the thread after the image under way."""
        self.stop()
        self._thread.join(timeout=5.0)

    @property
    def errors(self) -> list[str]:
        """Why images that are still kept could not be encoded, each reason once."""
        with self._condition:
            return list(dict.fromkeys(self._failed.values()))

    def told(self) -> dict[str, object]:
        """For people: how many images are encoded now, and how long the last one took, s."""
        with self._condition:
            return {"encoded": len(self._done), "last_s": round(self._last_s, 3)}

    def hold(self, frames: Sequence[Keyframe]) -> None:
        """These keyframes are kept now, the oldest first: those before are forgotten."""
        with self._condition:
            self._frames, self._changed = tuple(frames), True
            self._condition.notify_all()

    def of(self, images: Iterable[bytes], by: Deadline) -> Mapping[bytes, Encoded]:
        """What is encoded of these images; what is not comes next. Only who has for ever waits
        until it is."""
        with self._condition:
            wanted = self._wanted = tuple(dict.fromkeys(images))
            self._changed = True
            self._condition.notify_all()
            if math.isinf(by.at_s):
                self._wait_for(wanted, by)
            return {image: self._done[image] for image in wanted if image in self._done}

    def _wait_for(self, wanted: tuple[bytes, ...], by: Deadline) -> None:
        """Until they are encoded, whoever else asks meanwhile. The condition is held."""
        self._waiting.append(wanted)
        try:
            while not self._closed and self._left(wanted):
                self._clock.wait(self._condition, by.at_s)
        finally:
            self._waiting.remove(wanted)

    def _left(self, images: Sequence[bytes]) -> list[bytes]:
        """Those that are neither encoded nor known to be impossible."""
        return [i for i in images if i not in self._done and i not in self._failed]

    # -- the thread that encodes -----------------------------------------------------------------

    def _work(self) -> None:
        with suppress(OSError):  # where a thread cannot have a priority of its own
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICE)
        while (image := self._next()) is not None:
            began_s = self._clock.now_s()
            try:
                encoded = self._model.encode(image)
            except Exception as error:  # noqa: BLE001 -- told, and the next may do
                self._fail(image, error)
                continue
            with self._condition:
                self._done[image] = encoded
                self._last_s = self._clock.now_s() - began_s
                self._condition.notify_all()

    def _next(self) -> bytes | None:
        """Wait for an image that is to be encoded; None when it is over."""
        while True:
            with self._condition:
                if self._closed:
                    return None
                frames, self._changed = self._frames, False
            newest = [self._file(f) for f in reversed(frames) if f.image.size]
            with self._condition:
                each = *self._waiting, self._wanted
                needed = tuple(dict.fromkeys(image for wanted in each for image in wanted))
                image = self._chosen(tuple(dict.fromkeys((*needed, *newest))), len(needed))
                if image is not None:
                    return image
                while not self._changed and not self._closed:
                    self._condition.wait()

    def _file(self, frame: Keyframe) -> bytes:
        """A keyframe's JPEG; b"" where none can be made, which is then known to be impossible."""
        try:
            return frame.jpeg
        except Exception as error:  # noqa: BLE001 -- told, and the next may do
            self._fail(b"", error)
            return b""

    def _fail(self, image: bytes, error: Exception) -> None:
        told = " ".join(str(error).split())[:160] or type(error).__name__
        with self._condition:
            self._failed[image] = told
            self._condition.notify_all()

    def _chosen(self, ranked: Sequence[bytes], needed: int) -> bytes | None:
        """The first image that is not encoded, while there is room; what there is no room for is
        forgotten. The first few are `needed` whatever room they take."""
        held, size, chosen = {}, 0, None
        for rank, image in enumerate(ranked):
            encoded = self._done.get(image)
            if rank >= needed and size + self._size(encoded) > MOST_BYTES:
                break
            if encoded is not None:
                held[image] = encoded
                size += encoded.nbytes
            elif chosen is None and image not in self._failed:
                chosen = image
                size += self._size(None)
        self._done = held
        self._failed = {i: why for i, why in self._failed.items() if i in ranked}
        return chosen

    def _size(self, encoded: Encoded | None) -> int:
        """Bytes; of one that is still to be encoded, those of any other."""
        known = next(iter(self._done.values()), None) if encoded is None else encoded
        return known.nbytes if known is not None else 0
