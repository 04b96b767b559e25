"""Boxes by teachers: what they agree on, and the table that the trainer reads."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from labelled_frames import SOFA, sofa_graph, write_frames

from models.detection.detections import RawDetections
from models.errors import ModelFileError
from models.train.labelled import TAUGHT, read_frames
from models.train.teachers import agreed, main
from models.words.text_encoder import TextEncoder

SIDE, FAR = [10, 10, 50, 50], [60, 60, 90, 90]
NAMES = "{0: 'couch', 1: 'giraffe', 2: 'tv'}"


def seen(*things: tuple[list[float], int, float]) -> RawDetections:
    boxes = np.array([t[0] for t in things], np.float32).reshape(-1, 4)
    labels, surety = ([t[k] for t in things] for k in (1, 2))
    none = np.zeros(0, np.float32)
    return RawDetections(
        boxes, np.array(surety, np.float32), np.array(labels, np.int32), none, none, none
    )


def test_what_two_see_is_surer_than_what_one_does() -> None:
    first = seen((SIDE, 0, 0.6), (FAR, 1, 0.7))
    second = seen(([10, 10, 50, 46], 0, 0.2), (FAR, 2, 0.3))
    found = agreed([first, second])
    assert found.labels.tolist() == [1, 0, 2]
    np.testing.assert_allclose(found.surety, [0.7, 1 - 0.4 * 0.8, 0.3], atol=1e-6)
    np.testing.assert_allclose(found.boxes[1], [10, 10, 50, (0.6 * 50 + 0.2 * 46) / 0.8], atol=1e-4)
    assert agreed([seen((SIDE, 0, 0.5))] * 2).surety.tolist() == [0.75]


def test_nothing_seen() -> None:
    assert agreed([seen(), seen()]).boxes.shape == (0, 4)


def taught(folder: Path, teacher: Path, labelled: list[str] | None, out: Path) -> str:
    path = folder / "annotations.json"
    table = json.loads(path.read_text())
    if labelled is not None:
        path.write_text(json.dumps({**table, "info": {"labelled": labelled}}))
    command = ["--data", str(folder), "--teacher", str(teacher), "--out", str(out)]
    done = CliRunner().invoke(main, command, catch_exceptions=False)
    assert done.exit_code == 0
    return done.output


def test_a_teacher_boxes_what_is_not_boxed(
    tmp_path: Path, constant_graph: Callable[..., Path]
) -> None:
    cells = np.zeros((1, 7, 8 * 12 + 4 * 6 + 2 * 3), np.float32)
    cells[0, :, 0] = (48, 32, 40, 20, 0.9, 0.0, 0.0)  # a sofa
    cells[0, :, 1] = (20, 20, 10, 10, 0.0, 0.0, 0.3)  # perhaps a television
    teacher = constant_graph({"out": cells}, (64, 96), {"names": NAMES})
    write_frames(tmp_path / "data", [[(3, [2, 2, 9, 9], 0)], []])
    taught(tmp_path / "data", teacher, ["guitar"], tmp_path / "out")
    categories = ("guitar", "sofa", "television", "bed")
    first, second = read_frames(tmp_path / "out", categories)
    assert first.path == (tmp_path / "data" / "images" / "1.png").resolve()
    for frame in (first, second):
        assert frame.boxed.tolist() == pytest.approx([1, TAUGHT, TAUGHT, 0])
    assert (first.labels.tolist(), first.ignore.tolist()) == ([0, 1, 2], [False, False, True])
    assert second.boxes.tolist() == [[28, 22, 68, 42], [15, 15, 25, 25]]
    assert second.surety.tolist() == pytest.approx([0.9, 0.3])
    assert first.room == "bathroom"


def test_a_teacher_of_ours_knows_every_word_and_truth_comes_first(
    tmp_path: Path, constant_graph: Callable[..., Path], encoder: TextEncoder
) -> None:
    write_frames(tmp_path / "data", [[tuple(SOFA)]])
    taught(tmp_path / "data", sofa_graph(constant_graph, encoder), ["sofa"], tmp_path / "out")
    (frame,) = read_frames(tmp_path / "out", ("sofa", "bed"))
    assert frame.boxed.tolist() == pytest.approx([1, TAUGHT])
    assert frame.boxes[frame.labels == 0].tolist() == [[10, 10, 60, 50]]
    assert frame.surety[frame.labels == 0].tolist() == [1.0]


def test_a_table_that_says_nothing_of_what_is_boxed(
    tmp_path: Path, constant_graph: Callable[..., Path], encoder: TextEncoder
) -> None:
    write_frames(tmp_path / "data", [[]])
    with pytest.raises(ModelFileError, match=r"info\.labelled is missing"):
        taught(tmp_path / "data", sofa_graph(constant_graph, encoder), None, tmp_path / "out")
