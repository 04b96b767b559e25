"""Embeddings from the start before: to the last bit, of the same model, or none."""

import io
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest

from models.store import manifest
from models.words import row_file
from models.words.row_file import RowFile
from models.words.text_encoder import TextEncoder

ROWS = {"sofa": np.array([[0.1, 0.3]], np.float32), "bed": np.array([[1 / 3, 0.0]], np.float32)}


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "model.onnx"
    path.write_bytes(b"one")
    return path


def test_rows_come_back_to_the_last_bit(tmp_path: Path, model: Path):
    RowFile(tmp_path / "deep" / "rows.npz", model).keep(ROWS)
    found = RowFile(tmp_path / "deep" / "rows.npz", model).load()
    assert list(found) == ["sofa", "bed"]
    assert all((found[text] == ROWS[text]).all() for text in ROWS)
    assert [p.name for p in (tmp_path / "deep").iterdir()] == ["rows.npz"]


def test_those_of_another_model_or_processor_are_not_taken(
    tmp_path: Path, model: Path, monkeypatch: pytest.MonkeyPatch
):
    path = tmp_path / "rows.npz"
    RowFile(path, model).keep(ROWS)
    with monkeypatch.context() as patch:
        patch.setattr(row_file, "_processor", lambda: "another")
        assert RowFile(path, model).load() == {}
    model.write_bytes(b"two")
    assert RowFile(path, model).load() == {}


def headed(head: bytes) -> bytes:
    """An archive in which an array has that head."""
    array = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as made:
        made.writestr("identity.npy", array)
    return file.getvalue()


@pytest.mark.parametrize(
    "damage",
    [b"", b"PK\x03\x04 and no more", b"text", headed(b"{'shape': ("), headed(b"{\n  1L\n 2}")],
)
def test_a_damaged_file_is_told_of_and_made_anew(tmp_path: Path, model: Path, damage: bytes):
    path = tmp_path / "rows.npz"
    path.write_bytes(damage)
    file = RowFile(path, model)
    assert file.load() == {}
    assert file.error.startswith(f"{path}: cannot be read")
    assert "\n" not in file.error
    file.keep(ROWS)
    assert set(RowFile(path, model).load()) == set(ROWS)


def test_what_cannot_be_written_is_told_of(tmp_path: Path, model: Path):
    (tmp_path / "taken").write_text("a file")
    file = RowFile(tmp_path / "taken" / "rows.npz", model)
    file.keep(ROWS)
    assert "cannot be written" in file.error


def test_an_encoder_does_not_embed_again_what_it_has_from_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    where, kept = manifest.fetch("minilm"), tmp_path / "rows.npz"
    first = TextEncoder(where, kept=kept)
    rows = first.embed(["sofa", "bed"])
    assert first.keep() == ""
    monkeypatch.setattr(TextEncoder, "_embedded", lambda *_: pytest.fail("it is known"))
    second = TextEncoder(where, kept=kept)
    assert (second.embed(["sofa", "bed"]) == rows).all()
    written = kept.stat().st_mtime_ns
    assert second.keep() == ""
    assert kept.stat().st_mtime_ns == written  # there was nothing new
