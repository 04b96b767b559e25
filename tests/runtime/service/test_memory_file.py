"""What is written is read; whatever else is there is refused in words."""

import io
import json
import zipfile
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from lived_in import lived_in

from runtime.core.keepsake import Keepsake, keepsake_of
from runtime.core.types import Pose
from runtime.service.memory_file import ABOUT, packed, unpacked


def kept() -> Keepsake:
    return keepsake_of(lived_in(), Pose(1.0, 2.0, 0.5), "eyes, and others")


def test_what_was_kept_is_read():
    known = kept()
    read = unpacked(packed(known))
    assert read.frame == known.frame
    assert (read.on, read.looks, read.room_names) == (known.on, known.looks, known.room_names)
    for name, layer in known.layers.items():
        assert np.array_equal(read.layers[name], layer), name
        assert read.layers[name].dtype == layer.dtype
    assert np.array_equal(read.rooms, known.rooms)
    (mug,), (same,) = known.instances, read.instances
    assert same.evidence == mug.evidence
    assert (same.xy, same.z_m, same.low_m, same.high_m) == (mug.xy, mug.z_m, mug.low_m, mug.high_m)
    assert np.allclose(same.cells_xy, mug.cells_xy)
    assert np.array_equal(same.embedding_sum, mug.embedding_sum)
    assert same.views == mug.views
    assert (same.best_score, same.range_m) == (mug.best_score, mug.range_m)
    (frame,), (view,) = known.keyframes, read.keyframes
    assert (view.pose, view.sharpness) == (frame.pose, frame.sharpness)
    assert np.array_equal(view.embedding, frame.embedding)


def test_an_empty_memory_is_one():
    known = replace(kept(), instances=(), keyframes=())
    read = unpacked(packed(known))
    assert read.instances == read.keyframes == ()


def damaged(change: Callable[[dict], None], **arrays: bytes) -> bytes:
    """A file of which something else is told, or is there."""
    into = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(packed(kept()))) as old,
        zipfile.ZipFile(into, "w") as new,
    ):
        for name in old.namelist():
            raw = arrays.get(name, old.read(name))
            if name == ABOUT:
                about = json.loads(raw)
                change(about)
                raw = json.dumps(about).encode()
            new.writestr(name, raw)
    return into.getvalue()


def put(name: str, value: object) -> Callable[[dict], None]:
    def change(about: dict) -> None:
        *path, last = name.split(".")
        for step in path:
            about = about[int(step) if step.isdigit() else step]
        about[int(last) if last.isdigit() else last] = value  # type: ignore[index]

    return change


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("version", 2, "of version 2, not 1"),
        ("frame", [0, 0, 0.1, 5, 5], "cells of 0.1 m"),
        ("frame", [0, 0, 0.05, 10**9, 10**9], "no count"),
        ("frame", [0, 0, 0.05, 5, True], "no count"),
        ("frame", [0, 0, 0.05, 5, 5], "bytes"),
        ("frame", [1e9, 0, 0.05, 5, 5], "is not"),
        ("frame", "here", "no list"),
        ("on", [0, 0], "no memory of rfnav's"),
        ("on", [0, 0, 99.0], "is not -4 to 4"),
        ("rooms", ["a\nb", "c"], "no name"),
        ("rooms", ["a"], "rooms"),
        ("looks", 7, "no name"),
        ("things", [{}], "cells"),
        ("things.0.names", [], "without a name"),
        ("things.0.names", [["mug", float("1e9"), 0, 0]], "is not -8 to 8"),
        ("things.0.names", [["mug", 0.0, -1, 0]], "no count"),
        ("things.0.cells", 0, "bytes"),
        ("things.0.embedding", 10**6, "no count"),
        ("things.0.score", 2.0, "is not 0 to 1"),
        ("things.0.xyz", [1.0], "no memory of rfnav's"),
        ("keyframes.0", [0, 0, 0, 1.0, 3], "bytes"),
    ],
)
def test_what_is_no_memory_is_refused_in_words(name: str, value: object, told: str):
    with pytest.raises(ValueError, match=told):
        unpacked(damaged(put(name, value)))


@pytest.mark.parametrize(
    ("arrays", "told"),
    [
        ({"evidence": b"\0"}, "evidence: 1 bytes"),
        ({"evidence": bytes(1 << 20)}, "more than"),
        ({"rooms": b"\xff" * len(np.zeros((2, 1)))}, "bytes"),
        ({"cells": b"\xff" * 16}, "off the map"),
        ({"embeddings": b"\xff" * 8}, "not finite"),
    ],
)
def test_arrays_of_another_size_or_range_are_refused(arrays: dict[str, bytes], told: str):
    with pytest.raises(ValueError, match=told):
        unpacked(damaged(lambda about: None, **arrays))


def test_rooms_that_are_no_shares_are_refused():
    many = kept().rooms.size
    with pytest.raises(ValueError, match="no shares"):
        unpacked(damaged(lambda about: None, rooms=b"\xff" * 2 * many))


def test_evidence_is_within_what_evidence_may_be():
    known = kept()
    wild = np.full(known.frame.shape, 30_000, np.int16).tobytes()
    assert unpacked(damaged(lambda about: None, evidence=wild)).layers["evidence"].max() == 20


def test_a_torn_file_is_refused():
    raw = packed(kept())
    for end in (0, 10, len(raw) // 2, len(raw) - 1):
        with pytest.raises(ValueError, match="no memory of rfnav's"):
            unpacked(raw[:end])
    flipped = bytearray(raw)
    flipped[len(raw) // 3] ^= 0xFF
    with pytest.raises(ValueError, match="no memory of rfnav's"):
        unpacked(bytes(flipped))
