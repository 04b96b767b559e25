"""The head of a GGUF file is read and bounded before llama.cpp opens it."""

import struct
from pathlib import Path

import gguf
import numpy as np
import pytest

from models.errors import ModelFileError
from models.language.gguf_file import refuse_damaged


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("gguf") / "small.gguf"
    writer = gguf.GGUFWriter(path, "llama")
    writer.add_uint32("llama.block_count", 2)
    writer.add_array("tokenizer.ggml.tokens", ["a", "bc", "def"])
    writer.add_array("tokenizer.ggml.scores", [0.5, 1.0, 2.0])
    writer.add_string("general.name", "small")
    writer.add_tensor("blk.0.attn_q.weight", np.ones((4, 32), np.float32))
    writer.add_tensor("blk.1.attn_q.weight", np.ones((4, 32), np.float16))
    writer.write_header_to_file()
    writer.write_kv_data_to_file()
    writer.write_tensors_to_file()
    writer.close()
    return path.read_bytes()


def refused(data: bytes, tmp_path: Path) -> str:
    path = tmp_path / "model.gguf"
    path.write_bytes(data)
    with pytest.raises(ModelFileError) as caught:
        refuse_damaged(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_whole_file_is_none_of_ours_to_refuse(small: bytes, tmp_path: Path):
    path = tmp_path / "model.gguf"
    path.write_bytes(small)
    refuse_damaged(path)


@pytest.mark.parametrize(
    ("at", "form", "value", "told"),
    [
        (0, "<4s", b"GGML", "it does not begin with GGUF"),
        (4, "<I", 1, "of version 1; known are 2 and 3"),
        (8, "<Q", 2**63, "tensors and"),
        (16, "<Q", 2**40, "tensors and"),
        (24, "<Q", 2**62, "a text of"),
    ],
)
def test_a_field_that_no_model_has(
    small: bytes, tmp_path: Path, at: int, form: str, value: object, told: str
):
    data = bytearray(small)
    struct.pack_into(form, data, at, value)
    assert told in refused(bytes(data), tmp_path)


def test_cut_anywhere_it_is_refused(small: bytes, tmp_path: Path):
    for end in (*range(0, len(small), 7), len(small) - 33):
        refused(small[:end], tmp_path)


def test_weights_may_not_lie_beyond_the_end(small: bytes, tmp_path: Path):
    name = small.index(b"blk.1.attn_q.weight") + len(b"blk.1.attn_q.weight")
    data = bytearray(small)
    struct.pack_into("<Q", data, name + 4, 2**40)  # its first dimension
    assert "weights are beyond its end" in refused(bytes(data), tmp_path)


def test_arrays_and_alignments_are_bounded(small: bytes, tmp_path: Path):
    at = small.index(b"tokenizer.ggml.tokens") + len(b"tokenizer.ggml.tokens") + 8
    data = bytearray(small)
    struct.pack_into("<Q", data, at, 2**50)
    assert f"an array of {2**50} values" in refused(bytes(data), tmp_path)
    aligned = small.replace(b"llama.block_count", b"general.alignment")
    at = aligned.index(b"general.alignment") + len(b"general.alignment") + 4
    data = bytearray(aligned)
    struct.pack_into("<I", data, at, 0)
    assert "aligned to 0 bytes" in refused(bytes(data), tmp_path)
